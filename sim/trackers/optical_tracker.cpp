// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/trackers/optical_tracker.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "nav/check.hpp"
#include "nav/matrices.hpp"
#include "sim/random.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;

constexpr std::uint64_t kMarkerNoiseStream = 0x6f707469;
constexpr std::uint64_t kBiasStream = 0x62696173;

/// True when an obstacle blocks the line of sight from a camera to a point.
bool hides(const Obstacle& o, const Vec& camera, const Vec& p) {
  const Vec way = p - camera;
  const double t = std::clamp((o.centre_mm - camera).dot(way) / way.squaredNorm(), 0.0, 1.0);
  return (camera + t * way - o.centre_mm).norm() < o.radius_mm;
}

/// Smallest spread of the markers perpendicular to their best line, mm.
double width_of(const std::vector<OpticalMarker>& markers) {
  Eigen::Matrix3Xd points(3, static_cast<Eigen::Index>(markers.size()));
  for (std::size_t i = 0; i < markers.size(); ++i) {
    points.col(static_cast<Eigen::Index>(i)) = markers[i].position_mm;
  }
  points.colwise() -= points.rowwise().mean().eval();
  return extents(points)[1];
}

}  // namespace

Result<void> validate(const OpticalTrackerOptions& o) {
  const auto reject = [](const char* what) {
    return Error{ErrorCode::kUsage, std::string("optical tracker: expected ") + what};
  };
  if (!(o.baseline_mm > 0 && o.baseline_mm < 1e4)) return reject("a baseline of 0 to 10 000 mm");
  if (!(o.focal_px > 0 && o.focal_px < 1e6)) return reject("a focal length of 0 to 10^6 pixels");
  if (!(o.centroid_px >= 0 && o.centroid_px < 10)) return reject("a centroid noise in [0, 10) px");
  if (!(o.bias_mm >= 0 && o.bias_mm < 100)) return reject("a bias in [0, 100) mm");
  if (!(o.bias_length_mm >= 50)) return reject("a bias length >= 50 mm");
  if (!(o.near_mm >= 0 && o.far_mm > o.near_mm)) return reject("a volume with 0 <= near < far");
  if (!(o.half_angle_rad > 0 && o.half_angle_rad < 1.4)) return reject("a half angle in (0, 1.4)");
  if (!(o.max_incidence_rad > 0 && o.max_incidence_rad <= std::numbers::pi)) {
    return reject("an incidence in (0, pi] rad");
  }
  if (o.min_markers < 3 || static_cast<std::size_t>(o.min_markers) > o.markers.size()) {
    return reject("3 <= min_markers <= number of markers");
  }
  for (const OpticalMarker& m : o.markers) {
    if (!m.position_mm.allFinite() || !(m.normal.norm() > 0.1)) return reject("finite markers");
  }
  if (!(width_of(o.markers) > 5)) return reject("markers that are not on one line");
  return {};
}

OpticalTracker::OpticalTracker(const OpticalTrackerOptions& options) : options_(options) {
  const auto ok = validate(options);
  NAV_CHECK(ok.has_value(), ok.has_value() ? "" : ok.error().message);
}

Eigen::Vector2d OpticalTracker::marker_sigma_mm(double depth_mm) const {
  const double pixel = options_.centroid_px / options_.focal_px;
  return {depth_mm * pixel / std::numbers::sqrt2,
          std::numbers::sqrt2 * depth_mm * depth_mm * pixel / options_.baseline_mm};
}

bool OpticalTracker::inside(const Vec& p) const {
  return p.z() >= options_.near_mm && p.z() <= options_.far_mm &&
         std::atan2(p.head<2>().norm(), p.z()) <= options_.half_angle_rad;
}

bool OpticalTracker::seen(const Vec& p, const Vec& normal) const {
  if (options_.check_incidence &&
      normal.normalized().dot(-p.normalized()) < std::cos(options_.max_incidence_rad)) {
    return false;
  }
  const Vec half(0.5 * options_.baseline_mm, 0, 0);
  return std::ranges::none_of(options_.obstacles, [&](const Obstacle& o) {
    return hides(o, half, p) || hides(o, -half, p);
  });
}

/// Error of the device's factory calibration: smooth, and the same at every measurement.
Vec OpticalTracker::bias(const Vec& p) const {
  Vec sum;
  for (int axis = 0; axis < 3; ++axis) {
    const auto stream = kBiasStream + static_cast<std::uint64_t>(axis);
    const auto unit = [&](std::uint64_t k) {
      return unit_from_bits(hash_bits(options_.seed, stream, k));
    };
    const Vec wave =
        (Vec(unit(0), unit(1), unit(2)) - Vec::Constant(0.5)) * 4 / options_.bias_length_mm;
    sum[axis] = std::numbers::sqrt2 * std::sin(wave.dot(p) + 2 * std::numbers::pi * unit(3));
  }
  return options_.bias_mm / std::sqrt(3.0) * sum;
}

Observation OpticalTracker::observe(const Eigen::Matrix4d& truth, std::uint64_t body,
                                    std::uint64_t sample) const {
  const Eigen::Matrix3d turn = truth.topLeftCorner<3, 3>();
  const Vec shift = truth.topRightCorner<3, 1>();
  std::vector<Vec> own, measured;
  int outside = 0;
  for (std::size_t i = 0; i < options_.markers.size(); ++i) {
    const OpticalMarker& marker = options_.markers[i];
    const Vec p = turn * marker.position_mm + shift;
    if (!inside(p)) {
      ++outside;
      continue;
    }
    if (!seen(p, turn * marker.normal)) continue;
    const Eigen::Vector2d sigma = marker_sigma_mm(p.z());
    Vec noise;
    for (int axis = 0; axis < 3; ++axis) {
      const std::uint64_t counter =
          (sample * options_.markers.size() + i) * 3 + static_cast<std::uint64_t>(axis);
      noise[axis] =
          sigma[axis == 2 ? 1 : 0] * normal_at(options_.seed, kMarkerNoiseStream + body, counter);
    }
    own.push_back(marker.position_mm);
    measured.push_back(p + noise + bias(p));
  }
  if (static_cast<int>(own.size()) < options_.min_markers) {
    return {outside > 0 ? TrackingStatus::kOutOfVolume : TrackingStatus::kOccluded};
  }
  const auto count = static_cast<Eigen::Index>(own.size());
  const Eigen::Map<const Eigen::Matrix3Xd> from(own.front().data(), 3, count);
  const Eigen::Map<const Eigen::Matrix3Xd> to(measured.front().data(), 3, count);
  return {TrackingStatus::kOk, rigid_fit(from, to)};
}

}  // namespace nav::sim
