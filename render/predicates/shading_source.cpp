// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/shading_source.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>
#include <vector>

#include "render/transfer/smoothed_ct.hpp"

namespace nav::render {

Result<PredicateShading> shading_of_predicates(const StoredVolume& volume,
                                               const PredicateScene::IntensityWindow& window,
                                               double smoothing_mm, double full_gradient_per_mm,
                                               int threads) {
  const auto reject = [](const std::string& what, double found) {
    std::ostringstream text;
    text << "shading of predicates: expected " << what << ", found " << found;
    return Error{ErrorCode::kUsage, text.str()};
  };
  if (!(smoothing_mm > 0 && smoothing_mm <= kMostSmoothingMm)) {
    return reject("a smoothing above 0 and up to 20 mm", smoothing_mm);
  }
  if (!(full_gradient_per_mm >= 1e-4 && full_gradient_per_mm <= 100)) {
    return reject("a full gradient of 0.0001 to 100 of white per mm", full_gradient_per_mm);
  }
  constexpr double kSteps = 16000;  // Differences of neighbours fit into 16 bits.
  std::vector<std::int16_t> steps(volume.values().size());
  std::ranges::transform(volume.values(), steps.begin(), [&](std::int16_t v) {
    const double share = (v - window.black) / (window.white - window.black);
    return static_cast<std::int16_t>(std::lround(kSteps * std::clamp(share, 0.0, 1.0)));
  });
  auto scaled = StoredVolume::create(volume.grid(), std::move(steps), volume.name());
  if (!scaled) return scaled.error();
  auto source = smoothed_for_gradients(std::make_shared<const StoredVolume>(*std::move(scaled)),
                                       smoothing_mm, threads);
  if (!source) return source.error();
  PredicateShading shading;
  shading.source = *std::move(source);
  shading.full_gradient_per_mm = kSteps * full_gradient_per_mm;
  return shading;
}

}  // namespace nav::render
