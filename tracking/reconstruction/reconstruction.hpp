// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "nav/scan_line.hpp"
#include "nav/sweep.hpp"
#include "nav/volume.hpp"
#include "tracking/reconstruction/image_area.hpp"

namespace nav::tracking {

/// Way from pixels to voxels (docs/reconstruction.md has the equations).
enum class ReconstructionMethod {
  kNearest,    ///< Each pixel goes to the voxel that it lies in.
  kTrilinear,  ///< Each pixel goes to the eight voxels around it, by trilinear weights.
  kGaussian,   ///< Each pixel goes to the voxels around it, by a Gaussian of the distance.
  kBackward,   ///< Each voxel is sampled in the images that pass it, weighted by orientation.
};

/// Way from the values that reach a voxel to its value. Splatted values count for maximum, median
/// and latest where their weight is at least 1/8, as in PLUS; weights matter for the mean and, in
/// the backward method, for the median.
enum class Compounding { kMean, kMedian, kMaximum, kLatest };

struct ReconstructionOptions {
  ReconstructionMethod method = ReconstructionMethod::kNearest;
  Compounding compounding = Compounding::kMean;
  /// Standard deviation of the Gaussian, voxels, [0.3, 2]; it ends at two of them.
  double gaussian_voxels = 0.5;
  /// Backward: greatest distance of a voxel from an image that it takes values of, mm, (0, 100].
  double reach_mm = 1;
  /// Every pixel counts by its confidence, which add() takes. Only for the mean and, in the
  /// backward method, the median.
  bool by_confidence = false;
  int threads = 0;  ///< 0: all cores. The result does not depend on it.
};
/// Rejects numbers out of range, and by_confidence where weights have no effect.
Result<void> validate(const ReconstructionOptions& options);

/// Value of voxels that no image reached; all others are in [0, 255].
inline constexpr std::int16_t kUnseenVoxel = -1;

/// Interruption and progress of a long computation.
struct ReconstructionRun {
  std::stop_token stop{};
  /// Receives the share done, [0, 1], from any thread; may be empty.
  std::function<void(double)> progress = {};
};

/// Memory that a reconstruction takes at most, bytes: voxels, and for the median and the backward
/// method the values or images that it keeps. \p pixels: of the areas of all images together.
double reconstruction_bytes(const VoxelGridIn<frames::Reference>& grid,
                            const ReconstructionOptions& options, double pixels);

/// A volume that grows image by image. The state after any number of images can be read at any
/// time. The same images in the same order give the same bytes with any number of threads. One
/// thread calls it.
///
/// Limits: 2^31 voxels; 2^24 pixels in one voxel.
class Reconstruction {
 public:
  /// Rejects invalid options and grids.
  static Result<Reconstruction> create(const VoxelGridIn<frames::Reference>& grid,
                                       const ReconstructionOptions& options);
  ~Reconstruction();
  Reconstruction(Reconstruction&&) noexcept;
  Reconstruction& operator=(Reconstruction&&) noexcept;

  /// Adds the pixels of the area. Pixels whose voxels are not all in the grid are left out.
  /// Precondition: area.fits(image.frame), otherwise a Bug.
  /// \p confidence: of every pixel, 0 to 255; a pixel counts (confidence + 1) / 256. Of the image's
  /// size exactly where the options ask for it, otherwise empty; anything else is a Bug.
  void add(const TrackedImage& image, const std::shared_ptr<const ImageArea>& area,
           const Image2d<std::uint8_t>& confidence = {});

  [[nodiscard]] const VoxelGridIn<frames::Reference>& grid() const;
  /// Voxels as they are now, i fastest: rounded to [0, 255], or kUnseenVoxel. kCancelled when
  /// stopped. The backward method computes here, and only slices that changed since the last call.
  Result<std::vector<std::int16_t>> values(const ReconstructionRun& run = {});
  /// Scan lines of the voxels at the last call of values(); empty unless the method is backward.
  [[nodiscard]] std::span<const ScanLineAtVoxel> scan_lines() const;

  /// One method of reconstruction; an implementation detail.
  class Engine;

 private:
  explicit Reconstruction(std::unique_ptr<Engine> engine);
  std::unique_ptr<Engine> engine_;
};

}  // namespace nav::tracking
