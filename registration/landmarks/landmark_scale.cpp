// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/landmarks/landmark_scale.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <sstream>
#include <vector>

#include "registration/twist.hpp"

namespace nav::registration {
namespace {

constexpr std::size_t kLeastScaledPairs = 5;
constexpr int kMostScaleSteps = 100;
// A factor along an axis that the points do not show stays near 1.
constexpr double kUsualLogScale = 0.3;
constexpr double kShownLogScale = 0.1;
constexpr double kFactorSigmas = 3;
// The CT's pixels are blamed if both frames have the same axes.
constexpr double kOtherFrame = 1.5;

/// Continued fraction of the incomplete beta function (Press et al., Numerical Recipes, 6.4).
double beta_fraction(double a, double b, double x) {
  constexpr double kTiny = 1e-300;
  const auto away = [](double v) { return std::abs(v) < kTiny ? kTiny : v; };
  double c = 1;
  double d = 1 / away(1 - (a + b) * x / (a + 1));
  double h = d;
  for (int m = 1; m <= 200; ++m) {
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    d = 1 / away(1 + even * d);
    c = away(1 + even / c);
    h *= d * c;
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    d = 1 / away(1 + odd * d);
    c = away(1 + odd / c);
    const double step = d * c;
    h *= step;
    if (std::abs(step - 1) < 1e-12) break;
  }
  return h;
}

/// Regularised incomplete beta function I_x(a, b).
double incomplete_beta(double a, double b, double x) {
  if (x <= 0) return 0;
  if (x >= 1) return 1;
  const double front = std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) +
                                a * std::log(x) + b * std::log1p(-x));
  if (x < (a + 1) / (a + b + 2)) return front * beta_fraction(a, b, x) / a;
  return 1 - front * beta_fraction(b, a, 1 - x) / b;
}

/// Probability that F with these degrees of freedom is larger.
double f_tail(double f, double freedom, double rest_freedom) {
  if (!(f > 0)) return 1;
  return incomplete_beta(rest_freedom / 2, freedom / 2,
                         rest_freedom / (rest_freedom + freedom * f));
}

struct ScaledFit {
  Eigen::Vector3d log_factors = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigmas = Eigen::Vector3d::Zero();  ///< In units of the given sigmas.
  double chi2 = 0;
  double fre_rms_mm = 0;
};

/// b = t + D R a with one factor or three; weights 1/sigma².
class ScaledProblem {
 public:
  ScaledProblem(std::vector<Eigen::Vector3d> a, std::vector<Eigen::Vector3d> b,
                std::vector<double> sigmas, bool one_factor)
      : a_(std::move(a)), b_(std::move(b)), sigmas_(std::move(sigmas)), one_(one_factor) {}

  ScaledFit solve(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation) const {
    Eigen::Quaterniond q = rotation;
    Eigen::Vector3d t = translation;
    ScaledFit out;
    double damping = 1e-6;
    double cost = cost_of(q, t, out.log_factors);
    for (int step = 0; step < kMostScaleSteps && damping < 1e9; ++step) {
      Matrix h = Matrix::Zero();
      Vector g = Vector::Zero();
      linearise(q, t, out.log_factors, h, g);
      Matrix damped = h;
      damped.diagonal() *= 1 + damping;
      const Vector x = damped.ldlt().solve(-g);
      const Eigen::Quaterniond q2 = (exp_rotation(x.head<3>()) * q).normalized();
      const Eigen::Vector3d t2 = t + x.segment<3>(3);
      const Eigen::Vector3d l2 = out.log_factors + spread(x);
      const double next = cost_of(q2, t2, l2);
      if (!(next <= cost)) {
        damping *= 10;
        continue;
      }
      const bool done = cost - next <= 1e-12 * cost;
      q = q2;
      t = t2;
      out.log_factors = l2;
      cost = next;
      damping = std::max(damping / 10, 1e-12);
      if (done) break;
    }
    Matrix h = Matrix::Zero();
    Vector g = Vector::Zero();
    linearise(q, t, out.log_factors, h, g);
    const Matrix covariance = h.ldlt().solve(Matrix::Identity());
    for (Eigen::Index i = 0; i < 3; ++i) {
      const Eigen::Index at = one_ ? 6 : 6 + i;
      out.sigmas[i] = std::sqrt(std::max(covariance(at, at), 0.0));
    }
    double squares = 0;
    for (std::size_t i = 0; i < a_.size(); ++i) {
      const Eigen::Vector3d e = residual(i, q, t, out.log_factors);
      out.chi2 += e.squaredNorm() / (sigmas_[i] * sigmas_[i]);
      squares += e.squaredNorm();
    }
    out.fre_rms_mm = std::sqrt(squares / static_cast<double>(a_.size()));
    return out;
  }

