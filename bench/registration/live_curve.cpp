// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/registration/live_curve.hpp"

#include <cmath>
#include <iomanip>
#include <memory>
#include <numeric>
#include <sstream>

#include "bench/measure.hpp"
#include "bench/registration/session_case.hpp"
#include "bench/registration/summary.hpp"
#include "bench/registration/thread_time.hpp"
#include "registration/motion/live_registration.hpp"
#include "registration/prepared.hpp"
#include "registration/similarity/image_outline.hpp"

namespace nav::bench {
namespace {

using registration::LiveOptions;
using registration::LiveState;
using registration::Pose;

/// A patient's ultrasound images with their outline, and the CT for the live registration.
struct LiveCase {
  SessionCase session;
  Sweep sweep;
  std::shared_ptr<const registration::CtChannels> ct;
};

Result<LiveCase> make_case(const LiveCurveOptions& options, sim::BreathingKind kind,
                           std::uint64_t seed) {
  sim::SimulatedSessionOptions session;
  session.seed = seed;
  session.probe.model = options.model;
  session.duration_s = options.duration_s;
  session.frame_rate_hz = options.frame_rate_hz;
  session.breathing.kind = kind;
  session.breathing.amplitude_mm *= options.breathing_mm / -session.breathing.amplitude_mm.z();
  auto made = make_session_case(session);
  if (!made) return made.error();
  const auto channels =
      registration::make_ct_channels(made->ct, registration::box_of(made->ct.grid()),
                                     registration::sigma_of(LiveOptions().level.sample_step_mm));
  if (!channels) return channels.error();
  Sweep sweep = registration::with_outline(made->sweep);
  return LiveCase{std::move(*made), std::move(sweep),
                  std::make_shared<const registration::CtChannels>(*channels)};
}

/// Distance between two poses, RMS over the positions of an image, mm.
double distance_mm(const TrackedImage& image, const Pose& a, const Pose& b) {
  constexpr int kStride = 40;
  double sum = 0;
  int count = 0;
  for (int column = 0; column < image.frame.pixels.width(); column += kStride) {
    for (int row = 0; row < image.frame.pixels.height(); row += kStride) {
      const auto p = image.reference_from_image * image.frame.grid.at(column, row);
      sum += ((a * p).mm - (b * p).mm).squaredNorm();
      ++count;
    }
  }
  return std::sqrt(sum / count);
}

double rms(const std::vector<double>& values) {
  const double sum = std::inner_product(values.begin(), values.end(), values.begin(), 0.0);
  return std::sqrt(sum / static_cast<double>(values.size()));
}

/// Result of one setting on one patient.
struct LiveTrial {
  int images = 0;
  std::vector<double> still, following, predicted, cpu_ms;
  std::optional<int> withdrawn_after;  ///< Number of images.
};

Result<LiveTrial> run(const LiveCase& one, const LiveCase& whose_ct, const LiveOptions& options) {
  auto live = registration::LiveRegistration::create(whose_ct.ct, one.session.truth, options);
  if (!live) return live.error();
  LiveTrial trial;
  const auto& frames = one.sweep.frames();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    Result<registration::LiveUpdate> update = Error{ErrorCode::kUnavailable, "not updated"};
    trial.cpu_ms.push_back(1e3 * timed([&] { update = live->update(frames[i]); }));
    if (!update) return update.error();
    ++trial.images;
    const bool distinct = !(update->distinctness < options.min_distinctness);
    if (update->state == LiveState::kLost && !distinct && !trial.withdrawn_after) {
      trial.withdrawn_after = trial.images;
    }
    if (update->state != LiveState::kFollowing) continue;
    const Pose& truth = one.session.following_truth[i];
    trial.still.push_back(distance_mm(frames[i], one.session.truth, truth));
    trial.following.push_back(distance_mm(frames[i], update->ct_from_reference, truth));
    trial.predicted.push_back(update->predicted_rms_mm);
  }
  return trial;
}

Result<LivePoint> measure(const std::vector<LiveCase>& cases, sim::BreathingKind kind, int window,
                          int patches) {
  LiveOptions options;
  options.window = window;
  options.level.patches = patches;
  std::vector<double> still, following, all, predicted, cpu_ms;
  int images = 0;
  for (const LiveCase& one : cases) {
    const auto trial = run(one, one, options);
    if (!trial) return trial.error();
    images += trial->images;
    if (!trial->following.empty()) {
      still.push_back(rms(trial->still));
      following.push_back(rms(trial->following));
    }
    all.insert(all.end(), trial->following.begin(), trial->following.end());
    predicted.insert(predicted.end(), trial->predicted.begin(), trial->predicted.end());
    cpu_ms.insert(cpu_ms.end(), trial->cpu_ms.begin(), trial->cpu_ms.end());
  }
  return LivePoint{.kind = kind,
                   .window = window,
                   .patches = patches,
                   .trials = static_cast<int>(cases.size()),
                   .shown = static_cast<double>(all.size()) / images,
                   .still_mm = median(still),
                   .following_mm = median(following),
                   .p95_mm = quantile(all, 0.95),
                   .predicted_mm = median(predicted),
                   .update_cpu_ms = median(cpu_ms)};
}

Result<LiveEvidence> weigh(const std::vector<LiveCase>& cases) {
  LiveEvidence evidence;
  std::vector<double> images;
  for (const LiveCase& one : cases) {
    for (const LiveCase& other : cases) {
      const auto trial = run(one, other, {});
      if (!trial) return trial.error();
      const bool withdrawn = trial->withdrawn_after.has_value();
      if (&one == &other) {
        ++evidence.own;
        evidence.own_withdrawn += withdrawn ? 1 : 0;
        continue;
      }
      ++evidence.others;
      evidence.others_withdrawn += withdrawn ? 1 : 0;
      if (withdrawn) images.push_back(*trial->withdrawn_after);
    }
  }
  evidence.images_median = median(images);
  return evidence;
}

}  // namespace

