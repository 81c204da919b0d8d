// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "render/features/derived_features.hpp"
#include "render/predicates/predicate_sampler.hpp"
#include "render/predicates/shading_source.hpp"
#include "tests/render/scene_support.hpp"

/// Scenes that engines draw by predicates.
namespace nav::test {

inline render::PredicateModel model_of(
    std::vector<std::pair<render::PredicateExpression, double>> entries, double saturation = 0.6) {
  render::PredicateModel model;
  std::vector<render::PredicateHistogram::Bar> bars;
  for (auto& [expression, importance] : entries) {
    const double index = static_cast<double>(bars.size());
    model.entries.push_back({"entry " + std::to_string(bars.size()), expression});
    bars.push_back({importance, 75 * index, saturation});
  }
  model.histogram = *render::PredicateHistogram::create(std::move(bars));
  return model;
}

/// Makes a feature from a function of the voxel.
inline render::FeatureVolume feature(const VoxelGrid& grid, const std::string& name,
                                     const std::function<double(int, int, int)>& value) {
  std::vector<float> values;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) values.push_back(static_cast<float>(value(i, j, k)));
    }
  }
  return *render::FeatureVolume::create(grid, values, name);
}

/// Adds the features that the predicates read and that the scene does not have.
inline Result<void> add_features(const std::shared_ptr<const StoredVolume>& ct, double smoothing_mm,
                                 render::PredicateScene& predicates) {
  render::DerivedFeatureOptions options;
  options.gradient.smoothing_mm = smoothing_mm;
  render::features::DerivedVolumes service;
  return render::add_derived_features(ct, options, service, predicates);
}

/// A small model of ultrasound, 0 to 255: speckle, a bright layer, and a dark tube with a wall.
inline std::shared_ptr<const StoredVolume> small_ultrasound(const VoxelGrid& grid, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  const Eigen::Vector3d n(grid.size[0], grid.size[1], grid.size[2]);
  return make_volume(grid, [&](int i, int j, int k) {
    const double across = std::hypot(j / n.y() - 0.6, k / n.z() - 0.5);
    const double depth = j / n.y();
    double v = 60 * std::sqrt(-2 * std::log(1 - 0.999 * unit(random))) * (1 - 0.6 * depth);
    if (std::abs(depth - 0.25) < 0.06) v += 120;
    if (across < 0.12) v *= 0.1;
    if (std::abs(across - 0.15) < 0.03) v += 90;
    if (i < 3) v = 0;
    return std::min(v, 255.0);
  });
}

/// Features of all names, some with undefined voxels, and labels.
inline render::Features random_features(const std::shared_ptr<const StoredVolume>& ct,
                                        unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  const VoxelGrid& grid = ct->grid();
  render::Features out;
  for (const char* name :
       {render::feature::kSnr, render::feature::kVesselness, render::feature::kConfidence}) {
    const double period = 4 + 8 * unit(random);
    const bool holes = unit(random) < 0.4;
    out.volumes.emplace(name, feature(grid, name, [&](int i, int j, int k) {
                          if (holes && i > 8 && j > 8 && k > 3 && unit(random) < 0.05) {
                            return std::nan("");
                          }
                          return 0.5 +
                                 0.5 * std::sin((i + 0.7 * j) / period) * std::cos(k / period);
                        }));
  }
  std::vector<std::uint32_t> labels;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        labels.push_back((j < 9 ? 1U : 2U) | (i + k > 30 ? 0x80000000U : 0U));
      }
    }
  }
  out.labels = *render::LabelVolume::create(grid, std::move(labels), "layers");
  return out;
}

/// A predicate of the library with parameters that split the volumes above.
inline render::PredicateExpression random_leaf(std::mt19937& random) {
  using E = render::PredicateExpression;
  std::uniform_real_distribution<double> unit(0, 1);
  const double low = 0.6 * unit(random);
  switch (random() % 9) {
    case 0:
      return E::kind("intensity", {low, low + 0.3});
    case 1:
      return E::kind("gradient_magnitude", {0.1 * low, 0.1 * low + 0.1});
    case 2:
      return E::kind("gradient_angle", {low, low + 1.2, 0.003});
    case 3:
      return E::kind("snr", {low, low + 0.4});
    case 4:
      return E::kind("vesselness", {low, low + 0.4});
    case 5:
      return E::kind("label", {random() % 2 == 0 ? 1.0 : 2147483648.0});
    case 6:
      return E::kind("depth", {15 * low, 15 * low + 8});
    case 7:
      return E::kind("needle_distance", {-1, 3 + 6 * low});
    default:
      return E::kind("target_distance", {-20, 6 * low});
  }
}

inline render::PredicateExpression random_expression(std::mt19937& random, int depth) {
  using E = render::PredicateExpression;
  const auto kind = random() % (depth > 0 ? 5 : 1);
  if (kind < 2) return random_leaf(random);
  if (kind == 2) return E::negation(random_expression(random, depth - 1));
  const E a = random_expression(random, depth - 1);
  const E b = random_expression(random, depth - 1);
  return kind == 3 ? E::all({a, b}) : E::any({a, b});
}

/// Models for each method to composite: equal importances, few predicates, many predicates.
inline render::PredicateModel random_model(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  const bool equal = random() % 5 == 0;
  const std::size_t count = random() % 4 == 0 ? 9 + random() % 8 : 1 + random() % 4;
  std::vector<std::pair<render::PredicateExpression, double>> entries;
  for (std::size_t j = 0; j < count; ++j) {
    const int depth = count > 8 ? 0 : 2;
    const double k = unit(random) < 0.15 ? 0 : std::pow(unit(random), 2) + 1e-3;
    entries.emplace_back(random_expression(random, depth), equal ? 1 : k);
  }
  entries[0].second = 1;
  return model_of(std::move(entries));
}

