// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/camera/cv_planar_pose.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

namespace nav::devices {
namespace {

constexpr double kLeastSigmaPx = 0.1;
constexpr double kRuledOut = 16;
constexpr double kSamePoseRad = 0.05;

struct CvFit {
  cv::Vec3d rotation, translation;
  double residual = 0;  ///< Root mean square, in directions.
};

CvFit refined(const std::vector<cv::Point3d>& points, const std::vector<cv::Point2d>& directions,
              cv::Vec3d rotation, cv::Vec3d translation) {
  cv::solvePnPRefineLM(
      points, directions, cv::Matx33d::eye(), cv::noArray(), rotation, translation,
      cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 50, 1e-12));
  std::vector<cv::Point2d> seen;
  cv::projectPoints(points, rotation, translation, cv::Matx33d::eye(), cv::noArray(), seen);
  double sum = 0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const cv::Point2d off = seen[i] - directions[i];
    sum += off.dot(off);
  }
  return {rotation, translation, std::sqrt(sum / static_cast<double>(seen.size()))};
}

double angle_between(const cv::Vec3d& a, const cv::Vec3d& b) {
  cv::Matx33d first, second;
  cv::Rodrigues(a, first);
  cv::Rodrigues(b, second);
  const cv::Matx33d turn = first.t() * second;
  return std::acos(std::clamp(0.5 * (cv::trace(turn) - 1), -1.0, 1.0));
}

/// Standard deviation of the translation: to first order, for corners with this deviation.
double error_of(const std::vector<cv::Point3d>& points, const CvFit& fit, double sigma) {
  std::vector<cv::Point2d> seen;
  cv::Mat jacobian;
  cv::projectPoints(points, fit.rotation, fit.translation, cv::Matx33d::eye(), cv::noArray(), seen,
                    jacobian);
  const cv::Mat pose = jacobian.colRange(0, 6);
  const cv::Mat covariance = (pose.t() * pose).inv(cv::DECOMP_SVD) * (sigma * sigma);
  double sum = 0;
  for (int i = 3; i < 6; ++i) sum += covariance.at<double>(i, i);
  return std::sqrt(sum);
}

}  // namespace

std::optional<CvPlanarPose> planar_pose(const std::vector<cv::Point3d>& points,
                                        const std::vector<cv::Point2d>& directions,
                                        double focal_px) {
  if (points.size() < 4) return std::nullopt;
  std::vector<cv::Vec3d> rotations, translations;
  std::vector<CvFit> fits;
  try {
    cv::solvePnPGeneric(points, directions, cv::Matx33d::eye(), cv::noArray(), rotations,
                        translations, false, cv::SOLVEPNP_IPPE);
    for (std::size_t i = 0; i < rotations.size(); ++i) {
      const CvFit fit = refined(points, directions, rotations[i], translations[i]);
      if (std::isfinite(fit.residual) && fit.translation[2] > 0) fits.push_back(fit);
    }
  } catch (const cv::Exception&) {  // Corners on a line.
    return std::nullopt;
  }
  if (fits.empty()) return std::nullopt;
  std::ranges::sort(fits, {}, [](const CvFit& fit) { return fit.residual; });
  const CvFit& best = fits.front();
  const double numbers = 2.0 * static_cast<double>(points.size());
  const double free = std::max(numbers - 6, 2.0);
  const double sigma =
      std::max(best.residual * std::sqrt(numbers / free), kLeastSigmaPx / focal_px);
  CvPlanarPose pose;
  cv::Rodrigues(best.rotation, pose.rotation);
  pose.translation_mm = best.translation;
  pose.residual_px = best.residual * focal_px;
  pose.error_mm = error_of(points, best, sigma);
  if (fits.size() > 1 && angle_between(best.rotation, fits[1].rotation) > kSamePoseRad) {
    const double worse = fits[1].residual * fits[1].residual - best.residual * best.residual;
    pose.other_residual_px = fits[1].residual * focal_px;
    pose.ambiguous = numbers * worse < kRuledOut * sigma * sigma;
  }
  return pose;
}

}  // namespace nav::devices
