// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/quality/progressive.hpp"

#include <algorithm>

#include "render/parallel.hpp"

namespace nav::render {
namespace {

/// The position of a full pixel in the coarse image along one axis: its two neighbours, and the
/// weight of the second.
struct CoarsePair {
  int low;
  int high;
  float w;
};

/// Finds the position. Pixels of both images are square and their heights span the same angle, so
/// one scale about the middle holds for both axes.
CoarsePair coarse_pair(int full, int full_count, int coarse_count, double scale) {
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
  std::vector<CoarsePair> columns;
  for (int x = 0; x < width; ++x) columns.push_back(coarse_pair(x, width, from_width, scale));
  const auto pixels_of = [&](int row) {
    return coarse.pixels.pixels().data() + static_cast<std::ptrdiff_t>(row) * from_width;
  };
  std::vector<RgbaF> pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for_each_index(height, 0, [&](int y) {
    const CoarsePair rows = coarse_pair(y, height, from_height, scale);
    const RgbaF* above = pixels_of(rows.low);
    const RgbaF* below = pixels_of(rows.high);
    RgbaF* out = pixels.data() + static_cast<std::ptrdiff_t>(y) * width;
    for (int x = 0; x < width; ++x) {
      const CoarsePair& c = columns[static_cast<std::size_t>(x)];
      out[x] =
          mix(mix(above[c.low], above[c.high], c.w), mix(below[c.low], below[c.high], c.w), rows.w);
    }
  });
  return {{width, height, std::move(pixels)}, coarse.statistics};
}

ProgressiveRenderer::ProgressiveRenderer(Engine& engine, const ProgressiveOptions& options)
    : engine_(engine), refinement_(options) {}

Result<ProgressiveRenderer::ProgressiveImage> ProgressiveRenderer::draw(const Scene& scene,
                                                                        Timestamp now) {
  const Refinement::Plan plan = refinement_.plan(scene, now);
  auto image = engine_.render(with_fewer_pixels(plan.scene, plan.factor));
  if (!image) return image.error();
  const RenderStatistics& statistics = image->statistics;
  refinement_.drawn(statistics.cast_s, plan.factor, statistics.provisional);
  if (plan.factor == 1) return ProgressiveImage{std::move(image).value(), refinement_.is_refined()};
  return ProgressiveImage{enlarged(*image, scene.width, scene.height), false};
}

}  // namespace nav::render