Result<LiveCurve> measure_live(const LiveCurveOptions& options,
                               const std::function<void(double)>& progress) {
  LiveCurve curve;
  const auto settings = static_cast<double>(options.kinds.size() *
                                            (options.windows.size() + options.patches.size() - 1));
  const LiveOptions usual;
  for (const sim::BreathingKind kind : options.kinds) {
    std::vector<LiveCase> cases;
    for (int i = 0; i < options.patients; ++i) {
      auto one = make_case(options, kind, options.first_seed + static_cast<std::uint64_t>(i));
      if (!one) return one.error();
      cases.push_back(std::move(*one));
    }
    const auto add = [&](int window, int patches) -> Result<void> {
      auto point = measure(cases, kind, window, patches);
      if (!point) return point.error();
      curve.points.push_back(*point);
      if (progress) progress(static_cast<double>(curve.points.size()) / settings);
      return {};
    };
    for (const int window : options.windows) {
      if (auto ok = add(window, usual.level.patches); !ok) return ok.error();
    }
    for (const int patches : options.patches) {
      if (patches == usual.level.patches) continue;
      if (auto ok = add(usual.window, patches); !ok) return ok.error();
    }
    if (kind != options.kinds.back()) continue;
    auto evidence = weigh(cases);
    if (!evidence) return evidence.error();
    curve.evidence = *evidence;
  }
  return curve;
}

std::string to_text(const LiveCurve& curve) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(2)
       << "\nlive: RMS error over an image, mm; processor ms of an update\n";
  for (const LivePoint& p : curve.points) {
    text << "  " << std::setw(6) << std::left << sim::to_string(p.kind) << std::right << " window "
         << p.window << ", " << std::setw(3) << p.patches << " patches: shown " << 100 * p.shown
         << " % of " << p.trials << " patients, at the accepted pose " << p.still_mm
         << ", following " << p.following_mm << ", 95 % " << p.p95_mm << ", predicted "
         << p.predicted_mm << "; " << p.update_cpu_ms << '\n';
  }
  const LiveEvidence& e = curve.evidence;
  text << std::setprecision(0) << "  withdrawn: own CT " << e.own_withdrawn << '/' << e.own
       << ", another patient's CT " << e.others_withdrawn << '/' << e.others << ", after "
       << e.images_median << " images (median)\n";
  return text.str();
}

}  // namespace nav::bench
