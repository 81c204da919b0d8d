// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/predicate_picture.hpp"

#include <algorithm>
#include <cmath>

#include "render/canvas.hpp"
#include "render/slice.hpp"

namespace nav::app {
namespace {

using render::derived::Paint;
using render::derived::Stroke;

constexpr int kTitleHeight = 28;  // Pixels above the pictures.
constexpr int kBarsHeight = 150;  // And below.

/// The colour of a bar: its hue and saturation at half the luminance.
Rgba8 colour_of(const render::PredicateHistogram::Bar& bar) {
  const auto rgb = render::spec::hsl(render::spec::hsl_tint(bar.hue_deg, bar.saturation), 0.5);
  const auto byte = [](double x) { return static_cast<std::uint8_t>(std::lround(255 * x)); };
  return {byte(rgb.x()), byte(rgb.y()), byte(rgb.z()), 255};
}

/// The predicate histogram: heights are importances.
void draw_bars(const render::PredicateModel& model, int left, int width, int top,
               render::Canvas& canvas) {
  constexpr int kText = 15;
  constexpr int kMargin = 12;
  const int count = static_cast<int>(model.entries.size());
  const int pitch = (width - 2 * kMargin) / count;
  const int most = kBarsHeight - 2 * kMargin - 2 * kText;
  const int base = top + kBarsHeight - kMargin - kText;
  for (int j = 0; j < count; ++j) {
    const auto at = static_cast<std::size_t>(j);
    const auto& bar = model.histogram.bars()[at];
    const int height = std::max(1, static_cast<int>(std::lround(most * bar.importance)));
    const int x = left + kMargin + j * pitch;
    canvas.fill(x, base - height, std::max(pitch - kMargin, 1), height, colour_of(bar));
    if (canvas.text_width(kText, model.entries[at].name) < pitch) {
      canvas.text(x, base + kText + 2, kText, model.entries[at].name, render::rgb8(0xd0d0d0));
    }
  }
}

/// One plane for all strokes that lie in it, as far as their slices are thick.
struct Slice {
  render::SlicePlane plane;
  std::vector<const Stroke*> strokes;
};

bool lies_in(const Stroke& stroke, const render::SlicePlane& plane) {
  const Eigen::Vector3d normal = plane.right.v.cross(plane.down.v);
  constexpr double kNearMm = 0.5;
  return std::all_of(stroke.points.begin(), stroke.points.end(), [&](const auto& p) {
    return std::abs((p.mm - plane.centre_ct.mm).dot(normal)) < kNearMm;
  });
}

/// Down the picture is as far as possible along j, the way that scan lines mostly take.
render::SlicePlane plane_of(const Stroke& stroke, const VoxelGrid& grid) {
  const Eigen::Vector3d normal = stroke.plane_normal.v.normalized();
  Eigen::Vector3d down = grid.directions.col(1);
  if (std::abs(down.dot(normal)) > 0.9) down = grid.directions.col(2);
  down = (down - down.dot(normal) * normal).normalized();
  Eigen::Vector3d right = down.cross(normal);
  if (right.dot(grid.directions.col(0) + 0.5 * grid.directions.col(2)) < 0) right = -right;
  const Eigen::Vector3d centre = grid.centre().mm;
  const double off = (stroke.points.front().mm - centre).dot(normal);
  return {{centre + off * normal}, {right}, {down}};
}

std::vector<Slice> slices_of(const std::vector<Stroke>& strokes, const VoxelGrid& grid) {
  std::vector<Slice> slices;
  for (const Stroke& stroke : strokes) {
    const auto same = std::find_if(slices.begin(), slices.end(),
                                   [&](const Slice& s) { return lies_in(stroke, s.plane); });
    if (same != slices.end()) {
      same->strokes.push_back(&stroke);
    } else {
      slices.push_back({plane_of(stroke, grid), {&stroke}});
    }
  }
  constexpr std::size_t kMostSlices = 3;
  slices.resize(std::min(slices.size(), kMostSlices));
  return slices;
}

void draw_stroke(const Stroke& stroke, const render::SlicePlane& plane,
                 const Eigen::Vector2d& middle, double pixels_per_mm, render::Canvas& canvas) {
  const Rgba8 colour = stroke.paint == Paint::kShow   ? render::rgb8(0x30e060)
                       : stroke.paint == Paint::kHide ? render::rgb8(0xff4040)
                                                      : render::rgb8(0x808080);
  const auto at = [&](const Point<frames::Ct>& p) {
    const Eigen::Vector3d off = p.mm - plane.centre_ct.mm;
    return Eigen::Vector2d(
        middle + pixels_per_mm * Eigen::Vector2d(off.dot(plane.right.v), off.dot(plane.down.v)));
  };
  const double width = std::max(2.0, 2 * stroke.radius_mm * pixels_per_mm);
  for (std::size_t n = 0; n < stroke.points.size(); ++n) {
    const auto& next = stroke.points[std::min(n + 1, stroke.points.size() - 1)];
    canvas.line(at(stroke.points[n]), at(next) + Eigen::Vector2d(0.01, 0), width, colour);
  }
}

}  // namespace

Image2d<Rgba8> predicate_picture(const std::vector<PredicatePanel>& panels) {
  constexpr int kText = 16;
  constexpr int kMargin = 8;
  NAV_CHECK(!panels.empty());
  const int width = panels.front().picture.width();
  const int height = panels.front().picture.height();
  const bool bars =
      std::any_of(panels.begin(), panels.end(), [](const auto& p) { return p.model.has_value(); });
  render::Canvas canvas(static_cast<int>(panels.size()) * width,
                        kTitleHeight + height + (bars ? kBarsHeight : 0), render::rgb8(0x202020));
  int left = 0;
  for (const PredicatePanel& panel : panels) {
    canvas.copy(panel.picture, left, kTitleHeight);
    canvas.text(left + kMargin, kTitleHeight - kMargin, kText, panel.title, render::rgb8(0xffd24a));
    if (panel.model) draw_bars(*panel.model, left, width, kTitleHeight + height, canvas);
    left += width;
  }
  return canvas.picture();
}

Image2d<Rgba8> stroke_picture(const Volume& volume,
                              const render::PredicateScene::IntensityWindow& intensity,
                              const std::vector<Stroke>& strokes, int width, int height) {
  const auto slices = slices_of(strokes, volume.grid());
  NAV_CHECK(!slices.empty());
  const int each = height / static_cast<int>(slices.size());
  const render::HuWindow window{0.5 * (intensity.black + intensity.white),
                                intensity.white - intensity.black};
  const Eigen::Vector3d extent = volume.grid().extent_mm();
  render::Canvas canvas(width, height, render::rgb8(0x101010));
  for (std::size_t n = 0; n < slices.size(); ++n) {
    const auto span = [&](const Direction<frames::Ct>& axis) {
      return (volume.grid().directions.transpose() * axis.v).cwiseAbs().dot(extent);
    };
    render::SliceOptions options;
    options.width = width;
    options.height = each;
    options.mm_per_pixel =
        std::max(span(slices[n].plane.right) / width, span(slices[n].plane.down) / each);
    const auto values = render::slice_values(volume, slices[n].plane, options);
    NAV_CHECK(values.has_value());
    const int top = static_cast<int>(n) * each;
    canvas.copy(render::to_grey(*values, window), 0, top);
    const Eigen::Vector2d middle(0.5 * (width - 1), top + 0.5 * (each - 1));
    for (const Stroke* stroke : slices[n].strokes) {
      draw_stroke(*stroke, slices[n].plane, middle, 1 / options.mm_per_pixel, canvas);
    }
  }
  return canvas.picture();
}

}  // namespace nav::app
