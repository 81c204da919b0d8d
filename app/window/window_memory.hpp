// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>

#include "app/options/window_state.hpp"
#include "app/window/cutaway_page.hpp"
#include "app/window/flat_engine.hpp"
#include "render/scene.hpp"

// Conversions between the window's values and those of a session file. What was read and not
// changed is written as it was read, so that a session reopens to the same bytes.
namespace nav::app {

/// A text that was read, and the text of its values as Sonde writes them.
struct KeptText {
  std::string given{}, canonical{};
  /// The text for the values of now: the one that was read, if they are the same.
  [[nodiscard]] std::string text_of(std::string now) const {
    if (now == canonical) return given;
    return now;
  }
};

WindowState::Camera saved_camera(const render::Camera& camera);
/// Precondition: all parts are there.
render::Camera camera_of(const WindowState::Camera& saved);

WindowState::Cutaway saved_cutaway(const CutawaySettings& settings);
/// Precondition: all parts are there.
CutawaySettings cutaway_of(const WindowState::Cutaway& saved);

/// Writes cursor, windows and zooms into a state; name: of a view.
void save_slices(const SliceSettings& settings, const PerView<std::string>& names,
                 WindowState& state);
SliceSettings slices_of(const WindowState& state, const PerView<std::string>& names);

}  // namespace nav::app
