// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <gtest/gtest.h>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "render/engine.hpp"
#include "tests/support/matchers.hpp"

namespace nav::test {

/// A volume with voxels from a function of their indices.
inline std::shared_ptr<const StoredVolume> make_volume(
    const VoxelGrid& grid, const std::function<double(int, int, int)>& hu) {
  std::vector<std::int16_t> voxels;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        voxels.push_back(static_cast<std::int16_t>(std::lround(hu(i, j, k))));
      }
    }
  }
  return std::make_shared<StoredVolume>(
      *StoredVolume::create(grid, std::move(voxels), "test volume"));
}

/// A grid with its centre at the origin.
inline VoxelGrid centred_grid(std::array<int, 3> size, const Eigen::Vector3d& spacing_mm,
                              const Eigen::Matrix3d& directions = Eigen::Matrix3d::Identity()) {
  VoxelGrid grid;
  grid.size = size;
  grid.spacing_mm = spacing_mm;
  grid.directions = directions;
  grid.origin_mm = -grid.centre().mm;
  return grid;
}

/// A transfer function with one colour and one extinction for all values.
inline render::TransferFunction fog(double tau_per_mm,
                                    const Eigen::Vector3d& rgb = {1.0, 1.0, 1.0}) {
  const double opacity = -std::expm1(-tau_per_mm);
  return *render::TransferFunction::create("fog",
                                           {{-1000, rgb, opacity, 1}, {1000, rgb, opacity, 1}});
}

/// Invisible below 400 HU. Above 600 HU one voxel is nearly opaque.
inline render::TransferFunction solid(const Eigen::Vector3d& rgb) {
  return *render::TransferFunction::create(
      "solid", {{-1000, rgb, 0, 1}, {400, rgb, 0, 1}, {600, rgb, 1 - 1e-12, 1}});
}

/// A camera that looks along +y, from the front of the patient with the feet down. x grows to the
/// right.
inline render::Camera frontal(double distance_mm, double height_mm, bool orthographic) {
  render::Camera camera{{{0, -distance_mm, 0}}, {{0, 0, 0}}, {{0, 0, 1}}};
  camera.orthographic = orthographic;
  camera.orthographic_height_mm = height_mm;
  camera.vertical_fov_rad = 2 * std::atan(0.5 * height_mm / distance_mm);
  return camera;
}

/// A scene without shading and early termination, on black.
inline render::Scene plain_scene(std::shared_ptr<const StoredVolume> ct,
                                 render::TransferFunction transfer, render::Camera camera) {
  render::Scene scene{.ct = std::move(ct), .transfer = std::move(transfer), .camera = camera};
  scene.shading.enabled = false;
  scene.quality.opaque_at = 1;
  scene.width = 33;
  scene.height = 25;
  return scene;
}

/// A sheet across the view at the given distance. The values in front of it and behind it are on
/// both sides of the visible range, so nothing else is visible.
inline render::Scene sheet_scene(double distance_mm, int side) {
  static const auto ct = make_volume(centred_grid({48, 48, 48}, {1, 1, 1}),
                                     [](int, int j, int) { return j < 21 ? -1000 : 1000; });
  const auto sheet = *render::TransferFunction::create(
      "sheet", {{-500, {1, 1, 1}, 0, 1}, {0, {1, 1, 1}, 0.5, 1}, {500, {1, 1, 1}, 0, 1}});
  render::Scene scene = plain_scene(ct, sheet, frontal(distance_mm, 30, true));
  scene.width = scene.height = side;
  return scene;
}

inline render::RenderedImage draw(render::Engine& engine, const render::Scene& scene) {
  auto image = engine.render(scene);
  EXPECT_TRUE(has_value(image));
  if (!image) return {};
  for (const RgbaF& p : image->pixels.pixels()) {
    const bool sane = p.r >= 0 && p.r <= 1.0001F && p.g >= 0 && p.g <= 1.0001F && p.b >= 0 &&
                      p.b <= 1.0001F && p.a == 1.0F;
    EXPECT_TRUE(sane) << p.r << ' ' << p.g << ' ' << p.b << ' ' << p.a;
    if (!sane) break;
  }
  return *std::move(image);
}

/// The pixel in the middle. Images with odd sizes have one.
inline RgbaF middle(const render::RenderedImage& image) {
  return image.pixels.at(image.pixels.width() / 2, image.pixels.height() / 2);
}

inline float difference(const RgbaF& a, const RgbaF& b) {
  return std::max({std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b)});
}

/// True if all bits are equal.
inline bool same_bytes(const render::RenderedImage& a, const render::RenderedImage& b) {
  const auto x = a.pixels.pixels();
  const auto y = b.pixels.pixels();
  return x.size() == y.size() && std::memcmp(x.data(), y.data(), x.size_bytes()) == 0;
}

inline float max_difference(const render::RenderedImage& a, const render::RenderedImage& b) {
  float worst = 0;
  for (std::size_t i = 0; i < a.pixels.pixels().size(); ++i) {
    worst = std::max(worst, difference(a.pixels.pixels()[i], b.pixels.pixels()[i]));
  }
  return worst;
}

