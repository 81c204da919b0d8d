// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <memory>
#include <vector>

#include "render/scene.hpp"

namespace nav::test {

/// A ball of bone with a hollow, inside a ball of soft tissue, in air. The transitions are smooth
/// and one voxel wide. A small dense sphere beside the centre makes mirroring visible.
inline std::shared_ptr<const StoredVolume> ball_phantom(VoxelGrid grid) {
  std::vector<std::int16_t> hu;
  hu.reserve(grid.voxel_count());
  const Eigen::Vector3d centre = grid.centre().mm;
  const double size_mm = grid.extent_mm().minCoeff();
  const double soft_mm = grid.spacing_mm.maxCoeff();
  // 1 inside, 0 outside.
  const auto inside = [&](double distance_mm, double radius_mm) {
    return std::clamp((radius_mm - distance_mm) / soft_mm + 0.5, 0.0, 1.0);
  };
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const Eigen::Vector3d p = grid.at({double(i), double(j), double(k)}).mm - centre;
        const double r = p.norm();
        const Eigen::Vector3d aside(0.3 * size_mm, 0.1 * size_mm, 0.05 * size_mm);
        double value = -1000 + 1050 * inside(r, 0.45 * size_mm);
        value += 800 * (inside(r, 0.28 * size_mm) - inside(r, 0.2 * size_mm));
        value += 1200 * inside((p - aside).norm(), 0.06 * size_mm);
        hu.push_back(static_cast<std::int16_t>(std::lround(value)));
      }
    }
  }
  return std::make_shared<const StoredVolume>(
      *StoredVolume::create(grid, std::move(hu), "ball phantom"));
}

inline VoxelGrid cube_grid(int n, double spacing_mm) {
  VoxelGrid grid;
  grid.size = {n, n, n};
  grid.spacing_mm.setConstant(spacing_mm);
  grid.origin_mm.setConstant(-0.5 * spacing_mm * (n - 1));
  return grid;
}

/// Anisotropic, rotated and left-handed, far from the origin. The sizes are no multiples of a
/// brick.
inline VoxelGrid oblique_grid() {
  VoxelGrid grid;
  grid.size = {61, 45, 37};
  grid.spacing_mm = {0.8, 1.1, 1.4};
  grid.origin_mm = {5300, -4100, 800};
  grid.directions =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  grid.directions.col(2) *= -1;
  return grid;
}

/// Soft tissue is half transparent and bone nearly opaque. The nodes are at whole HU.
inline render::TransferFunction test_transfer() {
  return *render::TransferFunction::create("test", {{-1000, {0.8, 0.6, 0.5}, 0.0, 0.0},
                                                    {-300, {0.8, 0.6, 0.5}, 0.0, 0.0},
                                                    {50, {0.9, 0.5, 0.4}, 0.02, 0.3},
                                                    {400, {1.0, 0.9, 0.7}, 0.4, 0.8},
                                                    {1500, {1.0, 1.0, 1.0}, 0.8, 1.0}});
}

/// The phantom on a grid, seen from an oblique direction so that it fills the image.
inline render::Scene ball_scene(const VoxelGrid& grid, int width = 96, int height = 72) {
  const double size_mm = grid.extent_mm().maxCoeff();
  const Eigen::Vector3d centre = grid.centre().mm;
  render::Camera camera;
  camera.look_at_ct.mm = centre;
  camera.eye_ct.mm = centre + size_mm * Eigen::Vector3d(1.1, -1.9, 0.7);
  camera.up_ct.v = Eigen::Vector3d::UnitZ();
  camera.orthographic_height_mm = 1.2 * size_mm;
  return {.ct = ball_phantom(grid),
          .transfer = test_transfer(),
          .shading = {},
          .plane = {},
          .needle = {},
          .spheres = {},
          .camera = camera,
          .quality = {},
          .background_rgb = {0.1, 0.2, 0.3},
          .width = width,
          .height = height,
          .lines = {},
          .cutaway = {},
          .projection = render::Projection::kComposite,
          .grey = {}};
}

