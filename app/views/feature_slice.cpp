// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/views/feature_slice.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "app/views/overlay.hpp"
#include "render/slices/slice.hpp"

namespace nav::app {

using render::features::FeatureVolume;

Image2d<Rgba8> feature_slice(const FeatureVolume& volume, int axis,
                             const FeatureSliceOptions& options) {
  const VoxelGrid& grid = volume.grid;
  const auto axis_of = [](int a) { return static_cast<std::size_t>(a); };
  const std::array<int, 2> across{axis == 0 ? 1 : 0, axis == 2 ? 1 : 2};
  std::array<int, 2> voxels{};
  std::array<double, 2> extent_mm{};
  for (std::size_t n = 0; n < 2; ++n) {
    voxels[n] = grid.size[axis_of(across[n])];
    extent_mm[n] = voxels[n] * grid.spacing_mm[across[n]];
  }
  const double mm_per_px = std::max(extent_mm[0], extent_mm[1]) / options.size_px;
  const auto pixels_of = [&](std::size_t n) {
    return std::max(1, static_cast<int>(std::lround(extent_mm[n] / mm_per_px)));
  };
  const int width = pixels_of(0);
  const int height = pixels_of(1);
  const auto voxel_at = [&](int pixel, std::size_t n) {
    const double at = (pixel + 0.5) * mm_per_px / grid.spacing_mm[across[n]];
    return std::clamp(static_cast<int>(at), 0, voxels[n] - 1);
  };
  const double range = std::max(options.range.high - options.range.low, 1e-12);
  std::array<int, 3> at{};
  at[axis_of(axis)] = grid.size[axis_of(axis)] / 2;
  std::vector<Rgba8> pixels;
  pixels.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int y = 0; y < height; ++y) {
    at[axis_of(across[1])] = voxel_at(y, 1);
    for (int x = 0; x < width; ++x) {
      at[axis_of(across[0])] = voxel_at(x, 0);
      const auto value = static_cast<double>(volume.at(at[0], at[1], at[2]));
      if (std::isnan(value)) {
        pixels.push_back({0, 0, 90, 255});
        continue;
      }
      const double share = std::clamp((value - options.range.low) / range, 0.0, 1.0);
      const auto grey = static_cast<std::uint8_t>(std::lround(255 * share));
      pixels.push_back({grey, grey, grey, 255});
    }
  }
  constexpr int kLeastDescribed = 128;
  Image2d<Rgba8> image(width, height, std::move(pixels));
  if (std::min(width, height) < kLeastDescribed) return image;
  render::Canvas canvas(width, height, render::rgb8(0));
  canvas.copy(image, 0, 0);
  const Rgba8 colour = render::rgb8(0xffd24a);
  const int size = text_size(16, height);
  const int small = text_size(13, height);
  const int margin = text_size(6, height);
  Eigen::Vector3d middle =
      0.5 * Eigen::Vector3d(grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1);
  middle[axis] = at[axis_of(axis)];
  const Point<frames::Ct> centre = grid.at(middle);
  const CanvasArea whole{0, 0, width, height};
  draw_letters(canvas, whole,
               render::labels_of(
                   {centre, {grid.directions.col(across[0])}, {grid.directions.col(across[1])}}),
               size, colour);
  const auto fits = [&](const std::string& words, int text) {
    return 2 * margin + canvas.text_width(text, words) <= width;
  };
  // The name stands below the letter of the upper edge, position and range above the lower one.
  if (fits(options.title, size)) {
    canvas.outlined_text(margin, margin + 2 * size + 4, size, options.title, colour);
  }
  int base = height - 2 * margin - size;
  for (const std::string& words : {options.range_words, position_words(centre.mm)}) {
    if (fits(words, small)) {
      canvas.outlined_text(width - margin - canvas.text_width(small, words), base, small, words,
                           colour);
    }
    base -= small + 5;
  }
  draw_scale_bar(canvas, whole, margin, height - margin, mm_per_px, small, colour);
  return canvas.image();
}

}  // namespace nav::app
