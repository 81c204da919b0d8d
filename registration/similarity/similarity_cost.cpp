// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/similarity/similarity_cost.hpp"

#include <algorithm>
#include <cmath>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace nav::registration {
namespace {

// Fixed size, so that the order of the sum does not depend on the threads.
constexpr std::size_t kPatchesPerChunk = 32;
// With fewer patches, threads cost more than they save: about 0.1 ms of work.
constexpr std::size_t kLeastParallelPatches = 400;

/// Converts the terms to a twist about a common centre instead of the patch's, which lies r from it
/// (Grid): MᵀHM and Mᵀg with M = patch_from_common(r), block by block.
void about_common(const Eigen::Vector3d& r, PatchTerms& terms) {
  const Eigen::Matrix3d cross = cross_matrix(r);
  const Eigen::Matrix3d c = terms.hessian.bottomRightCorner<3, 3>();
  // First the rows of translations, then those of rotations; Mᵀ adds [r]ₓ times the former to the
  // latter.
  const Eigen::Matrix3d b =
      Eigen::Matrix3d(terms.hessian.topRightCorner<3, 3>()) + cross.lazyProduct(c);
  const Eigen::Matrix3d old = terms.hessian.topRightCorner<3, 3>();
  const Eigen::Matrix3d turned = cross.lazyProduct(old.transpose());
  terms.hessian.topLeftCorner<3, 3>() += turned - b.lazyProduct(cross);
  terms.hessian.topRightCorner<3, 3>() = b;
  terms.hessian.bottomLeftCorner<3, 3>() = b.transpose();
  terms.gradient.head<3>() += r.cross(terms.gradient.tail<3>());
}

}  // namespace

GridPose grid_pose(const CtChannels& ct, const Pose& pose) {
  return {ct.directions.transpose() * pose.rotation().toRotationMatrix(),
          ct.grid_of(pose.translation_mm())};
}

PlacedPatch place(const PatchSet& set, std::size_t i, const GridPose& pose) {
  const Patch& patch = set.patches[i];
  return {.centre = pose.rotation * patch.centre_mm + pose.translation_mm,
          .step_a = pose.rotation * patch.step_a,
          .step_b = pose.rotation * patch.step_b,
          .beam = pose.rotation * patch.beam,
          .side = set.side,
          .u = set.u(i)};
}

Matrix6d patch_from_common(const Eigen::Vector3d& r) {
  Matrix6d m = Matrix6d::Identity();
  m.bottomLeftCorner<3, 3>() = -cross_matrix(r);
  return m;
}

Matrix6d grid_from_ct(const CtChannels& ct) {
  Matrix6d m = Matrix6d::Zero();
  m.topLeftCorner<3, 3>() =
      (ct.directions.determinant() < 0 ? -1.0 : 1.0) * ct.directions.transpose();
  m.bottomRightCorner<3, 3>() = ct.directions.transpose();
  return m;
}

SimilarityCost::SimilarityCost(const CtChannels& ct, const PatchSet& patches, double ridge,
                               int threads, const SimilarityMeasure& measure)
    : ct_(ct), patches_(patches), ridge_(ridge), threads_(threads), measure_(&measure) {
  NAV_CHECK(ridge > 0, ridge);
  NAV_CHECK(threads >= 1, threads);
}

template <class Visit>
void SimilarityCost::for_each_chunk(const Visit& visit) const {
  const std::size_t n = patches_.patches.size();
  const std::size_t chunks = (n + kPatchesPerChunk - 1) / kPatchesPerChunk;
  const auto run = [&](std::size_t chunk) {
    visit(chunk, chunk * kPatchesPerChunk, std::min((chunk + 1) * kPatchesPerChunk, n));
  };
  if (threads_ == 1 || n < kLeastParallelPatches) {
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) run(chunk);
    return;
  }
  tbb::task_arena arena(threads_);
  arena.execute([&] { tbb::parallel_for(std::size_t{0}, chunks, run); });
}

void SimilarityCost::look_ahead(const GridPose& pose) const {
  if (near_ == nullptr) return;
  std::vector<IndexedPatch> outside;
  for (std::size_t i = 0; i < patches_.patches.size(); ++i) {
    const std::size_t index = patches_.patches[i].index;
    const PlacedPatch placed = place(patches_, i, pose);
    if (!near_->sees(index, placed)) outside.push_back({index, placed});
  }
  if (!outside.empty()) near_->share(outside);
}

