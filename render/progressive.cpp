// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/progressive.hpp"

#include <algorithm>
#include <cmath>

#include "nav/check.hpp"
#include "render/parallel.hpp"
#include "render/scene_compare.hpp"

namespace nav::render {
namespace {

/// Where a full pixel looks in the coarse picture along one axis: left of the two, and how far.
struct Between {
  int low;
  int high;
  float w;
};

/// Pixels of both pictures are square and their heights span the same angle, so one scale serves
/// both axes, about the middle.
Between between(int full, int full_count, int coarse_count, double scale) {
  const double x = (full + 0.5 - 0.5 * full_count) * scale + 0.5 * coarse_count - 0.5;
  const double inside = std::clamp(x, 0.0, coarse_count - 1.0);
  const int low = static_cast<int>(inside);
  return {low, std::min(low + 1, coarse_count - 1), static_cast<float>(inside - low)};
}

RgbaF mix(const RgbaF& a, const RgbaF& b, float w) {
  return {a.r + w * (b.r - a.r), a.g + w * (b.g - a.g), a.b + w * (b.b - a.b), 1.0F};
}

}  // namespace

RenderedImage enlarged(const RenderedImage& coarse, int width, int height) {
  const int from_width = coarse.pixels.width();
  const int from_height = coarse.pixels.height();
  const double scale = static_cast<double>(from_height) / height;
  std::vector<Between> columns;
  for (int x = 0; x < width; ++x) columns.push_back(between(x, width, from_width, scale));
  const auto pixels_of = [&](int row) {
    return coarse.pixels.pixels().data() + static_cast<std::ptrdiff_t>(row) * from_width;
  };
  std::vector<RgbaF> pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for_each_index(height, 0, [&](int y) {
    const Between rows = between(y, height, from_height, scale);
    const RgbaF* above = pixels_of(rows.low);
    const RgbaF* below = pixels_of(rows.high);
    RgbaF* out = pixels.data() + static_cast<std::ptrdiff_t>(y) * width;
    for (int x = 0; x < width; ++x) {
      const Between& c = columns[static_cast<std::size_t>(x)];
      out[x] =
          mix(mix(above[c.low], above[c.high], c.w), mix(below[c.low], below[c.high], c.w), rows.w);
    }
  });
  return {{width, height, std::move(pixels)}, coarse.statistics};
}

ProgressiveRenderer::ProgressiveRenderer(Engine& engine, const ProgressiveOptions& options)
    : engine_(engine), options_(options) {
  NAV_CHECK(options.budget_s >= 0 && options.refine_after_s >= 0, options.budget_s,
            options.refine_after_s);
  NAV_CHECK(options.coarse_pixel_error >= 0 && options.coarse_pixel_error <= 1,
            options.coarse_pixel_error);
  NAV_CHECK(options.coarse_factor >= 2 && options.coarse_factor <= 8, options.coarse_factor);
  NAV_CHECK(options.largest_factor >= options.coarse_factor && options.largest_factor <= 8,
            options.largest_factor);
}

/// The least that keeps to the budget, by what the last small picture took for each of its pixels.
int ProgressiveRenderer::small_factor() const {
  int factor = options_.coarse_factor;
  const auto takes_s = [&] {
    const double ratio = static_cast<double>(drawn_factor_) / factor;
    return small_s_ * ratio * ratio;
  };
  while (factor < options_.largest_factor && takes_s() > options_.budget_s) ++factor;
  return factor;
}

double& ProgressiveRenderer::cost_of(const Scene& scene) {
  const SceneChange change = drawn_ ? change_between(*drawn_, scene) : SceneChange::kView;
  return cost_s_[static_cast<std::size_t>(change)];
}

bool ProgressiveRenderer::may_be_coarse(const Scene& scene, Timestamp now) {
  const SceneChange change = last_ ? change_between(*last_, scene) : SceneChange::kView;
  const bool changed = change >= SceneChange::kGeometry;
  if (changed) changed_ = now;
  if (!changed && refined_) return false;
  const bool still = to_seconds(now - changed_) >= options_.refine_after_s;
  return !still && cost_of(scene) > options_.budget_s;
}

Result<ProgressiveRenderer::Picture> ProgressiveRenderer::draw(const Scene& scene, Timestamp now) {
  const bool coarse = may_be_coarse(scene, now);
  const int factor = small_factor();
  const auto fewer = [&](int n) { return (n + factor - 1) / factor; };
  Scene wanted = scene;
  double& whole_s = cost_of(scene);
  double& pixel_error = wanted.quality.pixel_error;
  if (coarse) pixel_error = std::max(pixel_error, options_.coarse_pixel_error);
  const bool sparse = pixel_error > scene.quality.pixel_error;
  const bool small = coarse && (!sparse || sparse_share_ * whole_s > options_.budget_s);
  if (small) {
    wanted.width = fewer(scene.width);
    wanted.height = fewer(scene.height);
  }
  // What an engine may keep of the last picture says nothing about the cost of a new one.
  const bool anew = !drawn_ || change_between(*drawn_, wanted) == SceneChange::kView;
  auto image = engine_.render(wanted);
  if (!image) return image.error();
  if (!coarse) whole_s = image->statistics.cast_s;
  if (coarse && !small && anew) sparse_share_ = image->statistics.cast_s / whole_s;
  if (small && anew) {
    small_s_ = image->statistics.cast_s;
    drawn_factor_ = factor;
  }
  last_ = scene;
  drawn_ = std::move(wanted);
  refined_ = !coarse;
  if (small) return Picture{enlarged(*image, scene.width, scene.height), false};
  return Picture{std::move(image).value(), refined_};
}

}  // namespace nav::render
