// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/shape/field_fit.hpp"

#include <Eigen/LU>
#include <Eigen/SparseCore>
#include <cmath>
#include <tbb/parallel_for.h>

#include "registration/similarity/lc2_kernel.hpp"

namespace nav::registration {
namespace {

using Vec = Eigen::Vector3d;
using Mat = Eigen::Matrix3d;
/// A row of three values for each control point.
using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

// A step need not be more accurate than the model that it minimises.
constexpr double kStepTolerance = 0.03;
constexpr int kMaxGradients = 200;
// The fit is finished when a step lowers the objective by less than this fraction.
constexpr double kCostTolerance = 1e-4;

/// Control points that affect a patch.
struct Reach {
  std::array<int, 64> index;
  std::array<double, 64> weight;
  int count;
};

/// A patch that the fit uses.
struct Used {
  const RestingPatch* patch;
  Reach reach;
};

Reach compact(const SplineField::Reach& all) { return {all.index, all.weight, all.count}; }

Vec at(const Reach& reach, const Points& c) {
  Vec sum = Vec::Zero();
  for (std::size_t n = 0; n < static_cast<std::size_t>(reach.count); ++n) {
    sum += reach.weight[n] * c.row(reach.index[n]).transpose();
  }
  return sum;
}

void add(const Reach& reach, const Vec& v, Points& sum) {
  for (std::size_t n = 0; n < static_cast<std::size_t>(reach.count); ++n) {
    sum.row(reach.index[n]) += reach.weight[n] * v.transpose();
  }
}

/// Σ w Rᵀ h R + bending + damping · its own diagonal.
class NormalMatrix {
 public:
  NormalMatrix(const std::vector<Used>& used, const std::vector<Mat>& hessians,
               const Eigen::SparseMatrix<double>& bending)
      : used_(used), hessians_(hessians), bending_(bending) {
    blocks_.assign(static_cast<std::size_t>(bending.rows()), Mat::Zero());
    for (Eigen::Index i = 0; i < bending.rows(); ++i) {
      blocks_[static_cast<std::size_t>(i)].diagonal().setConstant(bending.coeff(i, i));
    }
    for (std::size_t p = 0; p < used.size(); ++p) {
      const Reach& reach = used[p].reach;
      for (std::size_t n = 0; n < static_cast<std::size_t>(reach.count); ++n) {
        blocks_[static_cast<std::size_t>(reach.index[n])] +=
            reach.weight[n] * reach.weight[n] * hessians[p];
      }
    }
  }

  [[nodiscard]] Points times(const Points& x, double damping) const {
    Points out = bending_ * x;
    for (std::size_t p = 0; p < used_.size(); ++p) {
      add(used_[p].reach, hessians_[p] * at(used_[p].reach, x), out);
    }
    for (Eigen::Index i = 0; i < x.rows(); ++i) {
      const Mat& block = blocks_[static_cast<std::size_t>(i)];
      out.row(i).array() += damping * block.diagonal().transpose().array() * x.row(i).array();
    }
    return out;
  }
  /// Inverses of the diagonal blocks, one for each control point.
  [[nodiscard]] std::vector<Mat> inverse_blocks(double damping) const {
    std::vector<Mat> out;
    out.reserve(blocks_.size());
    for (Mat block : blocks_) {
      block.diagonal() *= 1 + damping;
      out.push_back(block.inverse());
    }
    return out;
  }

 private:
  const std::vector<Used>& used_;
  const std::vector<Mat>& hessians_;
  const Eigen::SparseMatrix<double>& bending_;
  std::vector<Mat> blocks_;  ///< Diagonal blocks.
};

Points times(const std::vector<Mat>& blocks, const Points& x) {
  Points out(x.rows(), 3);
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    out.row(i) = (blocks[static_cast<std::size_t>(i)] * x.row(i).transpose()).transpose();
  }
  return out;
}

double dot(const Points& a, const Points& b) { return (a.array() * b.array()).sum(); }

/// Conjugate gradients, preconditioned by the diagonal blocks of the control points.
Points solve(const NormalMatrix& matrix, const Points& rhs, double damping) {
  const std::vector<Mat> inverse = matrix.inverse_blocks(damping);
  Points x = Points::Zero(rhs.rows(), 3);
  Points residual = rhs;
  Points z = times(inverse, residual);
  Points direction = z;
  double rz = dot(residual, z);
  const double enough = kStepTolerance * kStepTolerance * rz;
  for (int i = 0; i < kMaxGradients && rz > enough; ++i) {
    const Points image = matrix.times(direction, damping);
    const double length = rz / dot(direction, image);
    if (!std::isfinite(length)) break;
    x += length * direction;
    residual -= length * image;
    z = times(inverse, residual);
    const double next = dot(residual, z);
    direction = z + (next / rz) * direction;
    rz = next;
  }
  return x;
}

class Fitter {
 public:
  Fitter(const DeformedCost& cost, const std::vector<bool>& frames, const SplineField& start,
         const DeformableOptions& options)
      : cost_(cost), field_(start), options_(options), bending_(options.bending * start.bending()) {
    for (const RestingPatch& patch : cost.patches()) {
      if (!frames[static_cast<std::size_t>(patch.frame)]) continue;
      used_.push_back({&patch, compact(start.reach(patch.centre_ct))});
      total_weight_ += patch.weight;
    }
    terms_.resize(used_.size());
    hessians_.resize(used_.size());
  }