/// A scene with all data that predicates can read, from a random direction. Models with an odd
/// number of entries are shaded.
inline render::Scene random_predicate_scene(std::mt19937& random,
                                            const std::shared_ptr<const StoredVolume>& ct,
                                            const render::Features& features) {
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto vector = [&](double size) {
    return Eigen::Vector3d(size * unit(random), size * unit(random), size * unit(random));
  };
  render::Camera camera{{vector(60)}, {vector(4)}, {vector(1)}};
  camera.orthographic = unit(random) > 0.5;
  camera.orthographic_height_mm = 35;
  camera.vertical_fov_rad = 0.7;
  render::Scene scene{
      .ct = ct, .transfer = *render::preset_transfer_function("ct-bone"), .camera = camera};
  scene.quality.step_voxels = std::pow(2.0, unit(random));
  scene.quality.jitter = unit(random) > 0.5;
  scene.width = 27;
  scene.height = 21;
  scene.background_rgb = {0.1, 0.2, 0.3};
  scene.needle = needle(vector(8), vector(30));
  scene.spheres.push_back({{vector(8)}, 2, {1, 0.8, 0.1}, 0.5});
  if (unit(random) > 0) {
    scene.plane = upright_plane(grey_image(20, 16, 120), 1, vector(8));
    scene.plane->opacity = 0.6;
  }
  render::PredicateScene predicates{random_model(random), features};
  predicates.opacity_length_mm = 1 + 3 * std::abs(unit(random));
  predicates.scan = render::FanScan{{{0, -40, 0}}, 20};
  EXPECT_TRUE(has_value(add_features(ct, 0.4, predicates)));
  if (predicates.model.entries.size() % 2 == 1) {
    auto shading = render::shading_of_predicates(*ct, {}, 0.8, 0.05, 1);
    EXPECT_TRUE(has_value(shading));
    predicates.shading = *std::move(shading);
  }
  scene.predicates = std::move(predicates);
  if (unit(random) > 0.3) {
    scene.cutaway.emplace();
    scene.cutaway->around_needle = true;
    scene.cutaway->overlay_mm = 8 * std::abs(unit(random));
  }
  return scene;
}

/// A scene that tests early ends. It has layers along the view. Their labels have nearly the same
/// importance. Each square of rays goes through other labels. The light behind the first layer is
/// hardly more than the permitted error. Dark and bright layers follow. Layers and squares are two
/// bricks wide, so that each brick knows its labels.
inline render::Scene layered_scene(unsigned seed, double error) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  constexpr int kLabels = 8;
  constexpr int kSide = 96;
  constexpr int kWide = 16;
  const VoxelGrid grid = centred_grid({kSide, kSide, kSide}, {1, 1, 1});
  const double opacity_length_mm = std::pow(10, -1 + 2 * unit(random));
  struct Block {
    int label;
    double value;
  };
  std::vector<Block> blocks;
  for (int n = 0; n < kSide / kWide * kSide / kWide * kSide / kWide; ++n) {
    const int layer = n / (kSide / kWide) % (kSide / kWide);
    const double left = error * (0.3 + 0.3 * unit(random));
    const double first = 1 - std::pow(left, opacity_length_mm / kWide);
    const double other = std::pow(unit(random), unit(random) < 0.5 ? 0.1 : 4);
    blocks.push_back(
        {static_cast<int>(kLabels * unit(random)), 255 * (layer == 0 ? first : other)});
  }
  std::vector<std::uint32_t> bits;
  const auto ct = make_volume(grid, [&](int i, int j, int k) {
    const int n = (k / kWide * (kSide / kWide) + j / kWide) * (kSide / kWide) + i / kWide;
    const Block& block = blocks[static_cast<std::size_t>(n)];
    bits.push_back(1U << block.label);
    return std::lround(block.value);
  });
  render::Scene scene = plain_scene(ct, fog(0.1), frontal(200, kSide, true));
  scene.width = scene.height = 48;
  scene.quality.step_voxels = 1;
  scene.predicates.emplace();
  const double spread = std::pow(10, -3 + 3 * unit(random));
  std::vector<std::pair<render::PredicateExpression, double>> entries;
  for (int label = 0; label < kLabels; ++label) {
    entries.emplace_back(render::PredicateExpression::kind("label", {std::exp2(label)}),
                         1 + spread * unit(random));
  }
  scene.predicates->model = model_of(std::move(entries), 1);
  scene.predicates->features.labels = *render::LabelVolume::create(grid, std::move(bits), "layers");
  scene.predicates->opacity_length_mm = opacity_length_mm;
  scene.predicates->termination_error = error;
  return scene;
}

/// Draws layered scenes with and without early ends. Seeds 106 and 733 come nearest to their error
/// of 800 seeds. draw: a function from a scene to its RenderedImage.
template <class Draw>
void expect_layers_within_error(const Draw& draw) {
  std::uint64_t with = 0;
  std::uint64_t without = 0;
  for (const unsigned seed : {0U, 1U, 2U, 3U, 4U, 5U, 6U, 7U, 8U, 9U, 106U, 733U}) {
    const double error = seed % 2 == 0 ? 0.05 : 0.2;
    render::Scene scene = layered_scene(seed, error);
    const render::RenderedImage fast = draw(scene);
    scene.predicates->termination_error = 0;
    const render::RenderedImage full = draw(scene);
    EXPECT_LE(max_difference(fast, full), error + 1e-4) << seed;
    with += fast.statistics.volume_samples;
    without += full.statistics.volume_samples;
  }
  EXPECT_LT(with, without * 9 / 10) << "nothing was left out";
}

}  // namespace nav::test
