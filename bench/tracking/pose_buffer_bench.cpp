// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Run time against error of poses between samples: a hand sways by 30 mm and 0.3 rad once per
// second and is sampled at a fixed rate; poses are requested at times between the samples.
#include <algorithm>
#include <benchmark/benchmark.h>
#include <cmath>

#include "tracking/frame_pairer.hpp"

namespace nav::tracking {
namespace {

using Pose = Transform<frames::Tracker, frames::Probe>;

Pose hand(double seconds) {
  const double phase = 2 * M_PI * seconds;
  return {Eigen::Quaterniond(
              Eigen::AngleAxisd(0.3 * std::sin(phase), Eigen::Vector3d(1, 2, 3).normalized())),
          {30 * std::sin(phase), 10 * std::cos(phase), 700}};
}

void BM_PoseAt(benchmark::State& state) {
  const double rate_hz = static_cast<double>(state.range(0));
  PoseBuffer<frames::Probe> buffer(512, std::chrono::seconds(1));
  const int samples = 400;
  for (int i = 0; i < samples; ++i) {
    const double t = i / rate_hz;
    buffer.push({Timestamp(from_seconds(t)), TrackingStatus::kOk, hand(t)});
  }
  double worst_mm = 0;
  double worst_rad = 0;
  int i = 0;
  for (auto _ : state) {
    const double t = (1 + (i++ * 7919 % (10 * (samples - 2))) / 10.0) / rate_hz;
    auto found = buffer.at(Timestamp(from_seconds(t)));
    benchmark::DoNotOptimize(found);
    const auto& pose = std::get<PoseAt<frames::Probe>>(found).tracker_from_body;
    const Pose truth = hand(t);
    worst_mm = std::max(worst_mm, (pose.translation_mm() - truth.translation_mm()).norm());
    worst_rad = std::max(worst_rad, rotation_distance_rad(pose, truth));
  }
  state.counters["worst_mm"] = worst_mm;
  state.counters["worst_mrad"] = 1e3 * worst_rad;
}
BENCHMARK(BM_PoseAt)->Arg(10)->Arg(20)->Arg(50)->Arg(100)->Arg(400);

void BM_Gate(benchmark::State& state) {
  PoseGate<frames::Probe> gate;
  RawPose raw;
  raw.status = TrackingStatus::kOk;
  raw.tracker_from_body = hand(0.1).matrix();
  std::int64_t ns = 0;
  for (auto _ : state) {
    raw.acquired = raw.received = Timestamp(Duration(ns += 1000000));
    benchmark::DoNotOptimize(gate.admit(raw));
  }
}
BENCHMARK(BM_Gate);

}  // namespace
}  // namespace nav::tracking
