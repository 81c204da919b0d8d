// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/landmarks/anisotropic_landmarks.hpp"

#include <ceres/ceres.h>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "nav/matrices.hpp"
#include "registration/pose_solver.hpp"
#include "registration/twist.hpp"

namespace nav::registration {
namespace {

using Landmarks = std::vector<AnisotropicLandmark>;
using Matrix36d = Eigen::Matrix<double, 3, 6>;

// Tolerance relative to the largest element: the rounding of text formats.
constexpr double kAsymmetry = 1e-6;

Error reject(const AnisotropicLandmark& landmark, const std::string& expected,
             const std::string& found) {
  return {ErrorCode::kMalformedData,
          "landmark '" + landmark.name + "': expected " + expected + ", found " + found};
}

Result<void> check_covariance(const AnisotropicLandmark& landmark, const Eigen::Matrix3d& c,
                              const std::string& frame) {
  const std::string what = "a covariance in " + frame + " that is ";
  if (!c.allFinite()) return reject(landmark, what + "finite", "NaN or Inf");
  const double size = c.cwiseAbs().maxCoeff();
  if ((c - c.transpose()).cwiseAbs().maxCoeff() > kAsymmetry * size) {
    return reject(landmark, what + "symmetric", "one that is not");
  }
  const double least = eigenpairs<3>(c).values[0];
  if (least < -kAsymmetry * size) {
    return reject(landmark, what + "not negative", "variance " + std::to_string(least) + " mm2");
  }
  return {};
}

Result<void> check(std::span<const AnisotropicLandmark> landmarks) {
  for (const AnisotropicLandmark& one : landmarks) {
    if (auto ok = check_covariance(one, one.reference_covariance_mm2, "Reference"); !ok) return ok;
    if (auto ok = check_covariance(one, one.ct_covariance_mm2, "Ct"); !ok) return ok;
    // The axes of the sum lie between these for any rotation.
    const Eigen::Vector3d a = eigenpairs<3>(one.reference_covariance_mm2).values;
    const Eigen::Vector3d b = eigenpairs<3>(one.ct_covariance_mm2).values;
    if (a[0] + b[0] < kLeastSigmaMm * kLeastSigmaMm ||
        a[2] + b[2] > kGreatestSigmaMm * kGreatestSigmaMm) {
      return reject(one, "covariances with axes of 0.001 to 1000 mm together",
                    std::to_string(std::sqrt(std::max(a[0] + b[0], 0.0))) + " to " +
                        std::to_string(std::sqrt(a[2] + b[2])) + " mm");
    }
  }
  return {};
}

/// The pairs with one variance each: the mean over the axes.
std::vector<LandmarkPair> isotropic(const Landmarks& landmarks) {
  std::vector<LandmarkPair> pairs;
  for (const AnisotropicLandmark& one : landmarks) {
    const double trace = (one.reference_covariance_mm2 + one.ct_covariance_mm2).trace();
    pairs.push_back({one.name, one.reference, one.ct, std::sqrt(trace / 3)});
  }
  return pairs;
}

/// Rotates the covariance in Reference into Ct.
Eigen::Matrix3d turned(const AnisotropicLandmark& landmark, const Pose& pose) {
  const Eigen::Matrix3d r = pose.rotation().toRotationMatrix();
  return r * landmark.reference_covariance_mm2 * r.transpose();
}

/// Whitened residual L⁻¹e of one landmark with LLᵀ = C + RDRᵀ, and its derivative by a twist about
/// the moved centre.
struct Whitened {
  Eigen::Vector3d r;
  Matrix36d by_twist;   ///< Exact: L rotates with R.
  Matrix36d by_motion;  ///< L held fixed: the derivative for the covariance.
};

Whitened whiten(const AnisotropicLandmark& landmark, const Pose& pose,
                const Eigen::Vector3d& centre) {
  const Eigen::Matrix3d d = turned(landmark, pose);
  const Eigen::LLT<Eigen::Matrix3d> llt(landmark.ct_covariance_mm2 + d);
  const auto lower = llt.matrixL();
  const Eigen::Vector3d x = (pose * landmark.reference).mm;
  Whitened out;
  out.r = lower.solve(landmark.ct.mm - x);
  Matrix36d motion;
  motion << cross_matrix(x - centre), -Eigen::Matrix3d::Identity();
  out.by_motion = lower.solve(motion);
  out.by_twist = out.by_motion;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const Eigen::Matrix3d k = cross_matrix(Eigen::Vector3d::Unit(axis));
    // dL = L Φ(L⁻¹ dΣ L⁻ᵀ), Φ the lower triangle with half the diagonal (Murray 2016, eq. 8).
    const Eigen::Matrix3d half = lower.solve(k * d - d * k);
    const Eigen::Matrix3d s = lower.solve(half.transpose());
    Eigen::Matrix3d phi = s.triangularView<Eigen::StrictlyLower>();
    phi.diagonal() = 0.5 * s.diagonal();
    out.by_twist.col(axis) -= phi * out.r;
  }
  return out;
}

/// 3 dimensionless residuals; parameters [60 ω | t] mm about a fixed centre.
class LandmarkCost final : public ceres::SizedCostFunction<3, 6> {
 public:
  LandmarkCost(const AnisotropicLandmark& landmark, const Pose& start,
               const Eigen::Vector3d& centre)
      : landmark_(landmark), start_(start), centre_(centre) {}