 private:
  using Matrix = Eigen::Matrix<double, 9, 9>;
  using Vector = Eigen::Matrix<double, 9, 1>;

  [[nodiscard]] Eigen::Vector3d spread(const Vector& x) const {
    return one_ ? Eigen::Vector3d::Constant(x[6]) : Eigen::Vector3d(x.tail<3>());
  }
  [[nodiscard]] Eigen::Vector3d residual(std::size_t i, const Eigen::Quaterniond& q,
                                         const Eigen::Vector3d& t,
                                         const Eigen::Vector3d& log_factors) const {
    return b_[i] - t - log_factors.array().exp().matrix().cwiseProduct(q * a_[i]);
  }
  [[nodiscard]] double cost_of(const Eigen::Quaterniond& q, const Eigen::Vector3d& t,
                               const Eigen::Vector3d& log_factors) const {
    double sum = log_factors.squaredNorm() / (kUsualLogScale * kUsualLogScale);
    for (std::size_t i = 0; i < a_.size(); ++i) {
      sum += residual(i, q, t, log_factors).squaredNorm() / (sigmas_[i] * sigmas_[i]);
    }
    return sum;
  }
  void linearise(const Eigen::Quaterniond& q, const Eigen::Vector3d& t,
                 const Eigen::Vector3d& log_factors, Matrix& h, Vector& g) const {
    const Eigen::Vector3d d = log_factors.array().exp();
    for (std::size_t i = 0; i < a_.size(); ++i) {
      const Eigen::Vector3d turned = q * a_[i];
      Eigen::Matrix<double, 3, 9> j = Eigen::Matrix<double, 3, 9>::Zero();
      j.leftCols<3>() = d.asDiagonal() * cross_matrix(turned);
      j.middleCols<3>(3) = -Eigen::Matrix3d::Identity();
      if (one_) {
        j.col(6) = -d.cwiseProduct(turned);
      } else {
        j.rightCols<3>() = -d.cwiseProduct(turned).asDiagonal().toDenseMatrix();
      }
      const double weight = 1 / (sigmas_[i] * sigmas_[i]);
      h += weight * j.transpose() * j;
      g += weight * j.transpose() * residual(i, q, t, log_factors);
    }
    const double prior = 1 / (kUsualLogScale * kUsualLogScale);
    for (Eigen::Index i = 0; i < 3; ++i) {
      h(6 + i, 6 + i) += one_ && i == 0 ? 3 * prior : prior;
      if (!one_ || i == 0) g[6 + i] += (one_ ? 3 : 1) * prior * log_factors[i];
    }
  }

  std::vector<Eigen::Vector3d> a_, b_;
  std::vector<double> sigmas_;
  bool one_;
};

}  // namespace

