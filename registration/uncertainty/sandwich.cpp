// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/uncertainty/sandwich.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <limits>
#include <map>
#include <set>
#include <sstream>
#include <utility>

#include "nav/index.hpp"
#include "nav/matrices.hpp"
#include "registration/assessment.hpp"
#include "registration/pose_solver.hpp"

namespace nav::registration {
namespace {

constexpr double kBlockMm = 20;
// The correction n/(n − 6) fails if the blocks hardly outnumber the parameters.
constexpr int kMinBlocks = 12;
// A well-conditioned sweep has 0.1; below this value a direction rests on noise.
constexpr double kMinCurvatureRatio = 1e-3;

constexpr std::size_t kHessianPatches = 600;

Matrix6d hessian_by_steps(const SimilarityCost& cost, const Pose& pose,
                          const Eigen::Vector3d& centre, double step_mm) {
  const Matrix6d scale = twist_from_scaled();
  Matrix6d h;
  for (Eigen::Index i = 0; i < 6; ++i) {
    const Vector6d step = scale.col(i) * step_mm;
    const Vector6d up = cost.gradient(moved(pose, centre, step), centre).gradient;
    const Vector6d down = cost.gradient(moved(pose, centre, -step), centre).gradient;
    h.col(i) = scale * (up - down) / (2 * step_mm);
  }
  return 0.5 * (h + h.transpose());
}

Matrix6d hessian_of(const CostsAround& around) {
  const Matrix6d scale = twist_from_scaled();
  Matrix6d h;
  for (Eigen::Index i = 0; i < 6; ++i) {
    const auto back = 2 * as_size(static_cast<int>(i));
    const double step = i < 3 ? kRotationScaleMm * around.turn_rad : kAroundMm;
    h.col(i) = scale *
               (around.beside[back + 1].terms.gradient - around.beside[back].terms.gradient) /
               (2 * step);
  }
  return 0.5 * (h + h.transpose());
}

/// Mean distance of the patches of one image from the plane of another, mm.
double way_mm(const std::vector<const Patch*>& from, const std::vector<const Patch*>& to) {
  const Patch& plane = *from.front();
  const Eigen::Vector3d normal = plane.step_a.cross(plane.step_b).normalized();
  double sum = 0;
  for (const Patch* patch : to) sum += std::abs(normal.dot(patch->centre_mm - plane.centre_mm));
  return sum / static_cast<double>(to.size());
}

/// Contribution of each image to the terms of all patches, in scaled parameters.
std::vector<ImageShape> shapes_of_images(const std::vector<Patch>& patches,
                                         const CostTerms& terms) {
  const Matrix6d scale = twist_from_scaled();
  std::map<int, std::vector<const Patch*>> patches_of;
  for (const Patch& patch : patches) patches_of[patch.frame].push_back(&patch);
  std::vector<ImageShape> images;
  const std::vector<const Patch*>* before = nullptr;
  for (const auto& [frame, of] : patches_of) {
    ImageShape image{.frame = frame,
                     .weight = 0,
                     .way_mm = 0,
                     .gradient = Vector6d::Zero(),
                     .hessian = Matrix6d::Zero()};
    if (before != nullptr) image.way_mm = way_mm(*before, of);
    for (const Patch* patch : of) {
      const auto i = static_cast<std::size_t>(patch - patches.data());
      image.weight += patch->weight;
      image.gradient += scale * terms.patch_gradients[i];
      if (!terms.patch_hessians.empty()) image.hessian += terms.patch_hessians[i];
    }
    // Without terms of single patches, an image gets its share by weight.
    if (terms.patch_hessians.empty()) image.hessian = image.weight * terms.hessian;
    image.hessian = scale * image.hessian * scale;
    images.push_back(image);
    before = &of;
  }
  return images;
}

/// n/(n−6) Σ g_b g_bᵀ in scaled parameters, and n.
std::pair<Matrix6d, int> block_scatter(const LocalShape& shape, const PatchSet& patches,
                                       const Pose& pose) {
  std::map<std::array<int, 3>, Vector6d> blocks;
  for (std::size_t i = 0; i < shape.patch_gradients.size(); ++i) {
    const Eigen::Vector3d p = (pose * Point<frames::Reference>{patches.patches[i].centre_mm}).mm;
    // Relative to the centre, so that a shift of the CT's origin has no effect.
    const Eigen::Array3d cell = ((p - shape.centre_ct.mm) / kBlockMm).array().floor();
    const std::array<int, 3> key{static_cast<int>(cell[0]), static_cast<int>(cell[1]),
                                 static_cast<int>(cell[2])};
    const auto [block, fresh] = blocks.try_emplace(key, Vector6d::Zero());
    block->second += shape.patch_gradients[i];
  }
  Matrix6d scatter = Matrix6d::Zero();
  for (const auto& [key, g] : blocks) scatter += g * g.transpose();
  const int n = static_cast<int>(blocks.size());
  if (n > 6) scatter *= static_cast<double>(n) / (n - 6);
  return {scatter, n};
}

std::string describe(const Vector6d& direction) {
  const bool rotation = direction.head<3>().squaredNorm() > direction.tail<3>().squaredNorm();
  Eigen::Vector3d axis = rotation ? direction.head<3>() : direction.tail<3>();
  axis.normalize();
  std::ostringstream text;
  text << std::fixed << std::setprecision(2) << (rotation ? "rotation about" : "translation along")
       << " Ct (" << axis.x() << ", " << axis.y() << ", " << axis.z() << ")";
  return text.str();
}

/// Correction of the curvature of every stride-th patch to that of all patches. It is estimated
/// from the Gauss–Newton Hessian, which is known for every patch, so that the result hardly depends
/// on the chosen patches.
Matrix6d missed_by(const std::vector<Patch>& patches, std::size_t stride, const LocalShape& shape) {
  constexpr double kMostShare = 2;  // Beyond this ratio the two Hessians are not comparable.
  if (shape.patch_hessians.empty()) return Matrix6d::Zero();
  Matrix6d of_all = Matrix6d::Zero();
  Matrix6d of_some = Matrix6d::Zero();
  double all = 0;
  double some = 0;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    of_all += shape.patch_hessians[i];
    all += patches[i].weight;
    if (i % stride != 0) continue;
    of_some += shape.patch_hessians[i];
    some += patches[i].weight;
  }
  if (!(some > 0)) return Matrix6d::Zero();
  const Matrix6d scale = twist_from_scaled();
  of_some *= all / some;
  const double share = shape.hessian.trace() / (scale * of_some * scale).trace();
  if (!(share > 0 && share < kMostShare)) return Matrix6d::Zero();
  return share * scale * (of_all - of_some) * scale;
}

/// All parts of the shape except the Hessian.
LocalShape gradients_of(const SimilarityCost& cost, const Pose& pose,
                        const Point<frames::Ct>& centre_ct) {
  LocalShape shape{centre_ct, Matrix6d::Zero(), {}, {}};
  CostTerms terms = cost.terms(pose, centre_ct.mm, true);
  shape.images = shapes_of_images(cost.patches().patches, terms);
  shape.patch_gradients = std::move(terms.patch_gradients);
  for (Vector6d& g : shape.patch_gradients) g = twist_from_scaled() * g;
  shape.patch_hessians = std::move(terms.patch_hessians);
  return shape;
}

}  // namespace

