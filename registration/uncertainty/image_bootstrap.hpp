// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nav/result.hpp"
#include "registration/twist.hpp"
#include "registration/uncertainty/pose_uncertainty.hpp"

/// The variation of the pose for other ultrasound images of the same patient, by bootstrap
/// resampling of the images.
namespace nav::registration {

struct LocalShape;
struct SandwichCovariance;

/// Options that resample the ultrasound images.
struct BootstrapOptions {
  int replicates = 400;  ///< 20 to 100 000, or 0: no bootstrap.
  /// Path length of the images that are drawn together, about the thickness of a slice: they share
  /// their speckle. mm, [0, 1000].
  double block_mm = 3;
  std::uint64_t seed = 1;
};

/// Returns an error that names the first option that is out of its range.
Result<void> validate(const BootstrapOptions& options);

/// Draws ultrasound images with replacement, in blocks of neighbours (circular block bootstrap,
/// Politis and Romano 1992).
class ImageDraws {
 public:
  /// way_mm: distances from each image to the next, one fewer than images.
  ImageDraws(const std::vector<double>& way_mm, const BootstrapOptions& options);

  /// Images in a block, 1 to all.
  [[nodiscard]] int block() const { return block_; }
  /// Blocks in a replicate: the number that comes nearest to all images.
  [[nodiscard]] int blocks() const { return blocks_; }
  /// First image of each block of a replicate; a block continues at the first image after the last.
  /// The same seed gives the same result, independent of earlier calls.
  [[nodiscard]] std::vector<int> starts(int replicate) const;
  /// Number of times that each image is drawn for a replicate.
  [[nodiscard]] std::vector<int> counts(int replicate) const;

 private:
  int images_, block_, blocks_;
  std::uint64_t seed_;
};

/// Poses of the replicates, or the reason why there are none.
struct ImageBootstrap {
  Point<frames::Ct> centre_ct{Eigen::Vector3d::Zero()};  ///< Centre of the twists.
  /// Twist of each replicate from the pose of all images, [rad | mm].
  std::vector<Vector6d> twists;
  int images = 0;    ///< Images that have patches.
  int block = 0;     ///< Images drawn together.
  int places = 0;    ///< Number of blocks in the images; 0 if no bootstrap was requested.
  int unsolved = 0;  ///< Replicates that do not determine the pose; they have no twist.
  bool valid = false;
  std::string fault = "not requested";  ///< One sentence; empty when valid.

  /// Mean outer product of the twists; zero unless valid.
  [[nodiscard]] PoseUncertainty uncertainty() const;
  /// Target error, RMS over the replicates, mm; infinite unless valid.
  [[nodiscard]] double tre_rms_mm(const Point<frames::Ct>& target) const;
  /// Quantile \p share, in [0, 1], of the replicates' target errors, mm; infinite unless valid.
  [[nodiscard]] double tre_quantile_mm(const Point<frames::Ct>& target, double share) const;
};

/// Fewer images do not show how images differ.
inline constexpr int kLeastImages = 6;
inline constexpr int kLeastPlaces = 3;

/// Each replicate is one Newton step −H_r⁻¹ g_r from the pose of all images, with the gradients and
/// Hessians of the drawn images; no image is evaluated again. The Hessians are Gauss–Newton's,
/// mapped so that their sum over all images is the true Hessian. Images without weight are not
/// drawn. The same arguments give the same bits. The result is not valid with fewer than
/// kLeastImages images, with fewer than kLeastPlaces blocks (the draws would hardly differ), or
/// if the pose is not determined by all images or in more than a tenth of the replicates.
ImageBootstrap image_bootstrap(const LocalShape& shape, const BootstrapOptions& options);

/// The covariance of a registration: the larger in every direction of that of the clusters of
/// patches and that of the replicates, each with bias_floor_mm as in sandwich_covariance(). It is
/// that of the clusters if there are no valid replicates, or if the clusters' covariance itself is
/// not valid.
PoseUncertainty with_bootstrap(const SandwichCovariance& clusters, const ImageBootstrap& bootstrap,
                               double bias_floor_mm);

}  // namespace nav::registration
