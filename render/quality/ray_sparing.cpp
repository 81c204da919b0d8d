// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/quality/ray_sparing.hpp"

#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "render/quality/sparse_rays.hpp"
#include "render/spec/ray_spec.hpp"

namespace nav::render {
namespace {

constexpr int kTileColumns = 8;
constexpr int kTileRows = 8;
constexpr int kTileSide = 13;  // In pixels: whole squares of a lattice of 4 and of 2.
constexpr double kPixelErrors[] = {0.025, 0.012};  // The errors of larger values show in few
                                                   // positions only.

// Costs of the CPU engine, in volume samples. Fitted to the process times of 252 sparse images of
// 28 views; they predict the ratio to dense images to 6 % (a standard deviation).
constexpr double kGradientSamples = 1.9;
constexpr double kRaySamples = 20;
constexpr double kMeanSamples = 9;  // An interpolated pixel.
// Costs of rays that lie apart: such rays seldom find the same at the same depth.
constexpr double kScattered = 1.2;  // A sample, relative to one of a dense image.
constexpr double kScatteredRaySamples = 35;

/// A part of the image around a pixel, at the image's own resolution. In perspective the camera
/// turns towards the pixel, which gives the same rays except for their slant.
Scene tile_of(const Scene& scene, int tile) {
  Scene part = scene;
  const auto view =
      spec::make_view<double>(scene.camera, scene.width, scene.height, scene.ct->grid());
  const auto x = (2 * (tile % kTileColumns) + 1) * scene.width / (2 * kTileColumns);
  const auto y = (2 * (tile / kTileColumns) + 1) * scene.height / (2 * kTileRows);
  const auto ray = spec::ray_of(view, x, y);
  const Eigen::Vector3d eye = ray.origin + scene.ct->grid().origin_mm;
  part.camera.eye_ct.mm = eye;
  part.camera.look_at_ct.mm = eye + ray.direction;
  part.camera.up_ct.v = view.up;  // Never parallel to the ray.
  part.width = part.height = kTileSide;
  const double share = static_cast<double>(kTileSide) / scene.height;
  part.camera.orthographic_height_mm *= share;
  part.camera.vertical_fov_rad = 2 * std::atan(share * std::tan(scene.camera.vertical_fov_rad / 2));
  return part;
}

ImageCost cost_of(const RenderStatistics& taken, const Quality& quality) {
  const bool dense = quality.pixel_error == 0;
  // Includes the samples that the engine passed over: their number depends on what it has drawn
  // before.
  const double samples = static_cast<double>(taken.volume_samples + taken.passed_samples) +
                         kGradientSamples * static_cast<double>(taken.gradient_samples);
  const double rays =
      (dense ? kRaySamples : kScatteredRaySamples) * static_cast<double>(taken.rays) +
      kMeanSamples * static_cast<double>(taken.pixels_without_ray);
  constexpr double kPixels = kTileSide * kTileSide;
  return {(dense ? 1 : kScattered) * quality.step_voxels * samples / kPixels, rays / kPixels};
}

/// A tile after it was drawn.
struct DrawnTile {
  Image2d<RgbaF> pixels;
  ImageCost cost;
};

Result<std::vector<DrawnTile>> draw_tiles(Engine& engine, const Scene& scene, double pixel_error) {
  std::vector<DrawnTile> drawn;
  for (int i = 0; i < kTileColumns * kTileRows; ++i) {
    Scene tile = tile_of(scene, i);
    tile.quality.pixel_error = pixel_error;
    auto image = engine.render(tile);
    if (!image) return image.error();
    drawn.push_back({std::move(image->pixels), cost_of(image->statistics, tile.quality)});
  }
  return drawn;
}

ImageCost mean_cost(const std::vector<DrawnTile>& tiles) {
  ImageCost mean;
  for (const DrawnTile& tile : tiles) {
    mean.samples_at_one_voxel += tile.cost.samples_at_one_voxel / static_cast<double>(tiles.size());
    mean.rays += tile.cost.rays / static_cast<double>(tiles.size());
  }
  return mean;
}

Estimate error_of(const std::vector<DrawnTile>& spared, const std::vector<DrawnTile>& dense) {
  std::vector<double> squares;
  for (std::size_t i = 0; i < dense.size(); ++i) {
    squares.push_back(std::pow(rms_difference(spared[i].pixels, dense[i].pixels), 2));
  }
  return Estimate::of(squares);
}

/// Tests whether sparing rays leaves little enough of the cost, by more than chance in these
/// positions.
bool pays(const std::vector<DrawnTile>& spared, const std::vector<DrawnTile>& dense,
          double step_voxels) {
  std::vector<double> saved;
  for (std::size_t i = 0; i < dense.size(); ++i) {
    saved.push_back(kSparingWorthwhile * dense[i].cost.at(step_voxels) -
                    spared[i].cost.at(step_voxels));
  }
  const Estimate found = Estimate::of(saved);
  return found.mean > found.deviation;
}

}  // namespace

Estimate Estimate::of(std::span<const double> values) {
  const double count = static_cast<double>(values.size());
  if (values.size() < 2) {
    return {values.empty() ? 0 : values[0], std::numeric_limits<double>::infinity()};
  }
  double sum = 0;
  for (const double value : values) sum += value;
  const double mean = sum / count;
  double scatter = 0;
  for (const double value : values) scatter += (value - mean) * (value - mean);
  return {mean, std::sqrt(scatter / (count - 1) / count)};
}

Result<std::vector<Sparing>> ray_sparings(Engine& engine, const Scene& scene, double step_voxels) {
  std::vector<Sparing> found;
  Scene few = scene;
  few.quality.step_voxels = step_voxels;
  few.quality.pixel_error = kPixelErrors[0];
  const bool large =
      scene.width >= kTileColumns * kTileSide && scene.height >= kTileRows * kTileSide;
  if (!large || !sparse_rays(few)) return found;
  const auto dense = draw_tiles(engine, few, 0);
  if (!dense) return dense.error();
  found.push_back({0, {}, mean_cost(*dense)});
  for (const double pixel_error : kPixelErrors) {
    const auto spared = draw_tiles(engine, few, pixel_error);
    if (!spared) return spared.error();
    // A smaller pixel error spares fewer rays.
    if (!pays(*spared, *dense, step_voxels)) break;
    found.push_back({pixel_error, error_of(*spared, *dense), mean_cost(*spared)});
  }
  return found;
}

}  // namespace nav::render