Matrix6d twist_from_scaled() {
  Vector6d diagonal = Vector6d::Ones();
  diagonal.head<3>() /= kRotationScaleMm;
  return diagonal.asDiagonal();
}

std::string curvature_fault(const Matrix6d& hessian) {
  if (!hessian.allFinite()) return "expected a finite curvature of the cost, found NaN or Inf";
  const auto eigen = eigenpairs(hessian);
  const double weakest = eigen.values[0];
  const double strongest = eigen.values[5];
  if (weakest > kMinCurvatureRatio * strongest && strongest > 0) return "";
  std::ostringstream fault;
  fault << "the sweep does not determine the " << describe(eigen.vectors.col(0)) << ": ";
  if (weakest < 0) {
    fault << "the pose is not a minimum of the cost along it";
  } else {
    fault << "expected a curvature ratio above " << kMinCurvatureRatio << ", found "
          << (strongest > 0 ? weakest / strongest : weakest);
  }
  return fault.str();
}

LocalShape local_shape(const SimilarityCost& cost, const Pose& pose,
                       const Point<frames::Ct>& centre_ct, double step_mm) {
  LocalShape shape = gradients_of(cost, pose, centre_ct);
  const std::vector<Patch>& patches = cost.patches().patches;
  const std::size_t stride =
      std::max<std::size_t>((patches.size() + kHessianPatches - 1) / kHessianPatches, 1);
  std::size_t index = 0;
  const PatchSet some = subset(cost.patches(), [&](const Patch&) { return index++ % stride == 0; });
  shape.hessian = hessian_by_steps(cost.on(some), pose, centre_ct.mm, step_mm);
  if (stride > 1) shape.hessian += missed_by(patches, stride, shape);
  return shape;
}

