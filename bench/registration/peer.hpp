// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/registration/elastix_peer.hpp"
#include "bench/registration/trials.hpp"
#include "registration/image_registration.hpp"

namespace nav::bench {

/// A local registration as a user can request it, or, for the curve, with a fraction of its
/// patches.
struct LocalEffort {
  registration::Effort effort = registration::Effort::kUsual;
  double patch_share = 1;  ///< Each level has at least 50 patches; 1: as a user gets it.
};

/// Pose that a program found from files, and the processor time of its whole process.
struct CommandRun {
  CtPose found;
  double cpu_s;
};

/// Registers the CT file of write_elastix_case() and a sweep from a start, in a separate process,
/// one thread.
using RegisterByCommand =
    std::function<Result<CommandRun>(const Sweep& sweep, const std::filesystem::path& ct,
                                     const CtPose& start, registration::Effort effort)>;

/// Cases for both sides: the same images, the same starts, one thread.
struct PeerOptions {
  std::uint64_t first_seed = 1;
  int patients = 4;
  /// Repeats of each run from the nearest start, which the ratios use, >= 1; the fastest counts, on
  /// both sides.
  int repeats = 3;
  std::vector<double> starts_mm{5, 10, 20, 40};
  /// Cheapest first, as in local_efforts.
  std::vector<ElastixEffort> efforts{{40, 2000, 1},  {60, 2000, 1},  {100, 2000, 1}, {150, 2000, 1},
                                     {150, 2000, 2}, {150, 2000, 3}, {500, 2000, 3}};
  std::vector<LocalEffort> local_efforts{
      {registration::Effort::kQuick, 0.5},  {registration::Effort::kQuick, 1},
      {registration::Effort::kQuick, 2},    {registration::Effort::kQuick, 4},
      {registration::Effort::kUsual, 0.25}, {registration::Effort::kUsual, 0.5},
      {registration::Effort::kUsual, 1}};
  RegisterByCommand by_command;  ///< Empty: runs from files are not measured.
};

/// Results of one method over all cases from one start distance.
struct PeerRow {
  std::string name;  ///< "sonde quick", "sonde local", "sonde global", "elastix 150x1" (iterations,
                     ///< resolutions).
  double start_mm;
  int trials, right;
  double error_median_mm;  ///< Error of the right results; NaN if there are none.
  /// Medians over cases of the fastest repeats, each part separately, processor s.
  double cpu_s;             ///< From images in memory to the pose, including preparation.
  double solve_cpu_s;       ///< Without pyramids and preparation.
  double end_to_end_cpu_s;  ///< The whole process, from files; NaN if not measured.
};

/// elastix over ours, processor time, at the nearest start. elastix runs at its cheapest effort
/// that converges: right on all of the nearest starts, with an error that the next effort of the
/// same number of resolutions does not lower by more than a tenth. Ours runs at the cheapest effort
/// that a user can request, is right on all of them, and has a lower error.
struct PeerRatios {
  double cpu, solve;
  std::optional<double> end_to_end{};
  std::string ours, theirs;  ///< Names of the rows.
};

struct PeerComparison {
  std::vector<PeerRow> rows;
  std::optional<PeerRatios> ratios;  ///< Absent: see reason.
  std::string reason;
};

/// Computes the ratios of rows, or the reason why there are none. Names must be those of
/// compare_with_elastix().
void add_ratios(const PeerOptions& options, PeerComparison& comparison);

/// elastix absent: only our rows, and the reason. folder: destination of its files; it must exist.
Result<PeerComparison> compare_with_elastix(const PeerOptions& options, CaseStore& store,
                                            const std::optional<std::filesystem::path>& elastix,
                                            const std::filesystem::path& folder,
                                            const std::function<void(double)>& progress = {});

std::string to_text(const PeerComparison& comparison);

}  // namespace nav::bench
