// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Composites the cells of a stretch by predicates: render/predicates/predicate_scene.hpp. Cells are
// tested in runs no longer than a brick, whose limits are the same for all rays and images. The
// data read at the first cell of a run holds for all bricks that the run can touch. The composited
// samples and the end of a ray depend on the runs and on the light alone, not on how runs without
// effect are passed. So images with and without leaps have the same bits.
// Data of a brick: the distance to the nearest visible brick, in bricks along the longest axis.
// Then, for the brick and all that touch it: the bits of the greatest importance, the leaves that
// are true throughout, and the leaves that are not decided.

uniform bool leaps;           // Leaps over bricks in which nothing is visible.
uniform bool tests_bricks;  // Tests bricks, for leaps or for early ends.
uniform float run_cells;
uniform float leave_out_from;  // spec::EarlyEnds; > 1: never.
uniform float end_at;
uniform vec2 entry_of_volume;   // Entry of the table of extinctions: scale, offset.
uniform float last_entry;
// One fetch reads everything. So runs without features need no loop of their own, which would cost
// one turn even if no ray takes it.
#ifdef VOLUME_IN_FEATURES
#if FEATURES == 1
#define ONE_TEXTURE
#endif
#endif
#if defined(FEATURE_PAIRS) && !defined(GENERIC)
#define ONE_TEXTURE
#endif
// Extinction per mm, and its difference to the next entry.
#ifdef STORAGE
layout(std430, binding = 0) readonly buffer Opacity { vec2 opacity[]; };
#define opacity_texel(i) opacity[i]
#else
uniform samplerBuffer opacity;
#define opacity_texel(i) texelFetch(opacity, i).rg
#endif
uniform vec3 spacing_mm;

#ifdef FEATURES
// Codes of up to four features each. With VOLUME_IN_FEATURES the first one is the volume.
#ifdef FEATURE_PAIRS
#define FEATURE_TEXTURE isamplerBuffer  // One after the other, like the CT in ct.glsl.
uniform int feature_words;              // Words from one feature to the next.
uniform ivec3 feature_counts;           // Number of features in each table.
#else
#define FEATURE_TEXTURE sampler3D
#endif
uniform FEATURE_TEXTURE features0;
#if FEATURES > 1
uniform FEATURE_TEXTURE features1;
#endif
#if FEATURES > 2
uniform FEATURE_TEXTURE features2;
#endif
uniform ivec4 feature_leaves;  // Leaves that read each texture.
#ifdef UNDEFINED
uniform usampler3D undefined_cells;  // Bits of features that are undefined at a corner of the cell.
#endif
#endif
#ifdef LABELS
uniform usampler3D labels;
uniform int label_leaves;
#endif
#ifdef CUTAWAY
uniform float cutaway_scale;  // Cutaway importance of importance 1.
uniform float cutaway_greatest;
#endif

#if defined(UNROLLED) && !defined(GENERIC) && !defined(TWO_VOLUMES)
#define TWO_AT_ONCE
#endif

bool ended;              // The light is final.
float greatest_to_come;  // Upper bound of the importance on the rest of the stretch.

// Copies: taken_over.glsl.
bool leaps_taken, tests_taken;
float run_taken, leave_out_from_taken, end_at_taken, last_entry_taken;
vec2 entry_taken;
vec3 spacing_taken;
#ifdef FEATURES
ivec3 readers_taken;
ivec3 counts_taken;
#ifdef FEATURE_PAIRS
int words_of_feature;
#endif
#endif
#ifdef LABELS
int label_leaves_taken;
#endif

