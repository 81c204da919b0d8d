// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bench/measure.hpp"
#include "nav/result.hpp"
#include "nav/volume.hpp"

namespace nav::bench {

/// Cost of what is computed once for a volume, before its first image, or once for every image
/// beside the rays. Medians.
struct PreparationCost {
  std::string what;
  double ms = 0;       ///< Process time.
  double wall_ms = 0;  ///< Wall time.
};

/// Measures, for a CT in HU: the contextual appearance as a whole and unused (an appearance that
/// asks for nothing); blood pool, bone mask and components of the vessels; table; smoothed
/// gradients; the legend of an image of 800 × 600; and, on a simulated ultrasound volume, connected
/// predicates and the gradients of their shading. An unused part has to leave the CT as it is,
/// otherwise a Bug. Errors: those of the preset folder.
Result<std::vector<PreparationCost>> measure_preparations(const std::shared_ptr<const Volume>& ct,
                                                          const Repeats& repeats);

}  // namespace nav::bench
