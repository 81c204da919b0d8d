// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "nav/result.hpp"

namespace nav::app {

/// State of the window that a session file keeps, so that the session reopens as it was. Absent
/// parts are those of a new session. Points in the CT (LPS), mm.
struct WindowState {
  std::optional<std::string> layout{};         ///< guidance, slices, needle or single.
  std::optional<std::string> layout_before{};  ///< Layout under single.
  std::optional<std::string> single{};         ///< Control's name of the view that is alone.
  std::optional<int> step{};                   ///< 1 to 7.
  std::optional<std::string> panel{};          ///< step, predicates, transfer or cutaway.

  /// Views of the second screen: view3d, ultrasound, ctplane, slices, each at most once, in this
  /// order. Empty: those of the window.
  std::vector<std::string> second_views{};

  /// Camera of the 3D view; all of its parts, or none.
  struct Camera {
    std::optional<Eigen::Vector3d> eye_mm{}, look_at_mm{}, up{};
    std::optional<double> fov_deg{};
    std::optional<bool> orthographic{};
    std::optional<double> height_mm{};  ///< Height of the image, when orthographic.
  } camera{};

  std::optional<Eigen::Vector3d> cursor_mm{};
  std::optional<double> grey_level{}, grey_width{};              ///< Slices of the CT.
  std::optional<double> ultrasound_level{}, ultrasound_width{};  ///< Slices of 3D ultrasound.
  struct Zoom {
    std::string view{};  ///< Control's name.
    double factor = 1;
    Eigen::Vector2d shift_mm = Eigen::Vector2d::Zero();
  };
  std::vector<Zoom> zooms{};

  /// Cutaway and shading as edited; all of its parts, or none.
  struct Cutaway {
    std::optional<bool> enabled{};
    std::optional<double> theta1_deg{}, theta2_deg{};
    std::optional<double> overlay_mm{};  ///< Infinity: no clear region.
    std::optional<double> emphasis{};
    std::optional<std::string> style{};
  } cutaway{};

  std::optional<std::string> transfer{};       ///< JSON of an appearance: its components.
  std::optional<std::string> predicate_set{};  ///< JSON of a predicate set, before the strokes.
  std::optional<std::string> strokes{};        ///< JSON of scribbles.
  std::optional<int> predicate{};              ///< Chosen bar, from 1.
  /// The user's word about the registration in use: accepted or rejected.
  std::optional<std::string> verdict{};

  /// False: a session that no window has saved.
  [[nodiscard]] bool is_saved() const { return layout.has_value(); }
};

/// Rejects parts that belong together and are not all there, and contradictions, by key.
Result<void> validate(const WindowState& state);

}  // namespace nav::app
