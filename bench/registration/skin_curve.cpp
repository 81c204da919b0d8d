// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/registration/skin_curve.hpp"

#include <algorithm>
#include <iomanip>
#include <limits>
#include <optional>
#include <sstream>

#include "bench/measure.hpp"
#include "bench/registration/session_case.hpp"
#include "bench/registration/thread_time.hpp"
#include "bench/registration/trials.hpp"
#include "registration/acceptance.hpp"

namespace nav::bench {
namespace {

using registration::SkinSearchOptions;

Result<SessionCase> make_case(const SkinCurveOptions& options, std::uint64_t seed,
                              sim::HandPathKind path) {
  sim::SimulatedSessionOptions session;
  session.seed = seed;
  session.probe.model = options.model;
  session.path.kind = path;
  session.path.length_mm = 60;
  session.duration_s = options.duration_s;
  session.frame_rate_hz = options.frame_rate_hz;
  auto made = make_session_case(session);
  if (!made) return made.error();
  std::vector<TrackedImage> frames = made->sweep.frames();
  for (TrackedImage& tracked : frames) tracked.frame.outline.reset();
  auto sweep = Sweep::create(std::move(frames), made->sweep.calibration_id());
  if (!sweep) return sweep.error();
  made->sweep = std::move(*sweep);
  return made;
}

/// The larger part of the CT outside everything that the images show, cut along the left-right axis
/// of the patient.
Result<Volume> without_what_it_shows(const SessionCase& one) {
  VoxelGrid grid = one.ct.grid();
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const TrackedImage& tracked : one.sweep.frames()) {
    const auto& pixels = tracked.frame.pixels;
    for (const double column : {0.0, pixels.width() - 1.0}) {
      for (const double row : {0.0, pixels.height() - 1.0}) {
        const auto p =
            one.truth * (tracked.reference_from_image * tracked.frame.grid.at(column, row));
        low = std::min(low, grid.index_of(p).x());
        high = std::max(high, grid.index_of(p).x());
      }
    }
  }
  const int all = grid.size[0];
  const int below = std::clamp(static_cast<int>(low), 0, all);
  const int above = std::clamp(all - 1 - static_cast<int>(high), 0, all);
  const int first = below >= above ? 0 : all - above;
  grid.size[0] = std::max({below, above, 2});
  grid.origin_mm = one.ct.grid().at({static_cast<double>(first), 0, 0}).mm;
  std::vector<std::int16_t> hu;
  hu.reserve(grid.voxel_count());
  const auto rows = one.ct.hu();
  for (auto row = rows.begin(); row != rows.end(); row += all) {
    hu.insert(hu.end(), row + first, row + first + grid.size[0]);
  }
  return Volume::create(grid, std::move(hu), one.ct.name() + ", cut");
}

struct SkinTrial {
  double cpu_s = 0;
  bool accepted = false;
  double error_mm = std::numeric_limits<double>::infinity();
};

SkinTrial run(const SessionCase& one, const Volume& ct, const SkinSearchOptions& search) {
  registration::ImageRegistrationOptions solver;
  solver.threads = 1;
  CollectingDiagnostics diagnostics;
  std::optional<Result<registration::ImageRegistrationResult>> found;
  SkinTrial trial;
  trial.cpu_s = timed(
      [&] { found = registration::register_on_skin(ct, one.sweep, solver, search, diagnostics); });
  if (!found->has_value()) return trial;
  const registration::Pose& pose = (*found)->ct_from_reference;
  trial.error_mm = error_mm(one, pose);
  trial.accepted = registration::decide(**found, {}, pose * one.sweep.centroid()).accepted;
  return trial;
}

/// A sweep with CTs that do not show the same region or patient.
struct SkinCase {
  SessionCase own;
  std::vector<Volume> hopeless;
};

SkinCurvePoint measure(const std::vector<SkinCase>& cases, const std::string& axis, double x,
                       const SkinSearchOptions& search) {
  SkinCurvePoint point{.axis = axis, .x = x};
  std::vector<double> errors, cpu, hopeless_cpu;
  for (const SkinCase& one : cases) {
    const SkinTrial own = run(one.own, one.own.ct, search);
    ++point.trials;
    cpu.push_back(own.cpu_s);
    point.accepted += own.accepted ? 1 : 0;
    point.false_accepts += own.accepted && !(own.error_mm < kFalseAcceptMm) ? 1 : 0;
    if (own.error_mm < kSuccessMm) {
      ++point.right;
      errors.push_back(own.error_mm);
    }
    for (const Volume& ct : one.hopeless) {
      const SkinTrial other = run(one.own, ct, search);
      ++point.hopeless;
      point.false_accepts += other.accepted ? 1 : 0;
      hopeless_cpu.push_back(other.cpu_s);
    }
  }
  point.error_median_mm = median(errors);
  point.cpu_s = median(cpu);
  point.hopeless_cpu_s = median(hopeless_cpu);
  return point;
}

Result<std::vector<SkinCase>> make_cases(const SkinCurveOptions& options) {
  std::vector<SkinCase> cases;
  for (int i = 0; i < options.patients; ++i) {
    const auto seed = options.first_seed + static_cast<std::uint64_t>(i);
    // The CT of another patient; the path does not matter.
    std::optional<Volume> other;
    for (const sim::HandPathKind path : options.paths) {
      auto own = make_case(options, seed, path);
      if (!own) return own.error();
      SkinCase one{std::move(*own), {}};
      if (options.hopeless) {
        if (!other) {
          SkinCurveOptions shortest = options;
          shortest.duration_s = 2 / options.frame_rate_hz;
          auto made = make_case(shortest, seed + 1, path);
          if (!made) return made.error();
          other = std::move(made->ct);
        }
        auto cut = without_what_it_shows(one.own);
        if (!cut) return cut.error();
        one.hopeless = {*other, std::move(*cut)};
      }
      cases.push_back(std::move(one));
    }
  }
  return cases;
}

}  // namespace

