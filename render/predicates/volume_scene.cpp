// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/volume_scene.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace nav::render {

Scene predicate_scene(const PredicateVolume& volume, const PredicateModel& model, int width,
                      int height) {
  const VoxelGrid& grid = volume.ultrasound->grid();
  const Point<frames::Ct> centre = grid.centre();
  const Eigen::Vector3d from =
      grid.directions * Eigen::Vector3d(-0.5, -1, 0.45).normalized() * grid.extent_mm().norm();
  Camera camera{{centre.mm + 1.9 * from}, centre, {grid.directions.col(0)}};
  camera.vertical_fov_rad = 0.5;
  Scene scene{.ct = volume.ultrasound,
              .transfer = *TransferFunction::create(
                  "grey", {{0, {0, 0, 0}, 0, 1}, {255, {1, 1, 1}, 0.5, 1}}),
              .camera = camera};
  scene.shading.enabled = false;
  scene.width = width;
  scene.height = height;
  scene.predicates = volume.predicates;
  scene.predicates->model = model;
  return scene;
}

Scene standard_scene(const Scene& by_predicates) {
  Scene scene = by_predicates;
  const PredicateScene& p = *by_predicates.predicates;
  std::vector<TransferNode> nodes;
  constexpr int kNodes = 256;
  for (int i = 0; i < kNodes; ++i) {
    const double x = static_cast<double>(i) / (kNodes - 1);
    const double opacity = std::min(x, PredicateScene::kMostOpacity);
    // Short opacity lengths make white denser than an opacity of 1 mm can distinguish from 1.
    constexpr double kDensest = 1 - std::numeric_limits<double>::epsilon() / 2;
    const double of_1_mm = -std::expm1(std::log1p(-opacity) / p.opacity_length_mm);
    nodes.push_back({p.intensity.black + x * (p.intensity.white - p.intensity.black),
                     {x, x, x},
                     std::min(of_1_mm, kDensest),
                     1});
  }
  scene.transfer = *TransferFunction::create("grey", std::move(nodes));
  scene.predicates.reset();
  return scene;
}

}  // namespace nav::render
