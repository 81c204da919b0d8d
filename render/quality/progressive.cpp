// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/quality/progressive.hpp"

#include <algorithm>
#include <chrono>

#include "nav/stopwatch.hpp"
#include "render/parallel.hpp"

namespace nav::render {
namespace {

RgbaF mix(const RgbaF& a, const RgbaF& b, float w) {
  return {a.r + w * (b.r - a.r), a.g + w * (b.g - a.g), a.b + w * (b.b - a.b), 1.0F};
}

}  // namespace

EnlargedRows::EnlargedRows(const Image2d<RgbaF>& coarse, int width, int height)
    : coarse_(coarse), height_(height), scale_(static_cast<double>(coarse.height()) / height) {
  columns_.reserve(static_cast<std::size_t>(width));
  for (int x = 0; x < width; ++x) {
    columns_.push_back(pair_of(x, width, coarse.width(), scale_));
  }
}

// Pixels of both images are square and their heights span the same angle, so one scale about the
// middle holds for both axes.
EnlargedRows::Pair EnlargedRows::pair_of(int full, int full_count, int coarse_count, double scale) {
  const double x = (full + 0.5 - 0.5 * full_count) * scale + 0.5 * coarse_count - 0.5;
  const double inside = std::clamp(x, 0.0, coarse_count - 1.0);
  const int low = static_cast<int>(inside);
  return {low, std::min(low + 1, coarse_count - 1), static_cast<float>(inside - low)};
}

void EnlargedRows::write(int y, std::vector<RgbaF>& between, RgbaF* row) const {
  const Pair rows = pair_of(y, height_, coarse_.height(), scale_);
  const auto from_width = static_cast<std::size_t>(coarse_.width());
  const RgbaF* above = coarse_.pixels().data() + static_cast<std::size_t>(rows.low) * from_width;
  const RgbaF* below = coarse_.pixels().data() + static_cast<std::size_t>(rows.high) * from_width;
  between.resize(from_width);
  for (std::size_t x = 0; x < from_width; ++x) between[x] = mix(above[x], below[x], rows.w);
  const RgbaF* from = between.data();
  for (const Pair& column : columns_) {
    *row++ = mix(from[column.low], from[column.high], column.w);
  }
}

RenderedImage enlarged(const RenderedImage& coarse, int width, int height) {
  const EnlargedRows rows(coarse.pixels, width, height);
  std::vector<RgbaF> pixels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for_each_index(height, 0, [&](int y) {
    std::vector<RgbaF> between;
    rows.write(y, between, pixels.data() + static_cast<std::ptrdiff_t>(y) * width);
  });
  return {{width, height, std::move(pixels)}, coarse.statistics};
}

ProgressiveRenderer::ProgressiveRenderer(Engine& engine, const ProgressiveOptions& options,
                                         CoarseEngine* coarse)
    : engine_(engine), coarse_(coarse), refinement_(options) {}

Result<ProgressiveRenderer::ProgressiveImage> ProgressiveRenderer::draw(const Scene& scene,
                                                                        Timestamp now,
                                                                        const Newer& newer) {
  auto drawn = draw_small(scene, now, newer);
  if (!drawn || drawn->factor == 1) return drawn;
  drawn->image = enlarged(drawn->image, scene.width, scene.height);
  return drawn;
}

Result<ProgressiveRenderer::ProgressiveImage> ProgressiveRenderer::draw_small(const Scene& scene,
                                                                              Timestamp now,
                                                                              const Newer& newer) {
  const Refinement::Plan plan = refinement_.plan(scene, now);
  const auto start = std::chrono::steady_clock::now();
  Interrupt interrupt;
  if (newer && plan.yields_to) {
    interrupt = Interrupt([&] {
      return newer() >= *plan.yields_to && seconds_since(start) >= refinement_.budget_s();
    });
  }
  const auto thin =
      coarse_ != nullptr && !plan.refined ? coarse_->scenes.of(plan.scene) : std::optional<Scene>();
  auto image = (thin ? coarse_->engine : engine_)
                   .render(with_fewer_pixels(thin ? *thin : plan.scene, plan.factor), interrupt);
  if (!image && image.error().code == ErrorCode::kCancelled) {
    refinement_.interrupted(seconds_since(start));
  }
  if (!image) return image.error();
  const RenderStatistics& statistics = image->statistics;
  refinement_.drawn(statistics.cast_s, plan.factor, statistics.provisional);
  return ProgressiveImage{std::move(image).value(), refinement_.is_refined(), plan.factor};
}

}  // namespace nav::render