std::optional<LandmarkScale> landmark_scale(std::span<const LandmarkPair> pairs,
                                            const LandmarkScaleOptions& options) {
  if (pairs.size() < kLeastScaledPairs) return {};
  const auto rigid = register_landmarks(pairs);
  if (!rigid) return {};
  const auto count = static_cast<double>(pairs.size());
  const double rigid_chi2 = std::pow(rigid->sigma_scale, 2) * (3 * count - 6);
  std::vector<Eigen::Vector3d> reference, ct;
  std::vector<double> sigmas;
  const auto& pose = rigid->ct_from_reference;
  const Eigen::Vector3d centre = rigid->uncertainty.centre_ct.mm;
  const Eigen::Vector3d origin = (pose.inverse() * rigid->uncertainty.centre_ct).mm;
  for (const LandmarkPair& pair : pairs) {
    reference.emplace_back(pair.reference.mm - origin);
    ct.emplace_back(pair.ct.mm - centre);
    sigmas.push_back(pair.sigma_mm);
  }
  const Eigen::Quaterniond r = pose.rotation();
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  struct Candidate {
    ScaledAxes axes;
    double parameters;
    ScaledFit fit;
  };
  std::vector<Candidate> candidates = {
      {ScaledAxes::kAll, 1, ScaledProblem(reference, ct, sigmas, true).solve(r, none)},
      {ScaledAxes::kCt, 3, ScaledProblem(reference, ct, sigmas, false).solve(r, none)},
      {ScaledAxes::kReference, 3,
       ScaledProblem(ct, reference, sigmas, false).solve(r.conjugate(), none)}};
  // The frames' roles are swapped in the last one.
  candidates[2].fit.log_factors *= -1;
  // One factor, unless three explain clearly more; then the frame along whose axes the fit is best.
  const Candidate& along = candidates[1].fit.chi2 <= kOtherFrame * candidates[2].fit.chi2
                               ? candidates[1]
                               : candidates[2];
  const auto chance_of = [&](double before, double parameters, const ScaledFit& fit,
                             double all_parameters) {
    const double rest = 3 * count - 6 - all_parameters;
    return f_tail((before - fit.chi2) / parameters / std::max(fit.chi2 / rest, 1e-12), parameters,
                  rest);
  };
  const double more = chance_of(candidates[0].fit.chi2, 2, along.fit, 3);
  const Candidate& best = more < options.greatest_chance ? along : candidates[0];
  const double chance = chance_of(rigid_chi2, best.parameters, best.fit, best.parameters);
  if (!(chance < options.greatest_chance) || !(best.fit.fre_rms_mm <= options.max_fre_rms_mm)) {
    return {};
  }
  LandmarkScale out{.axes = best.axes,
                    .factors = Eigen::Vector3d::Ones(),
                    .sigmas = Eigen::Vector3d::Zero(),
                    .fre_rms_mm = best.fit.fre_rms_mm,
                    .rigid_fre_rms_mm = rigid->fre_rms_mm,
                    .chance = chance};
  const double unit = std::sqrt(best.fit.chi2 / std::max(3 * count - 6 - best.parameters, 1.0));
  bool off = false;
  for (Eigen::Index i = 0; i < 3; ++i) {
    out.sigmas[i] = unit * best.fit.sigmas[i] * std::exp(best.fit.log_factors[i]);
    if (best.fit.sigmas[i] * unit > kShownLogScale) continue;
    out.factors[i] = std::exp(best.fit.log_factors[i]);
    off = off || std::abs(out.factors[i] - 1) >=
                     std::max(options.least_change, kFactorSigmas * out.sigmas[i]);
  }
  if (!off) return {};
  return out;
}

std::string in_words(const LandmarkScale& scale) {
  constexpr double kNamedChange = 0.015;
  std::ostringstream text;
  text.setf(std::ios::fixed);
  text.precision(0);
  // A factor above 1 means that the points of the named frame are too far apart: of Reference when
  // the factor is below 1.
  const bool reference = scale.axes == ScaledAxes::kReference;
  text << "the points in " << (reference ? "Reference" : "Ct") << " are ";
  const auto change = [&](double factor) {
    const double own = reference ? 1 / factor : factor;
    const double percent = 100 * std::abs(own - 1);
    text << (percent < 9.5 ? std::round(10 * percent) / 10 : std::round(percent)) << " % too "
         << (own < 1 ? "close together" : "far apart");
  };
  text.unsetf(std::ios::fixed);
  text.precision(3);
  if (scale.axes == ScaledAxes::kAll) {
    change(scale.factors[0]);
    text << " in all directions, or those in Reference too "
         << (scale.factors[0] < 1 ? "far apart" : "close together") << ": check the unit";
    return text.str();
  }
  bool first = true;
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (std::abs(scale.factors[i] - 1) < std::max(kNamedChange, kFactorSigmas * scale.sigmas[i])) {
      continue;
    }
    if (!first) text << ", ";
    change(scale.factors[i]);
    text << " along "
         << "xyz"[i];
    first = false;
  }
  text << ": check the " << (reference ? "tracker's scale" : "pixel size and slice spacing")
       << " or the unit";
  return text.str();
}

}  // namespace nav::registration
