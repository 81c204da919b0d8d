// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <random>

#include "tests/render/gl/gl_scenes.hpp"

namespace nav::test {

/// Random scenes from a seed. Every element of an image comes and goes.
class RandomScenes {
 public:
  explicit RandomScenes(unsigned seed) : random_(seed) {}

  render::Scene next() {
    const VoxelGrid grid = coin(0.5) ? oblique_grid() : cube_grid(20 + pick(30), 1.0);
    render::Scene scene = ball_scene(grid, 48, 36);
    if (coin(0.3)) scene.ct = noise(grid);
    scene.transfer = transfer();
    set_camera(scene);
    set_shading(scene.shading);
    scene.quality.opaque_at = 1;
    scene.quality.step_voxels = std::array{0.3, 0.5, 1.0, 1.7, 3.0}[index(5)];
    scene.quality.jitter = coin(0.3);
    if (coin(0.3)) scene.quality.classification = render::Classification::kPostClassified;
    if (coin(0.2)) scene.projection = static_cast<render::Projection>(1 + pick(3));
    scene.grey = {number(-200, 400), number(200, 2000)};
    add_surfaces(scene);
    if (coin(0.6)) scene.cutaway = cutaway(grid);
    return scene;
  }

  /// Replaces some fields of the scene by those of another random scene. Sometimes also changes the
  /// ultrasound image, its safety state, or its position a little.
  void edit(render::Scene& scene) {
    render::Scene other = next();
    const auto take = [&](auto member) {
      if (coin(0.15)) std::swap(scene.*member, other.*member);
    };
    take(&render::Scene::ct);
    take(&render::Scene::transfer);
    take(&render::Scene::shading);
    take(&render::Scene::plane);
    take(&render::Scene::needle);
    take(&render::Scene::spheres);
    take(&render::Scene::lines);
    take(&render::Scene::camera);
    take(&render::Scene::quality);
    take(&render::Scene::cutaway);
    take(&render::Scene::projection);
    take(&render::Scene::grey);
    if (coin(0.1)) scene.background_rgb = colour();
    if (coin(0.1)) scene.width = 30 + pick(40);
    if (coin(0.2)) scene.quality.pixel_error = coin(0.5) ? number(0.01, 0.2) : 0;
    if (scene.plane && coin(0.3)) edit(*scene.plane);
    if (scene.needle && coin(0.2)) scene.needle->tip_ct.mm += vector(1);
    if (scene.cutaway && coin(0.1)) scene.cutaway->overlay_mm = number(0, 20);
  }

  /// Changes the transfer function, the camera and the step, so that the program stays the same.
  void vary(render::Scene& scene) {
    const bool windows = scene.transfer.uses_gradient();
    do {
      scene.transfer = transfer();
    } while (scene.transfer.uses_gradient() != windows);
    const bool orthographic = scene.camera.orthographic;
    const Point<frames::Ct> middle = scene.camera.look_at_ct;
    set_camera(scene);
    scene.camera.look_at_ct.mm = 0.5 * (scene.camera.look_at_ct.mm + middle.mm);  // Stays near.
    scene.camera.orthographic = orthographic;
    scene.quality.step_voxels = std::array{0.3, 0.5, 1.0, 1.7, 3.0}[index(5)];
  }

