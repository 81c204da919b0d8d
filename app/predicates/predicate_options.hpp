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

/// A change of one bar of the predicate histogram; what is absent stays.
struct HistogramEdit {
  std::string entry;                   ///< Name of the predicate in the set-up.
  std::optional<double> importance{};  ///< [0, 1]; the others keep their proportions.
  std::optional<double> hue_deg{};     ///< Modulo 360.
  std::optional<double> saturation{};  ///< [0, 1].
};

/// 3D ultrasound by predicates: what is drawn, by which set-up, seen from where. Part of the
/// session file (section predicates).
struct PredicateOptions {
  std::filesystem::path volume;   ///< 3D ultrasound; empty: the phantom.
  std::string phantom = "neck";   ///< "neck", or a simulated patient (sim/predicate_patient.hpp).
  int phantom_side = 192;         ///< Voxels, [32, 512].
  bool alone = false;             ///< In a replay: instead of the CT, not inside it.
  double ct_importance = 1;       ///< Impact of the CT beside it: render::UltrasoundVolume.
  std::filesystem::path picture;  ///< PNG to write.
  std::string set_up = "carotid-vessel";      ///< Name of a preset, or a file.
  std::vector<HistogramEdit> histogram;       ///< In order.
  std::vector<std::filesystem::path> labels;  ///< One: bit masks; several: a bit for each.
  std::filesystem::path layers;               ///< File of surfaces between layers; instead.
  std::filesystem::path scan_lines;           ///< File of a sweep's planes; instead of the below.
  std::filesystem::path scribbles;            ///< File of strokes; before those below.
  std::vector<render::features::Stroke> strokes;
  double scribble_share = 0.25;  ///< q of Eq. 9, (0, 1].
  std::filesystem::path
      save_set_up;   ///< Where to write the set-up as it was drawn; empty: nowhere.
  double black = 0;  ///< Stored values.
  double white = 255;
  std::optional<double> opacity_length_mm{};  ///< Absent: what the set-up says.
  std::optional<Eigen::Vector3d> into_ct{};   ///< Parallel scan lines, LPS.
  /// LPS mm, a point of the plane where those have depth 0; absent: of the known voxel that lies
  /// furthest towards the probe.
  std::optional<Eigen::Vector3d> face_ct{};
  std::optional<Eigen::Vector3d> apex_ct{};  ///< Of a fan, LPS mm; instead.
  double face_radius_mm = 0;                 ///< Of the fan's probe.
  std::optional<double> smoothing_mm{};      ///< Of gradients; absent: what the set-up says.
  std::filesystem::path cache;               ///< Folder of derived features; empty: none is kept.
  /// Of vessels, for vesselness; absent: what the set-up says.
  std::optional<double> smallest_radius_mm{};
  std::optional<double> largest_radius_mm{};
  /// Brighter than what surrounds them; absent: what the set-up says.
  std::optional<bool> bright_vessels{};
  std::optional<std::string> hue_mean{};  ///< "circular" or "linear"; absent: as the set-up says.
  std::optional<int> unknown{};           ///< Stored value of voxels that no picture reached.
  /// The eye as seen from the volume's middle, along its axes i, j, k.
  Eigen::Vector3d from{-0.5, -1, 0.45};
  std::optional<Eigen::Vector4d> target{};  ///< x y z, LPS mm, and radius: drawn, and a distance.
  std::optional<Eigen::Matrix<double, 6, 1>> needle{};  ///< Tip and hub, LPS mm.
};

/// Refuses, naming the key of the session file: numbers that are not finite or out of range, both
/// kinds of scan lines at once.
Result<void> validate(const PredicateOptions& options);

/// Edits in order. Refuses entries that the set-up does not have, naming those that it has, and
/// another importance than 1 of the only one.
Result<void> apply_edits(const std::vector<HistogramEdit>& edits, render::PredicateModel& model);

/// "NAME=IMPORTANCE". kUsage for anything else.
Result<HistogramEdit> parse_importance(const std::string& text);
/// "NAME=HUE:SATURATION", degrees and share. kUsage for anything else.
Result<HistogramEdit> parse_colour(const std::string& text);

}  // namespace nav::app
