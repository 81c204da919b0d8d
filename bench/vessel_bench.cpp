// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/vessel_bench.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "nav/stopwatch.hpp"
#include "render/transfer/enclosed.hpp"

namespace nav::bench {
namespace {

constexpr const char* kVessels = "vessels";
constexpr const char* kOrgans = "organs";

/// Opacity of a component at a value, over its greatest; 0 without such a component.
double share_of_opacity(const render::TransferFunction& transfer, double hu) {
  for (const render::TransferComponent& component : transfer.components()) {
    if (component.name != kVessels) continue;
    render::TransferComponent alone = component;
    alone.gradient.reset();
    double most = 0;
    for (const auto& node : alone.nodes) most = std::max(most, node.opacity);
    const auto function = render::TransferFunction::blend(kVessels, {alone});
    const double tau = function->at(hu).tau_per_mm;
    return (1 - std::exp(-tau)) / most;
  }
  return 0;
}

VesselFigures figures(const Volume& drawn, const render::TransferFunction& transfer,
                      const VesselTruth& truth) {
  constexpr double kVisible = 0.5;
  std::vector<std::uint8_t> visible_at(65536);
  for (int v = -32768; v < 32768; ++v) {
    const bool visible = v >= -1024 && v < 4096 && share_of_opacity(transfer, v) >= kVisible;
    visible_at[static_cast<std::size_t>(v + 32768)] = visible ? 1 : 0;
  }
  std::size_t blood = 0;
  std::size_t blood_seen = 0;
  std::size_t seen = 0;
  std::size_t bone_seen = 0;
  const auto values = drawn.values();
  for (std::size_t i = 0; i < values.size(); ++i) {
    const bool visible = visible_at[static_cast<std::size_t>(values[i] + 32768)] != 0;
    if (truth.blood[i] != 0) {
      ++blood;
      if (visible) ++blood_seen;
    }
    if (!visible) continue;
    ++seen;
    if (truth.bone[i] != 0) ++bone_seen;
  }
  const auto share = [](std::size_t a, std::size_t b) {
    return static_cast<double>(a) / static_cast<double>(std::max<std::size_t>(b, 1));
  };
  return {share(blood_seen, blood), share(bone_seen, seen),
          static_cast<double>(seen) * drawn.grid().spacing_mm.prod() / 1000};
}

}  // namespace

VesselFigures figures_as_it_is(const Volume& ct, const render::TransferFunction& transfer,
                               const VesselTruth& truth) {
  return figures(ct, transfer, truth);
}

Result<FittedVessels> figures_fitted(const Volume& ct, const render::TransferFunction& transfer,
                                     const VesselTruth& truth) {
  const auto begun = std::chrono::steady_clock::now();
  FittedVessels fitted;
  auto window = render::VesselWindow{};
  for (const auto& component : transfer.components()) {
    if (component.name == kVessels) window = render::window_of(component);
  }
  render::TransferFunction shown = transfer;
  if (const auto pool = render::find_blood_pool(ct)) {
    fitted.pool = *pool;
    window = render::vessel_window(*pool);
    auto moved = render::with_vessel_window(transfer, window, kVessels, kOrgans);
    if (!moved) return moved.error();
    shown = *std::move(moved);
  }
  fitted.window = window;
  const auto classes = render::classify_vessels(ct, window);
  const auto separated = render::separate_vessels(ct, classes, window, shown, kVessels);
  if (!separated) return separated.error();
  fitted.classify_s = seconds_since(begun);
  fitted.figures = figures(*separated->ct, separated->transfer, truth);
  return fitted;
}

std::vector<std::uint8_t> bone_by_density(const Volume& ct, const std::vector<std::uint8_t>& artery,
                                          const std::vector<std::uint8_t>& labelled_bone) {
  constexpr int kDenseHu = 700;
  constexpr int kStentVoxels = 3;
  constexpr int kRimVoxels = 2;
  const render::VoxelLattice lattice(ct.grid());
  const auto hu = ct.hu();
  const auto near_artery = render::within_voxels(lattice, artery, kStentVoxels);
  std::vector<std::uint8_t> bone(hu.size(), 0);
  for (std::size_t i = 0; i < hu.size(); ++i) {
    bone[i] = static_cast<std::uint8_t>(hu[i] > kDenseHu && near_artery[i] == 0);
  }
  bone = render::within_voxels(lattice, std::move(bone), kRimVoxels);
  for (std::size_t i = 0; i < hu.size(); ++i) {
    if (!labelled_bone.empty() && labelled_bone[i] != 0) bone[i] = 1;
    if (artery[i] != 0) bone[i] = 0;
  }
  return bone;
}

}  // namespace nav::bench
