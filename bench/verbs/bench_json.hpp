// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "app/report.hpp"
#include "bench/render_comparison.hpp"
#include "bench/render_costs.hpp"
#include "bench/render_live.hpp"
#include "bench/render_scaling.hpp"

namespace nav::bench {

/// Measurements of 'sonde bench render'; absent, empty or NaN: not asked for.
struct BenchRenderReport {
  RenderBenchReport comparison;
  std::vector<SkipRatio> skipping;
  std::vector<SkipBound> skip_bounds;  ///< Result of the part skipping.
  double full_volume_overhead = std::numeric_limits<double>::quiet_NaN();
  std::optional<CutawayCost> cutaway;
  std::optional<ImageUpdate> update;
  std::vector<Interaction> interaction;
  std::optional<EditCost> edit;
  std::optional<CostTable> costs;
  struct SceneCosts {
    std::string scene;
    CostTable costs;
  };
  std::vector<SceneCosts> scene_costs;  ///< Result of the part costs.
};

/// Keys as docs/json.md has them, from gl_device on.
io::Json json_of(const BenchRenderReport& report);
io::Json json_of(const std::vector<ScalingPoint>& points);

/// The numbers beside the comparison as text: skipping, cutaway, update, interaction, edit.
/// Precondition: they were measured.
std::string live_text(const BenchRenderReport& report);

/// Text of the skipped samples in every scene, beside those that could be skipped.
std::string skip_text(const std::vector<SkipBound>& bounds);

}  // namespace nav::bench
