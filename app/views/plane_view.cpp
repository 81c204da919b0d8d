// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/views/plane_view.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace nav::app {

PlaneView fit(const UltrasoundImage& frame, int x, int y, int width, int height) {
  const auto [low, high] = box_mm(frame);
  constexpr double kMargin = 1.04;
  const Eigen::Vector2d size = (high - low).cwiseMax(1e-3);
  const double scale = kMargin * std::max(size.x() / width, size.y() / height);
  const Eigen::Vector2d centre = 0.5 * (low + high);
  return {.x = x,
          .y = y,
          .width = width,
          .height = height,
          .origin_mm = centre - 0.5 * scale * Eigen::Vector2d(width, height),
          .mm_per_px = scale};
}

namespace {

/// The four pixels around a point and their weights.
struct Bilinear {
  int c0, r0, c1, r1;
  double u, v;

  /// \p value: of a pixel (column, row).
  template <class Value>
  [[nodiscard]] double of(const Value& value) const {
    return (1 - v) * ((1 - u) * value(c0, r0) + u * value(c1, r0)) +
           v * ((1 - u) * value(c0, r1) + u * value(c1, r1));
  }
};

/// SectorOutline::contains() of many points: an arc tangent for each pixel took a tenth of a
/// processor. Only points on a border are asked for theirs.
class InOutline {
 public:
  explicit InOutline(const std::optional<SectorOutline>& outline) : outline_(outline) {
    constexpr double kNearlyFlat = 1.5;  // rad; beyond, every point is asked.
    if (outline && outline->half_angle_rad < kNearlyFlat)
      slope_ = std::tan(outline->half_angle_rad);
  }
  [[nodiscard]] bool contains(const Eigen::Vector2d& p_mm) const {
    if (!outline_) return true;
    const Eigen::Vector2d d = p_mm - outline_->apex_mm;
    if (!(d.y() > 0)) return false;
    constexpr double kRounding = 1e-9;  // Far above that of the slope and of an arc tangent.
    const double aside = std::abs(d.x());
    const double border = slope_ * d.y();
    if (aside > border * (1 + kRounding)) return false;
    if (!(aside < border * (1 - kRounding))) return outline_->contains(p_mm);
    const double radius = d.norm();
    return radius >= outline_->radius_min_mm && radius <= outline_->radius_max_mm;
  }

 private:
  const std::optional<SectorOutline>& outline_;
  double slope_ = std::numeric_limits<double>::quiet_NaN();
};

/// Absent outside the image's outline. \p pixel_from_mm: inverse of the grid's matrix, which is the
/// same for every point.
std::optional<Bilinear> bilinear_at(const UltrasoundImage& frame, const InOutline& outline,
                                    const Eigen::Matrix2d& pixel_from_mm,
                                    const Eigen::Vector2d& p_mm) {
  const Eigen::Vector2d pixel = pixel_from_mm * (p_mm - frame.grid.origin_mm);
  const int w = frame.pixels.width();
  const int h = frame.pixels.height();
  if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= w - 1 && pixel.y() <= h - 1)) {
    return std::nullopt;
  }
  if (!outline.contains(p_mm)) return std::nullopt;
  const int c = std::min(static_cast<int>(pixel.x()), std::max(w - 2, 0));
  const int r = std::min(static_cast<int>(pixel.y()), std::max(h - 2, 0));
  return Bilinear{
      c, r, std::min(c + 1, w - 1), std::min(r + 1, h - 1), pixel.x() - c, pixel.y() - r};
}

/// Rounds a number in [0, 255.5) as std::lround() does, which is slow.
std::uint8_t rounded(double value) {
  const auto whole = static_cast<unsigned>(value);
  return static_cast<std::uint8_t>(whole + (value - whole >= 0.5 ? 1U : 0U));
}

/// Colour of a frame at a point: grey if the frame is.
Rgba8 colour_at(const UltrasoundImage& frame, const Bilinear& at) {
  if (frame.colours.empty()) {
    const auto grey = rounded(at.of([&](int c, int r) { return frame.pixels.at(c, r); }));
    return {grey, grey, grey, 255};
  }
  const auto channel = [&](std::uint8_t Rgb8::*part) {
    return rounded(at.of([&](int c, int r) { return frame.colours.at(c, r).*part; }));
  };
  return {channel(&Rgb8::r), channel(&Rgb8::g), channel(&Rgb8::b), 255};
}

}  // namespace

double intensity(const UltrasoundImage& frame, const Eigen::Vector2d& p_mm) {
  const auto at =
      bilinear_at(frame, InOutline(frame.outline), frame.grid.mm_per_pixel.inverse(), p_mm);
  return at ? at->of([&](int c, int r) { return frame.pixels.at(c, r); }) : -1;
}

void draw_ultrasound(render::Canvas& canvas, const PlaneView& view, const UltrasoundImage& frame) {
  const Eigen::Matrix2d pixel_from_mm = frame.grid.mm_per_pixel.inverse();
  const InOutline outline(frame.outline);
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      const auto at = bilinear_at(frame, outline, pixel_from_mm, view.point_of(x, y));
      if (at) canvas.set(view.x + x, view.y + y, colour_at(frame, *at));
    }
  }
}

}  // namespace nav::app
