// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/deformable_registration.hpp"

#include <Eigen/SparseCholesky>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "nav/check.hpp"
#include "registration/lc2_kernel.hpp"
#include "registration/paired_gain.hpp"

namespace nav::registration {
namespace {

using Vec = Eigen::Vector3d;
using Sparse = Eigen::SparseMatrix<double>;

/// A patch at its rigid place; a displacement moves it as a whole.
struct RestingPatch {
  Vec centre_ct;
  Vec step_a, step_b, beam;  ///< Grid.
  double weight;
  int frame;
  std::size_t index;  ///< In the set.
};

/// LC² of patches under a displacement field.
class DeformedCost {
 public:
  DeformedCost(const CtChannels& ct, const PatchSet& set, const Pose& pose,
               const DeformableOptions& options)
      : ct_(ct), set_(set), ridge_(options.ridge) {
    const Eigen::Matrix3d turn = ct.directions.transpose() * pose.rotation().toRotationMatrix();
    for (std::size_t i = 0; i < set.patches.size(); ++i) {
      const Patch& p = set.patches[i];
      patches_.push_back({(pose * Point<frames::Reference>{p.centre_mm}).mm, turn * p.step_a,
                          turn * p.step_b, turn * p.beam,
                          std::pow(p.weight, options.contrast_power / kPatchWeightPower), p.frame,
                          i});
    }
    double total = 0;
    for (const RestingPatch& p : patches_) total += p.weight;
    for (RestingPatch& p : patches_) p.weight /= total;
  }
  [[nodiscard]] const std::vector<RestingPatch>& patches() const { return patches_; }
  [[nodiscard]] PlacedPatch placed(const RestingPatch& p, const Vec& displacement) const {
    return {ct_.grid_of(p.centre_ct + displacement),
            p.step_a,
            p.step_b,
            p.beam,
            set_.side,
            set_.u(p.index)};
  }
  [[nodiscard]] double cost(const RestingPatch& p, const Vec& displacement) const {
    return patch_cost(ct_, placed(p, displacement), ridge_);
  }
  /// Gradient and Hessian of s/2 by the displacement, Ct.
  [[nodiscard]] std::pair<Vec, Eigen::Matrix3d> slope(const RestingPatch& p,
                                                      const Vec& displacement) const {
    const PatchTerms terms = patch_terms(ct_, placed(p, displacement), ridge_);
    return {ct_.directions * terms.gradient.tail<3>(),
            ct_.directions * terms.hessian.bottomRightCorner<3, 3>() * ct_.directions.transpose()};
  }

 private:
  const CtChannels& ct_;
  const PatchSet& set_;
  double ridge_;
  std::vector<RestingPatch> patches_;
};

/// One fit of a field to some of the pictures.
class Fit {
 public:
  Fit(const DeformedCost& cost, const std::function<bool(int)>& uses_frame,
      const SplineField& empty, const DeformableOptions& options)
      : cost_(cost), field_(empty), options_(options) {
    for (const RestingPatch& patch : cost.patches()) {
      if (!uses_frame(patch.frame)) continue;
      used_.push_back({patch, empty.reach(patch.centre_ct)});
      total_weight_ += patch.weight;
    }
    const Sparse scalar = empty.bending();
    std::vector<Eigen::Triplet<double>> triplets;
    for (int column = 0; column < scalar.outerSize(); ++column) {
      for (Sparse::InnerIterator it(scalar, column); it; ++it) {
        for (int axis = 0; axis < 3; ++axis) {
          triplets.emplace_back(3 * static_cast<int>(it.row()) + axis, 3 * column + axis,
                                options.bending * it.value());
        }
      }
    }
    bending_.resize(scalar.rows() * 3, scalar.cols() * 3);
    bending_.setFromTriplets(triplets.begin(), triplets.end());
  }

  /// False: a cost was not finite.
  bool run() {
    double value = objective(field_.coefficients());
    if (!std::isfinite(value)) return false;
    double damping = 1e-3;
    for (iterations_ = 0; iterations_ < options_.max_iterations && damping < 1e6; ++iterations_) {
      const Eigen::VectorXd step = newton_step(damping);
      const Eigen::VectorXd next = field_.coefficients() + step;
      const double there = step.allFinite() ? objective(next) : value;
      if (!(there < value)) {
        damping *= 10;
        continue;
      }
      field_.set_coefficients(next);
      damping = std::max(damping / 10, 1e-6);
      const bool done = value - there < 1e-7;
      value = there;
      if (done) break;
    }
    return true;
  }
  [[nodiscard]] const SplineField& field() const { return field_; }
  [[nodiscard]] int iterations() const { return iterations_; }

