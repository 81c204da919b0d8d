// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

// Plain data only. Some files that include this are compiled for AVX2 or AVX-512, and the linker
// could take a shared inline function from one of them.
namespace nav::render {

/// Equal to spec::kFadeSteps and kFadeVaries. Kernels may not include headers with inline
/// functions.
inline constexpr int kMarchFadeSteps = 4;
inline constexpr float kMarchFadeVaries = 0.25F;
/// Equal to spec::kMostShades.
inline constexpr int kMarchMostShades = 4;

/// Number of lanes of a packet, usually a block of 4 × 4 pixels.
inline constexpr int kPacketLanes = 16;
inline constexpr int kPacketWidth = 4;
inline constexpr int kPacketHeight = kPacketLanes / kPacketWidth;

/// Entry of a transfer function at a whole HU: red, green, blue, extinction per mm, and the
/// differences to the next entry.
struct alignas(32) TableEntry {
  float value[4];
  float to_next[4];
};

/// The integrals of colour times extinction, and of extinction, over the values up to w beyond a
/// whole HU, in quanta: before + round(w (half + there)). there = half + w bend is half of the
/// integral's derivative.
struct alignas(64) IntegralEntry {
  std::int32_t before[4];
  float half[4];
  float bend[4];
};

/// Greatest number of cells of a ray that are classified before the first of them is blended.
/// Measured, the best of 1 to 8: processors wait less for memory and for earlier results, but rays
/// end within a run.
inline constexpr int kMarchRun = 4;

/// Greatest factor by which the distance between brick tests grows after tests that found nothing
/// to skip.
inline constexpr int kMarchPatience = 3;

/// Lanes whose voxels of the next run of cells are prefetched before those of this run are read.
/// Voxels in the cache need no prefetch. If rays lie close together, the corners of a packet in
/// every second cell suffice. Marches by predicates prefetch only at the corners.
enum class MarchPrefetch { kNone, kCorners, kAll };

/// Data that all rays of an image share.
struct MarchInputs {
  const std::int32_t* voxels;           ///< CpuVolume::origin().
  const std::int32_t* gradient_voxels;  ///< CpuVolume::origin() of the gradients.
  int row_stride;
  int slice_stride;
  float last[3];  ///< n - 1 per axis.

  /// Per invisible brick: the distance to the nearest occupied brick, > 0. Per occupied brick:
  /// minus the distance, in bricks, within which all bricks around it are occupied, <= 0. Null: no
  /// skipping. Readable 3 bytes past the end.
  const std::int8_t* brick_leap;
  /// visible_parts() of bricks. Null: parts are not tested. Readable 3 bytes past the end.
  const std::uint8_t* brick_parts;
  /// VisibleCells::words(). Null: every cell is sampled. Readable one word past that of the last
  /// cell.
  const std::int32_t* visible_cells;
  int cells_per_test;  ///< Number of cells that are marched between two brick tests, >= 1.
  /// Greatest importance of samples that may be visible in a brick, in steps of 1/254 rounded up;
  /// 255: 1. Null without a cutaway. Readable 3 bytes past the end.
  const std::uint8_t* brick_importance;
  const std::int32_t* brick_range;  ///< Least HU in the lower, greatest HU in the upper 16 bits.
                                    ///< For projections.
  int bricks[3];

  const TableEntry* table;  ///< table_size entries, row after row.
  const float* importance;  ///< One per entry.
  float table_low_hu;
  float table_high_hu;
  int table_size;
  int table_rows;            ///< 1 without gradient windows.
  float rows_per_gradient;   ///< mm/HU.
  float invisible_up_to_hu;  ///< Values up to here have no extinction; -infinity: there are none.
  /// table_size + 1 entries: below the table, from each entry to the next, above the table.
  const IntegralEntry* integrals;
  float quantum;  ///< HU/mm.

  float step_mm;
  MarchPrefetch prefetch;
  float opaque_at;  ///< Infinity: never.

  float half_per_spacing[3];   ///< 1 / (2 spacing), per mm.
  float mm_per_index_step[3];  ///< spacing / step: converts a step in indices to a unit direction.
  float light[3];              ///< Direction of the light of spec::gooch(), along the grid's axes.
  float per_full_gradient;     ///< mm/HU.
  float emphasis;
  float ambient;
  float diffuse;
  float specular;
  float shininess;
  int whole_shininess;  ///< shininess if it is an integer, otherwise -1.
  float least_cosine;   ///< Lower limit of cosines, so that no power in use underflows.
  float cool_share;
  float warm_share;
  float silhouette;
  float min_shaded_weight;  ///< Least weight in the pixel of a sample that is shaded.
  float shades_per_root;    ///< Factor for the weight of one cell: spec::shades_of().