  static Vector6d twist_of(const double* delta) {
    Vector6d twist = Eigen::Map<const Vector6d>(delta);
    twist.head<3>() /= kRotationScaleMm;
    return twist;
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const Vector6d twist = twist_of(parameters[0]);
    if (!twist.allFinite()) return false;
    const Whitened w = whiten(landmark_, moved(start_, centre_, twist), centre_ + twist.tail<3>());
    Eigen::Map<Eigen::Vector3d> r(residuals);
    r = w.r;
    if (jacobians == nullptr || jacobians[0] == nullptr) return r.allFinite();
    Eigen::Map<Eigen::Matrix<double, 3, 6, Eigen::RowMajor>> jacobian(jacobians[0]);
    jacobian = w.by_twist;
    jacobian.leftCols<3>() =
        (w.by_twist.leftCols<3>() * left_jacobian(twist.head<3>()) / kRotationScaleMm).eval();
    return r.allFinite() && jacobian.allFinite();
  }

 private:
  const AnisotropicLandmark& landmark_;
  Pose start_;
  Eigen::Vector3d centre_;
};

struct Solved {
  Pose pose;
  double chi2;
};

Eigen::Vector3d mean_ct(const Landmarks& landmarks, const Pose& pose) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const AnisotropicLandmark& one : landmarks) sum += (pose * one.reference).mm;
  return sum / static_cast<double>(landmarks.size());
}

Result<Solved> solve(const Landmarks& landmarks, const Pose& start) {
  const Eigen::Vector3d centre = mean_ct(landmarks, start);
  Vector6d delta = Vector6d::Zero();
  ceres::Problem problem;
  for (const AnisotropicLandmark& one : landmarks) {
    problem.AddResidualBlock(new LandmarkCost(one, start, centre), nullptr, delta.data());
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = 100;
  options.function_tolerance = 1e-14;
  options.gradient_tolerance = 1e-12;
  options.parameter_tolerance = 1e-10;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (!summary.IsSolutionUsable() || summary.termination_type != ceres::CONVERGENCE) {
    return Error{ErrorCode::kNumerical,
                 "landmarks: expected the anisotropic fit to converge, found " +
                     std::string(ceres::TerminationTypeToString(summary.termination_type))};
  }
  return Solved{moved(start, centre, LandmarkCost::twist_of(delta.data())), 2 * summary.final_cost};
}

PoseUncertainty uncertainty_of(const Landmarks& landmarks, const Pose& pose) {
  PoseUncertainty result{{mean_ct(landmarks, pose)}, Matrix6d::Zero()};
  Matrix6d information = Matrix6d::Zero();
  Vector6d scale = Vector6d::Ones();
  scale.head<3>() /= kRotationScaleMm;
  for (const AnisotropicLandmark& one : landmarks) {
    const Matrix36d j = whiten(one, pose, result.centre_ct.mm).by_motion * scale.asDiagonal();
    information += j.transpose() * j;
  }
  const Matrix6d inverse = symmetric_inverse(information);
  result.covariance =
      scale.asDiagonal() * (0.5 * (inverse + inverse.transpose())) * scale.asDiagonal();
  return result;
}

double distance_mm(const Pose& pose, const AnisotropicLandmark& landmark) {
  return ((pose * landmark.reference).mm - landmark.ct.mm).norm();
}

/// Distance of a landmark from the fit of the others; NaN if they do not determine one.
double leave_one_out_mm(const Landmarks& landmarks, std::size_t left_out) {
  Landmarks rest = landmarks;
  rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(left_out));
  const auto start = register_landmarks(isotropic(rest));
  if (!start) return std::numeric_limits<double>::quiet_NaN();
  const auto solved = solve(rest, start->ct_from_reference);
  if (!solved) return std::numeric_limits<double>::quiet_NaN();
  return distance_mm(solved->pose, landmarks[left_out]);
}

}  // namespace

Result<LandmarkRegistration> register_anisotropic_landmarks(
    std::span<const AnisotropicLandmark> landmarks) {
  if (const auto ok = check(landmarks); !ok) return ok.error();
  const Landmarks list(landmarks.begin(), landmarks.end());
  auto result = register_landmarks(isotropic(list));
  if (!result) return result.error();
  const auto solved = solve(list, result->ct_from_reference);
  if (!solved) return solved.error();
  const auto count = static_cast<double>(list.size());
  double sum2 = 0;
  double trace = 0;
  for (std::size_t i = 0; i < list.size(); ++i) {
    LandmarkResidual& residual = result->residuals[i];
    residual = {list[i].name, distance_mm(solved->pose, list[i]), leave_one_out_mm(list, i)};
    sum2 += residual.distance_mm * residual.distance_mm;
    trace += (list[i].reference_covariance_mm2 + list[i].ct_covariance_mm2).trace();
  }
  result->ct_from_reference = solved->pose;
  result->fre_rms_mm = std::sqrt(sum2 / count);
  result->sigma_scale = std::sqrt(solved->chi2 / (3 * count - 6));
  result->fle_rms_mm = std::sqrt(trace / count) * result->sigma_scale;
  result->uncertainty = uncertainty_of(list, solved->pose);
  return result;
}

}  // namespace nav::registration
