// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/motion/phase_fit.hpp"

#include <ceres/cost_function.h>
#include <cmath>
#include <limits>
#include <optional>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "registration/cost_solver.hpp"
#include "registration/pose_solver.hpp"
#include "registration/secant_curvature.hpp"

namespace nav::registration {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Calls visit(i) for each of n indices, in parallel.
template <class Visit>
void for_each(std::size_t n, int threads, const Visit& visit) {
  if (threads == 1 || n < 2) {
    for (std::size_t i = 0; i < n; ++i) visit(i);
    return;
  }
  tbb::task_arena arena(threads);
  arena.execute([&] { tbb::parallel_for(std::size_t{0}, n, visit); });
}

/// E(series) and the derivatives of E/2.
struct SeriesTerms {
  double cost = 0;
  Eigen::VectorXd gradient;
  Eigen::MatrixXd hessian;
};

/// E(series) = mean of the images' costs at the poses of their phases + stiffness.
class PhaseCost final : public ceres::CostFunction {
 public:
  /// Parameters are added to start's series. All arguments must outlive this object.
  PhaseCost(const CtChannels& ct, const ChosenImages& images, const PhaseFit& start,
            const PhaseOptions& options)
      : images_(images), start_(start), columns_(start.series.cols()), options_(options) {
    for (const PhaseImage* p : images) {
      total_ += p->weight;
      costs_.emplace_back(ct, p->patches, options.ridge, 1);
      bases_.push_back(phase_basis(p->phase, columns_));
    }
    set_num_residuals(static_cast<int>(6 * columns_) + 1);
    mutable_parameter_block_sizes()->push_back(static_cast<int>(6 * columns_));
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Eigen::Index n = 6 * columns_;
    const Eigen::Map<const Eigen::VectorXd> delta(parameters[0], n);
    const Eigen::MatrixXd series =
        start_.series + Eigen::Map<const Eigen::MatrixXd>(parameters[0], 6, columns_);
    if (!series.allFinite() || series.cwiseAbs().maxCoeff() > kMaxTravelMm) return false;
    if (!tried_ || *tried_ != delta) {
      // Most tried steps are accepted, and Ceres then asks for their derivatives.
      terms_ = terms(series);
      tried_ = delta;
    }
    if (!std::isfinite(terms_.cost) || !terms_.hessian.allFinite()) return false;
    Eigen::Map<Eigen::VectorXd> r(residuals, n + 1);
    r.setZero();
    r[n] = std::sqrt(terms_.cost);
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    Eigen::Map<RowMajor> jacobian(jacobians[0], n + 1, n);
    const Eigen::MatrixXd h = curvature_.corrected(delta, terms_.gradient, terms_.hessian);
    fill_residuals(terms_.cost, terms_.gradient, h, r, jacobian);
    return true;
  }

 private:
  [[nodiscard]] SeriesTerms terms(const Eigen::MatrixXd& series) const {
    const Eigen::Index n = 6 * columns_;
    std::vector<CostTerms> each(images_.size());
    for_each(images_.size(), options_.threads,
             [&](std::size_t i) { each[i] = image_terms(i, series); });
    SeriesTerms sum{0, Eigen::VectorXd::Zero(n), Eigen::MatrixXd::Zero(n, n)};
    add_stiffness(series, sum);
    for (std::size_t i = 0; i < each.size(); ++i) add(bases_[i], each[i], sum);
    return sum;
  }

  /// Weighted terms by the coefficients [60 rad | mm] of the image's own twist.
  [[nodiscard]] CostTerms image_terms(std::size_t i, const Eigen::MatrixXd& series) const {
    const Vector6d twist = phase_twist(series, bases_[i]);
    CostTerms terms =
        costs_[i].terms(moved(start_.pose, start_.centre, twist), start_.centre + twist.tail<3>());
    Matrix6d chain = Matrix6d::Identity();
    chain.topLeftCorner<3, 3>() = left_jacobian(twist.head<3>()) / kRotationScaleMm;
    const double weight = images_[i]->weight / total_;
    terms.cost *= weight;
    terms.gradient = weight * (chain.transpose() * terms.gradient);
    terms.hessian = weight * (chain.transpose() * terms.hessian * chain);
    return terms;
  }

  void add(const Eigen::VectorXd& basis, const CostTerms& one, SeriesTerms& sum) const {
    sum.cost += one.cost;
    for (Eigen::Index i = 0; i < columns_; ++i) {
      sum.gradient.segment<6>(6 * i) += basis[i] * one.gradient;
      for (Eigen::Index j = 0; j < columns_; ++j) {
        sum.hessian.block<6, 6>(6 * i, 6 * j) += basis[i] * basis[j] * one.hessian;
      }
    }
  }

  void add_stiffness(const Eigen::MatrixXd& series, SeriesTerms& sum) const {
    const Vector6d first = options_.stiffness * options_.usual_mm.array().square().inverse();
    for (Eigen::Index column = 1; column < columns_; ++column) {
      const double k = static_cast<double>((column + 1) / 2);
      const Vector6d weight = k * k * k * k * first;
      const Vector6d pull = weight.cwiseProduct(series.col(column));
      sum.cost += pull.dot(series.col(column));
      sum.gradient.segment<6>(6 * column) += pull;
      sum.hessian.diagonal().segment<6>(6 * column) += weight;
    }
  }

  const ChosenImages& images_;
  const PhaseFit& start_;
  std::vector<SimilarityCost> costs_;   // One for each image.
  std::vector<Eigen::VectorXd> bases_;  // One for each image.
  Eigen::Index columns_;
  const PhaseOptions& options_;
  double total_ = 0;
  mutable std::optional<Eigen::VectorXd> tried_;
  mutable SeriesTerms terms_;  // At tried_.
  // Ceres asks for Jacobians on one thread, once for each accepted step.
  mutable SecantCurvature<Eigen::Dynamic> curvature_;
};

}  // namespace

PhaseFit fit_phases(const CtChannels& ct, const ChosenImages& images, const PhaseFit& given,
                    Eigen::Index columns, const PhaseOptions& options) {
  PhaseFit start = given;
  start.series = Eigen::MatrixXd::Zero(6, columns);
  const Eigen::Index known = std::min(columns, given.series.cols());
  start.series.leftCols(known) = given.series.leftCols(known);
  Eigen::VectorXd delta(6 * columns);
  auto* cost = new PhaseCost(ct, images, start, options);  // Ceres takes ownership.
  const CostSolution found =
      minimise(cost, delta, {options.max_iterations, options.cost_tolerance}, {});
  PhaseFit out = start;
  out.series += Eigen::Map<const Eigen::MatrixXd>(delta.data(), 6, columns);
  out.cost = found.final_cost;
  out.iterations += found.iterations;
  out.finite = out.finite && found.termination != Termination::kFailed;
  return out;
}

std::vector<double> costs_at(const CtChannels& ct, const ChosenImages& images,
                             const PhaseMotion& motion, const PhaseOptions& options) {
  std::vector<double> costs(images.size());
  for_each(images.size(), options.threads, [&](std::size_t i) {
    const PhaseImage& image = *images[i];
    const CostTerms terms = SimilarityCost(ct, image.patches, options.ridge, 1)
                                .cost(motion.ct_from_reference(image.phase));
    costs[i] = terms.non_finite > 0 ? std::numeric_limits<double>::quiet_NaN() : terms.cost;
  });
  return costs;
}

}  // namespace nav::registration