CostTerms SimilarityCost::cost(const Pose& ct_from_reference, bool keep_patches) const {
  if (const SampleMeasure* all = measure_->by_samples()) {
    return all->cost(ct_, patches_, ct_from_reference);
  }
  const PatchMeasure& measure = *measure_->by_patch();
  const GridPose pose = grid_pose(ct_, ct_from_reference);
  look_ahead(pose);
  std::vector<CostTerms> parts(patches_.patches.size() / kPatchesPerChunk + 1);
  std::vector<double> costs(keep_patches ? patches_.patches.size() : 0);
  for_each_chunk([&](std::size_t chunk, std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      PlacedPatch placed = place(patches_, i, pose);
      const CtChannels& ct = ct_near(i, placed);
      const double s = measure.cost(ct, placed, ridge_);
      const bool finite = !std::isnan(s);
      const double weighted = patches_.patches[i].weight * (finite ? loss_.value(s) : 1.0);
      parts[chunk].cost += weighted;
      if (keep_patches) costs[i] = weighted;
      parts[chunk].non_finite += finite ? 0 : 1;
    }
  });
  CostTerms sum;
  for (const CostTerms& part : parts) {
    sum.cost += part.cost;
    sum.non_finite += part.non_finite;
  }
  sum.patch_costs = std::move(costs);
  return sum;
}

CostTerms SimilarityCost::terms(const Pose& ct_from_reference, const Eigen::Vector3d& centre_ct_mm,
                                bool keep_patches) const {
  return sum_terms(true, ct_from_reference, centre_ct_mm, keep_patches);
}

CostTerms SimilarityCost::gradient(const Pose& ct_from_reference,
                                   const Eigen::Vector3d& centre_ct_mm,
                                   bool keep_patch_gradients) const {
  return sum_terms(false, ct_from_reference, centre_ct_mm, keep_patch_gradients);
}

PatchTerms SimilarityCost::patch(const PlacedPatch& placed, bool with_hessian) const {
  return terms_of(ct_, placed, with_hessian);
}

PatchTerms SimilarityCost::terms_of(const CtChannels& ct, const PlacedPatch& placed,
                                    bool with_hessian) const {
  NAV_CHECK(has_patch_terms(), measure_->name());
  PatchTerms terms = measure_->by_patch()->terms(ct, placed, ridge_, with_hessian);
  // The omitted part of the Hessian is negative: the solver needs a convex model.
  const double pull = loss_.derivative(terms.s);
  terms.gradient *= pull;
  if (with_hessian) terms.hessian *= pull;
  terms.s = loss_.value(terms.s);
  return terms;
}

CostTerms SimilarityCost::sum_terms(bool with_hessian, const Pose& ct_from_reference,
                                    const Eigen::Vector3d& centre_ct_mm,
                                    bool keep_patch_gradients) const {
  if (const SampleMeasure* all = measure_->by_samples()) {
    return all->terms(ct_, patches_, ct_from_reference, centre_ct_mm, keep_patch_gradients);
  }
  const GridPose pose = grid_pose(ct_, ct_from_reference);
  look_ahead(pose);
  const Eigen::Vector3d centre = ct_.grid_of(centre_ct_mm);
  std::vector<CostTerms> parts(patches_.patches.size() / kPatchesPerChunk + 1);
  std::vector<Vector6d> gradients(keep_patch_gradients ? patches_.patches.size() : 0);
  std::vector<double> costs(gradients.size());
  std::vector<Matrix6d> hessians(with_hessian ? gradients.size() : 0);
  for_each_chunk([&](std::size_t chunk, std::size_t begin, std::size_t end) {
    CostTerms& part = parts[chunk];
    for (std::size_t i = begin; i < end; ++i) {
      PlacedPatch placed = place(patches_, i, pose);
      const Eigen::Vector3d from_centre = placed.centre - centre;
      const CtChannels& ct = ct_near(i, placed);
      PatchTerms terms = terms_of(ct, placed, with_hessian);
      const double w = patches_.patches[i].weight;
      if (keep_patch_gradients) gradients[i].setZero();
      if (!hessians.empty()) hessians[i].setZero();
      if (keep_patch_gradients) costs[i] = w * (std::isnan(terms.s) ? 1 : terms.s);
      if (std::isnan(terms.s)) {
        part.cost += w;
        ++part.non_finite;
        continue;
      }
      about_common(from_centre, terms);
      part.cost += w * terms.s;
      part.gradient += w * terms.gradient;
      if (with_hessian) part.hessian += w * terms.hessian;
      if (keep_patch_gradients) gradients[i] = w * terms.gradient;
      if (!hessians.empty()) hessians[i] = w * terms.hessian;
    }
  });
  CostTerms sum;
  for (const CostTerms& part : parts) {
    sum.cost += part.cost;
    sum.gradient += part.gradient;
    sum.hessian += part.hessian;
    sum.non_finite += part.non_finite;
  }
  const Matrix6d to_grid = grid_from_ct(ct_);
  sum.gradient = to_grid.transpose() * sum.gradient;
  sum.hessian = to_grid.transpose() * sum.hessian * to_grid;
  sum.patch_costs = std::move(costs);
  sum.patch_gradients = std::move(gradients);
  for (Vector6d& g : sum.patch_gradients) g = to_grid.transpose() * g;
  sum.patch_hessians = std::move(hessians);
  for (Matrix6d& h : sum.patch_hessians) h = to_grid.transpose() * h * to_grid;
  return sum;
}

}  // namespace nav::registration