  FieldFit run() {
    Points c = Eigen::Map<const Points>(field_.coefficients().data(), field_.control_points(), 3);
    double value = evaluate(c);
    if (!std::isfinite(value)) return {field_, 0, false};
    double damping = 1e-3;
    int iterations = 0;
    while (iterations < options_.max_iterations && damping < 1e6) {
      ++iterations;
      const Points gradient = linearise(c);
      const double before = value;
      // Tries shorter steps of the same model until one lowers the objective.
      for (; damping < 1e6; damping *= 10) {
        const Points step = solve({used_, hessians_, bending_}, -gradient, damping);
        const double there = step.allFinite() ? evaluate(c + step) : value;
        if (!(there < value)) continue;
        c += step;
        value = there;
        damping = std::max(damping / 10, 1e-6);
        break;
      }
      if (before - value < kCostTolerance * before) break;
    }
    field_.set_coefficients(Eigen::Map<const Eigen::VectorXd>(c.data(), c.size()));
    return {field_, iterations, true};
  }

 private:
  /// Half the objective; stores the terms of the patches.
  double evaluate(const Points& c) {
    tbb::parallel_for(std::size_t{0}, used_.size(), [&](std::size_t i) {
      terms_[i] = cost_.terms(*used_[i].patch, at(used_[i].reach, c));
    });
    double sum = 0;
    for (std::size_t i = 0; i < used_.size(); ++i) sum += share(i) * terms_[i].s;
    return 0.5 * sum + 0.5 * dot(c, bending_ * c);
  }
  /// Gradient of the objective at the accepted point, and the Hessians. The terms must be those of
  /// this point.
  Points linearise(const Points& c) {
    Points gradient = bending_ * c;
    for (std::size_t i = 0; i < used_.size(); ++i) {
      add(used_[i].reach, share(i) * terms_[i].gradient, gradient);
      hessians_[i] = share(i) * terms_[i].hessian;
    }
    return gradient;
  }
  [[nodiscard]] double share(std::size_t i) const { return used_[i].patch->weight / total_weight_; }

  const DeformedCost& cost_;
  SplineField field_;
  const DeformableOptions& options_;
  std::vector<Used> used_;
  std::vector<DeformedCost::Terms> terms_;  // Terms of the used patches at the last evaluation.
  std::vector<Mat> hessians_;
  double total_weight_ = 0;
  Eigen::SparseMatrix<double> bending_;
};

}  // namespace

DeformedCost::DeformedCost(const CtChannels& ct, const PatchSet& set, const Pose& pose,
                           const DeformableOptions& options)
    : ct_(ct), set_(set), ridge_(options.ridge) {
  const Mat turn = ct.directions.transpose() * pose.rotation().toRotationMatrix();
  double total = 0;
  for (std::size_t i = 0; i < set.patches.size(); ++i) {
    const Patch& p = set.patches[i];
    const double weight = std::pow(p.weight, options.contrast_power / kPatchWeightPower);
    total += weight;
    patches_.push_back({.centre_ct = (pose * Point<frames::Reference>{p.centre_mm}).mm,
                        .step_a = turn * p.step_a,
                        .step_b = turn * p.step_b,
                        .beam = turn * p.beam,
                        .weight = weight,
                        .frame = p.frame,
                        .index = i});
  }
  for (RestingPatch& p : patches_) p.weight /= total;
}

PlacedPatch DeformedCost::placed(const RestingPatch& p, const Vec& displacement) const {
  return {.centre = ct_.grid_of(p.centre_ct + displacement),
          .step_a = p.step_a,
          .step_b = p.step_b,
          .beam = p.beam,
          .side = set_.side,
          .u = set_.u(p.index)};
}

double DeformedCost::cost(const RestingPatch& p, const Vec& displacement) const {
  return patch_cost(ct_, placed(p, displacement), ridge_);
}

DeformedCost::Terms DeformedCost::terms(const RestingPatch& p, const Vec& displacement) const {
  const PatchTerms terms = patch_terms(ct_, placed(p, displacement), ridge_);
  return {terms.s, ct_.directions * terms.gradient.tail<3>(),
          ct_.directions * terms.hessian.bottomRightCorner<3, 3>() * ct_.directions.transpose()};
}

FieldFit fit_field(const DeformedCost& cost, const std::vector<bool>& frames,
                   const SplineField& start, const DeformableOptions& options) {
  return Fitter(cost, frames, start, options).run();
}

}  // namespace nav::registration
