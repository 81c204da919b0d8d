// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/measure.hpp"
#include "bench/preparation_costs.hpp"
#include "nav/result.hpp"
#include "render/scene.hpp"

namespace nav::bench {

/// Cost of one element of an image: the image with it minus the image without it, CPU engine,
/// process time and counts. Negative: the element saves time.
struct ElementCost {
  std::string element;
  double ms = 0;
  double scatter_ms = 0;  ///< Spread of these differences in this run.
  std::int64_t samples = 0;
  std::int64_t gradients = 0;
  /// Cost of the element when it is in the scene but has nothing to do there: a lost plane, a
  /// cutaway about nothing, shading of tissue without importance. Counts are exact.
  bool has_idle = false;
  double idle_ms = 0;
  double idle_scatter_ms = 0;
  std::int64_t idle_samples = 0;
  std::int64_t idle_gradients = 0;
};

/// Cost of a change of the scene: the image after it, with caches as they were before it.
struct ChangeCost {
  std::string change;
  double ms = 0;          ///< Process time of the whole image, median.
  double wall_ms = 0;     ///< Wall time of the whole image, median.
  double prepare_ms = 0;  ///< Wall time of the rebuilt data, median.
  std::uint64_t samples = 0;
  std::uint64_t gradients = 0;
};

struct CostTable {
  double frame_ms = 0;  ///< The whole scene, process time.
  std::uint64_t frame_samples = 0;
  std::vector<ElementCost> elements;
  std::vector<ChangeCost> changes;
  std::vector<PreparationCost> preparations{};  ///< Empty: not asked for.
};

/// Measures every element of an image separately, on the CPU engine. scene: CT, plane, needle,
/// spheres, lines and cutaway are all present, otherwise kUsage.
Result<CostTable> measure_costs(const render::Scene& scene, const Repeats& repeats);

/// Plain-text table.
std::string to_text(const CostTable& table);

}  // namespace nav::bench