  float per_overlay;    ///< 1 / overlay, in cells; 1e30 for 0.
  float overlay_cells;  ///< 1e30 for infinity.
  float fade_share;     ///< 1: thresholds by importance; 0: constant ones.
  float fade_low;       ///< Constant thresholds; 0 by importance.
  float fade_high;
};

/// Rays in voxel indices. Positions are in cells from each ray's own base cell.
struct alignas(64) RayPacket {
  float origin[3][kPacketLanes];  ///< Index of sample 0: the begin of cell 0 if pre-integrated,
                                  ///< otherwise its middle.
  float step[3][kPacketLanes];    ///< Index change per cell.
  float begin[kPacketLanes];      ///< Part to march, in cells; empty when end <= begin.
  float end[kPacketLanes];
  float rgb[3][kPacketLanes];  ///< Accumulated colour, premultiplied.
  float alpha[kPacketLanes];   ///< Accumulated opacity.
  // Only for marches that fade.
  float t1[kPacketLanes];  ///< Surface of theta1 of the cutaway, in cells; -1e30: no intersection.
  float t2[kPacketLanes];  ///< Surface of theta2; see t1.
  float per_transition[kPacketLanes];  ///< 1 / (t2 - t1); 1e30 for 0.
  float margin[kPacketLanes];  ///< Margin for the rounding of Omega's break points, in cells.
  float value[kPacketLanes];   ///< Result of a projection, HU.
};

/// The camera and the volume's box for starting rays: spec::View and spec::clip_to_box() in voxel
/// indices. Vectors are in voxels per mm.
struct RayInputs {
  double eye[3];
  double right[3];
  double up[3];
  double forward[3];
  double pixel;  ///< Side of a pixel at distance 1; orthographic: mm.
  double half_width;
  double half_height;
  double low[3];
  double high[3];
  double step_mm;
  double first_sample;  ///< Position of sample 0 in cell 0, in cells.
  int width;
  int height;
  bool orthographic;
  bool jitter;
};

/// The parts of a packet's rays in the volume.
struct RayStarts {
  double base[kPacketLanes];   ///< Begin of cell 0, in cells from the ray's origin.
  double begin[kPacketLanes];  ///< mm; empty when end <= begin, as in lanes outside the image.
  double end[kPacketLanes];
  bool any;  ///< At least one lane is not empty.
};

/// The pixels of a packet's rays. Lanes without a pixel lie beyond the image's width.
struct alignas(32) PacketPixels {
  std::int32_t x[kPacketLanes];
  std::int32_t y[kPacketLanes];
};

/// Starts the rays of a packet, without the cutaway.
using RayStart = void (*)(const RayInputs&, const PacketPixels&, RayPacket&, RayStarts&);

struct MarchCounts {
  std::uint64_t samples;  ///< Values that lanes needed.
  std::uint64_t passed;   ///< Values that lanes did not need, because their cells are not visible.
  std::uint64_t gradients;
  std::uint64_t window_gradients;
  std::uint64_t faded;
};

enum class MarchClassify { kPreIntegrated, kPostClassified, kWindows };
enum class MarchShade { kNone, kPhong, kGooch };
/// Cells that a march takes: all, or those of MarchInputs::visible_cells.
enum class MarchCells { kAll, kVisible };
enum class MarchProject { kMaximum, kMinimum, kMean };

/// Properties that a march is compiled for. Features that a scene does not have cost nothing.
struct MarchKey {
  MarchClassify classify;
  MarchShade shade;
  bool fade;
  MarchCells cells;
};

/// Marches the given part of each ray of a packet: compositing adds to its colour and opacity,
/// projecting sets its value.
using March = void (*)(const MarchInputs&, RayPacket&, MarchCounts&);

struct CutObjects;
struct CutBlock;
struct CutChoice;
struct CutRays;
/// Keeps the objects of a choice that may decide for any ray of a block. Returns a distance from
/// the foot that no surface exceeds in the block, mm.
using CutCull = float (*)(const CutObjects&, const CutBlock&, const CutChoice& in, CutChoice& out);
/// Sets t1 and t2 from the chosen objects.
using CutMeet = void (*)(const CutObjects&, const CutChoice&, CutRays&);

/// The camera in mm; the eye is relative to the reference point of a cutaway.
struct CutView {
  double eye[3];
  double right[3];
  double up[3];
  double forward[3];
};
/// Sets the rays of a packet, and the kPacketLanes distances of their feet from their origins, mm.
using CutAim = void (*)(const RayInputs&, const CutView&, const PacketPixels&, CutRays&,
                        double* feet);

/// The functions compiled for one instruction set.
struct MarchSet {
  March (*composite)(const MarchKey&);
  March (*project)(MarchProject);
  CutCull cull;
  CutMeet meet;
  RayStart start;
  CutAim aim;
};
MarchSet portable_marches();
// Call these through cpu_marches(), because they need AVX2 and FMA, or x86-64-v4.
MarchSet avx2_marches();
MarchSet avx512_marches();

}  // namespace nav::render
