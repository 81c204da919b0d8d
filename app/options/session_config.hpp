// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/options/cutaway_objects.hpp"
#include "app/options/window_state.hpp"
#include "app/predicates/predicate_options.hpp"
#include "nav/plan.hpp"
#include "nav/result.hpp"
#include "render/quality/step_search.hpp"
#include "render/transfer/transfer_function.hpp"
#include "render/transfer/transfer_presets.hpp"
#include "render/transfer/vessel_fit.hpp"
#include "session/critical_structures.hpp"
#include "session/options.hpp"

namespace nav::app {

/// One procedure: what goes in, how it is placed, how it is shown, where it goes. The TOML form is
/// documented in docs/session-file.md; units stand in the keys, unknown keys are rejected, paths
/// are relative to the file.
struct SessionConfig {
  std::filesystem::path file;  ///< Empty when made from the command line.

  using SourceKind = session::SourceKind;
  using Source = session::SourceOptions;
  using Placement = session::PlacementOptions;
  session::CtOptions ct;
  Source source;
  session::PlacementOptions placement;

  /// Later members win: preset, nodes, file, then what is said one by one.
  struct Appearance {
    std::string preset = "contextual";          ///< One of all_preset_names().
    std::vector<render::TransferNode> nodes{};  ///< Replaces the preset when not empty.
    bool shading = true;                        ///< false: off, whatever the file says.
    double plane_opacity = 1.0;
    std::string plane_texture = "ultrasound";  ///< Or ct: the CT along the plane.
    std::filesystem::path file{};        ///< Appearance or Slicer preset; replaces preset, nodes.
    std::optional<std::string> style{};  ///< phong or gooch.
    std::optional<double> emphasis{};    ///< [0, 1].
    std::vector<render::ImportanceRule> importance{};
    /// Regions in which the ultrasound and the objects of the plan are cut free; absent: values of
    /// the file, or render::Cutaway's own values.
    struct Cutaway {
      std::optional<bool> enabled{};  ///< Absent here and in the file: on.
      std::optional<double> theta1_deg{};
      std::optional<double> theta2_deg{};
      std::optional<double> overlay_mm{};  ///< Infinity: no clear region.
      /// Thresholds of the fade, lower and upper, in place of those by importance; absent: those
      /// of the file.
      std::optional<Eigen::Vector2d> constant{};
      std::optional<bool> around_plane{};
      std::optional<bool> around_needle{};
      std::optional<bool> around_targets{};
    } cutaway{};
    bool fit_vessels = true;                       ///< false: never, whatever preset or file say.
    std::optional<Eigen::Vector3d> blood_at_mm{};  ///< Point in a vessel, LPS; absent: searched.
    double least_vessel_ml = render::kLeastVesselMl;  ///< Smaller fragments are not drawn.
    bool remove_table = true;  ///< false: the table is drawn, whatever preset or file say.
    /// Smoothing of the gradients, [0, 20] mm; absent: of the appearance.
    std::optional<double> smoothing_mm{};
    std::filesystem::path save{};          ///< Stores the appearance that is drawn; empty: no.
    std::string projection = "composite";  ///< Or maximum, minimum, mean.
    /// Grey window of projections other than composite; absent: that of
    /// render::window_of_projection().
    std::optional<double> grey_level_hu{};
    std::optional<double> grey_width_hu{};
  } appearance;

  /// Plan of a replay; the simulated procedure has its own. Absent: no target, path or entry is
  /// drawn.
  std::optional<NeedlePlan> plan;

  /// Structures that the planned path has to stay away from.
  std::vector<session::CriticalStructure> critical_structures;

  /// Objects that are cut free beside the plane, the needle and the targets.
  std::vector<CutawayObject> cutaway_objects;

  /// How the 3D view is sampled.
  struct Quality {
    std::string classification = "pre-integrated";  ///< Or post-classified.
    bool jitter = false;
  } quality;

  /// Options of 'sonde predicates'; 'sonde replay' draws by them when they name a volume.
  PredicateOptions predicates;

  /// About the point that the plane shows. Azimuth 0 looks from the front (anterior), 90 from the
  /// patient's left; elevation from above (superior). Both absent: so that the plane is well seen.
  struct View {
    std::optional<double> azimuth_deg = std::nullopt;
    std::optional<double> elevation_deg = std::nullopt;
    double distance_mm =
        0;  ///< 0: so that the CT, or the plane with its surroundings, fills the view.
    double fov_deg = 30;
    bool orthographic = false;  ///< Parallel rays; what the view looks at keeps its size.
    /// Grey window of the flat images of the CT, HU. Absent: depends on the shown values, by
    /// ct_window().
    std::optional<double> window_level = std::nullopt;
    std::optional<double> window_width = std::nullopt;
  } view;

  /// State of the window, in sessions that it has saved.
  WindowState window;

  struct Output {
    std::filesystem::path folder;
    std::string engine = "cpu";
    int threads = 0;
    int width = 800;   ///< Width of the 3D view, pixels.
    int height = 600;  ///< Height of the 3D view, pixels.
    /// Absent: the step that rms_error needs, found at the first image; by predicates half a voxel.
    std::optional<double> step_voxels = std::nullopt;
    double rms_error = render::kDefaultRms;  ///< Estimated rms error of the image of the CT.
    double pixel_error = 0;                  ///< Allowed error of interpolated pixels; 0: none.
    int frames = 0;                          ///< Largest number of written images; 0: all.
    double seconds = 0;                      ///< Duration of a live session; 0: until it is ended.
    std::filesystem::path record;            ///< Recording of a live session; empty: none.
    bool window = false;
  } output;
};

/// Reads a session file. Errors name file, line, key, what was expected and what was found.
Result<SessionConfig> read_session_config(const std::filesystem::path& path);

/// Rejects values out of range, by key.
Result<void> validate(const SessionConfig& config);

Result<void> validate(const SessionConfig::Appearance& appearance);

/// Rejects a path that neither the session nor an option gave, by that option. what: "a CT".
Result<void> require_path(const std::filesystem::path& path, const char* option, const char* what);

/// The resolved form, as TOML: what the program really uses. Rejects, by key, a text that is not
/// UTF-8, as names of files may be: TOML cannot hold it. folder: of the file to be written, which
/// paths are relative to; empty: paths are absolute.
Result<std::string> to_toml(const SessionConfig& config, const std::filesystem::path& folder = {});

}  // namespace nav::app
