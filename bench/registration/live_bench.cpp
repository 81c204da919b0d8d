// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <benchmark/benchmark.h>
#include <cmath>

#include "registration/live_registration.hpp"
#include "sim/ct_scanner.hpp"
#include "sim/session/simulated_session.hpp"

/// One update of the live registration, default window, on a simulated patient who breathes; and
/// how far it is from the truth.
namespace nav::registration {
namespace {

constexpr int kPictures = 45;

struct Recording {
  std::shared_ptr<const CtChannels> ct;
  std::vector<TrackedFrame> pictures;
  std::vector<Pose> truth;
  Pose accepted;
};

Recording make() {
  sim::SimulatedSessionOptions options;
  options.seed = 3;
  options.duration_s = (kPictures - 1) / options.frame_rate_hz;
  options.path.kind = sim::HandPathKind::kFan;
  options.path.angle_rad = 0.3;
  options.breathing.kind = sim::BreathingKind::kRigid;
  const auto session = sim::SimulatedSession::create(options);
  sim::CtOptions scan;
  scan.spacing_mm.setConstant(2);
  const auto ct = sim::scan_ct(session->patient(), scan);
  const auto channels =
      make_ct_channels(*ct, box_of(ct->grid()), 0.75 * LiveOptions{}.level.sample_step_mm);
  Recording out{
      std::make_shared<const CtChannels>(*channels), {}, {}, session->ct_from_reference()};
  auto frames = session->frames();
  for (int i = 0; i < session->frame_count(); ++i) {
    const sim::FrameTruth truth = session->truth(i);
    const auto reference_from_image = session->ct_from_reference().inverse() * truth.ct_from_image;
    out.pictures.push_back({*frames->next(Timestamp::max()), reference_from_image, Duration{0}});
    out.truth.push_back(truth.rest.ct_from_image * reference_from_image.inverse());
  }
  return out;
}

double error_mm(const TrackedFrame& picture, const Pose& found, const Pose& truth) {
  double sum = 0;
  int count = 0;
  for (int column = 0; column < picture.frame.pixels.width(); column += 40) {
    for (int row = 0; row < picture.frame.pixels.height(); row += 40) {
      const auto p = picture.reference_from_image * picture.frame.grid.at(column, row);
      sum += ((found * p).mm - (truth * p).mm).squaredNorm();
      ++count;
    }
  }
  return std::sqrt(sum / count);
}

void live_update(benchmark::State& state) {
  static const Recording recording = make();
  std::vector<double> errors, moved, costs;
  int following = 0;
  auto live = LiveRegistration::create(recording.ct, recording.accepted, {});
  std::size_t next = 0;
  for (auto _ : state) {
    const TrackedFrame& picture = recording.pictures[next];
    const auto update = live->update(picture);
    state.PauseTiming();
    errors.push_back(error_mm(picture, update->ct_from_reference, recording.truth[next]));
    moved.push_back(error_mm(picture, recording.accepted, recording.truth[next]));
    costs.push_back(update->cost);
    following += update->state == LiveState::kFollowing ? 1 : 0;
    if (++next == recording.pictures.size()) {
      next = 0;
      live = LiveRegistration::create(recording.ct, recording.accepted, {});
    }
    state.ResumeTiming();
  }
  const auto median = [](std::vector<double> v) {
    std::ranges::nth_element(v, v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2));
    return v[v.size() / 2];
  };
  state.counters["error_median_mm"] = median(errors);
  state.counters["error_max_mm"] = *std::ranges::max_element(errors);
  state.counters["motion_max_mm"] = *std::ranges::max_element(moved);
  state.counters["cost_median"] = median(costs);
  state.counters["following_share"] = following / static_cast<double>(errors.size());
}
BENCHMARK(live_update)
    ->Iterations(kPictures)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime();

}  // namespace
}  // namespace nav::registration
