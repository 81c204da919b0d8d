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

/// One run, in processor seconds. kInfinite: it ended early.
struct Run {
  std::optional<double> error_mm;
  double cpu_s = kInfinite, solve_cpu_s = kInfinite, end_to_end_cpu_s = kInfinite;
};

/// Results of one method from one start distance.
struct Tally {
  int trials = 0, right = 0;
  std::vector<double> errors_mm, cpu_s, solve_cpu_s, end_to_end_cpu_s;

  /// The times of a run that gave up do not count: they are unknown or incomparable.
  void add(const Run& run) {
    ++trials;
    if (std::isfinite(run.cpu_s)) {
      cpu_s.push_back(run.cpu_s);
      solve_cpu_s.push_back(run.solve_cpu_s);
    }
    if (std::isfinite(run.end_to_end_cpu_s)) end_to_end_cpu_s.push_back(run.end_to_end_cpu_s);
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
  name << "sonde " << (effort.effort == registration::Effort::kQuick ? "quick" : "local");
  if (effort.patch_share != 1) name << " x" << effort.patch_share;
  return name.str();
}

/// Input of both sides.
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

/// The fastest of the repeats, which all give the same result; each part separately.
template <typename Once>
Run quickest(int repeats, const Once& once) {
  Run best = once();
  for (int i = 1; i < repeats; ++i) {
    const Run again = once();
    best.cpu_s = std::min(best.cpu_s, again.cpu_s);
    best.solve_cpu_s = std::min(best.solve_cpu_s, again.solve_cpu_s);
    best.end_to_end_cpu_s = std::min(best.end_to_end_cpu_s, again.end_to_end_cpu_s);
  }
  return best;
}

ImageRegistrationOptions options_of(const LocalEffort& effort, bool global) {
  ImageRegistrationOptions options =
      with_patch_share(registration::with_effort(effort.effort), effort.patch_share);
  options.threads = 1;
  if (!global) options.starts = 0;
  return options;
}

/// Our run: everything from the images on, and the solve alone with the CT prepared before.
Run run_ours(const ImageRegistrationOptions& options, const registration::PreparedCt& ct,
             const Case& c) {
  CollectingDiagnostics diagnostics;
  const double begin = thread_time_s();
  const auto sweep = registration::PreparedSweep::create(c.recorded.sweep, options, diagnostics);
  if (!sweep) return {};
  const auto result = registration::register_prepared(*c.patient.ct, *sweep, c.start, options);
  const double end = thread_time_s();
  const auto again = registration::register_prepared(ct, *sweep, c.start, options);
  if (!result || !again) return {};
  return {c.error_mm(result->ct_from_reference), end - begin, thread_time_s() - end};
}

/// Time that elastix takes besides its iterations, processor s.
struct Overhead {
  double startup_s = 0;  ///< Start of the process.
  /// Whole process with a single iteration: start, reading, pyramids, initialisation.
  double one_s = 0;
};

Run run_theirs(const ElastixEffort& effort, const fs::path& elastix, const fs::path& folder,
               const Overhead& overhead, const Case& c) {
  const auto run = run_elastix(elastix, folder, c.start, effort);
  if (!run) return {};
  return {c.error_mm(run->found), std::max(run->cpu_s - overhead.startup_s - run->reading_s, 0.0),
          std::max(run->cpu_s - overhead.one_s, 0.0), run->cpu_s};
}

void add_theirs(const PeerOptions& options, const fs::path& elastix, const fs::path& folder,
                const Case& c, Tallies& out) {
  Overhead overhead;
  const auto best_of = [&](const ElastixEffort& effort) {
    return quickest(c.repeats, [&] { return run_theirs(effort, elastix, folder, overhead, c); });
  };
  const Run one = best_of({1, options.efforts.front().samples, 1});
  if (std::isfinite(one.end_to_end_cpu_s)) overhead.one_s = one.end_to_end_cpu_s;
  overhead.startup_s = startup_s(elastix);
  for (int i = 1; i < c.repeats; ++i) {
    overhead.startup_s = std::min(overhead.startup_s, startup_s(elastix));
  }
  for (const ElastixEffort& effort : options.efforts) {
    out[{name_of(effort), c.mm}].add(best_of(effort));
  }
}

std::vector<PeerRow> rows_of(const Tallies& tallies) {
  std::vector<PeerRow> rows;
  for (const auto& [key, tally] : tallies) {
    rows.push_back({.name = key.first,
                    .start_mm = key.second,
                    .trials = tally.trials,
                    .right = tally.right,
                    .error_median_mm = median(tally.errors_mm),
                    .cpu_s = median(tally.cpu_s),
                    .solve_cpu_s = median(tally.solve_cpu_s),
                    .end_to_end_cpu_s = median(tally.end_to_end_cpu_s)});
  }
  return rows;
}

}  // namespace

