// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/registration/peer.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <map>
#include <sstream>

#include "bench/measure.hpp"
#include "bench/registration/effort_curve.hpp"
#include "bench/registration/thread_time.hpp"
#include "registration/prepared.hpp"

namespace nav::bench {
namespace {

namespace fs = std::filesystem;
using registration::ImageRegistrationOptions;

constexpr int kFrames = 60;
constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// One run, in processor seconds. kInfinite: it ended before.
struct Run {
  std::optional<double> error_mm;
  double cpu_s = kInfinite, solve_cpu_s = kInfinite;
};

/// What a way of registering did from one distance.
struct Tally {
  int trials = 0, right = 0;
  std::vector<double> errors_mm, cpu_s, solve_cpu_s;

  /// What a run that gave up took does not count: it is not known, or of another thing.
  void add(const Run& run) {
    ++trials;
    if (std::isfinite(run.cpu_s)) {
      cpu_s.push_back(run.cpu_s);
      solve_cpu_s.push_back(run.solve_cpu_s);
    }
    if (!run.error_mm || *run.error_mm >= kSuccessMm) return;
    ++right;
    errors_mm.push_back(*run.error_mm);
  }
};

using Tallies = std::map<std::pair<std::string, double>, Tally>;

std::string name_of(const ElastixEffort& effort) {
  return "elastix " + std::to_string(effort.iterations) + "x" + std::to_string(effort.resolutions);
}

std::string name_of(const LocalEffort& effort) {
  std::ostringstream name;
  name << "sonde local";
  if (effort.patch_share < 1) name << " x" << effort.patch_share;
  if (effort.picture_stride > 1) name << " 1/" << effort.picture_stride;
  if (effort.finest_step_mm > 0) name << ' ' << effort.finest_step_mm << " mm";
  return name.str();
}

/// What both sides get.
struct Case {
  const Patient& patient;
  const RecordedSweep& recorded;
  double mm;
  CtPose start;
  int repeats;

