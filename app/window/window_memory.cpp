// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/window_memory.hpp"

#include <cmath>

namespace nav::app {
namespace {

constexpr double kRadOfDegree = M_PI / 180;

/// Degrees that come back to the same number from radians.
double whole_degrees(double rad) {
  constexpr double kSteps = 1e9;
  return std::round(rad / kRadOfDegree * kSteps) / kSteps;
}

}  // namespace

WindowState::Camera saved_camera(const render::Camera& camera) {
  return {.eye_mm = camera.eye_ct.mm,
          .look_at_mm = camera.look_at_ct.mm,
          .up = camera.up_ct.v,
          .fov_deg = whole_degrees(camera.vertical_fov_rad),
          .orthographic = camera.orthographic,
          .height_mm = camera.orthographic_height_mm};
}

render::Camera camera_of(const WindowState::Camera& saved) {
  return {.eye_ct = {*saved.eye_mm},
          .look_at_ct = {*saved.look_at_mm},
          .up_ct = {*saved.up},
          .vertical_fov_rad = *saved.fov_deg * kRadOfDegree,
          .orthographic = *saved.orthographic,
          .orthographic_height_mm = *saved.height_mm};
}

WindowState::Cutaway saved_cutaway(const CutawaySettings& settings) {
  return {.enabled = settings.cutaway.on,
          .theta1_deg = whole_degrees(settings.cutaway.theta1_rad),
          .theta2_deg = whole_degrees(settings.cutaway.theta2_rad),
          .overlay_mm = settings.cutaway.overlay_mm,
          .emphasis = settings.emphasis,
          .style = settings.style == render::ShadingStyle::kGooch ? "gooch" : "phong"};
}

CutawaySettings cutaway_of(const WindowState::Cutaway& saved) {
  return {.cutaway = {.on = *saved.enabled,
                      .theta1_rad = *saved.theta1_deg * kRadOfDegree,
                      .theta2_rad = *saved.theta2_deg * kRadOfDegree,
                      .overlay_mm = *saved.overlay_mm},
          .emphasis = *saved.emphasis,
          .style =
              saved.style == "gooch" ? render::ShadingStyle::kGooch : render::ShadingStyle::kPhong};
}

void save_slices(const SliceSettings& settings, const PerView<std::string>& names,
                 WindowState& state) {
  if (settings.cursor) state.cursor_mm = settings.cursor->mm;
  if (settings.window) {
    state.grey_level = settings.window->level;
    state.grey_width = settings.window->width;
  }
  if (settings.ultrasound_window) {
    state.ultrasound_level = settings.ultrasound_window->level;
    state.ultrasound_width = settings.ultrasound_window->width;
  }
  for (const ViewId id : kFlatViews) {
    const SliceZoom& zoom = settings.zoom[id];
    if (zoom.factor == 1 && zoom.shift_mm.isZero(0)) continue;
    state.zooms.push_back({names[id], zoom.factor, zoom.shift_mm});
  }
}

SliceSettings slices_of(const WindowState& state, const PerView<std::string>& names) {
  SliceSettings settings;
  if (state.cursor_mm) settings.cursor = Point<frames::Ct>{*state.cursor_mm};
  if (state.grey_level) settings.window = render::HuWindow{*state.grey_level, *state.grey_width};
  if (state.ultrasound_level) {
    settings.ultrasound_window = render::HuWindow{*state.ultrasound_level, *state.ultrasound_width};
  }
  for (const auto& saved : state.zooms) {
    for (const ViewId id : kFlatViews) {
      if (names[id] == saved.view) settings.zoom[id] = {saved.factor, saved.shift_mm};
    }
  }
  return settings;
}

}  // namespace nav::app
