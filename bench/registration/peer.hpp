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

/// A local registration by what a user can ask for, or, for the curve, with a share of its patches.
struct LocalEffort {
  registration::Effort effort = registration::Effort::kUsual;
  double patch_share = 1;  ///< Each level has 50 at least; 1: as a user gets it.
};

/// Where a program registered files to, and the processor time of its whole process.
struct CommandRun {
  CtPose found;
  double cpu_s;
};

/// Registers the files of write_elastix_case()'s CT and of a sweep from a start, in a process of
/// its own, one thread.
using RegisterByCommand =
    std::function<Result<CommandRun>(const Sweep& sweep, const std::filesystem::path& ct,
                                     const CtPose& start, registration::Effort effort)>;

/// Which cases both sides get. The same images, the same starts, one thread.
struct PeerOptions {
  std::uint64_t first_seed = 1;
  int patients = 4;
  /// Of each run from the nearest start, which the ratios are of, >= 1; the quickest counts, on
  /// both sides.
  int repeats = 3;
  std::vector<double> starts_mm{5, 10, 20, 40};
  /// Cheapest first, as ours below.
  std::vector<ElastixEffort> efforts{{40, 2000, 1},  {60, 2000, 1},  {100, 2000, 1}, {150, 2000, 1},
                                     {150, 2000, 2}, {150, 2000, 3}, {500, 2000, 3}};
  std::vector<LocalEffort> local_efforts{
      {registration::Effort::kQuick, 0.5},  {registration::Effort::kQuick, 1},
      {registration::Effort::kQuick, 2},    {registration::Effort::kQuick, 4},
      {registration::Effort::kUsual, 0.25}, {registration::Effort::kUsual, 0.5},
      {registration::Effort::kUsual, 1}};
  RegisterByCommand by_command;  ///< Empty: nothing is known of files to file.
};

/// One way to register, over all cases from one distance.
struct PeerRow {
  std::string name;  ///< "sonde quick", "sonde local", "sonde global", "elastix 150x1" (iterations,
                     ///< resolutions).
  double start_mm;
  int trials, right;
  double error_median_mm;  ///< Of the right ones; NaN without.
  /// Medians over cases of the quickest repeats, each part on its own, processor s.
  double cpu_s;             ///< From images in memory to the pose, preparation included.
  double solve_cpu_s;       ///< The same without pyramids and preparation.
  double end_to_end_cpu_s;  ///< The whole process, from files; NaN where not measured.
};

/// elastix over ours, processor time, at the nearest start: at its cheapest effort that converges,
/// that is: right on all of the nearest starts, with an error that the next effort of as many
/// resolutions does not lower by more than a tenth. Ours at the cheapest effort that a user can ask
/// for that is right on all of them with a lower error.
struct PeerRatios {
  double cpu, solve;
  std::optional<double> end_to_end;
  std::string ours, theirs;  ///< Rows.
};

struct PeerComparison {
  std::vector<PeerRow> rows;
  std::optional<PeerRatios> ratios;  ///< Absent: reason.
  std::string reason;
};

/// The ratios of rows, or why there are none. Names are those that compare_with_elastix() gives.
void add_ratios(const PeerOptions& options, PeerComparison& comparison);

/// elastix absent: only our rows, and the reason. folder: where its files go; it must exist.
Result<PeerComparison> compare_with_elastix(const PeerOptions& options, CaseStore& store,
                                            const std::optional<std::filesystem::path>& elastix,
                                            const std::filesystem::path& folder,
                                            const std::function<void(double)>& progress = {});

std::string to_text(const PeerComparison& comparison);

}  // namespace nav::bench