 private:
  void edit(render::UltrasoundPlane& plane) {
    if (coin(0.6)) {
      std::vector<std::uint8_t> pixels(plane.frame.pixels.pixels().size());
      for (std::uint8_t& grey : pixels) grey = static_cast<std::uint8_t>(pick(256));
      const auto& before = plane.frame.pixels;
      plane.frame.pixels = {before.width(), before.height(), std::move(pixels)};
    }
    if (coin(0.3)) plane.safety.state = state();
    if (coin(0.3)) {
      const auto& pose = plane.ct_from_image;
      plane.ct_from_image = {pose.rotation(), pose.translation_mm() + vector(1)};
    }
  }
  double number(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  bool coin(double chance) { return number(0, 1) < chance; }
  int pick(int count) { return static_cast<int>(number(0, count - 1e-9)); }
  std::size_t index(int count) { return static_cast<std::size_t>(pick(count)); }
  Eigen::Vector3d vector(double size) {
    return {number(-size, size), number(-size, size), number(-size, size)};
  }
  Eigen::Vector3d colour() { return {number(0, 1), number(0, 1), number(0, 1)}; }
  SafetyState state() {
    return std::array{SafetyState::kValid, SafetyState::kDegraded, SafetyState::kStale,
                      SafetyState::kLost}[index(4)];
  }

  std::shared_ptr<const StoredVolume> noise(const VoxelGrid& grid) {
    std::vector<std::int16_t> hu;
    for (std::size_t i = 0; i < grid.voxel_count(); ++i) {
      hu.push_back(static_cast<std::int16_t>(number(-1000, 500)));
    }
    return std::make_shared<const StoredVolume>(
        *StoredVolume::create(grid, std::move(hu), "noise"));
  }

  render::TransferComponent component() {
    render::TransferComponent c{"c", {}, {}};
    double hu = number(-900, 300);
    const int nodes = 2 + pick(4);
    for (int i = 0; i < nodes; ++i) {
      const bool clear = i == 0 || coin(0.2);
      const double opacity = clear ? 0 : std::pow(10.0, number(-4, -0.1));
      c.nodes.push_back({hu, colour(), opacity, coin(0.2) ? 1.0 : number(0, 1)});
      hu += number(20, 500);
    }
    if (coin(0.15)) {
      const double low = number(0, 40);
      c.gradient = {low, low + number(1, 50), low + number(60, 200), low + number(250, 400)};
    }
    return c;
  }

  render::TransferFunction transfer() {
    std::vector<render::TransferComponent> components;
    for (int i = 1 + pick(3); i > 0; --i) components.push_back(component());
    return *render::TransferFunction::blend("random", std::move(components));
  }

  void set_camera(render::Scene& scene) {
    render::Camera& camera = scene.camera;
    const double size = scene.ct->grid().extent_mm().maxCoeff();
    const double distance = coin(0.1) ? 0.2 * size : number(0.8, 6) * size;
    camera.eye_ct.mm = camera.look_at_ct.mm + distance * vector(1).normalized();
    camera.look_at_ct.mm += vector(0.1 * size);
    camera.up_ct.v = vector(1).normalized();
    camera.orthographic = coin(0.4);
    camera.vertical_fov_rad = std::min(2.0, 1.3 * size / distance);
  }

  void set_shading(render::Shading& shading) {
    shading.enabled = coin(0.7);
    shading.style = coin(0.5) ? render::ShadingStyle::kPhong : render::ShadingStyle::kGooch;
    shading.emphasis = coin(0.5) ? number(0, 1) : 0;
    shading.full_gradient_per_mm = number(1, 200);
    shading.silhouette = number(0, 1);
  }

  void add_surfaces(render::Scene& scene) {
    const VoxelGrid& grid = scene.ct->grid();
    const double size = grid.extent_mm().minCoeff();
    const Eigen::Vector3d centre = grid.centre().mm;
    if (coin(0.6)) {
      scene.plane = test_plane(grid, state());
      scene.plane->opacity = coin(0.5) ? 1 : number(0.1, 1);
      if (coin(0.5)) scene.plane->frame.outline = SectorOutline{{0, -10}, 12, 45, 0.5};
    }
    if (coin(0.4)) scene.needle = test_needle(grid, state());
    if (coin(0.4)) scene.spheres = test_spheres(grid);
    for (int i = pick(3); i > 0; --i) {
      scene.lines.push_back({.from_ct = {centre + vector(0.5 * size)},
                             .to_ct = {centre + vector(0.5 * size)},
                             .radius_mm = number(0.01, 0.05) * size,
                             .rgb = colour(),
                             .opacity = number(0.1, 1)});
    }
  }

  render::Cutaway cutaway(const VoxelGrid& grid) {
    const double size = grid.extent_mm().minCoeff();
    const Eigen::Vector3d centre = grid.centre().mm;
    render::Cutaway cut;
    cut.theta1_rad = number(0.1, 1);
    cut.theta2_rad = coin(0.3) ? cut.theta1_rad : number(cut.theta1_rad, 1.4);
    cut.overlay_mm = coin(0.2)   ? 0
                     : coin(0.1) ? std::numeric_limits<double>::infinity()
                                 : number(0, size);
    cut.around_needle = coin(0.5);
    cut.around_spheres = coin(0.5);
    if (coin(0.4)) {
      const Eigen::Vector3d u = vector(1).normalized();
      const Eigen::Vector3d v = u.cross(vector(1)).normalized();
      render::PolygonObject polygon;
      const int count = 2 + pick(8);
      for (int i = 0; i < count; ++i) {
        const double angle = 2 * M_PI * i / count;
        const double radius = number(0.05, 0.4) * size;
        polygon.vertices_ct.push_back(
            {centre + radius * (std::cos(angle) * u + std::sin(angle) * v)});
      }
      cut.polygons.push_back(polygon);
    }
    if (coin(0.3)) {
      const Eigen::Matrix3d turn =
          Eigen::AngleAxisd(number(0, 3), vector(1).normalized()).toRotationMatrix();
      cut.boxes.push_back({{centre + vector(0.2 * size)}, 0.1 * size * turn});
    }
    return cut;
  }

  std::mt19937 random_;
};

}  // namespace nav::test
