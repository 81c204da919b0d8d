// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/error_probability.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace nav::registration {
namespace {

constexpr std::size_t kFeatures = 8;
using Features = std::array<double, kFeatures>;
// Fitted by tools/fit_decision.py, in the order of features_of().
constexpr Features kWeights{-4.265, 0, 4.286, 0.871, 0.302, 0.729, 0, 1.177};
// A search without another minimum ends at this score.
constexpr double kClearScore = 7;
constexpr double kUnknownMargin = 0.3;

/// log2 of a distance, held within 0.05 and 16 mm; unknown distances are infinite.
double log2_of(double mm) { return std::log2(std::isnan(mm) ? 16.0 : std::clamp(mm, 0.05, 16.0)); }

Features features_of(const ImageRegistrationResult& result, const Point<frames::Ct>& target) {
  const double margin =
      result.margin.value_or(result.z_score >= kClearScore ? 1.0 : kUnknownMargin);
  return {1,
          10 * (result.final_cost - 0.3),
          1 - std::clamp(margin, 0.0, 0.6) / 0.6,
          log2_of(result.tre_rms_mm(target)),
          log2_of(result.split_disagreement_mm),
          log2_of(result.halves_disagreement_mm),
          std::clamp(result.basin.shift_mm, 0.0, 4.0),
          1 - std::clamp(result.z_score, 0.0, 8.0) / 8};
}

}  // namespace

double error_probability(const ImageRegistrationResult& result, const Point<frames::Ct>& target) {
  if (!result.covariance_valid) return 1;
  const Features features = features_of(result, target);
  double sum = 0;
  for (std::size_t i = 0; i < kFeatures; ++i) sum += kWeights[i] * features[i];
  return std::isfinite(sum) ? 1 / (1 + std::exp(-sum)) : 1;
}

}  // namespace nav::registration
