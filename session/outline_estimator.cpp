// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/outline_estimator.hpp"

#include <cmath>

#include "registration/similarity/image_outline.hpp"

namespace nav::session {
namespace {

bool agree(const SectorOutline& a, const SectorOutline& b) {
  constexpr double kMm = 2;
  constexpr double kRad = 0.02;
  return (a.apex_mm - b.apex_mm).norm() <= kMm &&
         std::abs(a.radius_min_mm - b.radius_min_mm) <= kMm &&
         std::abs(a.radius_max_mm - b.radius_max_mm) <= kMm &&
         std::abs(a.half_angle_rad - b.half_angle_rad) <= kRad;
}

}  // namespace

void OutlineEstimator::add(const UltrasoundImage& image) {
  if (image.pixels.width() != width_ || image.pixels.height() != height_) {
    *this = {};
    width_ = image.pixels.width();
    height_ = image.pixels.height();
  }
  if (decided_after_ || image.pixels.empty()) return;
  // Only the pixels count here: equal poses and increasing times make a sweep of them.
  UltrasoundImage kept = image;
  kept.acquired = Timestamp(std::chrono::milliseconds(images_.size()));
  images_.push_back({std::move(kept),
                     Transform<frames::Reference, frames::Image>(Eigen::Quaterniond::Identity(),
                                                                 Eigen::Vector3d::Zero()),
                     Duration(0)});
  if (images_.size() >= next_) estimate();
}

void OutlineEstimator::estimate() {
  const auto sweep = Sweep::create(images_, "outline");
  const auto sector = sweep ? registration::sector_of(*sweep) : std::nullopt;
  const bool last = next_ >= kMost;
  if (last || (sector && previous_ && agree(*sector, *previous_))) {
    outline_ = sector;
    decided_after_ = images_.size();
    images_.clear();
    return;
  }
  previous_ = sector;
  next_ *= 2;
}

}  // namespace nav::session