 private:
  struct Used {
    RestingPatch patch;
    SplineField::Reach reach;
  };
  static Vec at(const SplineField::Reach& reach, const Eigen::VectorXd& c) {
    Vec sum = Vec::Zero();
    for (std::size_t n = 0; n < static_cast<std::size_t>(reach.count); ++n) {
      sum += reach.weight[n] * c.segment<3>(3 * reach.index[n]);
    }
    return sum;
  }
  [[nodiscard]] double objective(const Eigen::VectorXd& c) const {
    double sum = 0;
    for (const Used& used : used_) {
      sum += used.patch.weight / total_weight_ * cost_.cost(used.patch, at(used.reach, c));
    }
    return 0.5 * sum + 0.5 * c.dot(bending_ * c);
  }
  [[nodiscard]] Eigen::VectorXd newton_step(double damping) const {
    const Eigen::VectorXd& c = field_.coefficients();
    Eigen::VectorXd gradient = bending_ * c;
    // The same control points meet in many patches: sum their blocks before the matrix is made.
    std::map<std::pair<int, int>, Eigen::Matrix3d> blocks;
    for (const Used& used : used_) {
      const auto [g, h] = cost_.slope(used.patch, at(used.reach, c));
      const double w = used.patch.weight / total_weight_;
      for (std::size_t a = 0; a < static_cast<std::size_t>(used.reach.count); ++a) {
        const double wa = w * used.reach.weight[a];
        gradient.segment<3>(3 * used.reach.index[a]) += wa * g;
        if (used.reach.weight[a] < kNegligible) continue;
        for (std::size_t b = 0; b < static_cast<std::size_t>(used.reach.count); ++b) {
          if (used.reach.weight[b] < kNegligible || used.reach.index[b] > used.reach.index[a]) {
            continue;
          }
          auto [block, fresh] = blocks.try_emplace({used.reach.index[a], used.reach.index[b]},
                                                   Eigen::Matrix3d::Zero());
          block->second += wa * used.reach.weight[b] * h;
        }
      }
    }
    return solve(blocks, gradient, damping);
  }
  [[nodiscard]] Eigen::VectorXd solve(const std::map<std::pair<int, int>, Eigen::Matrix3d>& blocks,
                                      const Eigen::VectorXd& gradient, double damping) const {
    std::vector<Eigen::Triplet<double>> triplets;
    triplets.reserve(9 * blocks.size());
    for (const auto& [place, block] : blocks) {
      for (int r = 0; r < 3; ++r) {
        for (int k = 0; k < 3; ++k) {
          triplets.emplace_back(3 * place.first + r, 3 * place.second + k, block(r, k));
        }
      }
    }
    Sparse data(bending_.rows(), bending_.cols());
    data.setFromTriplets(triplets.begin(), triplets.end());
    Sparse matrix = data + Sparse(bending_.triangularView<Eigen::Lower>());
    for (int i = 0; i < matrix.rows(); ++i) matrix.coeffRef(i, i) *= 1 + damping;
    const Eigen::SimplicialLDLT<Sparse, Eigen::Lower> factor(matrix);
    if (factor.info() != Eigen::Success) {
      return Eigen::VectorXd::Constant(gradient.size(), std::nan(""));
    }
    return -factor.solve(gradient);
  }

