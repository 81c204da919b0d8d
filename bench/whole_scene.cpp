// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/whole_scene.hpp"

#include <cmath>
#include <utility>
#include <vector>

namespace nav::bench {
namespace {

/// An image of stripes across the beam that darken with depth.
UltrasoundImage image(double side_mm) {
  constexpr int kPixels = 256;
  constexpr double kStripes = 24;
  std::vector<std::uint8_t> grey;
  grey.reserve(std::size_t{kPixels} * kPixels);
  for (int y = 0; y < kPixels; ++y) {
    for (int x = 0; x < kPixels; ++x) {
      const double depth = 1.0 * y / kPixels;
      const double stripe = 0.5 + 0.5 * std::sin(kStripes * depth + 3.0 * x / kPixels);
      grey.push_back(static_cast<std::uint8_t>(40 + 200 * stripe * (1 - 0.6 * depth)));
    }
  }
  UltrasoundImage frame;
  const double spacing_mm = side_mm / kPixels;
  frame.grid = PixelGrid::centred(kPixels, spacing_mm, spacing_mm);
  frame.pixels = {kPixels, kPixels, std::move(grey)};
  return frame;
}

}  // namespace

render::Scene with_everything(render::Scene scene) {
  constexpr double kShare = 0.4;  // Fraction of the CT's smallest extent.
  // Rad: an ultrasound image is hardly ever viewed perpendicularly.
  constexpr double kOffNormal = 0.6;
  const VoxelGrid& grid = scene.ct->grid();
  const double side_mm = kShare * grid.extent_mm().minCoeff();
  const Eigen::Vector3d centre = grid.centre().mm;
  const Eigen::Vector3d towards =
      (scene.camera.eye_ct.mm - scene.camera.look_at_ct.mm).normalized();
  const Eigen::Vector3d right = scene.camera.up_ct.v.cross(towards).normalized();
  const Eigen::Vector3d up = towards.cross(right);
  Eigen::Matrix3d axes;
  axes.col(0) = std::cos(kOffNormal) * right + std::sin(kOffNormal) * towards;
  axes.col(1) = -up;
  axes.col(2) = axes.col(0).cross(axes.col(1));
  const Safety valid{SafetyState::kValid, ""};
  scene.plane = render::UltrasoundPlane{
      image(side_mm), {Eigen::Quaterniond(axes), centre + 0.5 * side_mm * up}, 1.0, valid};
  const Eigen::Vector3d target = centre + 0.1 * side_mm * right;
  const Eigen::Vector3d entry = target + side_mm * (towards + 0.5 * up + 0.3 * right);
  const Eigen::Vector3d tip = target + 0.3 * (entry - target);
  scene.needle = render::NeedleShape{.tip_ct = {tip},
                                     .hub_ct = {tip + 1.2 * (entry - target)},
                                     .radius_mm = 0.01 * side_mm,
                                     .rgb = {0.95, 0.95, 1.0},
                                     .safety = valid};
  scene.spheres = {{{target}, 0.08 * side_mm, {1.0, 0.85, 0.1}, 0.45},
                   {{target}, 0.12 * side_mm, {1.0, 0.45, 0.2}, 0.25},
                   {{entry}, 0.02 * side_mm, {0.2, 0.7, 1.0}, 1.0}};
  scene.lines = {{.from_ct = {entry},
                  .to_ct = {target},
                  .radius_mm = 0.005 * side_mm,
                  .rgb = {0.2, 0.7, 1.0},
                  .opacity = 1.0},
                 {.from_ct = {entry},
                  .to_ct = {tip},
                  .radius_mm = 0.005 * side_mm,
                  .rgb = {1.0, 1.0, 1.0},
                  .opacity = 0.5}};
  scene.cutaway.emplace();
  return scene;
}

}  // namespace nav::bench