/// The position of a point in pixels, from the definition of a pinhole or parallel projection.
inline Eigen::Vector2d project(const render::Scene& scene, const Eigen::Vector3d& p_ct) {
  const render::Camera& c = scene.camera;
  const Eigen::Vector3d forward = (c.look_at_ct.mm - c.eye_ct.mm).normalized();
  const Eigen::Vector3d right = forward.cross(c.up_ct.v).normalized();
  const Eigen::Vector3d up = right.cross(forward);
  const Eigen::Vector3d d = p_ct - c.eye_ct.mm;
  const double height_mm = c.orthographic ? c.orthographic_height_mm
                                          : 2 * d.dot(forward) * std::tan(0.5 * c.vertical_fov_rad);
  const double pixels_per_mm = scene.height / height_mm;
  return {0.5 * scene.width + d.dot(right) * pixels_per_mm - 0.5,
          0.5 * scene.height - d.dot(up) * pixels_per_mm - 0.5};
}

/// The mean position weighted by brightness, in pixels.
inline Eigen::Vector2d centroid(const render::RenderedImage& image) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double weight = 0;
  for (int y = 0; y < image.pixels.height(); ++y) {
    for (int x = 0; x < image.pixels.width(); ++x) {
      const RgbaF& p = image.pixels.at(x, y);
      const double w = p.r + p.g + p.b;
      sum += w * Eigen::Vector2d(x, y);
      weight += w;
    }
  }
  return sum / weight;
}

/// An image plane parallel to the camera plane of frontal(): image x to the right (+x), image y
/// down (-z). So its normal x × y points along +y. top_middle_ct: the middle of the first row.
inline render::UltrasoundPlane upright_plane(Image2d<std::uint8_t> pixels, double spacing_mm,
                                             const Eigen::Vector3d& top_middle_ct) {
  Eigen::Matrix3d turn;
  turn << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  UltrasoundImage frame;
  frame.grid = PixelGrid::centred(pixels.width(), spacing_mm, spacing_mm);
  frame.pixels = std::move(pixels);
  return {frame, {Eigen::Quaterniond(turn), top_middle_ct}, 1.0, {SafetyState::kValid, ""}};
}

inline Image2d<std::uint8_t> grey_image(int width, int height, std::uint8_t value) {
  return {width, height,
          std::vector<std::uint8_t>(static_cast<std::size_t>(width * height), value)};
}

inline render::NeedleShape needle(const Eigen::Vector3d& tip_ct, const Eigen::Vector3d& hub_ct,
                                  SafetyState state = SafetyState::kValid) {
  return {.tip_ct = {tip_ct},
          .hub_ct = {hub_ct},
          .radius_mm = 0.8,
          .rgb = {0.95, 0.95, 1.0},
          .safety = {state, "test"}};
}

/// The name of the vector instructions that the CPU engine uses for these lanes. If the processor
/// lacks them, the engine uses others.
inline std::string lanes_found(render::CpuLanes lanes) {
  return render::make_cpu_engine({1, lanes})->device();
}

/// The vector instructions that this processor has, each once, as parameters of a test.
inline auto every_lanes() {
  using render::CpuLanes;
  std::vector<CpuLanes> all{CpuLanes::kPortable};
  for (const CpuLanes lanes : {CpuLanes::kAvx2, CpuLanes::kAvx512}) {
    if (lanes_found(lanes) != lanes_found(all.back())) all.push_back(lanes);
  }
  return ::testing::ValuesIn(all);
}

inline std::string lanes_name(const ::testing::TestParamInfo<render::CpuLanes>& info) {
  return info.param == render::CpuLanes::kPortable ? "portable"
         : info.param == render::CpuLanes::kAvx2   ? "avx2"
                                                   : "avx512";
}

/// The CPU engines that differ on this computer, for tests that all engines must pass.
struct EngineCase {
  const char* name;
  std::unique_ptr<render::Engine> (*make)();
};
inline const std::vector<EngineCase>& engine_cases() {
  using render::CpuLanes;
  static const std::vector<EngineCase> cases = [] {
    std::vector<EngineCase> found{{"reference", [] { return render::make_reference_engine(); }},
                                  {"vector", [] { return render::make_cpu_engine(); }}};
    const auto differs = [](CpuLanes lanes) {
      return lanes_found(lanes) != lanes_found(CpuLanes::kFastest);
    };
    if (differs(CpuLanes::kAvx2)) {
      found.push_back({"avx2", [] { return render::make_cpu_engine({0, CpuLanes::kAvx2}); }});
    }
    if (differs(CpuLanes::kPortable)) {
      found.push_back({"portable", [] {
                         return render::make_cpu_engine({0, CpuLanes::kPortable});
                       }});
    }
    return found;
  }();
  return cases;
}
class EngineTest : public ::testing::TestWithParam<EngineCase> {
 protected:
  std::unique_ptr<render::Engine> engine_ = GetParam().make();
};

}  // namespace nav::test