/// An ultrasound image with a ramp and a checkerboard. It passes through the middle of a volume and
/// faces the camera of ball_scene() at an angle.
inline render::UltrasoundPlane test_plane(const VoxelGrid& grid, SafetyState state) {
  constexpr int kWidth = 40;
  constexpr int kHeight = 30;
  std::vector<std::uint8_t> pixels;
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      const bool dark = (row / 5 + column / 5) % 2 == 0;
      pixels.push_back(static_cast<std::uint8_t>(dark ? 2 * column : 100 + 5 * row));
    }
  }
  const double size_mm = grid.extent_mm().minCoeff();
  UltrasoundImage frame{
      .acquired = {},
      .received = {},
      .sequence = 1,
      .pixels = {kWidth, kHeight, std::move(pixels)},
      .grid = PixelGrid::centred(kWidth, 0.8 * size_mm / kWidth, 0.8 * size_mm / kHeight),
      .outline = {}};
  frame.grid.mm_per_pixel(0, 1) = 0.1 * frame.grid.mm_per_pixel(0, 0);  // A sheared calibration.
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.4, Eigen::Vector3d(0.2, 0.5, 1).normalized()) *
                                Eigen::AngleAxisd(-1.2, Eigen::Vector3d::UnitX()));
  const Eigen::Vector3d origin = grid.centre().mm - turn * Eigen::Vector3d(0, 0.4 * size_mm, 0);
  return {
      std::move(frame), {turn, origin}, 1.0, {state, state == SafetyState::kValid ? "" : "test"}};
}

inline render::NeedleShape test_needle(const VoxelGrid& grid, SafetyState state) {
  const double size_mm = grid.extent_mm().minCoeff();
  const Eigen::Vector3d centre = grid.centre().mm;
  return {.tip_ct = {centre + size_mm * Eigen::Vector3d(0.25, -0.1, 0.1)},
          .hub_ct = {centre + size_mm * Eigen::Vector3d(0.1, -0.9, 0.6)},
          .radius_mm = 0.02 * size_mm,
          .rgb = {0.95, 0.95, 1.0},
          .safety = {state, state == SafetyState::kValid ? "" : "test"}};
}

/// A ball of triangles: 12 around, 8 from pole to pole.
inline std::shared_ptr<const render::MeshObject> ball_mesh(const Eigen::Vector3d& centre_ct,
                                                           double radius_mm) {
  constexpr int kAround = 12;
  constexpr int kDown = 8;
  auto mesh = std::make_shared<render::MeshObject>();
  for (int j = 0; j <= kDown; ++j) {
    for (int i = 0; i < kAround; ++i) {
      const double a = 2 * M_PI * i / kAround;
      const double b = M_PI * j / kDown;
      const Eigen::Vector3d out(std::sin(b) * std::cos(a), std::sin(b) * std::sin(a), std::cos(b));
      mesh->vertices_ct.push_back({centre_ct + radius_mm * out});
    }
  }
  for (int j = 0; j < kDown; ++j) {
    for (int i = 0; i < kAround; ++i) {
      const int a = j * kAround + i;
      const int b = j * kAround + (i + 1) % kAround;
      mesh->triangles.push_back({a, b, a + kAround});
      mesh->triangles.push_back({b, b + kAround, a + kAround});
    }
  }
  return mesh;
}

inline std::vector<render::SphereShape> test_spheres(const VoxelGrid& grid) {
  const double size_mm = grid.extent_mm().minCoeff();
  const Eigen::Vector3d centre = grid.centre().mm;
  return {
      {{centre + size_mm * Eigen::Vector3d(0.2, -0.35, 0.0)}, 0.12 * size_mm, {1, 0.8, 0.1}, 0.5},
      {{centre + size_mm * Eigen::Vector3d(0.25, -0.3, 0.1)}, 0.1 * size_mm, {0.2, 0.8, 1}, 0.3},
      {{centre + size_mm * Eigen::Vector3d(-0.5, -0.2, 0.3)}, 0.08 * size_mm, {0.3, 1, 0.3}, 1}};
}

}  // namespace nav::test
