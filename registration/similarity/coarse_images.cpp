// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/similarity/coarse_images.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "nav/check.hpp"
#include "nav/index.hpp"
#include "registration/similarity/patches.hpp"

namespace nav::registration {
namespace {

/// Adds a row of greys to the column sums: 256 values of eight bits fit into sixteen.
void add_row(std::span<const std::uint8_t> row, std::vector<std::uint16_t>& sums) {
  for (std::size_t i = 0; i < sums.size(); ++i) {
    sums[i] = static_cast<std::uint16_t>(sums[i] + row[i]);
  }
}

/// Indices of at most \p most ultrasound images, evenly along the path that the farthest corner
/// takes from image to image.
std::vector<std::size_t> evenly(const Sweep& sweep, int most) {
  std::vector<double> way_mm{0};
  for (std::size_t i = 1; i < sweep.frames().size(); ++i) {
    const double moved_mm = corners_moved_mm(sweep.frames()[i - 1], sweep.frames()[i]);
    way_mm.push_back(way_mm.back() + (std::isfinite(moved_mm) ? moved_mm : 0.0));
  }
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < way_mm.size(); ++i) {
    // The first image beyond each of \p most equal parts of the path.
    const double due_mm = way_mm.back() * static_cast<double>(kept.size()) / most;
    if (kept.size() < as_size(most) && way_mm[i] >= due_mm) kept.push_back(i);
  }
  return kept;
}

}  // namespace

UltrasoundImage averaged(const UltrasoundImage& frame, int factor) {
  const int width = frame.pixels.width() / factor;
  const int height = frame.pixels.height() / factor;
  NAV_CHECK(factor >= 1 && factor <= kMostPixelsPerBlock && width >= 1 && height >= 1, factor);
  if (factor == 1) return frame;
  const auto pixels = frame.pixels.pixels();
  const auto row_size = as_size(frame.pixels.width());
  const auto count = static_cast<std::uint64_t>(factor) * static_cast<std::uint64_t>(factor);
  // Division by multiplication: exact below 2^40, and no value here reaches 2^33.
  constexpr int kShift = 40;
  const std::uint64_t per_count = (std::uint64_t{1} << kShift) / count + 1;
  std::vector<std::uint16_t> sums(as_size(width * factor));
  std::vector<std::uint8_t> means(as_size(width) * as_size(height));
  for (int row = 0; row < height; ++row) {
    std::fill(sums.begin(), sums.end(), std::uint16_t{0});
    for (int y = row * factor; y < (row + 1) * factor; ++y) {
      add_row(pixels.subspan(as_size(y) * row_size, sums.size()), sums);
    }
    const std::uint16_t* from = sums.data();
    std::uint8_t* to = &means[as_size(row) * as_size(width)];
    for (int column = 0; column < width; ++column) {
      std::uint64_t sum = count / 2;
      for (int x = 0; x < factor; ++x) sum += *from++;
      *to++ = static_cast<std::uint8_t>(sum * per_count >> kShift);
    }
  }
  UltrasoundImage out = frame;
  out.pixels = Image2d<std::uint8_t>(width, height, std::move(means));
  const double middle = 0.5 * (factor - 1);
  out.grid.origin_mm = frame.grid.at(middle, middle).mm.head<2>();
  out.grid.mm_per_pixel *= factor;
  return out;
}

int pixels_per_block(const PixelGrid& grid, int width, int height, double sigma_mm) {
  const double pixel_mm =
      std::max(grid.mm_per_pixel.col(0).norm(), grid.mm_per_pixel.col(1).norm());
  const double most = std::min({width, height, kMostPixelsPerBlock});
  if (!(pixel_mm > 0)) return 1;  // The later use of the image rejects it.
  return static_cast<int>(std::clamp(kBlockPerSigma * sigma_mm / pixel_mm, 1.0, most));
}

Sweep coarse_images(const Sweep& sweep, int most, double sigma_mm) {
  NAV_CHECK(most >= 1, most);
  std::vector<TrackedImage> kept;
  for (const std::size_t index : evenly(sweep, most)) {
    kept.push_back(sweep.frames()[index]);
    UltrasoundImage& frame = kept.back().frame;
    frame = averaged(
        frame, pixels_per_block(frame.grid, frame.pixels.width(), frame.pixels.height(), sigma_mm));
  }
  auto made = Sweep::create(std::move(kept), sweep.calibration_id());
  NAV_CHECK(made.has_value());
  return *std::move(made);
}

}  // namespace nav::registration
