// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tracking/reconstruction/image_area.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace nav::tracking {
namespace {

bool in_fan(const PlusClip::Fan& fan, double column, double row) {
  const Eigen::Vector2d from = Eigen::Vector2d(column, row) - fan.origin_px;
  if (from.y() < 0) return false;
  const double angle = std::atan2(from.x(), from.y());
  const double radius = from.norm();
  return angle >= fan.low_rad && angle <= fan.high_rad && radius >= fan.radius_start_px &&
         radius <= fan.radius_stop_px;
}

Error bad_clip(const std::string& name, const std::string& expected,
               const std::vector<double>& found) {
  std::ostringstream text;
  text << name << ": expected " << expected << ", found";
  for (const double x : found) text << ' ' << x;
  return {ErrorCode::kUsage, text.str()};
}

}  // namespace

Result<void> validate(const PlusClip& clip) {
  if (const auto& r = clip.rectangle) {
    const bool good = r->origin_px.allFinite() && r->size_px.allFinite() && r->size_px.x() > 0 &&
                      r->size_px.y() > 0;
    if (!good) {
      return bad_clip("clip rectangle", "origin and size > 0 in pixels",
                      {r->origin_px.x(), r->origin_px.y(), r->size_px.x(), r->size_px.y()});
    }
  }
  if (const auto& f = clip.fan) {
    const bool good = f->origin_px.allFinite() && f->low_rad > -M_PI / 2 &&
                      f->high_rad > f->low_rad && f->high_rad < M_PI / 2 &&
                      f->radius_start_px >= 0 && f->radius_stop_px > f->radius_start_px &&
                      std::isfinite(f->radius_stop_px);
    if (!good) {
      constexpr double kDeg = 180 / M_PI;
      return bad_clip("fan",
                      "two increasing angles within 90 degrees, an origin and two increasing radii",
                      {kDeg * f->low_rad, kDeg * f->high_rad, f->origin_px.x(), f->origin_px.y(),
                       f->radius_start_px, f->radius_stop_px});
    }
  }
  return {};
}

ImageArea::ImageArea(const UltrasoundImage& image, const PlusClip& clip)
    : width_(image.pixels.width()),
      height_(image.pixels.height()),
      grid_(image.grid),
      outline_(image.outline),
      low_px_(0, 0),
      high_px_(width_ - 1, height_ - 1) {
  if (clip.rectangle) {
    const Eigen::Vector2d end = clip.rectangle->origin_px + clip.rectangle->size_px;
    low_px_ = low_px_.cwiseMax(clip.rectangle->origin_px.array().ceil().matrix());
    high_px_ = high_px_.cwiseMin(end.array().floor().matrix());
  }
  const auto inside = [&](int column, int row) {
    if (clip.fan && !in_fan(*clip.fan, column, row)) return false;
    return !outline_ || outline_->contains(grid_.at(column, row).mm.head<2>());
  };
  mask_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 0);
  Eigen::Vector2d least(width_, height_);
  Eigen::Vector2d most(-1, -1);
  for (int row = static_cast<int>(low_px_.y()); row <= static_cast<int>(high_px_.y()); ++row) {
    const int past = static_cast<int>(high_px_.x()) + 1;
    for (int column = static_cast<int>(low_px_.x()); column < past; ++column) {
      if (!inside(column, row)) continue;
      const int first = column;
      while (column < past && inside(column, row)) ++column;
      runs_.push_back({row, first, column});
      pixels_ += static_cast<std::size_t>(column - first);
      std::fill_n(mask_.begin() + static_cast<std::ptrdiff_t>(row) * width_ + first, column - first,
                  std::uint8_t{1});
      least = least.cwiseMin(Eigen::Vector2d(first, row));
      most = most.cwiseMax(Eigen::Vector2d(column - 1, row));
    }
  }
  if (!clip.rectangle && !runs_.empty()) {
    low_px_ = least;
    high_px_ = most;
  }
  if (outline_) {
    apex_ = Apex{outline_->apex_mm, outline_->radius_min_mm};
  } else if (clip.fan) {
    const Eigen::Vector2d down =
        clip.fan->origin_px + Eigen::Vector2d(0, clip.fan->radius_start_px);
    const Eigen::Vector3d at = grid_.at(clip.fan->origin_px.x(), clip.fan->origin_px.y()).mm;
    apex_ = Apex{at.head<2>(), (grid_.at(down.x(), down.y()).mm - at).norm()};
  }
}

bool ImageArea::fits(const UltrasoundImage& image) const {
  const auto& other = image.outline;
  const bool same_outline = outline_.has_value() == other.has_value() &&
                            (!outline_ || (outline_->apex_mm == other->apex_mm &&
                                           outline_->radius_min_mm == other->radius_min_mm &&
                                           outline_->radius_max_mm == other->radius_max_mm &&
                                           outline_->half_angle_rad == other->half_angle_rad));
  return same_outline && width_ == image.pixels.width() && height_ == image.pixels.height() &&
         grid_.mm_per_pixel == image.grid.mm_per_pixel && grid_.origin_mm == image.grid.origin_mm;
}

std::vector<Eigen::Vector2d> ImageArea::corners() const {
  return {low_px_, {high_px_.x(), low_px_.y()}, {low_px_.x(), high_px_.y()}, high_px_};
}

}  // namespace nav::tracking
