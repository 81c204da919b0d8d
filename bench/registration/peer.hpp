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

namespace nav::bench {

/// A cheaper local registration: fewer patches on every level, of the pictures only some, and
/// samples further apart on the finest level, which makes the CT's part cheaper as well.
struct LocalEffort {
  double patch_share = 1;     ///< Of the usual number, (0, 1]; each level has 50 at least.
  int picture_stride = 1;     ///< Every so many-th, >= 1.
  double finest_step_mm = 0;  ///< Of the finest level's samples; 0: as usual.
};

/// Which cases both sides get. The same images, the same starts, one thread.
struct PeerOptions {
  std::uint64_t first_seed = 1;
  int patients = 4;
  /// Of each run from the nearest start, which the ratios are of, >= 1; the quickest counts, on
  /// both sides.
  int repeats = 3;
  std::vector<double> starts_mm{5, 10, 20, 40};
  /// Cheapest first, as ours below.
  std::vector<ElastixEffort> efforts{
      {150, 2000, 1}, {150, 2000, 2}, {150, 2000, 3}, {500, 2000, 3}};
  registration::ImageRegistrationOptions local, global;
  std::vector<LocalEffort> local_efforts{{0.05, 4, 2},  {0.05, 4}, {0.1, 4, 2},
                                         {0.1, 4, 1.6}, {0.1, 4},  {0.25, 4},
                                         {0.25, 1},     {0.5, 1},  {1, 1}};
};

/// One way to register, over all cases from one distance.
struct PeerRow {
  std::string name;  ///< "sonde local", "sonde global", "elastix 150x1" (iterations, resolutions).
  double start_mm;
  int trials, right;
  double error_median_mm;  ///< Of the right ones; NaN without.
  double cpu_s;            ///< Median of the quickest of each case's repeats, from images in memory
                           ///< (ours) or files (elastix) to the pose.
  double solve_cpu_s;      ///< The same without reading, pyramids and preparation.
};

struct PeerComparison {
  std::vector<PeerRow> rows;
  /// elastix at its cheapest effort that is right on more than half of the nearest starts, over our
  /// local registration from the same starts at its cheapest that is right on all of them with a
  /// lower error: processor time of the whole. Absent: reason.
  std::optional<double> cpu_ratio;
  std::optional<double> solve_cpu_ratio;
  std::string ours;    ///< Row that the ratios are with.
  std::string reason;  ///< Why there is no ratio.
};

/// elastix absent: only our rows, and the reason. folder: where its files go; it must exist.
Result<PeerComparison> compare_with_elastix(const PeerOptions& options, CaseStore& store,
                                            const std::optional<std::filesystem::path>& elastix,
                                            const std::filesystem::path& folder,
                                            const std::function<void(double)>& progress = {});

std::string to_text(const PeerComparison& comparison);

}  // namespace nav::bench
