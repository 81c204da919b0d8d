// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/gallery/gallery_views.hpp"

#include <cmath>
#include <utility>
#include <vector>

namespace nav::bench {

using Vec = Eigen::Vector3d;

render::Camera looking(const Vec& at, const Vec& from, double distance_mm) {
  constexpr double kFieldOfViewRad = 30 * M_PI / 180;
  render::Camera camera;
  camera.look_at_ct = {at};
  camera.eye_ct = {at + distance_mm * from.normalized()};
  camera.up_ct = {Vec::UnitZ()};
  camera.vertical_fov_rad = kFieldOfViewRad;
  return camera;
}

render::UltrasoundPlane coronal_slice(const Volume& volume, const Vec& centre, double width_mm,
                                      double height_mm, render::HuWindow window) {
  constexpr double kPixelMm = 0.45;
  const int width = static_cast<int>(std::lround(width_mm / kPixelMm));
  const int height = static_cast<int>(std::lround(height_mm / kPixelMm));
  Eigen::Matrix3d axes;  // Image x to the patient's left, y to the feet.
  axes << Vec::UnitX(), -Vec::UnitZ(), Vec::UnitX().cross(-Vec::UnitZ());
  const Transform<frames::Ct, frames::Image> pose(Eigen::Quaterniond(axes),
                                                  centre + Vec(0, 0, 0.5 * height * kPixelMm));
  UltrasoundImage frame;
  frame.grid = PixelGrid::centred(width, kPixelMm, kPixelMm);
  const auto slice = render::slice_along_image(volume, pose, frame.grid.origin_mm, kPixelMm, width,
                                               height, window);
  std::vector<std::uint8_t> grey;
  for (const Rgba8& p : slice.pixels()) grey.push_back(p.r);
  frame.pixels = {width, height, std::move(grey)};
  return {std::move(frame), pose, 1.0, {SafetyState::kValid, ""}};
}

}  // namespace nav::bench
