// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/predicate_phantom.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/scene_set.hpp"
#include "io/ct.hpp"
#include "render/features/derived_features.hpp"

namespace nav::bench {
namespace {

using render::PredicateExpression;
using E = PredicateExpression;

constexpr double kSideMm = 40;

/// Distance of a point from the vessel's axis, mm, and the radius there: a tube that forks.
double off_vessel(const Eigen::Vector3d& p) {
  const double bend = 3 * std::sin(p.x() / 9);
  const double fork = std::max(0.0, p.x() - 22) * 0.35;
  const double y = p.y() - 22 - bend;
  const double left = std::hypot(y, p.z() - 20 - fork) - 2.6;
  const double right = std::hypot(y, p.z() - 20 + fork) - 2.2;
  return std::min(left, right);
}

/// Counter-based noise in (0, 1].
double noise(std::uint64_t i) {
  std::uint64_t x = (i + 1) * 0x9E3779B97F4A7C15U;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9U;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBU;
  return (static_cast<double>((x ^ (x >> 31)) >> 11) + 1) / 9007199254740992.0;
}

/// Reflectivity of tissue, [0, 1].
double tissue(const Eigen::Vector3d& p) {
  const double vessel = off_vessel(p);
  if (vessel < 0) return 0.04;
  if (vessel < 0.8) return 0.8;
  if (p.y() < 3) return 0.9;
  if (p.y() < 14) return 0.35 + 0.25 * std::pow(std::sin(2.2 * p.y() + 0.15 * p.x()), 8);
  return 0.3;
}

std::int16_t echo(const Eigen::Vector3d& p, std::uint64_t i) {
  const double speckle = std::sqrt(-2 * std::log(noise(i))) * 0.8;
  const double shown = 255 * tissue(p) * (0.35 + 0.65 * speckle) * std::exp(-p.y() / 60);
  return static_cast<std::int16_t>(std::clamp(std::lround(shown), 0L, 255L));
}

PredicateVolume::Look look(std::string name, std::vector<render::PredicateEntry> entries,
                           std::vector<render::PredicateHistogram::Bar> bars) {
  return {std::move(name),
          {std::move(entries), *render::PredicateHistogram::create(std::move(bars))}};
}

E bright(double low) { return E::kind("intensity", {low, 1e6}); }
E steep(double low) { return E::kind("gradient_magnitude", {low, 1e6}); }
E below(double mm) { return E::kind("depth", {mm, 1e4}); }

/// Predicate sets that need only the volume and the position of its scan.
std::vector<PredicateVolume::Look> general_looks() {
  return {look("uniform", {{"tissue", bright(0.1)}, {"interfaces", steep(0.15)}},
               {{1, 30, 0.3}, {1, 200, 0.5}}),
          look("layers of depth",
               {{"near", E::negation(below(8))}, {"far", E::all({below(8), bright(0.15)})}},
               {{0.2, 20, 0.3}, {0.8, 40, 0.4}}),
          look("interfaces",
               {{"interfaces", E::all({steep(0.2), below(4)})},
                {"across the scan", E::kind("gradient_angle", {0, 0.7, 0.1})},
                {"tissue", bright(0.1)}},
               {{0.6, 45, 0.6}, {0.3, 200, 0.5}, {0.1, 30, 0.1}})};
}

Result<void> add_gradients(PredicateVolume& volume) {
  render::DerivedFeatureOptions options;
  options.gradient.smoothing_mm = render::features::kUsualSmoothingMm;
  render::features::DerivedVolumes service;
  for (const auto& one : volume.looks) {
    volume.predicates.model = one.model;
    if (auto ok =
            render::add_derived_features(volume.ultrasound, options, service, volume.predicates);
        !ok) {
      return ok;
    }
  }
  return {};
}

/// Values of all voxels, i fastest: of(position in mm).
template <class T, class Of>
std::vector<T> of_places(const VoxelGrid& grid, const Of& of) {
  std::vector<T> values;
  values.reserve(grid.voxel_count());
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        values.push_back(of(grid.at({double(i), double(j), double(k)}).mm));
      }
    }
  }
  return values;
}

/// Exact vesselness of the neck.
Result<void> add_vesselness(PredicateVolume& volume) {
  const VoxelGrid& grid = volume.ultrasound->grid();
  const auto vesselness = of_places<float>(grid, [](const Eigen::Vector3d& p) {
    const double off = off_vessel(p);
    return static_cast<float>(off < 0 ? 1 : std::exp(-0.5 * off * off));
  });
  auto feature = render::FeatureVolume::create(grid, vesselness, render::feature::kVesselness);
  if (!feature) return feature.error();
  volume.predicates.features.volumes.emplace(render::feature::kVesselness, *std::move(feature));
  return {};
}

/// Exact labels of the neck.
Result<void> add_labels(const VoxelGrid& grid, PredicateVolume& volume) {
  auto labels = of_places<std::uint32_t>(grid, [](const Eigen::Vector3d& p) {
    return p.y() < 3 ? 1U : off_vessel(p) < 0.8 ? 4U : 2U;
  });
  auto layers = render::LabelVolume::create(grid, std::move(labels), "layers");
  if (!layers) return layers.error();
  volume.predicates.features.labels = *std::move(layers);
  return {};
}

}  // namespace

