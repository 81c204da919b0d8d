// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/registration/motion_curve.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "bench/measure.hpp"
#include "bench/registration/session_case.hpp"
#include "nav/stopwatch.hpp"
#include "registration/motion/moving_registration.hpp"

namespace nav::bench {
namespace {

constexpr double kMotionStartMm = 5;
constexpr double kStartRad = 0.07;

/// A patient who breathes during the sweep.
struct MotionCase {
  SessionCase session;  ///< Its truth is that at the end of expiration.
  std::vector<double> phases;
};

Result<MotionCase> make_case(const MotionCurveOptions& options, sim::BreathingKind kind,
                             std::uint64_t seed) {
  sim::SimulatedSessionOptions session;
  session.seed = seed;
  session.probe.model = options.model;
  session.duration_s = options.duration_s;
  session.frame_rate_hz = options.frame_rate_hz;
  session.breathing.kind = kind;
  session.breathing.period_s = options.period_s;
  session.breathing.amplitude_mm *= options.breathing_mm / -session.breathing.amplitude_mm.z();
  auto made = make_session_case(session);
  if (!made) return made.error();
  std::vector<double> phases;
  const Timestamp first = made->sweep.frames().front().frame.acquired;
  for (const TrackedImage& tracked : made->sweep.frames()) {
    const double breaths = to_seconds(tracked.frame.acquired - first) / options.period_s;
    phases.push_back(breaths - std::floor(breaths));
  }
  return MotionCase{std::move(*made), std::move(phases)};
}

/// Every stride-th image.
Result<Sweep> thinned(const MotionCase& all, int stride, std::vector<double>& phases) {
  std::vector<TrackedImage> frames;
  for (std::size_t i = 0; i < all.phases.size(); i += static_cast<std::size_t>(stride)) {
    frames.push_back(all.session.sweep.frames()[i]);
    phases.push_back(all.phases[i]);
  }
  return Sweep::create(std::move(frames), "simulated");
}

/// Result of one setting on one case.
struct MotionTrial {
  double common_mm, cpu_s, wall_s;
  std::optional<double> error_mm;
};

Result<MotionTrial> run(const MotionCase& one, int stride, int harmonics, int threads) {
  std::vector<double> phases;
  const auto sweep = thinned(one, stride, phases);
  if (!sweep) return sweep.error();
  registration::ImageRegistrationOptions solver;
  solver.threads = threads;
  registration::PhaseOptions fit;
  fit.threads = threads;
  fit.harmonics = harmonics;
  const Eigen::Vector3d centre = (one.session.truth * sweep->centroid()).mm;
  registration::Vector6d off;
  off << kStartRad, 0, 0, 0, kMotionStartMm, 0;
  CollectingDiagnostics diagnostics;
  const auto common = registration::register_sweep(
      one.session.ct, *sweep, registration::moved(one.session.truth, centre, off), solver,
      diagnostics);
  if (!common) return common.error();
  MotionTrial trial{error_mm(one.session, common->ct_from_reference), process_time_s(), 0, {}};
  const auto start = std::chrono::steady_clock::now();
  const auto moving = registration::register_moving(
      one.session.ct, *sweep, phases, common->ct_from_reference, fit, solver, diagnostics);
  if (!moving) return moving.error();
  trial.cpu_s = process_time_s() - trial.cpu_s;
  trial.wall_s = seconds_since(start);
  if (moving->at_rest) trial.error_mm = error_mm(one.session, moving->at_rest->ct_from_reference);
  return trial;
}

Result<MotionPoint> measure(const std::vector<MotionCase>& cases, sim::BreathingKind kind,
                            int stride, int harmonics, int threads) {
  MotionPoint point{.kind = kind, .harmonics = harmonics};
  std::vector<double> commons, errors, cpu, wall;
  for (const MotionCase& one : cases) {
    const auto trial = run(one, stride, harmonics, threads);
    if (!trial) return trial.error();
    point.images = static_cast<int>((one.phases.size() - 1) / static_cast<std::size_t>(stride)) + 1;
    ++point.trials;
    commons.push_back(trial->common_mm);
    cpu.push_back(trial->cpu_s);
    wall.push_back(trial->wall_s);
    if (trial->error_mm) errors.push_back(*trial->error_mm);
  }
  point.supported = static_cast<int>(errors.size());
  point.common_mm = median(commons);
  point.error_median_mm = median(errors);
  point.error_worst_mm = errors.empty() ? std::nan("") : *std::ranges::max_element(errors);
  point.motion_cpu_s = median(cpu);
  point.motion_wall_s = median(wall);
  return point;
}

}  // namespace

Result<std::vector<MotionPoint>> measure_motion(const MotionCurveOptions& options,
                                                const std::function<void(double)>& progress) {
  std::vector<MotionPoint> points;
  const auto settings = static_cast<double>(
      options.kinds.size() * (options.image_strides.size() + options.harmonics.size()));
  double done = 0;
  for (const sim::BreathingKind kind : options.kinds) {
    std::vector<MotionCase> cases;
    for (int i = 0; i < options.patients; ++i) {
      auto one = make_case(options, kind, options.first_seed + static_cast<std::uint64_t>(i));
      if (!one) return one.error();
      cases.push_back(std::move(*one));
    }
    const auto add = [&](int stride, int harmonics) -> Result<void> {
      auto point = measure(cases, kind, stride, harmonics, options.threads);
      if (!point) return point.error();
      points.push_back(*point);
      if (progress) progress(++done / settings);
      return {};
    };
    const int usual = registration::PhaseOptions().harmonics;
    for (const int stride : options.image_strides) {
      if (auto ok = add(stride, usual); !ok) return ok.error();
    }
    for (const int harmonics : options.harmonics) {
      if (harmonics == usual) continue;
      if (auto ok = add(options.image_strides.back(), harmonics); !ok) return ok.error();
    }
  }
  return points;
}

std::string to_text(const std::vector<MotionPoint>& points) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(2)
       << "\nbreathing: RMS error over the targets at the end of expiration, mm; processor s and "
          "wall s for the motion\n";
  for (const MotionPoint& p : points) {
    text << "  " << std::setw(6) << std::left << sim::to_string(p.kind) << std::right
         << std::setw(5) << p.images << " images, harmonics " << p.harmonics << ": supported "
         << p.supported << '/' << p.trials << ", common pose " << p.common_mm << ", at rest median "
         << p.error_median_mm << ", worst " << p.error_worst_mm << "; " << p.motion_cpu_s << ", "
         << p.motion_wall_s << '\n';
  }
  return text.str();
}

}  // namespace nav::bench