  // Of a step; the gradient has all of it.
  static constexpr double kNegligible = 1e-4;
  const DeformedCost& cost_;
  SplineField field_;
  const DeformableOptions& options_;
  std::vector<Used> used_;
  double total_weight_ = 0;
  Sparse bending_;
  int iterations_ = 0;
};

/// Mean cost of a picture's patches without and with a field.
struct PictureCost {
  double rigid = 0, deformed = 0, weight = 0;
};

void add_held_out(const DeformedCost& cost, const SplineField& field,
                  const std::function<bool(int)>& holds, std::map<int, PictureCost>& pictures) {
  for (const RestingPatch& patch : cost.patches()) {
    if (!holds(patch.frame)) continue;
    PictureCost& picture = pictures[patch.frame];
    picture.rigid += patch.weight * cost.cost(patch, Vec::Zero());
    picture.deformed += patch.weight * cost.cost(patch, field.displacement(patch.centre_ct));
    picture.weight += patch.weight;
  }
}

double mean_cost(const DeformedCost& cost, const SplineField* field) {
  double sum = 0;
  for (const RestingPatch& p : cost.patches()) {
    const Vec shift = field != nullptr ? field->displacement(p.centre_ct) : Vec::Zero();
    sum += p.weight * cost.cost(p, shift);
  }
  return sum;
}

CtBox box_of_patches(const DeformedCost& cost) {
  CtBox box{Vec::Constant(1e300), Vec::Constant(-1e300)};
  for (const RestingPatch& p : cost.patches()) {
    box.low = box.low.cwiseMin(p.centre_ct);
    box.high = box.high.cwiseMax(p.centre_ct);
  }
  return box;
}

void weigh(const std::map<int, PictureCost>& pictures, DeformableResult& result) {
  PairedGain gain;
  for (const auto& [frame, p] : pictures) {
    result.held_out_rigid += p.rigid / p.weight / static_cast<double>(pictures.size());
    result.held_out_deformed += p.deformed / p.weight / static_cast<double>(pictures.size());
    gain.add((p.rigid - p.deformed) / p.weight);
  }
  result.gain_sigmas = gain.sigmas();
}

}  // namespace

Result<void> validate(const DeformableOptions& o) {
  const auto refuse = [](const char* what) {
    return Error{ErrorCode::kUsage, std::string("deformable registration: expected ") + what};
  };
  if (!(o.spacing_mm >= 10 && o.spacing_mm <= 200)) return refuse("a spacing of 10 to 200 mm");
  if (!(o.bending > 0 && std::isfinite(o.bending))) return refuse("bending > 0");
  if (o.max_iterations < 1 || o.max_iterations > 100) return refuse("1 to 100 iterations");
  if (!(o.ridge > 0 && std::isfinite(o.ridge))) return refuse("ridge > 0");
  if (!(o.contrast_power >= 0 && o.contrast_power <= 3)) return refuse("contrast_power in [0, 3]");
  if (!(o.min_gain_share >= 0 && o.min_gain_share < 1)) return refuse("min_gain_share in [0, 1)");
  if (!(o.min_gain_sigmas > 0)) return refuse("min_gain_sigmas > 0");
  if (!(o.min_determinant > 0 && o.min_determinant < 1)) return refuse("min_determinant in (0, 1)");
  return {};
}

Result<DeformableResult> refine_deformable(const CtChannels& ct, const PatchSet& patches,
                                           const Pose& ct_from_reference,
                                           const DeformableOptions& options) {
  if (const auto ok = validate(options); !ok) return ok.error();
  std::set<int> numbers;
  for (const Patch& patch : patches.patches) numbers.insert(patch.frame);
  if (numbers.size() < 4) {
    return Error{ErrorCode::kRefused,
                 "deformable registration: expected at least 4 pictures with patches, found " +
                     std::to_string(numbers.size())};
  }
  std::map<int, int> order;
  for (const int frame : numbers) order.emplace(frame, static_cast<int>(order.size()));
  const DeformedCost cost(ct, patches, ct_from_reference, options);
  const SplineField empty(box_of_patches(cost), options.spacing_mm);
  DeformableResult result{empty, false, "", mean_cost(cost, nullptr), 0, 0, 0, 0, 1, 0};
  result.final_cost = result.rigid_cost;
  const Error not_finite{ErrorCode::kNumerical,
                         "deformable registration: expected a finite similarity of every patch"};
  if (!std::isfinite(result.rigid_cost)) return not_finite;

  std::map<int, PictureCost> pictures;
  for (const int part : {0, 1}) {
    const auto fitted = [&](int frame) { return order.at(frame) % 2 == part; };
    const auto held = [&](int frame) { return order.at(frame) % 2 != part; };
    Fit fit(cost, fitted, empty, options);
    if (!fit.run()) return not_finite;
    add_held_out(cost, fit.field(), held, pictures);
  }
  weigh(pictures, result);
  std::ostringstream text;
  text.precision(3);
  const double share = 1 - result.held_out_deformed / std::max(result.held_out_rigid, 1e-12);
  if (!(result.gain_sigmas >= options.min_gain_sigmas && share >= options.min_gain_share)) {
    text << "rigid: pictures that were left out gained " << 100 * share << " % and "
         << result.gain_sigmas << " standard errors by a deformation, expected "
         << 100 * options.min_gain_share << " % and " << options.min_gain_sigmas;
    result.reason = text.str();
    return result;
  }
  Fit all(
      cost, [](int) { return true; }, empty, options);
  if (!all.run()) return not_finite;
  result.iterations = all.iterations();
  result.min_determinant = all.field().min_determinant();
  if (!(result.min_determinant >= options.min_determinant)) {
    text << "rigid: the deformation squeezes tissue to " << result.min_determinant
         << " of its volume, expected at least " << options.min_determinant;
    result.reason = text.str();
    return result;
  }
  result.field = all.field();
  result.supported = true;
  result.final_cost = mean_cost(cost, &result.field);
  text << "deformable: pictures that were left out gained " << 100 * share << " % and "
       << result.gain_sigmas << " standard errors";
  result.reason = text.str();
  return result;
}

}  // namespace nav::registration
