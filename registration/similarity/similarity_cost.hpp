// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "nav/transform.hpp"
#include "registration/similarity/ct_channels.hpp"
#include "registration/similarity/lc2_kernel.hpp"
#include "registration/similarity/patch_channels.hpp"
#include "registration/similarity/patch_loss.hpp"
#include "registration/similarity/patches.hpp"
#include "registration/similarity/similarity_measure.hpp"
#include "registration/twist.hpp"

namespace nav::registration {

/// E = Σ wᵢ sᵢ of a patch set at a pose, and the derivatives of E/2.
struct CostTerms {
  double cost = 0;                        ///< [0, 1]; a patch that is not finite counts as 1.
  Vector6d gradient = Vector6d::Zero();   ///< Gradient by a twist [rad | mm] about the centre, Ct.
  Matrix6d hessian = Matrix6d::Zero();    ///< Gauss–Newton, the same twist.
  int non_finite = 0;                     ///< Patches whose term was not finite.
  std::vector<Vector6d> patch_gradients;  ///< wᵢ gᵢ of each patch if requested, else empty.
  /// wᵢ Hᵢ of each patch if requested from terms(); empty without terms of single patches.
  std::vector<Matrix6d> patch_hessians;
  /// wᵢ sᵢ of each patch if requested; empty without terms of single patches.
  std::vector<double> patch_costs;
};

/// ct_from_reference followed by the change to Grid axes.
struct GridPose {
  Eigen::Matrix3d rotation;  ///< May reflect.
  Eigen::Vector3d translation_mm;
};

GridPose grid_pose(const CtChannels& ct, const Pose& pose);

/// Patch i of a set at a pose.
PlacedPatch place(const PatchSet& set, std::size_t i, const GridPose& pose);

/// Converts a twist about a common centre to one about a patch centre, r apart (Grid):
/// t_patch = t + ω × r.
Matrix6d patch_from_common(const Eigen::Vector3d& r);

/// Converts a Ct twist to a Grid twist. A rotation is an axial vector: it changes sign under
/// reflection.
Matrix6d grid_from_ct(const CtChannels& ct);

/// The cost of a patch set by one measure, LC² by default: thread-safe to read. Keeps references to
/// ct and patches.
class SimilarityCost {
 public:
  /// Preconditions: ridge > 0, threads >= 1, otherwise a Bug.
  SimilarityCost(const CtChannels& ct, const PatchSet& patches, double ridge, int threads,
                 const SimilarityMeasure& measure = measure_of(Similarity::kLc2));

  /// Cost only; takes a bit more than half the time of terms().
  [[nodiscard]] CostTerms cost(const Pose& ct_from_reference, bool keep_patches = false) const;
  /// Cost, gradient and Gauss–Newton Hessian by a twist about centre_ct_mm. Sums are taken over
  /// fixed chunks, so that the result has the same bits for any number of threads.
  [[nodiscard]] CostTerms terms(const Pose& ct_from_reference, const Eigen::Vector3d& centre_ct_mm,
                                bool keep_patches = false) const;
  /// terms() without the Hessian, which is 0, in less time; a SampleMeasure computes both.
  [[nodiscard]] CostTerms gradient(const Pose& ct_from_reference,
                                   const Eigen::Vector3d& centre_ct_mm,
                                   bool keep_patch_gradients = false) const;
  [[nodiscard]] const PatchSet& patches() const { return patches_; }
  [[nodiscard]] const CtChannels& ct() const { return ct_; }
  /// False for a measure of all samples together.
  [[nodiscard]] bool has_patch_terms() const { return measure_->by_patch() != nullptr; }
  /// Contribution of one patch to terms(), without its weight; s is NaN if it is not finite.
  /// Precondition: has_patch_terms(), otherwise a Bug.
  [[nodiscard]] PatchTerms patch(const PlacedPatch& placed, bool with_hessian = true) const;
  /// This cost of other patches, which must outlive the result.
  [[nodiscard]] SimilarityCost on(const PatchSet& patches) const {
    return SimilarityCost(ct_, patches, ridge_, threads_, *measure_).robust(loss_).where(near_);
  }
  /// This cost with the CT channels near each patch, by its index; null: those of ct().
  /// Do not use it with a SampleMeasure or patch(), which read ct(), nor for two evaluations at
  /// once.
  [[nodiscard]] SimilarityCost where(PatchChannels* near) const {
    SimilarityCost same(*this);
    same.near_ = near;
    return same;
  }
  /// This cost with a loss on every patch's term. It has no effect without terms of single
  /// patches.
  [[nodiscard]] SimilarityCost robust(const RobustLoss& loss) const {
    SimilarityCost same(*this);
    same.loss_ = loss;
    return same;
  }

 private:
  template <class Visit>
  void for_each_chunk(const Visit& visit) const;
  /// Prepares the channels that patches at this pose need outside their boxes, for all patches at
  /// once.
  void look_ahead(const GridPose& pose) const;
  /// The channels that patch i needs; moves the patch into their Grid.
  [[nodiscard]] const CtChannels& ct_near(std::size_t i, PlacedPatch& placed) const {
    return near_ != nullptr ? near_->around(patches_.patches[i].index, placed) : ct_;
  }
  [[nodiscard]] PatchTerms terms_of(const CtChannels& ct, const PlacedPatch& placed,
                                    bool with_hessian) const;
  [[nodiscard]] CostTerms sum_terms(bool with_hessian, const Pose& ct_from_reference,
                                    const Eigen::Vector3d& centre_ct_mm,
                                    bool keep_patch_gradients) const;

  const CtChannels& ct_;
  const PatchSet& patches_;
  double ridge_;
  int threads_;
  const SimilarityMeasure* measure_;
  RobustLoss loss_;
  PatchChannels* near_ = nullptr;
};

}  // namespace nav::registration
