// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "nav/result.hpp"
#include "registration/twist.hpp"
#include "registration/uncertainty/pose_uncertainty.hpp"

/// What other pictures of the same patient might have found: pictures drawn anew.
namespace nav::registration {

struct LocalShape;
struct SandwichCovariance;

/// How to draw pictures anew.
struct BootstrapOptions {
  int replicates = 400;  ///< 20 to 100 000, or 0: none.
  /// Way of the pictures that are drawn together, about the thickness of a slice: they share their
  /// speckle. mm, [0, 1000].
  double block_mm = 3;
  std::uint64_t seed = 1;
};

/// A refusal that names the first option out of its range.
Result<void> validate(const BootstrapOptions& options);

/// Pictures drawn with replacement, in blocks of neighbours (circular block bootstrap, Politis and
/// Romano 1992).
class PictureDraws {
 public:
  /// way_mm: from each picture to the next, one less than pictures.
  PictureDraws(const std::vector<double>& way_mm, const BootstrapOptions& options);

  /// Pictures of a block, 1 to all.
  [[nodiscard]] int block() const { return block_; }
  /// Blocks of a replicate: as many as come nearest to all pictures.
  [[nodiscard]] int blocks() const { return blocks_; }
  /// First picture of each block of a replicate; a block goes on at the first after the last. The
  /// same for the same seed, whatever was asked for before.
  [[nodiscard]] std::vector<int> starts(int replicate) const;
  /// How often each picture is drawn for a replicate.
  [[nodiscard]] std::vector<int> counts(int replicate) const;

 private:
  int pictures_, block_, blocks_;
  std::uint64_t seed_;
};

/// Where replicates end, or why there are none.
struct FrameBootstrap {
  Point<frames::Ct> centre_ct{Eigen::Vector3d::Zero()};  ///< Of the twists.
  std::vector<Vector6d> twists;  ///< Of each replicate from the pose of all pictures, [rad | mm].
  int pictures = 0;              ///< That have patches.
  int block = 0;                 ///< Pictures drawn together.
  int places = 0;    ///< How many blocks the pictures make up; 0 where none was asked for.
  int unsolved = 0;  ///< Replicates that do not determine the pose: without a twist.
  bool valid = false;
  std::string fault = "not asked for";  ///< One sentence; empty when valid.

  /// Mean outer product of the twists; zero unless valid.
  [[nodiscard]] PoseUncertainty uncertainty() const;
  /// Target error, RMS of the replicates, mm; infinite unless valid.
  [[nodiscard]] double tre_rms_mm(const Point<frames::Ct>& target) const;
  /// What this share of the replicates' target errors stays below, share in [0, 1], mm; infinite
  /// unless valid.
  [[nodiscard]] double tre_quantile_mm(const Point<frames::Ct>& target, double share) const;
};

/// Fewer pictures say nothing of how pictures differ.
inline constexpr int kLeastPictures = 6;
inline constexpr int kLeastPlaces = 3;

/// Each replicate is one Newton step −H_r⁻¹ g_r from the pose of all pictures, with the gradients
/// and the Hessians of the pictures that were drawn: no picture is looked at again. The Hessians
/// are Gauss–Newton's, mapped so that those of all pictures together are the true one. Pictures
/// without weight are not drawn. Same arguments give the same bits. Not valid: fewer than
/// kLeastPictures, fewer than kLeastPlaces, which draws hardly differ by, a pose that is not
/// determined, by all pictures or in more than a tenth of the replicates.
FrameBootstrap frame_bootstrap(const LocalShape& shape, const BootstrapOptions& options);

/// The covariance of a registration: of the clusters of patches and of the replicates, the larger
/// in every direction, each with bias_floor_mm as sandwich_covariance() has it. That of the
/// clusters where there are no replicates, or where it is not valid itself.
PoseUncertainty with_bootstrap(const SandwichCovariance& clusters, const FrameBootstrap& bootstrap,
                               double bias_floor_mm);

}  // namespace nav::registration
