// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/image_confidence.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "render/features/confidence.hpp"

namespace nav::app {

Result<Image2d<std::uint8_t>> image_confidence(const UltrasoundImage& image,
                                               const tracking::ImageArea& area, int threads) {
  namespace features = render::features;
  const int width = image.pixels.width();
  const int height = image.pixels.height();
  const Eigen::Matrix2d& mm_per_pixel = image.grid.mm_per_pixel;
  // The image as one slice whose axes are those of its pixels, and whose first pixel is the origin.
  VoxelGrid grid;
  grid.size = {width, height, 1};
  grid.spacing_mm = {mm_per_pixel.col(0).norm(), mm_per_pixel.col(1).norm(), 1};
  const Eigen::Matrix2d axes = mm_per_pixel.colwise().normalized();
  std::vector<float> values(image.pixels.pixels().size(), features::kUnknown);
  for (const auto& run : area.runs()) {
    for (int column = run.first; column < run.past; ++column) {
      const std::size_t at = static_cast<std::size_t>(run.row) * static_cast<std::size_t>(width) +
                             static_cast<std::size_t>(column);
      values[at] = static_cast<float>(image.pixels.pixels()[at]);
    }
  }
  const auto fail = [&](const Error& error) {
    return Error{error.code,
                 "confidence of image " + std::to_string(image.sequence) + ": " + error.message};
  };
  const auto volume = features::ScalarVolume::create(grid, std::move(values), "image");
  if (!volume) return fail(volume.error());
  const auto in_slice = [&](const Eigen::Vector2d& v) {
    const Eigen::Vector2d along = axes.transpose() * v;
    return Eigen::Vector3d(along.x(), along.y(), 0);
  };
  const auto lines =
      area.apex() ? features::ScanLines::fan({in_slice(area.apex()->mm - image.grid.origin_mm)},
                                             area.apex()->radius_mm)
                  : features::ScanLines::parallel(
                        {in_slice(Eigen::Vector2d::UnitY())},
                        {in_slice(Eigen::Vector2d::Zero() - image.grid.origin_mm)});
  if (!lines) return fail(lines.error());
  const auto found =
      features::confidence(*volume, *lines, {}, {.threads = threads, .progress = {}});
  if (!found) return fail(found.error());
  std::vector<std::uint8_t> bytes(image.pixels.pixels().size());
  std::ranges::transform(*found->volume.values, bytes.begin(), [](float share) {
    return std::isnan(share) ? std::uint8_t{0}
                             : static_cast<std::uint8_t>(std::lround(
                                   255 * std::clamp(static_cast<double>(share), 0.0, 1.0)));
  });
  return Image2d<std::uint8_t>(width, height, std::move(bytes));
}

}  // namespace nav::app