void take_over_predicates() {
  leaps_taken = taken_over(int(leaps)) != 0;
  tests_taken = taken_over(int(tests_bricks)) != 0;
  run_taken = taken_over(run_cells);
  leave_out_from_taken = taken_over(leave_out_from);
  end_at_taken = taken_over(end_at);
  last_entry_taken = taken_over(last_entry);
  entry_taken = vec2(taken_over(entry_of_volume.x), taken_over(entry_of_volume.y));
  spacing_taken = taken_over(spacing_mm);
#ifdef FEATURES
  readers_taken = ivec3(taken_over(feature_leaves.x), taken_over(feature_leaves.y),
                        taken_over(feature_leaves.z));
#ifdef FEATURE_PAIRS
  counts_taken = ivec3(taken_over(feature_counts.x), taken_over(feature_counts.y),
                       taken_over(feature_counts.z));
  words_of_feature = taken_over(feature_words);
#endif
#endif
#ifdef LABELS
  label_leaves_taken = taken_over(label_leaves);
#endif
#ifdef TAKES_OVER_LEAVES
  take_over_leaves();
#endif
#ifdef PREDICATE_SHADING
  take_over_predicate_shading();
#endif
}

#ifdef FEATURES
#ifdef FEATURE_PAIRS
// count: number of features in the table, >= 1.
vec4 features_at(isamplerBuffer texels, int count, vec3 index) {
  Words at = words_at(index);
  vec4 found = vec4(0.0);
#ifdef GENERIC
  int c = 0;
  do {
    float value = pairs_between(texels, at);
    found = mix(found, vec4(value), equal(ivec4(0, 1, 2, 3), ivec4(c)));
    at.first += words_of_feature;
  } while (++c < count);
#else
  for (int c = 0; c < 4; ++c) {  // The compiler leaves out channels that are not used.
    found[c] = pairs_between(texels, at);
    at.first += words_of_feature;
  }
#endif
  return found;
}
#else
vec4 features_at(sampler3D texels, int count, vec3 index) { return trilinear(texels, index); }
#endif
#endif

// The first texel that a sample reads. reads: some leaf that matters reads features.
vec4 first_texel(vec3 index, bool reads) {
#ifdef VOLUME_IN_FEATURES
  if (reads) return trilinear(features0, index);
#endif
  return vec4(ct_hu(index));
}

// The leaves that are true at a position. asked: those that matter. reads: some of them reads
// features.
uint leaves_at(vec3 index, vec4 first, uint asked, bool reads) {
  uint undefined = 0u;
  uint bits = 0u;
#ifdef FEATURES
  vec4 texels[FEATURES];
#ifdef VOLUME_IN_FEATURES
  texels[0] = first;
#else
  texels[0] = vec4(0.0);
  if (reads && (asked & uint(readers_taken.x)) != 0u) texels[0] = features_at(features0, counts_taken.x, index);
#endif
#if FEATURES > 1
  texels[1] = vec4(0.0);
  if (reads && (asked & uint(readers_taken.y)) != 0u) texels[1] = features_at(features1, counts_taken.y, index);
#endif
#if FEATURES > 2
  texels[2] = vec4(0.0);
  if (reads && (asked & uint(readers_taken.z)) != 0u) texels[2] = features_at(features2, counts_taken.z, index);
#endif
#ifdef UNDEFINED
#ifdef GENERIC
  reads = reads && has_undefined;
#endif
  if (reads) undefined = texelFetch(undefined_cells, ivec3(index), 0).r;
#endif
#else
  const vec4 texels[1] = vec4[1](vec4(0.0));
#endif
#ifdef LABELS
  if ((asked & uint(label_leaves_taken)) != 0u) bits = texelFetch(labels, ivec3(index + 0.5), 0).r;
#endif
#ifdef GENERIC
  asked_leaves = asked;
#endif
  return predicate_leaves(texels, first.x, undefined, bits, spacing_taken * index);
}

float extinction_of(float entry) {
  float at = min(floor(entry), last_entry_taken - 1.0);
  vec2 known = opacity_texel(int(at));
  return fma(entry - at, known.y, known.x);
}

#ifdef CUTAWAY
float linear_importance(float importance) {
#ifdef LOG_IMPORTANCE
  return importance;
#else
  return log(max(importance, 1.0e-37)) + cutaway_greatest;
#endif
}

