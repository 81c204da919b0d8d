// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/motion/warp.hpp"

#include <cmath>
#include <sstream>

#include "nav/check.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;
using Mat = Eigen::Matrix3d;

double weight(const WarpBump& bump, const Vec& p) {
  return std::exp(-0.5 * (p - bump.centre_mm).cwiseQuotient(bump.sigma_mm).squaredNorm());
}

}  // namespace

AffineWarp::AffineWarp(const Mat& matrix, const Vec& shift_mm)
    : matrix_(matrix), inverse_(matrix.inverse()), shift_mm_(shift_mm) {
  NAV_CHECK(matrix.allFinite() && shift_mm.allFinite());
  NAV_CHECK(matrix.determinant() > 0.01, matrix.determinant());
}

AffineWarp AffineWarp::rigid(const Vec& turn_rad, const Vec& centre_mm, const Vec& shift_mm) {
  const double angle = turn_rad.norm();
  const Mat turn =
      angle > 0 ? Eigen::AngleAxisd(angle, turn_rad / angle).toRotationMatrix() : Mat::Identity();
  return {turn, centre_mm - turn * centre_mm + shift_mm};
}

double steepness(const std::vector<WarpBump>& bumps) {
  double sum = 0;
  for (const WarpBump& bump : bumps) {
    sum += bump.peak_mm.norm() * std::exp(-0.5) / bump.sigma_mm.minCoeff();
  }
  return sum;
}

Result<SmoothWarp> SmoothWarp::create(std::vector<WarpBump> bumps) {
  for (const WarpBump& bump : bumps) {
    const bool finite =
        bump.centre_mm.allFinite() && bump.sigma_mm.allFinite() && bump.peak_mm.allFinite();
    if (!finite) return Error{ErrorCode::kUsage, "smooth warp: expected finite bumps, found NaN"};
    if (!(bump.sigma_mm.minCoeff() > 0)) {
      return Error{ErrorCode::kUsage, "smooth warp: expected sigma > 0 mm, found " +
                                          std::to_string(bump.sigma_mm.minCoeff())};
    }
  }
  const double steep = steepness(bumps);
  if (!(steep <= kMaxLipschitz)) {
    std::ostringstream text;
    text << "smooth warp: expected bumps of steepness <= " << kMaxLipschitz
         << " (else tissue could fold), found " << steep;
    return Error{ErrorCode::kUsage, text.str()};
  }
  return SmoothWarp(std::move(bumps), steep);
}

Vec displacement(const std::vector<WarpBump>& bumps, const Vec& rest) {
  Vec sum = Vec::Zero();
  for (const WarpBump& bump : bumps) sum += weight(bump, rest) * bump.peak_mm;
  return sum;
}

Vec SmoothWarp::apply(const Vec& rest) const { return rest + displacement(bumps_, rest); }

Mat SmoothWarp::jacobian(const Vec& rest) const {
  Mat sum = Mat::Identity();
  for (const WarpBump& bump : bumps_) {
    const Vec slope =
        -weight(bump, rest) * (rest - bump.centre_mm).cwiseQuotient(bump.sigma_mm.cwiseAbs2());
    sum += bump.peak_mm * slope.transpose();
  }
  return sum;
}

Vec SmoothWarp::invert(const Vec& now) const {
  constexpr int kNewtonSteps = 12;
  // Each step contracts the largest displacement by a factor of 0.9.
  constexpr int kFixedPointSteps = 400;
  Vec rest = now - displacement(bumps_, now);
  double miss = (apply(rest) - now).norm();
  for (int i = 0; i < kNewtonSteps && miss > kInverseToleranceMm; ++i) {
    const Vec next = rest - jacobian(rest).inverse() * (apply(rest) - now);
    const double next_miss = (apply(next) - now).norm();
    if (!(next_miss < miss)) break;
    rest = next;
    miss = next_miss;
  }
  for (int i = 0; i < kFixedPointSteps && miss > kInverseToleranceMm; ++i) {
    rest = now - displacement(bumps_, rest);
    miss = (apply(rest) - now).norm();
  }
  // Far from the origin the last digit of a coordinate is coarser than the tolerance.
  NAV_CHECK(miss <= kInverseToleranceMm + 1e-14 * now.norm(), miss);
  return rest;
}

ComposedWarp::ComposedWarp(std::shared_ptr<const Warp> first, std::shared_ptr<const Warp> then)
    : first_(std::move(first)), then_(std::move(then)) {
  NAV_CHECK(first_ != nullptr && then_ != nullptr);
}

Vec ComposedWarp::invert(const Vec& now) const {
  const Vec rest = first_->invert(then_->invert(now));
  // The errors of both inverses add up; one Newton step removes them.
  return rest - jacobian(rest).inverse() * (apply(rest) - now);
}

}  // namespace nav::sim