Result<PredicateVolume> neck_volume(int n) {
  VoxelGrid grid;
  grid.size = {n, n, n};
  grid.spacing_mm.setConstant(kSideMm / n);
  std::vector<std::int16_t> voxels(grid.voxel_count());
  std::size_t at = 0;
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i, ++at) {
        voxels[at] = echo(grid.at({double(i), double(j), double(k)}).mm, at);
      }
    }
  }
  auto made = Volume::create(grid, std::move(voxels), "neck phantom");
  if (!made) return made.error();
  PredicateVolume out{"neck-" + std::to_string(n),
                      std::make_shared<const Volume>(*std::move(made)),
                      {},
                      general_looks()};
  out.predicates.scan = render::ParallelScan{{{0, 0, 0}}, {{0, 1, 0}}};
  out.looks.push_back(look("vessel",
                           {{"vessel", E::kind("vesselness", {0.5, 1})},
                            {"tissue", E::all({bright(0.15), below(3)})},
                            {"skin", E::negation(below(3))}},
                           {{0.75, 0, 0.8}, {0.2, 35, 0.25}, {0.05, 20, 0.2}}));
  out.looks.push_back(look("labels",
                           {{"skin", E::kind("label", {1})},
                            {"muscle", E::kind("label", {2})},
                            {"vessel", E::kind("label", {4})}},
                           {{0.05, 20, 0.3}, {0.25, 5, 0.5}, {0.7, 50, 0.7}}));
  if (auto ok = add_labels(grid, out); !ok) return ok.error();
  return out;
}

Result<PredicateVolume> neck_phantom(int n) {
  auto out = neck_volume(n);
  if (!out) return out;
  if (auto ok = add_vesselness(*out); !ok) return ok.error();
  if (auto ok = add_gradients(*out); !ok) return ok.error();
  return out;
}

Result<PredicateVolume> prostate_volume(Diagnostics& diagnostics) {
  auto read = io::read_ct(bench_data_dir() / "us-predicate" / "prostatePhantom.mha", diagnostics);
  if (!read) return read.error();
  PredicateVolume out{
      "prostate phantom", std::make_shared<const Volume>(*std::move(read)), {}, general_looks()};
  const VoxelGrid& grid = out.ultrasound->grid();
  // The fan opens along +j, with its apex in front of the first row.
  const Eigen::Vector3d middle(0.5 * (grid.size[0] - 1), 0, 0.5 * (grid.size[2] - 1));
  constexpr double kApexMm = 15;
  const Eigen::Vector3d back = grid.directions.col(1) * kApexMm;
  out.predicates.scan = render::FanScan{{grid.at(middle).mm - back}, kApexMm};
  if (auto ok = add_gradients(out); !ok) return ok.error();
  return out;
}

render::Scene predicate_scene(const PredicateVolume& volume, const PredicateVolume::Look& look,
                              int width, int height) {
  const VoxelGrid& grid = volume.ultrasound->grid();
  const Point<frames::Ct> centre = grid.centre();
  const Eigen::Vector3d from =
      grid.directions * Eigen::Vector3d(-0.5, -1, 0.45).normalized() * grid.extent_mm().norm();
  render::Camera camera{{centre.mm + 1.9 * from}, centre, {grid.directions.col(0)}};
  camera.vertical_fov_rad = 0.5;
  render::Scene scene{
      volume.ultrasound,
      *render::TransferFunction::create("grey", {{0, {0, 0, 0}, 0, 1}, {255, {1, 1, 1}, 0.5, 1}}),
      {},
      {},
      {},
      {},
      camera,
      {}};
  scene.shading.enabled = false;
  scene.width = width;
  scene.height = height;
  scene.predicates = volume.predicates;
  scene.predicates->model = look.model;
  return scene;
}

render::Scene standard_scene(const render::Scene& by_predicates) {
  render::Scene scene = by_predicates;
  const render::PredicateScene& p = *by_predicates.predicates;
  std::vector<render::TransferNode> nodes;
  constexpr int kNodes = 256;
  for (int i = 0; i < kNodes; ++i) {
    const double x = static_cast<double>(i) / (kNodes - 1);
    const double opacity = std::min(x, render::PredicateScene::kMostOpacity);
    // Short opacity lengths make white denser than an opacity of 1 mm can distinguish from 1.
    constexpr double kDensest = 1 - std::numeric_limits<double>::epsilon() / 2;
    const double of_1_mm = -std::expm1(std::log1p(-opacity) / p.opacity_length_mm);
    nodes.push_back({p.intensity.black + x * (p.intensity.white - p.intensity.black),
                     {x, x, x},
                     std::min(of_1_mm, kDensest),
                     1});
  }
  scene.transfer = *render::TransferFunction::create("grey", std::move(nodes));
  scene.predicates.reset();
  return scene;
}

}  // namespace nav::bench
