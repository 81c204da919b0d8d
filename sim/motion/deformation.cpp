// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/motion/deformation.hpp"

#include <algorithm>
#include <sstream>

#include "sim/random.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;

constexpr int kBumps = 3;
constexpr double kLargestMm = 20;
constexpr double kAsideMm = 30;
constexpr double kNarrowestMm = 40;
constexpr double kWidestMm = 60;
constexpr double kSmallestPeak = 0.6;  ///< Smallest peak before scaling, relative to the largest.

std::vector<WarpBump> unscaled_bumps(std::uint64_t seed, const Vec& middle) {
  Random random(seed, 0x646566);
  std::vector<WarpBump> bumps;
  for (int i = 0; i < kBumps; ++i) {
    WarpBump bump;
    bump.centre_mm = middle + random.offset(kAsideMm);
    for (int axis = 0; axis < 3; ++axis) {
      bump.sigma_mm[axis] = random.uniform(kNarrowestMm, kWidestMm);
    }
    bump.peak_mm = random.uniform(kSmallestPeak, 1) * random.direction();
    bumps.push_back(bump);
  }
  return bumps;
}

}  // namespace

Result<void> validate(const DeformationOptions& o) {
  if (o.largest_mm >= 0 && o.largest_mm <= kLargestMm) return {};
  std::ostringstream text;
  text << "deformation: expected 0 to " << kLargestMm << " mm, found " << o.largest_mm;
  return Error{ErrorCode::kUsage, text.str()};
}

Result<SmoothWarp> make_deformation(const DeformationOptions& options,
                                    std::span<const Point<frames::Ct>> points_ct) {
  if (const auto ok = validate(options); !ok) return ok.error();
  if (points_ct.empty()) {
    return Error{ErrorCode::kUsage, "deformation: expected points to move, found none"};
  }
  Vec middle = Vec::Zero();
  for (const auto& p : points_ct) middle += p.mm / static_cast<double>(points_ct.size());
  std::vector<WarpBump> bumps = unscaled_bumps(options.seed, middle);
  double farthest = 0;
  for (const auto& p : points_ct) {
    farthest = std::max(farthest, displacement(bumps, p.mm).norm());
  }
  for (WarpBump& bump : bumps) bump.peak_mm *= options.largest_mm / farthest;
  return SmoothWarp::create(std::move(bumps));
}

}  // namespace nav::sim
