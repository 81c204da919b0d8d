// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Run time against error of poses between samples: a hand sways by 30 mm and 0.3 rad once per
// second and is sampled at a fixed rate; poses are requested at times between the samples.
#include <algorithm>
#include <benchmark/benchmark.h>
#include <cmath>
#include <random>
#include <vector>

#include "tracking/image_pairer.hpp"

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

/// A pose through clock model, gate and buffer.
void BM_Gate(benchmark::State& state) {
  PoseGate<frames::Probe> gate;
  PoseBuffer<frames::Probe> buffer(1024);
  std::vector<RawPose> poses(1000);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i].status = TrackingStatus::kOk;
    poses[i].tracker_from_body = hand(1e-3 * static_cast<double>(i)).matrix();
  }
  std::int64_t n = 0;
  std::int64_t rejected = 0;
  for (auto _ : state) {
    RawPose& raw = poses[static_cast<std::size_t>(n) % poses.size()];
    raw.acquired = raw.received = Timestamp(std::chrono::milliseconds(++n));
    auto admission = gate.admit(raw);
    if (admission.rejection) ++rejected;
    buffer.push(std::move(admission.pose));
  }
  state.counters["rejected"] = static_cast<double>(rejected);
}
BENCHMARK(BM_Gate);

/// A device that is 100 ppm fast, with delays of 8 ms and an exponential tail of 5 ms.
void BM_ClockModel(benchmark::State& state) {
  const double rate_hz = static_cast<double>(state.range(0));
  std::mt19937_64 random(1);
  std::exponential_distribution<double> tail(1 / 0.005);
  std::vector<double> delay_s(4096);
  for (double& delay : delay_s) delay = 0.008 + tail(random);
  ClockModel model;
  double worst_ms = 0;
  double last = 0;
  std::size_t i = 0;
  for (auto _ : state) {
    const double t = static_cast<double>(i) / rate_hz;
    last = std::max(last, t + delay_s[i % delay_s.size()]);
    const DeviceTime stamp(DeviceClock::duration(std::llround(1e9 * t * (1 + 100e-6))));
    const auto reading = model.add(stamp, Timestamp(from_seconds(last)));
    if (t > 10) {
      worst_ms = std::max(worst_ms, std::abs(1e3 * (to_seconds(reading.acquired) - t - 0.008)));
    }
    ++i;
  }
  state.counters["worst_ms"] = worst_ms;
  state.counters["skew_ppm"] = model.skew_ppm();
}
BENCHMARK(BM_ClockModel)->Arg(20)->Arg(50)->Arg(400);

}  // namespace
}  // namespace nav::tracking
