// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/trackers/electromagnetic_tracker.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "nav/check.hpp"
#include "sim/random.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;

constexpr std::uint64_t kFieldNoiseStream = 0x656d;

/// Largest slope of 1 / (1 + q)^(3/2): 3 d (1 + d²)^(−5/2) at d = 1/2, which is 0.858.
constexpr double kSteepest = 0.8587;

}  // namespace

Result<void> validate(const ElectromagneticTrackerOptions& o) {
  const auto reject = [](const char* what) {
    return Error{ErrorCode::kUsage, std::string("electromagnetic tracker: expected ") + what};
  };
  if (!(o.noise_mm >= 0 && o.noise_mm < 100)) return reject("a noise in [0, 100) mm");
  if (!(o.noise_rad >= 0 && o.noise_rad < 1)) return reject("a noise in [0, 1) rad");
  if (!(o.reference_mm > 0)) return reject("a reference distance > 0 mm");
  if (!(o.near_mm >= 0 && o.far_mm > o.near_mm)) return reject("a volume with 0 <= near < far");
  if (!(o.half_width_mm > 0)) return reject("a half width > 0 mm");
  double steep = 0;
  for (const FieldDistorter& d : o.distorters) {
    if (!d.centre_mm.allFinite() || !d.peak_mm.allFinite() || !(d.radius_mm > 0)) {
      return reject("finite distorters of radius > 0 mm");
    }
    steep += kSteepest * d.peak_mm.norm() / d.radius_mm;
  }
  if (!(steep < 0.5)) return reject("distorters with a sum of slopes below 0.5");
  return {};
}

ElectromagneticTracker::ElectromagneticTracker(const ElectromagneticTrackerOptions& options)
    : options_(options) {
  const auto ok = validate(options);
  NAV_CHECK(ok.has_value(), ok.has_value() ? "" : ok.error().message);
}

Vec ElectromagneticTracker::distortion_mm(const Vec& p) const {
  Vec sum = Vec::Zero();
  for (const FieldDistorter& d : options_.distorters) {
    const double q = ((p - d.centre_mm) / d.radius_mm).squaredNorm();
    sum += d.peak_mm / std::pow(1 + q, 1.5);
  }
  return sum;
}

Eigen::Matrix3d ElectromagneticTracker::distortion_jacobian(const Vec& p) const {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const FieldDistorter& d : options_.distorters) {
    const Vec offset = (p - d.centre_mm) / d.radius_mm;
    const Vec slope = -3.0 * std::pow(1 + offset.squaredNorm(), -2.5) / d.radius_mm * offset;
    sum += d.peak_mm * slope.transpose();
  }
  return sum;
}

Vec ElectromagneticTracker::distortion_rad(const Vec& p) const {
  const Eigen::Matrix3d j = distortion_jacobian(p);
  return 0.5 * Vec(j(2, 1) - j(1, 2), j(0, 2) - j(2, 0), j(1, 0) - j(0, 1));
}

double ElectromagneticTracker::noise_growth(double distance_mm) const {
  return std::max(1.0, std::pow(distance_mm / options_.reference_mm, 4));
}

Observation ElectromagneticTracker::observe(const Eigen::Matrix4d& truth, std::uint64_t body,
                                            std::uint64_t sample) const {
  const Vec p = truth.topRightCorner<3, 1>();
  const bool inside = p.z() >= options_.near_mm && p.z() <= options_.far_mm &&
                      p.head<2>().cwiseAbs().maxCoeff() <= options_.half_width_mm;
  if (!inside) return {TrackingStatus::kOutOfVolume};
  const double growth = noise_growth(p.norm());
  Vec shift = distortion_mm(p);
  Vec turn = distortion_rad(p);
  for (int axis = 0; axis < 3; ++axis) {
    const std::uint64_t counter = 6 * sample + static_cast<std::uint64_t>(axis);
    shift[axis] +=
        growth * options_.noise_mm * normal_at(options_.seed, kFieldNoiseStream + body, counter);
    turn[axis] += growth * options_.noise_rad *
                  normal_at(options_.seed, kFieldNoiseStream + body, counter + 3);
  }
  Observation out{TrackingStatus::kOk, truth};
  out.pose.topRightCorner<3, 1>() = p + shift;
  if (const double angle = turn.norm(); angle > 0) {
    const Eigen::Matrix3d small = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
    out.pose.topLeftCorner<3, 3>() = (small * truth.topLeftCorner<3, 3>()).eval();
  }
  return out;
}

}  // namespace nav::sim
