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

/// One scene on the GL engine: predicates compared with the standard transfer function, with brute
/// force and with the paper's own shader. Times of an image: process time if OpenGL runs in
/// software, otherwise the device's time for the rays of an image that stays on it.
struct GlPredicateRow {
  std::string scene;
  double standard_ms = 0;
  double predicate_ms = 0;
  double brute_ms = 0;
  double paper_ms = 0;
  /// Largest difference in any channel from the same scene drawn by brute force, [0, 1].
  double paper_difference = 0;
  double paper_rms = 0;  ///< RMS of the same difference over all pixels and channels.
  /// Time on a device of the paper's shader with the filter of its textures, which may be too
  /// coarse for the same image.
  std::optional<double> paper_own_filter_ms;
  std::optional<double> paper_own_filter_difference;  ///< Like paper_difference.
  /// Comparison with the CPU engine, if OpenGL runs in software.
  std::optional<double> cpu_engine_ms;
  std::optional<double> cpu_paper_difference;
  double max_error = 0;    ///< Error of early termination, as on the CPU.
  bool identical = false;  ///< Skipping on and off draw the same bytes.
  double edit_ms = 0;      ///< Wall time before the first ray after a new importance.
  /// Extra time of the first image of a predicate set that was never drawn, compared with an image
  /// of the set once it has its own program. The set before reads only the volume: features and
  /// labels are uploaded too. Process time if OpenGL runs in software; the compiler's cache is used
  /// as found.
  double set_edit_ms = 0;
  ProgressiveEdit edit;  ///< After the same change of the predicate set.
  /// Extra time of the longest image after the first one: that image compiles the program of the
  /// set.
  double settle_ms = 0;
};

/// Largest difference of the paper's shader from the image that its time is compared with. Single
/// pixels may differ more, where a feature is at the edge of a predicate.
inline constexpr double kSameImageRms = 1.0 / 255;

struct GlPredicateReport {
  std::string device;
  int width = 0;
  int height = 0;
  std::vector<GlPredicateRow> rows;

  /// Median over scenes of standard_ms / predicate_ms.
  [[nodiscard]] double predicate_over_standard() const;
  /// Median over scenes of paper_ms / predicate_ms; empty unless all images agree within
  /// kSameImageRms.
  [[nodiscard]] std::optional<double> vs_paper_shader() const;
  /// Median over scenes of paper_own_filter_ms / predicate_ms, whatever the shader draws; empty if
  /// OpenGL runs in software.
  [[nodiscard]] std::optional<double> vs_paper_shader_own_filter() const;
  /// Median over scenes of paper_ms / cpu_engine_ms under the same condition; empty if OpenGL has
  /// its own device.
  [[nodiscard]] std::optional<double> cpu_vs_paper_shader() const;
  [[nodiscard]] double max_error() const;
  [[nodiscard]] double worst_set_edit_ms() const;
  [[nodiscard]] double worst_set_edit_wall_ms() const;
};

/// kUnavailable without OpenGL. Images have half the size if OpenGL runs in software. done():
/// called after each scene. of_device: replaces the decision by the device's name, for tests.
Result<GlPredicateReport> measure_gl_predicates(const std::vector<PredicateVolume>& volumes,
                                                int width, int height, int repeats,
                                                Diagnostics& diagnostics,
                                                const std::function<void()>& done,
                                                std::optional<bool> of_device = {});

/// Plain-text table.
std::string to_text(const GlPredicateReport& report);

}  // namespace nav::bench
