// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

// Plain data only: some of the files that include this are compiled for AVX2 or AVX-512, and an
// inline function shared with the others could be linked in from there.
namespace nav::render {

/// spec::kFadeSteps and kFadeVaries; kernels may not include what has inline functions.
inline constexpr int kMarchFadeSteps = 4;
inline constexpr float kMarchFadeVaries = 0.25F;
/// spec::kMostShades.
inline constexpr int kMarchMostShades = 4;

/// Lanes of a packet: as a rule a block of 4 × 4 pixels.
inline constexpr int kPacketLanes = 16;
inline constexpr int kPacketWidth = 4;
inline constexpr int kPacketHeight = kPacketLanes / kPacketWidth;

/// One whole HU of a transfer function: red, green, blue, extinction per mm, and what to add to
/// reach the next.
struct alignas(32) TableEntry {
  float value[4];
  float to_next[4];
};

/// The integral of colour times extinction, and of extinction, over the values up to w beyond a
/// whole HU, in quanta: before + round(w (half + there)), where there = half + w bend is half of
/// its derivative.
struct alignas(64) IntegralEntry {
  std::int32_t before[4];
  float half[4];
  float bend[4];
};

/// Most cells of a ray that are classified before the first of them is blended. Measured, of 1 to
/// 8: processors wait less for memory and for one another's results, but rays end among them.
inline constexpr int kMarchRun = 4;

/// How many times as far a ray marches at most before it looks at bricks again, after looks that
/// found nothing to leap over.
inline constexpr int kMarchPatience = 3;

/// Whose voxels of the next run of cells are asked for before those of this one are read: what lies
/// in the cache is not asked for, and where rays lie close together, those at the corners of a
/// packet of every second cell will do. Marches by predicates always ask at the corners.
enum class MarchPrefetch { kNone, kCorners, kAll };

/// What all rays of a picture share.
struct MarchInputs {
  const std::int32_t* voxels;  ///< CpuVolume::origin().
  int row_stride;
  int slice_stride;
  float last[3];  ///< n - 1 per axis.

  /// Per brick where nothing is visible: the distance to the nearest one that is occupied, > 0. Per
  /// occupied brick: minus how many occupied bricks lie all around it, <= 0. Null: no skipping.
  /// Readable 3 bytes past the end.
  const std::int8_t* brick_leap;
  /// visible_parts() of bricks. Null: parts are not looked at. Readable 3 bytes past the end.
  const std::uint8_t* brick_parts;
  /// VisibleCells::words(). Null: every cell is sampled. Readable a word past the last cell's.
  const std::int32_t* visible_cells;
  int cells_per_look;  ///< Cells that are marched before bricks are looked at again, >= 1.
  /// Greatest importance of what may be visible in a brick, in parts of 254 rounded up; 255: 1.
  /// Null without a cutaway. Readable 3 bytes past the end.
  const std::uint8_t* brick_importance;
  /// Cells of a brick that may be taken as one: brick_cells(). Null: single cells. Readable 3 bytes
  /// past the end.
  const std::uint8_t* brick_cells;
  const std::int32_t* brick_range;  ///< Least HU below, greatest in the upper 16 bits. Projections.
  int bricks[3];

  const TableEntry* table;  ///< table_size entries, row after row.
  const float* importance;  ///< One per entry.
  float table_low_hu;
  float table_high_hu;
  int table_size;
  int table_rows;            ///< 1 without gradient windows.
  float rows_per_gradient;   ///< mm/HU.
  float invisible_up_to_hu;  ///< Everything up to here has no extinction; -infinity: nothing.
  /// table_size + 1 entries: below the table, from each entry to the next, beyond it.
  const IntegralEntry* integrals;
  float quantum;  ///< HU/mm.

  float step_mm;
  MarchPrefetch prefetch;
  float opaque_at;  ///< Infinity: never.

  float half_per_spacing[3];   ///< 1 / (2 spacing), per mm.
  float mm_per_index_step[3];  ///< spacing / step: turns a step in indices into a unit direction.
  float light[3];              ///< Of spec::gooch(), along the grid's axes.
  float per_full_gradient;     ///< mm/HU.
  float emphasis;
  float ambient;
  float diffuse;
  float specular;
  float shininess;
  int whole_shininess;  ///< The same where it is a whole number, else -1.
  float least_cosine;   ///< Less counts as this much; no power of it in use underflows.
  float cool_share;
  float warm_share;
  float silhouette;
  float min_shaded_weight;  ///< A sample that weighs less in the pixel is not shaded.
  float shades_per_root;    ///< Of the weight of one cell: spec::shades_of().

