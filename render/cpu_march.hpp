// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

// Plain data only: one of the files that include this is compiled for AVX2, and an inline function
// shared with the others could be linked in from there.
namespace nav::render {

/// Lanes of a packet: a block of 4 × 2 pixels.
inline constexpr int kPacketLanes = 8;

/// One whole HU of a transfer function: red, green, blue, extinction per mm, and what to add to
/// reach the next.
struct alignas(32) TableEntry {
  float value[4];
  float to_next[4];
};

/// What all rays of a picture share.
struct MarchInputs {
  const std::int16_t* voxels;  ///< Voxel (0, 0, 0) of a volume with repeated borders.
  int row_stride;
  int slice_stride;
  float last[3];  ///< n - 1 per axis.

  const std::uint8_t* brick_distance;  ///< Null: no skipping. Readable 3 bytes past the end.
  int bricks[3];

  const TableEntry* table;
  float table_low_hu;
  float table_high_hu;
  float invisible_up_to_hu;  ///< Everything up to here has no extinction; -infinity: nothing.

  float step_mm;
  float opaque_at;  ///< Infinity: never.

  bool shading;
  float half_per_spacing[3];   ///< 1 / (2 spacing), per mm.
  float mm_per_index_step[3];  ///< spacing / step: turns a step in indices into a unit direction.
  float per_full_gradient;     ///< mm/HU.
  float ambient;
  float diffuse;
  float specular;
  float shininess;
  float min_shaded_weight;  ///< A sample that weighs less in the pixel is not shaded.
};

/// Rays in voxel indices, counted in cells from each ray's own base cell.
struct alignas(32) RayPacket {
  float origin[3][kPacketLanes];  ///< Index at the centre of cell 0.
  float step[3][kPacketLanes];    ///< Index per cell.
  float begin[kPacketLanes];      ///< Part to march, in cells; empty when end <= begin.
  float end[kPacketLanes];
  float rgb[3][kPacketLanes];  ///< Colour so far, premultiplied.
  float alpha[kPacketLanes];   ///< Opacity so far.
};

struct MarchCounts {
  std::uint64_t samples;
  std::uint64_t gradients;
};

/// Marches the given part of each ray of a packet, adding to its colour and opacity.
using March = void (*)(const MarchInputs&, RayPacket&, MarchCounts&);
void march_portable(const MarchInputs& in, RayPacket& rays, MarchCounts& counts);
/// Needs AVX2 and FMA; ask for it through vector_march().
void march_avx2(const MarchInputs& in, RayPacket& rays, MarchCounts& counts);
/// The fastest march for this processor besides the portable one; null when there is none.
March vector_march();

}  // namespace nav::render
