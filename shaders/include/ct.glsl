// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The CT. Space: index, that is continuous voxel coordinates with voxel centres at integers. Values
// in HU.

#ifdef VOXEL_PAIRS
// Software rasterisers pay for every texel that a filter reads, so the shader reads two voxels at a
// time: one word for each voxel, with the next voxel of its row in the high half.
uniform isamplerBuffer ct;
uniform ivec2 ct_strides;        // Words to the next row and slice; 0 if there is only one.
#else
// Signed 16 bit normalised: HU = texel * 32767.
#ifdef GATHERS
uniform sampler2DArray ct;       // One layer per slice.
#else
uniform sampler3D ct;
#endif
#endif
uniform ivec3 ct_size;           // In voxels.
uniform mat3 index_from_local;   // Per mm.

const float kHuPerTexel = 32767.0;

vec3 last_voxel;  // Copies: taken_over.glsl.
vec3 per_voxel;

#ifdef MANUAL_FILTER
// Interpolates so that two equal values give exactly that value, which mix() does not guarantee.
vec4 between(vec4 a, vec4 b, float w) { return fma(vec4(w), b - a, a); }
float between(float a, float b, float w) { return fma(w, b - a, a); }

// Interpolates between four voxels of one slice and four of the next, in the order of
// textureGather().
float between_eight(vec4 near, vec4 far, vec3 part) {
  float front = between(between(near.w, near.z, part.x), between(near.x, near.y, part.x), part.y);
  float back = between(between(far.w, far.z, part.x), between(far.x, far.y, part.x), part.y);
  return between(front, back, part.z);
}
#endif

#ifdef GATHERS
// Trilinear from two gathers; the index is clamped to the outermost voxel centres. Only for volumes
// with one number per voxel: for several numbers eight fetches are cheaper.
float gathered(sampler2DArray volume, vec3 index) {
  vec3 inside = clamp(index, vec3(0.0), last_voxel);
  vec3 low = min(floor(inside), max(last_voxel - 1.0, 0.0));
  // The corner that four voxels share, and their slice.
  vec3 near = vec3((low.xy + 1.0) * per_voxel.xy, low.z);
  vec3 far = vec3(near.xy, low.z + 1.0);
  return kHuPerTexel *
         between_eight(textureGather(volume, near, 0), textureGather(volume, far, 0), inside - low);
}
#endif

// Trilinear; the index is clamped to the outermost voxel centres.
vec4 trilinear(sampler3D volume, vec3 index) {
  vec3 inside = clamp(index, vec3(0.0), last_voxel);
#ifdef MANUAL_FILTER
  ivec3 a = min(ivec3(inside), max(ct_size - 2, 0));
  ivec3 b = min(a + 1, ct_size - 1);
  vec3 f = inside - vec3(a);
  vec4 v000 = texelFetch(volume, a, 0);
  vec4 v100 = texelFetch(volume, ivec3(b.x, a.yz), 0);
  vec4 v010 = texelFetch(volume, ivec3(a.x, b.y, a.z), 0);
  vec4 v110 = texelFetch(volume, ivec3(b.xy, a.z), 0);
  vec4 v001 = texelFetch(volume, ivec3(a.xy, b.z), 0);
  vec4 v101 = texelFetch(volume, ivec3(b.x, a.y, b.z), 0);
  vec4 v011 = texelFetch(volume, ivec3(a.x, b.yz), 0);
  vec4 v111 = texelFetch(volume, b, 0);
  vec4 front = between(between(v000, v100, f.x), between(v010, v110, f.x), f.y);
  vec4 back = between(between(v001, v101, f.x), between(v011, v111, f.x), f.y);
  return between(front, back, f.z) * kHuPerTexel;
#else
  return textureLod(volume, (inside + 0.5) * per_voxel, 0.0) * kHuPerTexel;
#endif
}

#ifdef VOXEL_PAIRS
int row_words;  // Copies: taken_over.glsl.
int slice_words;

void take_over_volume() {
  last_voxel = vec3(ct_size - 1);
  per_voxel = 1.0 / vec3(ct_size);
  row_words = taken_over(ct_strides.x);
  slice_words = taken_over(ct_strides.y);
}

// The words around a position in the volume. Beyond its last voxels other words are read, with
// weight zero.
struct Words {
  int first;
  vec3 part;  // Position within a voxel, [0, 1).
};

Words words_at(vec3 index) {
  vec3 inside = clamp(index, vec3(0.0), last_voxel);
  ivec3 low = ivec3(inside);
  return Words(low.x + low.y * row_words + low.z * slice_words, inside - vec3(low));
}