  float per_overlay;    ///< 1 / overlay, in cells; 1e30 for 0.
  float overlay_cells;  ///< 1e30 for infinity.
};

/// Rays in voxel indices, counted in cells from each ray's own base cell.
struct alignas(64) RayPacket {
  float origin[3][kPacketLanes];  ///< Index of sample 0: the begin of cell 0 pre-integrated, else
                                  ///< its middle.
  float step[3][kPacketLanes];    ///< Index per cell.
  float begin[kPacketLanes];      ///< Part to march, in cells; empty when end <= begin.
  float end[kPacketLanes];
  float rgb[3][kPacketLanes];  ///< Colour so far, premultiplied.
  float alpha[kPacketLanes];   ///< Opacity so far.
  // Only for marches that fade.
  float t1[kPacketLanes];              ///< Of the cutaway, in cells; -1e30: nowhere.
  float t2[kPacketLanes];              ///< As t1.
  float per_transition[kPacketLanes];  ///< 1 / (t2 - t1); 1e30 for 0.
  float margin[kPacketLanes];          ///< Rounding of Omega's break points, in cells.
  float value[kPacketLanes];           ///< What a projection found, HU.
};

/// The camera and the volume's box for starting rays: spec::View and spec::clip_to_box() in voxel
/// indices; vectors in voxels per mm.
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
  double first_sample;  ///< Where sample 0 lies in cell 0, in cells.
  int width;
  int height;
  bool orthographic;
  bool jitter;
};

/// Where the rays of a packet run through the volume.
struct RayStarts {
  double base[kPacketLanes];   ///< Begin of cell 0, in cells from the ray's origin.
  double begin[kPacketLanes];  ///< mm; empty when end <= begin, as for lanes beyond the picture.
  double end[kPacketLanes];
  bool any;  ///< Some lane is not empty.
};

/// The pixels of a packet's rays; lanes without one lie beyond the picture's width.
struct alignas(32) PacketPixels {
  std::int32_t x[kPacketLanes];
  std::int32_t y[kPacketLanes];
};

/// Starts the rays of a packet: all but the cutaway.
using RayStart = void (*)(const RayInputs&, const PacketPixels&, RayPacket&, RayStarts&);

struct MarchCounts {
  std::uint64_t samples;  ///< Values that lanes needed.
  std::uint64_t passed;   ///< That they did not: those of cells that are not visible.
  std::uint64_t gradients;
  std::uint64_t window_gradients;
  std::uint64_t faded;
};

enum class MarchClassify { kPreIntegrated, kPostClassified, kWindows };
enum class MarchShade { kNone, kPhong, kGooch };
/// Which cells a march takes: every one; those that MarchInputs::visible_cells has; or several as
/// one, only with kPreIntegrated.
enum class MarchCells { kAll, kVisible, kAdaptive };
enum class MarchProject { kMaximum, kMinimum, kMean };

/// What a march is compiled for: what a scene has not, costs nothing.
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
/// Keeps those objects of a choice that may decide for some ray of a block; returns a distance from
/// the foot that no surface exceeds there, mm.
using CutCull = float (*)(const CutObjects&, const CutBlock&, const CutChoice& in, CutChoice& out);
/// Fills t1 and t2 from the chosen objects.
using CutMeet = void (*)(const CutObjects&, const CutChoice&, CutRays&);

/// The camera in mm, the eye from the reference point of a cutaway.
struct CutView {
  double eye[3];
  double right[3];
  double up[3];
  double forward[3];
};
/// Fills the rays of a packet, and the distances of their feet from their origins, mm, kPacketLanes
/// of them.
using CutAim = void (*)(const RayInputs&, const CutView&, const PacketPixels&, CutRays&,
                        double* feet);

/// What is compiled for one instruction set.
struct MarchSet {
  March (*composite)(const MarchKey&);
  March (*project)(MarchProject);
  CutCull cull;
  CutMeet meet;
  RayStart start;
  CutAim aim;
};
MarchSet portable_marches();
// Ask for these through cpu_marches(): they need AVX2 and FMA, and what x86-64-v4 has.
MarchSet avx2_marches();
MarchSet avx512_marches();
MarchSet avx512_gathers_marches();  ///< Fetches voxels by gathers.

}  // namespace nav::render