  [[nodiscard]] double error_mm(const CtPose& found) const {
    return target_error_mm(found, patient.truth, recorded.targets);
  }
};

/// The quickest of the repeats of what always answers the same; the parts each on their own.
template <typename Once>
Run quickest(int repeats, const Once& once) {
  Run best = once();
  for (int i = 1; i < repeats; ++i) {
    const Run again = once();
    best.cpu_s = std::min(best.cpu_s, again.cpu_s);
    best.solve_cpu_s = std::min(best.solve_cpu_s, again.solve_cpu_s);
  }
  return best;
}

ImageRegistrationOptions with_effort(const ImageRegistrationOptions& usual,
                                     const LocalEffort& effort) {
  ImageRegistrationOptions options = with_patch_share(usual, effort.patch_share);
  if (effort.finest_step_mm > 0) options.levels.back().sample_step_mm = effort.finest_step_mm;
  return options;
}

/// Ours: everything from the images on, and the solve alone, with the CT prepared before.
Run run_ours(const ImageRegistrationOptions& options, int picture_stride,
             const registration::PreparedCt& ct, const Case& c) {
  CollectingDiagnostics diagnostics;
  const Sweep pictures = every(picture_stride, c.recorded.sweep);
  const double begin = thread_time_s();
  const auto sweep = registration::PreparedSweep::create(pictures, options, diagnostics);
  if (!sweep) return {};
  const auto result = registration::register_prepared(*c.patient.ct, *sweep, c.start, options);
  const double end = thread_time_s();
  const auto again = registration::register_prepared(ct, *sweep, c.start, options);
  if (!result || !again) return {};
  return {c.error_mm(result->ct_from_reference), end - begin, thread_time_s() - end};
}

Run run_theirs(const ElastixEffort& effort, const fs::path& elastix, const fs::path& folder,
               const Case& c) {
  const auto run = run_elastix(elastix, folder, c.start, effort);
  if (!run) return {};
  return {c.error_mm(run->found), run->cpu_s, run->cpu_s};
}

/// What a run of one iteration takes is reading, pyramids and set-up.
void add_theirs(const std::vector<ElastixEffort>& efforts, const fs::path& elastix,
                const fs::path& folder, const Case& c, Tallies& out) {
  const auto best_of = [&](const ElastixEffort& effort) {
    return quickest(c.repeats, [&] { return run_theirs(effort, elastix, folder, c); });
  };
  const Run empty = best_of({1, efforts.front().samples, 1});
  const double overhead_s = std::isfinite(empty.cpu_s) ? empty.cpu_s : 0;
  for (const ElastixEffort& effort : efforts) {
    Run run = best_of(effort);
    run.solve_cpu_s = std::max(run.solve_cpu_s - overhead_s, 0.0);
    out[{name_of(effort), c.mm}].add(run);
  }
}

std::vector<PeerRow> rows_of(const Tallies& tallies) {
  std::vector<PeerRow> rows;
  for (const auto& [key, tally] : tallies) {
    rows.push_back({key.first, key.second, tally.trials, tally.right, median(tally.errors_mm),
                    median(tally.cpu_s), median(tally.solve_cpu_s)});
  }
  return rows;
}

void add_ratio(const PeerOptions& options, PeerComparison& out) {
  const double mm = options.starts_mm.front();
  const auto find = [&](const std::string& name) {
    return std::find_if(out.rows.begin(), out.rows.end(),
                        [&](const PeerRow& row) { return row.name == name && row.start_mm == mm; });
  };
  const auto theirs = std::find_if(options.efforts.begin(), options.efforts.end(),
                                   [&](const ElastixEffort& effort) {
                                     const auto row = find(name_of(effort));
                                     return row != out.rows.end() && 2 * row->right > row->trials;
                                   });
  if (theirs == options.efforts.end()) {
    out.reason = "elastix was right on half or fewer of the nearest starts at every effort";
    return;
  }
  const auto row = find(name_of(*theirs));
  for (const LocalEffort& effort : options.local_efforts) {
    const auto ours = find(name_of(effort));
    if (ours->right < ours->trials || !(ours->error_median_mm < row->error_median_mm)) continue;
    out.cpu_ratio = row->cpu_s / ours->cpu_s;
    out.solve_cpu_ratio = row->solve_cpu_s / ours->solve_cpu_s;
    out.ours = ours->name;
    return;
  }
  out.reason = "no local registration was right on all of the nearest starts with a lower error";
}

}  // namespace

Result<PeerComparison> compare_with_elastix(const PeerOptions& options, CaseStore& store,
                                            const std::optional<fs::path>& elastix,
                                            const fs::path& folder,
                                            const std::function<void(double)>& progress) {
  Tallies tallies;
  int done = 0;
  for (int i = 0; i < options.patients; ++i) {
    const std::uint64_t seed = options.first_seed + static_cast<std::uint64_t>(i);
    const auto held_patient = store.patient(seed);
    const auto held_sweep = store.sweep(seed, SweepPath::kSubcostal, kFrames);
    const Patient& patient = *held_patient;
    const RecordedSweep& recorded = *held_sweep;
    if (elastix) {
      if (auto ok = write_elastix_case(patient, recorded, folder); !ok) return ok.error();
    }
    for (const double mm : options.starts_mm) {
      const Case c{patient, recorded, mm, start_at(mm, patient.truth, recorded, patient.seed),
                   mm == options.starts_mm.front() ? options.repeats : 1};
      const auto add_ours = [&](const std::string& name, const ImageRegistrationOptions& with,
                                int picture_stride) {
        const auto ct = store.ready_ct(seed, with);
        tallies[{name, mm}].add(
            quickest(c.repeats, [&] { return run_ours(with, picture_stride, ct->prepared, c); }));
      };
      for (const LocalEffort& effort : options.local_efforts) {
        add_ours(name_of(effort), with_effort(options.local, effort), effort.picture_stride);
      }
      add_ours("sonde global", options.global, 1);
      if (elastix) add_theirs(options.efforts, *elastix, folder, c, tallies);
      if (progress) {
        progress(++done / static_cast<double>(options.starts_mm.size()) / options.patients);
      }
    }
  }
  PeerComparison out{rows_of(tallies), {}, {}, "", ""};
  if (elastix) {
    add_ratio(options, out);
  } else {
    out.reason = "elastix is not in PATH (Debian package elastix)";
  }
  return out;
}

std::string to_text(const PeerComparison& comparison) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(3)
       << "\nbeside elastix, same images and starts, one thread; processor s whole (solve), "
          "quickest of repeats\n";
  for (const PeerRow& row : comparison.rows) {
    text << "  " << std::setw(17) << std::left << row.name << std::right << " from " << std::setw(3)
         << static_cast<int>(row.start_mm) << " mm: right " << row.right << '/' << row.trials
         << ", median " << row.error_median_mm << " mm, " << row.cpu_s << " (" << row.solve_cpu_s
         << ")\n";
  }
  if (comparison.cpu_ratio) {
    text << "  elastix / " << comparison.ours << " at the nearest start: " << *comparison.cpu_ratio
         << " whole, " << *comparison.solve_cpu_ratio << " solve\n";
  } else {
    text << "  no ratio: " << comparison.reason << '\n';
  }
  return text.str();
}

}  // namespace nav::bench
