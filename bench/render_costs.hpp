// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/measure.hpp"
#include "nav/result.hpp"
#include "render/scene.hpp"

namespace nav::bench {

/// What one element of a picture costs: the picture with it less the picture without it, CPU
/// engine, process time and counts. Negative: it saves.
struct ElementCost {
  std::string element;
  double ms = 0;
  double scatter_ms = 0;  ///< How far apart such differences lie in this run.
  std::int64_t samples = 0;
  std::int64_t gradients = 0;
  /// The same where the element is in the scene but has nothing to do there: a lost plane, a
  /// cutaway about nothing, shading of what has no importance. Counts are exact.
  bool has_idle = false;
  double idle_ms = 0;
  double idle_scatter_ms = 0;
  std::int64_t idle_samples = 0;
  std::int64_t idle_gradients = 0;
};

/// What a change of the scene costs: the picture after it, caches as they were before it.
struct ChangeCost {
  std::string change;
  double ms = 0;          ///< Process time of the whole picture, median.
  double wall_ms = 0;     ///< Wall time of the whole picture, median.
  double prepare_ms = 0;  ///< Wall time of what had to be rebuilt, median.
  std::uint64_t samples = 0;
  std::uint64_t gradients = 0;
};

struct CostTable {
  double frame_ms = 0;  ///< The whole scene, process time.
  std::uint64_t frame_samples = 0;
  std::vector<ElementCost> elements;
  std::vector<ChangeCost> changes;
};

/// Every element of a picture by itself, on the CPU engine. scene: CT, plane, needle, spheres,
/// lines and cutaway all present, otherwise kUsage.
Result<CostTable> measure_costs(const render::Scene& scene, const Repeats& repeats);

/// Plain-text table.
std::string to_text(const CostTable& table);

}  // namespace nav::bench
