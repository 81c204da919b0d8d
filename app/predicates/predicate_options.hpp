// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "nav/result.hpp"
#include "render/features/scribbles.hpp"
#include "render/predicates/model.hpp"

namespace nav::app {

/// Change of one bar of the predicate histogram. Absent values stay unchanged.
struct HistogramEdit {
  std::string entry;                   ///< Name of the predicate in the predicate set.
  std::optional<double> importance{};  ///< [0, 1]; the others keep their proportions.
  std::optional<double> hue_deg{};     ///< Modulo 360.
  std::optional<double> saturation{};  ///< [0, 1].
  std::optional<double> floor{};       ///< [0, 1]: render::PredicateEntry::floor.
};

/// Options for drawing 3D ultrasound by predicates: volume, predicate set and view. Part of the
/// session file (section predicates).
struct PredicateOptions {
  std::filesystem::path volume;  ///< 3D ultrasound; empty: the phantom.
  std::string phantom = "neck";  ///< "neck", or a simulated patient (sim/predicate_patient.hpp).
  int phantom_side = 192;        ///< Voxels.
  bool alone = false;            ///< In a replay: drawn instead of the CT, not inside it.
  double ct_importance = 1;      ///< Impact of the CT beside the ultrasound: see
                                 ///< render::UltrasoundVolume.
  std::filesystem::path image;   ///< PNG to write.
  std::string set_up = "carotid-vessel";      ///< Name of a preset, or a file.
  std::vector<HistogramEdit> histogram;       ///< In order.
  std::vector<std::filesystem::path> labels;  ///< One: bit masks; several: a bit for each.
  std::filesystem::path layers;               ///< File of surfaces between layers, not labels.
  std::filesystem::path scan_lines;           ///< File of a sweep's planes, not into or apex.
  std::filesystem::path scribbles;            ///< File of strokes; applied before strokes.
  std::vector<render::features::Stroke> strokes;
  double scribble_share = 0.25;  ///< q of Eq. 9.
  std::filesystem::path
      save_set_up;  ///< File for the predicate set as it was drawn; empty: not written.
  /// Stored values that are drawn black and white. Both absent: intensity_window(). One absent: 0
  /// or 255.
  std::optional<double> black{};
  std::optional<double> white{};
  std::optional<double> shading_mm{};  ///< Smoothing of the gradients that shade; absent: value of
                                       ///< the predicate set.
  std::optional<double> soft_share{};  ///< Soft thresholds; absent: value of the predicate set.
  std::optional<double> opacity_length_mm{};  ///< Absent: value of the predicate set.
  std::optional<Eigen::Vector3d> into_ct{};   ///< Direction of parallel scan lines, LPS.
  /// Point of the plane where parallel scan lines have depth 0, LPS mm; absent: the known voxel
  /// that lies furthest towards the probe.
  std::optional<Eigen::Vector3d> face_ct{};
  std::optional<Eigen::Vector3d> apex_ct{};  ///< Apex of a fan, LPS mm; instead of into_ct.
  double face_radius_mm = 0;                 ///< Radius of the fan's probe.
  std::optional<double> smoothing_mm{};      ///< For gradients; absent: value of the predicate set.
  std::filesystem::path cache;               ///< Folder of derived features; empty: no cache.
  /// Radii of vessels, for vesselness; absent: values of the predicate set.
  std::optional<double> smallest_radius_mm{};
  std::optional<double> largest_radius_mm{};
  /// Vessels are brighter than their surroundings; absent: value of the predicate set.
  std::optional<bool> bright_vessels{};
  std::optional<std::string> hue_mean{};  ///< "circular", "linear"; absent: of the predicate set.
  std::optional<int> unknown{};           ///< Stored value of voxels that no image reached.
  /// Direction from the volume's middle to the eye, along the volume's axes i, j, k.
  Eigen::Vector3d from{-0.5, -1, 0.45};
  /// Centre x y z and radius, LPS mm. The target is drawn, and predicates measure distances from
  /// it.
  std::optional<Eigen::Vector4d> target{};
  std::optional<Eigen::Matrix<double, 6, 1>> needle{};  ///< Tip and hub, LPS mm.
};

/// Rejects histogram edits, points and directions that are not finite or out of range, and values
/// that contradict each other, such as both kinds of scan lines. The message names the key of the
/// session file. Ranges of single numbers stand in the option table, which
/// validate(SessionConfig) checks.
Result<void> validate(const PredicateOptions& options);

/// Applies edits in order. Rejects entries that the predicate set does not have, naming those that
/// it has, and an importance other than 1 for a single entry.
Result<void> apply_edits(const std::vector<HistogramEdit>& edits, render::PredicateModel& model);

/// Parses "NAME=IMPORTANCE". kUsage for anything else.
Result<HistogramEdit> parse_importance(const std::string& text);
/// Parses "NAME=FLOOR". kUsage for anything else.
Result<HistogramEdit> parse_floor(const std::string& text);
/// Parses "NAME=HUE:SATURATION", degrees and a share in [0, 1]. kUsage for anything else.
Result<HistogramEdit> parse_colour(const std::string& text);

}  // namespace nav::app