LocalShape local_shape(const SimilarityCost& cost, const Point<frames::Ct>& centre_ct,
                       const CostsAround& around) {
  LocalShape shape = gradients_of(cost, around.pose, centre_ct);
  shape.hessian = hessian_of(around);
  return shape;
}

Disagreement disagreement(const LocalShape& shape, const PatchSet& patches,
                          const SweepPoints& sweep, const Pose& pose, Halves halves) {
  const auto unknown = [](std::string fault) {
    return Disagreement{std::numeric_limits<double>::infinity(), std::move(fault)};
  };
  std::set<int> frames;
  for (const Patch& patch : patches.patches) frames.insert(patch.frame);
  const std::vector<int> order(frames.begin(), frames.end());
  // Images are thinned by the distance between them.
  if (order.size() == 1) {
    return unknown("expected images with patches at two or more positions, found one position");
  }
  std::array<Vector6d, 2> gradient{Vector6d::Zero(), Vector6d::Zero()};
  std::array<double, 2> weight{0, 0};
  std::array<std::size_t, 2> count{0, 0};
  for (std::size_t i = 0; i < patches.patches.size(); ++i) {
    const auto at = std::lower_bound(order.begin(), order.end(), patches.patches[i].frame);
    const auto rank = static_cast<std::size_t>(at - order.begin());
    const bool second = halves == Halves::kOddEven ? rank % 2 == 1 : 2 * rank >= order.size();
    const std::size_t half = second ? 1 : 0;
    gradient[half] += shape.patch_gradients[i];
    weight[half] += patches.patches[i].weight;
    ++count[half];
  }
  const std::size_t fewest = std::min(count[0], count[1]);
  if (fewest < kMinPatches) {
    return unknown("expected at least " + std::to_string(kMinPatches) +
                   " patches in each half, found " + std::to_string(fewest));
  }
  const Eigen::LLT<Matrix6d> llt(shape.hessian);
  if (llt.info() != Eigen::Success) return unknown(curvature_fault(shape.hessian));
  const Vector6d apart =
      twist_from_scaled() * llt.solve(gradient[0] / weight[0] - gradient[1] / weight[1]);
  const Eigen::Matrix3d turn = cross_matrix(apart.head<3>());
  const Eigen::Vector3d shift =
      turn * ((pose * sweep.centroid) - shape.centre_ct).v + apart.tail<3>();
  const double rms =
      std::sqrt(shift.squaredNorm() + spread_mm2(sweep, turn * pose.rotation().toRotationMatrix()));
  if (!std::isfinite(rms))
    return unknown("expected finite gradients of the cost, found NaN or Inf");
  return {rms, ""};
}

SandwichCovariance sandwich_covariance(const LocalShape& shape, const PatchSet& patches,
                                       const Pose& pose, double bias_floor_mm) {
  SandwichCovariance result{{shape.centre_ct, Matrix6d::Zero()}, false, ""};
  const auto [scatter, blocks] = block_scatter(shape, patches, pose);
  std::ostringstream fault;
  if (blocks < kMinBlocks) {
    fault << "expected the patches to spread over at least " << kMinBlocks
          << " cubes of 20 mm, found " << blocks;
    result.fault = fault.str();
    return result;
  }
  const Matrix6d& h = shape.hessian;
  result.fault = scatter.allFinite() ? curvature_fault(h) : curvature_fault(scatter);
  if (!result.fault.empty()) return result;
  const Matrix6d inverse = symmetric_inverse(h);
  Matrix6d sigma = inverse * scatter * inverse;
  sigma += bias_floor_mm * bias_floor_mm * Matrix6d::Identity();
  const Matrix6d scale = twist_from_scaled();
  sigma = scale * sigma * scale;
  result.uncertainty.covariance = 0.5 * (sigma + sigma.transpose());
  result.valid = true;
  return result;
}

}  // namespace nav::registration