Result<std::vector<SkinCurvePoint>> measure_skin(const SkinCurveOptions& options,
                                                 const std::function<void(double)>& progress) {
  const auto cases = make_cases(options);
  if (!cases) return cases.error();
  std::vector<SkinCurvePoint> points;
  const auto total =
      static_cast<double>(options.tried.size() + options.spacings_mm.size() + options.turns.size());
  const auto add = [&](const std::string& axis, double x, const SkinSearchOptions& search) {
    points.push_back(measure(*cases, axis, x, search));
    if (progress) progress(static_cast<double>(points.size()) / total);
  };
  for (const double tried : options.tried) {
    SkinSearchOptions search;
    search.tried = static_cast<int>(tried);
    add("tried", tried, search);
  }
  for (const double spacing_mm : options.spacings_mm) {
    SkinSearchOptions search;
    search.spacing_mm = spacing_mm;
    add("spacing_mm", spacing_mm, search);
  }
  for (const double turns : options.turns) {
    SkinSearchOptions search;
    search.turns = static_cast<int>(turns);
    add("turns", turns, search);
  }
  return points;
}

std::string to_text(const std::vector<SkinCurvePoint>& points) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(2)
       << "\nwithout a start pose, over the skin of the CT: processor s, with all preparation\n";
  for (const SkinCurvePoint& p : points) {
    text << "  " << std::setw(10) << std::left << p.axis << std::right << std::setw(7) << p.x
         << ": correct " << p.right << '/' << p.trials << ", accepted " << p.accepted << ", median "
         << p.error_median_mm << " mm, " << p.cpu_s << " s; hopeless " << p.hopeless
         << ", false accepts " << p.false_accepts << ", " << p.hopeless_cpu_s << " s\n";
  }
  return text.str();
}

}  // namespace nav::bench