void add_ratios(const PeerOptions& options, PeerComparison& out) {
  constexpr double kConverged = 1.1;  // Relative to the error of the next effort.
  const double mm = options.starts_mm.front();
  const auto find = [&](const std::string& name) -> const PeerRow* {
    const auto row = std::find_if(out.rows.begin(), out.rows.end(), [&](const PeerRow& r) {
      return r.name == name && r.start_mm == mm && r.right == r.trials && r.trials > 0;
    });
    return row != out.rows.end() ? &*row : nullptr;
  };
  const PeerRow* theirs = nullptr;
  for (std::size_t i = 0; i < options.efforts.size() && theirs == nullptr; ++i) {
    const PeerRow* row = find(name_of(options.efforts[i]));
    if (row == nullptr) continue;
    const bool last = i + 1 == options.efforts.size() ||
                      options.efforts[i + 1].resolutions != options.efforts[i].resolutions;
    const PeerRow* next = last ? nullptr : find(name_of(options.efforts[i + 1]));
    if (next == nullptr || row->error_median_mm <= kConverged * next->error_median_mm) theirs = row;
  }
  if (theirs == nullptr) {
    out.reason = "elastix was not correct from all of the nearest starts at any effort";
    return;
  }
  for (const LocalEffort& effort : options.local_efforts) {
    const PeerRow* ours = effort.patch_share == 1 ? find(name_of(effort)) : nullptr;
    if (ours == nullptr || !(ours->error_median_mm < theirs->error_median_mm)) continue;
    PeerRatios ratios{.cpu = theirs->cpu_s / ours->cpu_s,
                      .solve = theirs->solve_cpu_s / ours->solve_cpu_s,
                      .ours = ours->name,
                      .theirs = theirs->name};
    const double end_to_end = theirs->end_to_end_cpu_s / ours->end_to_end_cpu_s;
    if (std::isfinite(end_to_end)) ratios.end_to_end = end_to_end;
    out.ratios = ratios;
    return;
  }
  out.reason =
      "no local registration was correct from all of the nearest starts with a lower error";
}

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
      const Case c{.patient = patient,
                   .recorded = recorded,
                   .mm = mm,
                   .start = start_at(mm, patient.truth, recorded, patient.seed),
                   .repeats = mm == options.starts_mm.front() ? options.repeats : 1};
      const auto add_ours = [&](const std::string& name, const LocalEffort& effort, bool global) {
        const ImageRegistrationOptions with = options_of(effort, global);
        const auto ct = store.ready_ct(seed, with);
        Run run = quickest(c.repeats, [&] { return run_ours(with, ct->prepared, c); });
        // Only settings that a user can give: no number of patches and no search range.
        const bool by_command = options.by_command && elastix && !global &&
                                effort.patch_share == 1 && mm == options.starts_mm.front();
        for (int k = 0; by_command && k < c.repeats; ++k) {
          const auto whole =
              options.by_command(recorded.sweep, folder / "ct.mhd", c.start, effort.effort);
          if (whole) run.end_to_end_cpu_s = std::min(run.end_to_end_cpu_s, whole->cpu_s);
        }
        tallies[{name, mm}].add(run);
      };
      for (const LocalEffort& effort : options.local_efforts) {
        add_ours(name_of(effort), effort, false);
      }
      add_ours("sonde global", {}, true);
      if (elastix) add_theirs(options, *elastix, folder, c, tallies);
      if (progress) {
        progress(++done / static_cast<double>(options.starts_mm.size()) / options.patients);
      }
    }
  }
  PeerComparison out{rows_of(tallies), {}, ""};
  if (elastix) {
    add_ratios(options, out);
  } else {
    out.reason = "elastix is not in PATH (Debian package elastix)";
  }
  return out;
}

std::string to_text(const PeerComparison& comparison) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(3)
       << "\ncompared with elastix, same images and starts, one thread; processor s from images in "
          "memory (solve alone; whole process from files), fastest of the repeats\n";
  for (const PeerRow& row : comparison.rows) {
    text << "  " << std::setw(17) << std::left << row.name << std::right << " from " << std::setw(3)
         << static_cast<int>(row.start_mm) << " mm: correct " << row.right << '/' << row.trials
         << ", median " << row.error_median_mm << " mm, " << row.cpu_s << " (" << row.solve_cpu_s
         << "; " << row.end_to_end_cpu_s << ")\n";
  }
  if (const auto& r = comparison.ratios) {
    text << "  " << r->theirs << " / " << r->ours << " at the nearest start: " << r->cpu
         << " from images in memory, " << r->solve << " solve, "
         << r->end_to_end.value_or(std::numeric_limits<double>::quiet_NaN()) << " from files\n";
  } else {
    text << "  no ratio: " << comparison.reason << '\n';
  }
  return text.str();
}

}  // namespace nav::bench
