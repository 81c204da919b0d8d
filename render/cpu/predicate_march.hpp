// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include "render/cpu/cpu_march.hpp"

// Plain data only, as in cpu_march.hpp.
namespace nav::render {

/// Greatest number of channels of a set: the volume, and two for each leaf.
inline constexpr int kMostChannels = 65;

/// Equal to kFullImportance.
inline constexpr float kMarchFullImportance = 1 - 1.0F / 4096;

/// Greatest number of appearances that are picked from registers.
inline constexpr int kFewAppearances = 32;
inline constexpr int kAppearancesOfNibbles = 16;
/// Greatest number of leaves for which PredicateInputs::matters is computed.
inline constexpr int kWeighedLeaves = 6;

/// One leaf: a PredicateForm in codes of its channels, in single precision.
struct PredicateAtom {
  enum Kind : std::int32_t { kRange, kWedge, kBits, kSegment, kSlab, kNever };
  std::int32_t kind;
  std::int32_t channel[2];
  float low;        ///< Range: code. Wedge: least sum of squares. Segment: mm². Slab: mm.
  float high;       ///< In the units of low.
  float offset[2];  ///< Wedge: value = offset + scale · code.
  float scale[2];
  float wedge[3][2];
  float slack[3];  ///< Wedge: wedge_slack() of each form.
  std::int32_t mask;
  float a[3];     ///< Grid mm: end of a segment, normal of a slab.
  float axis[3];  ///< Grid mm: from a to the other end.
  float foot[3];  ///< axis / |axis|², or 0.
};

/// Number of channels of which a leaf reads the voxels.
constexpr int channels_of(std::int32_t kind) {
  if (kind == PredicateAtom::kWedge) return 2;
  return kind == PredicateAtom::kRange ? 1 : 0;
}

/// Appearance of the samples for which the same leaves are true.
struct alignas(16) PredicateAppearance {
  float tint[3];     ///< spec::hsl_tint().
  float importance;  ///< I, or exp(I - I_max) in the weight form; <= 0: invisible.
};

/// Compositing of a packet.
enum class PredicateBlend { kOver, kWeight, kLog };

/// Opacity of a whole cell of an intensity x in [0, kWhitest], from registers. There is one
/// polynomial for each octave of z = kMost - x, which lies in [2^-8, 1), because opacities are
/// powers of 1 - x except at the corners of their table. Each polynomial meets the opacity at both
/// ends and at four positions between. Whiter intensities use the table, because its last corner is
/// far from any polynomial. White itself has its own value.
struct alignas(64) OpacityPieces {
  static constexpr int kPieces = 8;
  static constexpr int kFactors = 6;
  static constexpr float kMost = 0.99999994F;  ///< The greatest float below 1.
  static constexpr float kWhitest = 254.0F / 255;
  /// Factors of the polynomials: sum of of[i] t^i, where t in [0, 1) is the fraction by which z
  /// lies beyond the begin of its octave.
  float of[kFactors][kPieces];
  float white;  ///< Opacity at x = 1.
};

/// Data that all rays of an image by predicates share.
struct PredicateInputs {
  /// Grid, bricks, step, cutaway and, for marches with shading, gradients and light. Its voxels and
  /// table are not used.
  MarchInputs base;

  const std::int32_t* codes[kMostChannels];  ///< CpuVolume::origin(), with the strides of base.
  bool has_undefined[kMostChannels];
  const std::uint32_t* labels;  ///< Without borders; null: no leaf needs them.
  int label_row;
  int label_slice;
  float spacing_mm[3];

  const PredicateAtom* atoms;
  std::uint32_t all_leaves;  ///< One bit for each leaf.
  int leaf_count;
  std::int32_t order[32];  ///< Order in which leaves are tested: cheap ones first.
  int cheap_leaves;        ///< Number of first leaves that are tested without checking whether they
                           ///< matter.
  /// Bit b of entry leaf_count · known + i is set if leaf i may decide the appearance when the
  /// leaves of the bits `known` are as in b. All other bits of b are 0. Null above kWeighedLeaves.
  const std::uint64_t* matters;
  /// Appearances by leaf bits. Null above 12 leaves; then find_appearance() is called.
  const PredicateAppearance* appearances;
  void (*find_appearance)(const void* appearances, std::uint32_t leaves, PredicateAppearance* out);
  const void* appearance_finder;
  /// The different appearances in columns, importance last, each of 8 · few_eights floats. Null
  /// above kFewAppearances.
  const float* few_appearances;
  int few_eights;
  const std::int32_t* appearance_numbers;  ///< Positions in few_appearances, by leaf bits; null:
                                           ///< the bits are the positions.
  /// Positions in numbered_appearances, which holds at most kAppearancesOfNibbles different
  /// appearances, by the bits b of at most kWeighedLeaves leaves: four bits from bit 4 (b mod 8) on
  /// of word b / 8 of eight. Null: there are more, or so few leaves that few_appearances is no
  /// larger.
  const std::int32_t* appearance_nibbles;
  const float*
      numbered_appearances;  ///< Columns of 8 · numbered_eights floats; see few_appearances.
  int numbered_eights;

  /// Per brick: leaves that are true everywhere, and leaves that must be tested. Null: test all.
  const std::int32_t* brick_sure;
  const std::int32_t* brick_open;
  /// Per brick: upper bound of the importance of its samples, in the units of PredicateAppearance.
  const float* brick_importance;

  float intensity_offset;  ///< Intensity = offset + scale · code of codes[0].
  float intensity_scale;
  const float* tau;      ///< Per entry: extinction per mm, and the difference to the next entry.
  float last_entry;      ///< kTauEntries - 1.
  const float* opacity;  ///< OpacityPieces::of. Null: the extinction of each sample is looked up.
  float white_opacity;   ///< OpacityPieces::white.

  float leave_out_from;  ///< spec::EarlyEnds; infinity: never.
  float leave_out_for;
  float end_at;
  float cutaway_scale;  ///< Cutaway importance of importance 1. Weight form: see cutaway_greatest.
  float cutaway_greatest;  ///< Weight form: I = cutaway_greatest + ln w.
};

/// State of a packet's rays besides RayPacket, whose colour is not premultiplied here.
struct alignas(64) PredicateRays {
  float image[kPacketLanes];       ///< Share of the ultrasound image in the colour.
  float importance[kPacketLanes];  ///< spec::ImportanceState::importance.
  float left_out[kPacketLanes];    ///< spec::LeftOut::spent; 0: nothing was left out.
};

/// Marches the given part of each ray of a packet.
using PredicateMarch = void (*)(const PredicateInputs&, RayPacket&, PredicateRays&, MarchCounts&);

/// The functions compiled for one instruction set.
struct PredicateMarchSet {
  PredicateMarch (*march)(PredicateBlend, bool fade, bool shade);
};
PredicateMarchSet portable_predicate_marches();
// See avx2_marches() and the others.
PredicateMarchSet avx2_predicate_marches();
PredicateMarchSet avx512_predicate_marches();

}  // namespace nav::render