float faded_extinction(float tau, float importance, float begin, float end) {
  float share = max(cutaway_scale * linear_importance(importance), 0.0);
  if (share >= 1.0 - 1.0 / 4096.0) share = 1.0;  // Same as kFullImportance of the CPU.
  float sum = 0.0;
  for (int i = 0; i < kFadeSteps; ++i) {
    float t = t_of(mix(begin, end, (float(i) + 0.5) / float(kFadeSteps)));
    sum += visibility(share, occlusion(cut_span, t));
  }
  return faded(tau, sum / float(kFadeSteps));
}
#endif

// Composites the part of cell n between begin and end. counts false: no effect.
void add_cell(int n, bool counts, float begin, float end, uint sure, uint open, bool reads,
              bool fading) {
  float cell = float(n);
  vec3 index = clamp(index_at(cell + 0.5), vec3(0.0), last_voxel);
  cost.x += float(counts);
  vec4 first = first_texel(index, reads);
  // Without a branch: an invisible sample is composited with an opacity of 0.
  float entry = clamp(fma(first.x, entry_taken.x, entry_taken.y), 0.0, last_entry_taken);
  uint leaves = sure | (leaves_at(index, first, open, reads) & open);
  Appearance appearance = appearance_of(predicate_class(leaves));
  float from = max(cell, begin);
  float to = min(cell + 1.0, end);
  precise float tau = extinction_of(entry);
#ifdef CUTAWAY
  if (fading && t_of(from) < cut_span.t2) {
    cost.z += float(counts && entry > 0.0 && appearance.importance > 0.0);
    tau = faded_extinction(tau, appearance.importance, from, to);
  }
#endif
  precise float seen = opacity_of(max(tau * cell_mm * (to - from), 0.0));
  seen = counts && entry > 0.0 && appearance.importance > 0.0 ? seen : 0.0;
  precise float grey = entry / last_entry_taken;
  precise vec3 rgb = fma(vec3(1.0 - abs(fma(2.0, grey, -1.0))), appearance.tint, vec3(grey));
#ifdef PREDICATE_SHADING
  if (seen > 0.0) {
    cost.y += 1.0;
    rgb = shaded_sample(rgb, index);
  }
#endif
  blend(rgb, seen, appearance.importance, 0.0);
  if (counts) ended = light.alpha >= end_at_taken && !left_out &&
          light.alpha * kept_before(greatest_to_come) >= end_at_taken;
}

// Composites cells from n on, before run_end, and returns the next cell. Several at once, as in
// march.glsl.
int add_cells(int n, int run_end, float begin, float end, uint sure, uint open, bool reads,
              bool fading) {
  add_cell(n, true, begin, end, sure, open, reads, fading);
#ifdef TWO_AT_ONCE
  if (!fading) {
    add_cell(n + 1, n + 1 < run_end && !ended, begin, end, sure, open, reads, false);
    return n + 2;
  }
#endif
  return n + 1;
}

int begin_of_run(int n) {
  return int(floor((float(n) + 0.5) / run_taken) * run_taken);
}

// The cell after the run of cell n, if nothing in that run counts.
int behind_run(int n, uint distance) {
  int next = begin_of_run(n) + int(run_taken);
  vec3 size = abs(lattice_step) * bricks_a_voxel;
  float cells = float(max(int(distance), 1) - 1) / max(max(size.x, size.y), size.z);
  return max(next, begin_of_run(n + int(min(cells, 1.0e6))));
}

// Finds the greatest importance of cells n to last - 1, and the cell up to which it stays the
// greatest.
void look_ahead(int n, int last, out int valid_to) {
  greatest_to_come = 0.0;
  valid_to = last;
  do {
    uvec4 known = texelFetch(bricks, brick_of(n), 0);
    n = behind_run(n, known.r);
    if (uintBitsToFloat(known.g) >= greatest_to_come) {
      greatest_to_come = uintBitsToFloat(known.g);
      valid_to = n;
    }
  } while (n < last);
}

