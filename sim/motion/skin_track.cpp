// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/motion/skin_track.hpp"

#include <algorithm>
#include <cmath>

#include "nav/check.hpp"
#include "nav/matrices.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;

constexpr double kStepMm = 1;
constexpr double kFootprintMm = 8;
// Number of corrections back to the depth; the distance is only of first order.
constexpr int kCorrections = 3;

/// One step along the image's z, rotated with the skin and corrected to the depth.
SkinTrack::Pose step(const Anatomy& patient, const SkinTrack::Pose& from, double way_mm,
                     double depth_mm) {
  const Vec here = from.translation_mm();
  const Vec normal = outward(patient, here, kFootprintMm);
  const Vec across = from.rotation() * Vec::UnitZ();
  const Vec tangent = (across - across.dot(normal) * normal).normalized();
  Vec there = here + way_mm * tangent;
  const Vec next = outward(patient, there, kFootprintMm);
  for (int i = 0; i < kCorrections; ++i) {
    there -= (patient.skin_distance_mm({there}) - depth_mm) * next;
  }
  const Eigen::Quaterniond turn = rotation_between(normal, next);
  const SkinTrack::Pose moved((turn * from.rotation()).normalized(), there);
  // Without a slope of the skin the probe stays.
  return there.allFinite() ? moved : from;
}

}  // namespace

Vec outward(const Anatomy& patient, const Vec& at_ct_mm, double footprint_mm) {
  Vec slope;
  for (int axis = 0; axis < 3; ++axis) {
    const Vec step = footprint_mm * Vec::Unit(axis);
    slope[axis] =
        patient.skin_distance_mm({at_ct_mm + step}) - patient.skin_distance_mm({at_ct_mm - step});
  }
  return slope.normalized();
}

SkinTrack::SkinTrack(const Anatomy& patient, const Pose& start, double reach_mm)
    : poses_{start}, reach_mm_(kStepMm * std::ceil(reach_mm / kStepMm)) {
  NAV_CHECK(reach_mm >= 0, reach_mm);
  const double depth_mm = patient.skin_distance_mm({start.translation_mm()});
  const int steps = static_cast<int>(std::lround(reach_mm_ / kStepMm));
  for (int i = 0; i < steps; ++i) {
    poses_.push_back(step(patient, poses_.back(), kStepMm, depth_mm));
  }
  std::vector<Pose> before{start};
  for (int i = 0; i < steps; ++i) {
    before.push_back(step(patient, before.back(), -kStepMm, depth_mm));
  }
  poses_.insert(poses_.begin(), before.rbegin(), before.rend() - 1);
}

SkinTrack::Pose SkinTrack::at(double along_mm) const {
  const double place = (std::clamp(along_mm, -reach_mm_, reach_mm_) + reach_mm_) / kStepMm;
  const auto last = poses_.size() - 1;
  const auto index = std::min(static_cast<std::size_t>(place), last == 0 ? 0 : last - 1);
  if (last == 0) return poses_.front();
  return interpolate(poses_[index], poses_[index + 1], place - static_cast<double>(index));
}

}  // namespace nav::sim