// Two equal values give exactly that value.
float pairs_between(isamplerBuffer pairs, Words at) {
  int behind = at.first + slice_words;
  ivec4 words = ivec4(texelFetch(pairs, at.first).r, texelFetch(pairs, at.first + row_words).r,
                      texelFetch(pairs, behind).r, texelFetch(pairs, behind + row_words).r);
  vec4 low = vec4((words << 16) >> 16);
  vec4 rows = low + at.part.x * (vec4(words >> 16) - low);
  vec2 slices = rows.xz + at.part.y * (rows.yw - rows.xz);
  return slices.x + at.part.z * (slices.y - slices.x);
}

float ct_hu(vec3 index) { return pairs_between(ct, words_at(index)); }

#ifdef GRADIENTS
vec4 lows_of(ivec4 words) { return vec4((words << 16) >> 16); }
vec4 highs_of(ivec4 words) { return vec4(words >> 16); }

ivec4 pairs_of(ivec4 at) {
  return ivec4(texelFetch(ct, at.x).r, texelFetch(ct, at.y).r, texelFetch(ct, at.z).r,
               texelFetch(ct, at.w).r);
}

// Interpolates between the four rows around a position.
float between_rows(vec4 rows, vec2 part) {
  vec2 slices = rows.xz + part.x * (rows.yw - rows.xz);
  return slices.x + part.y * (slices.y - slices.x);
}

// Differences of the trilinear values one voxel on either side along each axis, HU. Outside the
// volume the outermost voxels are repeated. The 32 voxels that the values share are read once.
vec3 differences_at(vec3 index) {
  vec3 inside = clamp(index, vec3(0.0), last_voxel);
  ivec3 low = ivec3(inside);
  vec3 part = inside - vec3(low);
  ivec3 words = ivec3(1, row_words, slice_words);
  ivec3 before = words * min(low, 1);
  ivec3 room = ivec3(last_voxel) - low;
  ivec3 behind = words * min(room, 1);
  ivec3 beyond = words * min(room, 2);
  int at = low.x + low.y * row_words + low.z * slice_words;
  // The four rows, from x - 1 to x + 2.
  ivec4 rows = at + ivec4(0, behind.y, behind.z, behind.y + behind.z);
  ivec4 left = pairs_of(rows - before.x);
  ivec4 right = pairs_of(rows + behind.x);
  vec4 v0 = lows_of(left);
  vec4 v1 = low.x == 0 ? v0 : highs_of(left);
  vec4 v2 = lows_of(right);
  vec4 rise = v2 - v0;
  vec4 x_rises = rise + part.x * ((highs_of(right) - v1) - rise);
  vec4 centre = v1 + part.x * (v2 - v1);
  // The rows before and after them, then the slices.
  ivec4 outer = at + ivec4(-before.y, beyond.y, behind.z - before.y, behind.z + beyond.y);
  ivec4 pairs = pairs_of(outer);
  vec4 y_low = lows_of(pairs);
  vec4 beside = y_low + part.x * (highs_of(pairs) - y_low);
  outer = at + ivec4(-before.z, behind.y - before.z, beyond.z, behind.y + beyond.z);
  pairs = pairs_of(outer);
  vec4 z_low = lows_of(pairs);
  vec4 around = z_low + part.x * (highs_of(pairs) - z_low);
  vec2 y_rises = centre.yw - beside.xz;
  y_rises += part.y * ((beside.yw - centre.xz) - y_rises);
  vec2 slices = centre.xz + part.y * (centre.yw - centre.xz);
  vec2 outer_slices = around.xz + part.y * (around.yw - around.xz);
  float z_rise = slices.y - outer_slices.x;
  z_rise += part.z * ((outer_slices.y - slices.x) - z_rise);
  return vec3(between_rows(x_rises, part.yz), y_rises.x + part.z * (y_rises.y - y_rises.x),
              z_rise);
}
#endif
#else
void take_over_volume() {
  last_voxel = vec3(ct_size - 1);
  per_voxel = 1.0 / vec3(ct_size);
}

#ifdef GATHERS
float ct_hu(vec3 index) { return gathered(ct, index); }
#else
float ct_hu(vec3 index) { return trilinear(ct, index).r; }
#endif
#endif

// The part of an index ray that lies inside the box of voxel centres and in front of the eye; mm,
// empty if y <= x. An axis of one voxel extends half a voxel to either side.
vec2 clip_to_box(vec3 origin, vec3 direction, float t_eye) {
  vec2 part = vec2(t_eye, 3.0e38);
  for (int axis = 0; axis < 3; ++axis) {
    float low = ct_size[axis] > 1 ? 0.0 : -0.5;
    float high = ct_size[axis] > 1 ? float(ct_size[axis] - 1) : 0.5;
    float o = origin[axis];
    float d = direction[axis];
    if (d == 0.0) {
      if (o < low || o > high) return vec2(0.0);
    } else {
      float a = (low - o) / d;
      float b = (high - o) / d;
      part = vec2(max(part.x, min(a, b)), min(part.y, max(a, b)));
    }
  }
  return part.y > part.x ? part : vec2(0.0);
}
