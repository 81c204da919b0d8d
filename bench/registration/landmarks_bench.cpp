// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>
#include <cmath>
#include <string>

#include "registration/landmarks/landmarks.hpp"

namespace nav::registration {
namespace {

/// Whole call, leave-one-out fits and covariance included.
void register_points(benchmark::State& state) {
  const Transform<frames::Ct, frames::Reference> truth(
      Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Eigen::Vector3d(1, 2, 3).normalized())),
      {10, 20, 30});
  std::vector<LandmarkPair> pairs;
  for (int i = 0; i < state.range(0); ++i) {
    const Point<frames::Reference> p{
        {60 * std::cos(2.4 * i), 60 * std::sin(2.4 * i), 7.0 * i - 30}};
    pairs.push_back({std::to_string(i), p, truth * p, 1.0});
  }
  for (auto _ : state) {
    const auto result = register_landmarks(pairs);
    benchmark::DoNotOptimize(result->fre_rms_mm);
  }
}
BENCHMARK(register_points)->Arg(4)->Arg(10)->Arg(30)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace nav::registration