// True if nothing of the run of cell n is visible yet.
bool is_hidden(int n, float importance) {
#ifdef CUTAWAY
  float share = cutaway_scale * linear_importance(importance);
  float hidden = cells_of(hidden_until(cut_span, clamp(share, 0.0, 0.99)));
  return share < 0.99 && hidden > float(begin_of_run(n)) + run_taken;
#else
  return false;
#endif
}

bool reads_features(uint asked) {
#ifdef FEATURES
  return (asked & uint(readers_taken.x | readers_taken.y | readers_taken.z)) != 0u;
#else
  return true;
#endif
}

// Loops are tested at their ends, as in march.glsl. begin, end, far: in cells. far: the cell at
// which the volume ends before the next surface, for rule 2, which ends the ray up to there.
#ifdef TWO_VOLUMES
float clear_to;  // See march.glsl.
#endif
void march(float begin, float end, float far, bool fading) {
  int n = int(floor(begin));
  int last = end > begin ? int(ceil(end)) : n;
  int last_of_all = int(ceil(far));
  int valid_to = n - 1;
  bool marching = last > n && !ended;
  if (marching) do {
    int run_end = last;
    uint sure = 0u;
    uint open = ~0u;
    if (tests_taken) {
      bool passed;
      do {
        uvec4 known = texelFetch(bricks, brick_of(n), 0);
        float importance = uintBitsToFloat(known.g);
        // Rule 1 of spec::EarlyEnds, run by run.
        passed = light.alpha >= leave_out_from_taken && can_leave_out(importance);
        if (leaps_taken) {
          passed = passed || known.r > 1u || (fading && is_hidden(n, importance));
          sure = known.b;
          open = known.a;
        }
        if (passed) n = behind_run(n, leaps_taken ? known.r : 0u);
      } while (passed && n < last);
      run_end = min(begin_of_run(n) + int(run_taken), last);
      // Rule 2, unless rule 1 was used.
      if (light.alpha >= end_at_taken && !left_out && n < last) {
        if (n >= valid_to) look_ahead(n, last_of_all, valid_to);
        ended = light.alpha * kept_before(greatest_to_come) >= end_at_taken;
      }
    }
    // A software rasteriser skips no part of a loop, only whole loops. Both loops do the same
    // operations, so that the bits are the same.
#ifdef ONE_TEXTURE
    const bool reads = true;
#else
    bool reads = fading || reads_features(open);
#endif
#if defined(UNROLLED) && defined(FEATURES) && !defined(ONE_TEXTURE)
    if (n < run_end && !ended && !reads && !fading) do {
      n = add_cells(n, run_end, begin, end, sure, open, false, false);
    } while (n < run_end && !ended);
    if (n < run_end && !ended && reads) do {
      n = add_cells(n, run_end, begin, end, sure, open, true, fading);
    } while (n < run_end && !ended);
#else
    if (n < run_end && !ended) do {
      n = add_cells(n, run_end, begin, end, sure, open, reads, fading);
    } while (n < run_end && !ended);
#endif
    n = min(n, run_end);
    marching = n < last && !ended;
  } while (marching);
#ifdef TWO_VOLUMES
  clear_to = max(clear_to, float(n - 1));
#endif
}

#ifdef CUTAWAY
// See march.glsl.
void march_cut(float begin, float end) {
  float fade = cells_of(cut_span.t2);
  float turn = fade > begin ? clamp(ceil(min(fade, 1.0e9)), begin, max(begin, end)) : begin;
#ifdef UNROLLED
  march(begin, min(turn, end), end, true);
  march(turn, end, end, false);
#else
  bool fading = end > begin;
  bool going = fading;
  while (going) {
    march(fading ? begin : turn, fading ? min(turn, end) : end, end, fading);
    going = fading;
    fading = false;
  }
#endif
}
#endif
