// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/predicate_cases.hpp"
#include "bench/predicate_edit.hpp"

namespace nav::bench {

/// One scene on the GL engine: predicates beside the standard transfer function, beside brute force
/// and beside the paper's own shader. Times of a frame: process time where OpenGL runs in software,
/// otherwise what the device took for the rays of a frame that stays on it.
struct GlPredicateRow {
  std::string scene;
  double standard_ms = 0;
  double predicate_ms = 0;
  double brute_ms = 0;
  double paper_ms = 0;
  double paper_difference = 0;  ///< Of any channel to the same scene drawn by brute force, [0, 1].
  double paper_rms = 0;         ///< Likewise, over all pixels and channels.
  /// On a device, the paper's shader with the filter of its textures, which may be too coarse for
  /// the same picture.
  std::optional<double> paper_own_filter_ms;
  std::optional<double> paper_own_filter_difference;  ///< As paper_difference.
  /// Where OpenGL runs in software, the same on the CPU engine.
  std::optional<double> cpu_engine_ms;
  std::optional<double> cpu_paper_difference;
  double max_error = 0;    ///< Of early termination, as well.
  bool identical = false;  ///< Skipping on and off draw the same bytes.
  double edit_ms = 0;      ///< Wall time before the first ray after a new importance.
  /// By how much the first frame of a set that was never drawn takes longer than a frame of it once
  /// it has its own program, after a set that reads nothing but the volume: features and labels are
  /// sent too. Process time where OpenGL runs in software, with the compiler's cache as it was
  /// found.
  double set_edit_ms = 0;
  ProgressiveEdit edit;  ///< From that other set.
  /// By how much the longest of the frames after that one does: it compiles the program of the set.
  double settle_ms = 0;
};

/// The paper's shader differs by no more from what its time is compared with. Single pixels may:
/// where a feature is at the edge of a predicate.
inline constexpr double kSamePictureRms = 1.0 / 255;

struct GlPredicateReport {
  std::string device;
  int width = 0;
  int height = 0;
  std::vector<GlPredicateRow> rows;

  /// Median over scenes of standard_ms / predicate_ms.
  [[nodiscard]] double predicate_over_standard() const;
  /// Median over scenes of paper_ms / predicate_ms; empty unless all are the same picture, within
  /// kSamePictureRms.
  [[nodiscard]] std::optional<double> vs_paper_shader() const;
  /// Median over scenes of paper_own_filter_ms / predicate_ms, whatever it draws; empty where
  /// OpenGL runs in software.
  [[nodiscard]] std::optional<double> vs_paper_shader_own_filter() const;
  /// Median over scenes of paper_ms / cpu_engine_ms, likewise; empty where OpenGL has a device of
  /// its own.
  [[nodiscard]] std::optional<double> cpu_vs_paper_shader() const;
  [[nodiscard]] double max_error() const;
  [[nodiscard]] double worst_set_edit_ms() const;
  [[nodiscard]] double worst_set_edit_wall_ms() const;
};

/// kUnavailable without OpenGL. Pictures of half the size where OpenGL runs in software. done():
/// called after each scene. of_device: instead of what the device's name says, for tests.
Result<GlPredicateReport> measure_gl_predicates(const std::vector<PredicateVolume>& volumes,
                                                int width, int height, int repeats,
                                                Diagnostics& diagnostics,
                                                const std::function<void()>& done,
                                                std::optional<bool> of_device = {});

/// Plain-text table.
std::string to_text(const GlPredicateReport& report);

}  // namespace nav::bench
