// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/predicate_cases.hpp"

#include <map>
#include <utility>

#include "app/predicates/phantom_volume.hpp"
#include "bench/scene_set.hpp"
#include "io/ct.hpp"
#include "render/features/derived_features.hpp"
#include "sim/predicate_phantom.hpp"

namespace nav::bench {
namespace {

using render::PredicateExpression;
using E = PredicateExpression;

PredicateVolume::Appearance appearance(std::string name,
                                       std::vector<render::PredicateEntry> entries,
                                       std::vector<render::PredicateHistogram::Bar> bars) {
  return {std::move(name),
          {std::move(entries), *render::PredicateHistogram::create(std::move(bars))}};
}

E bright(double low) { return E::kind("intensity", {low, 1e6}); }
E steep(double low) { return E::kind("gradient_magnitude", {low, 1e6}); }
E below(double mm) { return E::kind("depth", {mm, 1e4}); }

/// Predicate sets that need only the volume and the position of its scan.
std::vector<PredicateVolume::Appearance> general_looks() {
  return {appearance("uniform", {{"tissue", bright(0.1)}, {"interfaces", steep(0.15)}},
                     {{1, 30, 0.3}, {1, 200, 0.5}}),
          appearance("layers of depth",
                     {{"near", E::negation(below(8))}, {"far", E::all({below(8), bright(0.15)})}},
                     {{0.2, 20, 0.3}, {0.8, 40, 0.4}}),
          appearance("interfaces",
                     {{"interfaces", E::all({steep(0.2), below(4)})},
                      {"across the scan", E::kind("gradient_angle", {0, 0.7, 0.1})},
                      {"tissue", bright(0.1)}},
                     {{0.6, 45, 0.6}, {0.3, 200, 0.5}, {0.1, 30, 0.1}})};
}

Result<void> add_gradients(PredicateVolume& volume) {
  render::DerivedFeatureOptions options;
  options.gradient.smoothing_mm = render::features::kUsualSmoothingMm;
  render::features::DerivedVolumes service;
  for (const auto& one : volume.appearances) {
    volume.predicates.model = one.model;
    if (auto ok =
            render::add_derived_features(volume.ultrasound, options, service, volume.predicates);
        !ok) {
      return ok;
    }
  }
  return {};
}

/// Exact vesselness of the neck.
Result<void> add_vesselness(PredicateVolume& volume) {
  const VoxelGrid& grid = volume.ultrasound->grid();
  const std::vector<float> vesselness = sim::neck_vesselness(grid);
  auto feature = render::FeatureVolume::create(grid, vesselness, render::feature::kVesselness);
  if (!feature) return feature.error();
  volume.predicates.features.volumes.emplace(render::feature::kVesselness, *std::move(feature));
  return {};
}

/// Presets of a simulated patient; none for names that are not known.
std::vector<std::string> presets_of(const std::string& patient) {
  static const std::map<std::string, std::vector<std::string>> all{
      {"carotid", {"carotid-context", "carotid-vessel"}},
      {"carotid-2", {"carotid-context", "carotid-vessel"}},
      {"shoulder", {"shoulder-muscle", "shoulder-bone"}},
      {"tendon", {"tendon-fibres", "tendon-context"}}};
  const auto found = all.find(patient);
  return found == all.end() ? std::vector<std::string>() : found->second;
}

}  // namespace

Result<PredicateVolume> neck_phantom(int n) {
  auto neck = app::phantom_volume("neck", n);
  if (!neck) return neck.error();
  PredicateVolume out{*std::move(neck), general_looks()};
  out.appearances.push_back(appearance("vessel",
                                       {{"vessel", E::kind("vesselness", {0.5, 1})},
                                        {"tissue", E::all({bright(0.15), below(3)})},
                                        {"skin", E::negation(below(3))}},
                                       {{0.75, 0, 0.8}, {0.2, 35, 0.25}, {0.05, 20, 0.2}}));
  out.appearances.push_back(appearance("labels",
                                       {{"skin", E::kind("label", {1})},
                                        {"muscle", E::kind("label", {2})},
                                        {"vessel", E::kind("label", {4})}},
                                       {{0.05, 20, 0.3}, {0.25, 5, 0.5}, {0.7, 50, 0.7}}));
  if (auto ok = add_vesselness(out); !ok) return ok.error();
  if (auto ok = add_gradients(out); !ok) return ok.error();
  return out;
}

Result<PredicateVolume> patient_volume(const std::string& name, int side) {
  auto volume = app::phantom_volume(name, side);
  if (!volume) return volume.error();
  PredicateVolume out{*std::move(volume), {}};
  for (const std::string& preset : presets_of(name)) {
    const auto model = render::preset_predicates(preset);
    if (!model) return model.error();
    out.appearances.push_back({preset, *model});
  }
  return out;
}

Result<PredicateVolume> prostate_volume(Diagnostics& diagnostics) {
  auto read = io::read_stored_volume(bench_data_dir() / "us-predicate" / "prostatePhantom.mha",
                                     diagnostics);
  if (!read) return read.error();
  PredicateVolume out{
      {"prostate phantom", std::make_shared<const StoredVolume>(*std::move(read)), {}},
      general_looks()};
  const VoxelGrid& grid = out.ultrasound->grid();
  // The fan opens along +j, with its apex in front of the first row.
  const Eigen::Vector3d middle(0.5 * (grid.size[0] - 1), 0, 0.5 * (grid.size[2] - 1));
  constexpr double kApexMm = 15;
  const Eigen::Vector3d back = grid.directions.col(1) * kApexMm;
  out.predicates.scan = render::FanScan{{grid.at(middle).mm - back}, kApexMm};
  if (auto ok = add_gradients(out); !ok) return ok.error();
  return out;
}

Result<void> add_features(const render::PredicateModel& model, render::PredicateVolume& volume) {
  volume.predicates.model = model;
  render::DerivedFeatureOptions derive;
  derive.gradient.smoothing_mm = render::features::kUsualSmoothingMm;
  derive.vesselness.smallest_radius_mm = 2;  // Smallest radius of a carotid artery.
  derive.vesselness.largest_radius_mm = 4.5;
  render::features::DerivedVolumes service;
  return render::add_derived_features(volume.ultrasound, derive, service, volume.predicates);
}

}  // namespace nav::bench
