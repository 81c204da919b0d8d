// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "render/cpu/cpu_march.hpp"

// Plain data only, as cpu_march.hpp.
namespace nav::render {

/// Channels of a set, at most: the volume, and two for each leaf.
inline constexpr int kMostChannels = 65;

/// kFullImportance.
inline constexpr float kMarchFullImportance = 1 - 1.0F / 4096;

/// So many looks are picked from registers.
inline constexpr int kFewLooks = 32;
inline constexpr int kLooksOfNibbles = 16;
/// Leaves of which it is known when one of them does not matter.
inline constexpr int kWeighedLeaves = 6;

/// One leaf: PredicateForm in codes of its channels and single precision.
struct PredicateAtom {
  enum Kind : std::int32_t { kRange, kWedge, kBits, kSegment, kSlab, kNever };
  std::int32_t kind;
  std::int32_t channel[2];
  float low;        ///< Range: code. Wedge: least square. Segment: square of mm. Slab: mm.
  float high;       ///< As low.
  float offset[2];  ///< Wedge: value = offset + scale · code.
  float scale[2];
  float wedge[3][2];
  float slack[3];  ///< Wedge: of each form, wedge_slack().
  std::int32_t mask;
  float a[3];     ///< Grid mm: end of a segment, normal of a slab.
  float axis[3];  ///< Grid mm: from a to the other end.
  float foot[3];  ///< axis / |axis|², or 0.
};

/// Of how many of its channels a leaf reads the voxels.
constexpr int channels_of(std::int32_t kind) {
  if (kind == PredicateAtom::kWedge) return 2;
  return kind == PredicateAtom::kRange ? 1 : 0;
}

/// What samples look like for which the same leaves are true.
struct alignas(16) PredicateLook {
  float tint[3];     ///< spec::hsl_tint().
  float importance;  ///< I, or exp(I - I_max) in the weight form; <= 0: invisible.
};

/// How a packet is composited.
enum class PredicateBlend { kOver, kWeight, kLog };

/// Opacity of a whole cell of an intensity x in [0, kWhitest], from registers: a polynomial for
/// each octave of z = kMost - x, which lies in [2^-8, 1), since opacities are powers of 1 - x but
/// for the corners of its table. Polynomials meet the opacity at both ends and at four places
/// between. Whiter ones are left to the table, whose last corner is far from any, but for white
/// itself.
struct alignas(64) OpacityPieces {
  static constexpr int kPieces = 8;
  static constexpr int kFactors = 6;
  static constexpr float kMost = 0.99999994F;  ///< The last before 1.
  static constexpr float kWhitest = 254.0F / 255;
  /// Of the fraction t in [0, 1) by which z is beyond the begin of its octave: sum of of[i] t^i.
  float of[kFactors][kPieces];
  float white;  ///< Of x = 1.
};

/// What all rays of a picture by predicates share.
struct PredicateInputs {
  MarchInputs base;  ///< Grid, bricks, step and cutaway; its voxels and table are not used.

  const std::int32_t* codes[kMostChannels];  ///< CpuVolume::origin(), with base's strides.
  bool has_undefined[kMostChannels];
  const std::uint32_t* labels;  ///< Without borders; null: no leaf needs them.
  int label_row;
  int label_slice;
  float spacing_mm[3];

  const PredicateAtom* atoms;
  std::uint32_t all_leaves;  ///< A bit for each.
  int leaf_count;
  std::int32_t order[32];  ///< In which leaves are tested: cheap ones first.
  int cheap_leaves;        ///< The first ones, which are tested without asking whether they matter.
  /// At leaf_count · known + i, bit b: with the leaves of the bits `known` true as in b, where all
  /// others are 0, leaf i may decide the look. Null above kWeighedLeaves.
  const std::uint64_t* matters;
  /// Looks by leaf bits; null above 12 leaves, then find_look() is asked.
  const PredicateLook* looks;
  void (*find_look)(const void* looks, std::uint32_t leaves, PredicateLook* out);
  const void* look_finder;
  /// The different ones by columns, importance last, each of 8 · few_eights floats; null above
  /// kFewLooks.
  const float* few_looks;
  int few_eights;
  const std::int32_t* look_numbers;  ///< Where they stand, by leaf bits; null: at the bits.
  /// Where those of numbered_looks stand that differ, kLooksOfNibbles at most, by the bits b of
  /// kWeighedLeaves leaves at most: bits 4 (b mod 8) on of word b / 8 of eight. Null: more, or so
  /// few leaves that few_looks holds no more.
  const std::int32_t* look_nibbles;
  const float* numbered_looks;  ///< As few_looks, each column of 8 · numbered_eights.
  int numbered_eights;

  /// Per brick: leaves true everywhere, and leaves to be tested. Null: test all.
  const std::int32_t* brick_sure;
  const std::int32_t* brick_open;
  /// Per brick: no sample has more importance, in the measure of PredicateLook.
  const float* brick_importance;

  float intensity_offset;  ///< Of codes[0].
  float intensity_scale;
  const float* tau;      ///< Per entry: extinction per mm, what to add to reach the next.
  float last_entry;      ///< kTauEntries - 1.
  const float* opacity;  ///< OpacityPieces::of. Null: the extinction of each sample is asked for.
  float white_opacity;   ///< OpacityPieces::white.

  float leave_out_from;  ///< spec::EarlyEnds; infinity: never.
  float leave_out_for;
  float end_at;
  float cutaway_scale;  ///< Cutaway importance of importance 1; weight form: see cutaway_greatest.
  float cutaway_greatest;  ///< Weight form: I = cutaway_greatest + ln w.
};

/// The state of a packet's rays besides RayPacket, whose colour is not premultiplied here.
struct alignas(64) PredicateRays {
  float picture[kPacketLanes];     ///< Share of the ultrasound picture in the colour.
  float importance[kPacketLanes];  ///< spec::ImportanceState::importance.
  float left_out[kPacketLanes];    ///< spec::LeftOut::spent; 0: nothing was.
};

/// Marches the given part of each ray of a packet.
using PredicateMarch = void (*)(const PredicateInputs&, RayPacket&, PredicateRays&, MarchCounts&);

/// What is compiled for one instruction set.
struct PredicateMarchSet {
  PredicateMarch (*march)(PredicateBlend, bool fade);
};
PredicateMarchSet portable_predicate_marches();
// As avx2_marches() and so on.
PredicateMarchSet avx2_predicate_marches();
PredicateMarchSet avx512_predicate_marches();
PredicateMarchSet avx512_gathers_predicate_marches();

}  // namespace nav::render
