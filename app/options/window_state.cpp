// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/window_state.hpp"

#include <array>

namespace nav::app {
namespace {

Error contradiction(const std::string& key, const std::string& expected, const std::string& found) {
  return {ErrorCode::kUsage, key + ": expected " + expected + ", found " + found};
}

/// A part of a group of which all parts are there, or none.
struct Part {
  const char* name;
  bool there;
};

template <std::size_t N>
Result<void> check_group(const std::string& table, const std::array<Part, N>& parts) {
  std::string there, missing;
  for (const Part& part : parts) {
    std::string& list = part.there ? there : missing;
    list += (list.empty() ? "" : ", ") + std::string(part.name);
  }
  if (there.empty() || missing.empty()) return {};
  return contradiction(table, missing + " beside " + there, "nothing");
}

}  // namespace

Result<void> validate(const WindowState& state) {
  const auto& camera = state.camera;
  if (auto ok = check_group(
          "window.camera",
          std::array{Part{"eye_mm", camera.eye_mm.has_value()},
                     Part{"look_at_mm", camera.look_at_mm.has_value()},
                     Part{"up", camera.up.has_value()}, Part{"fov_deg", camera.fov_deg.has_value()},
                     Part{"orthographic", camera.orthographic.has_value()},
                     Part{"height_mm", camera.height_mm.has_value()}});
      !ok) {
    return ok;
  }
  if (camera.eye_mm) {
    const Eigen::Vector3d view = *camera.look_at_mm - *camera.eye_mm;
    const bool turned = view.cross(*camera.up).norm() > 1e-9 * view.norm() * camera.up->norm();
    if (!(view.norm() > 1e-6) || !turned) {
      return contradiction("window.camera",
                           "an eye apart from its look-at point, and up beside that direction",
                           "others");
    }
  }
  const auto& cutaway = state.cutaway;
  if (auto ok = check_group("window.cutaway",
                            std::array{Part{"enabled", cutaway.enabled.has_value()},
                                       Part{"theta1_deg", cutaway.theta1_deg.has_value()},
                                       Part{"theta2_deg", cutaway.theta2_deg.has_value()},
                                       Part{"overlay_mm", cutaway.overlay_mm.has_value()},
                                       Part{"emphasis", cutaway.emphasis.has_value()},
                                       Part{"style", cutaway.style.has_value()}});
      !ok) {
    return ok;
  }
  if (cutaway.theta1_deg && *cutaway.theta1_deg > *cutaway.theta2_deg) {
    return contradiction("window.cutaway.theta1_deg", "at most theta2_deg",
                         std::to_string(*cutaway.theta1_deg));
  }
  if (state.grey_level.has_value() != state.grey_width.has_value()) {
    return Error{ErrorCode::kUsage,
                 "window.grey_level requires window.grey_width, and the reverse"};
  }
  if (state.ultrasound_level.has_value() != state.ultrasound_width.has_value()) {
    return Error{ErrorCode::kUsage,
                 "window.ultrasound_level requires window.ultrasound_width, and the reverse"};
  }
  const bool alone = state.layout == "single";
  if (alone != state.single.has_value() || alone != state.layout_before.has_value()) {
    return contradiction("window.layout",
                         alone ? "window.single and window.layout_before beside single"
                               : "single beside window.single and window.layout_before",
                         alone ? "nothing" : state.layout.value_or("nothing"));
  }
  if (state.strokes && !state.predicate_set) {
    return Error{ErrorCode::kUsage, "window.strokes requires window.predicate_set"};
  }
  return {};
}

}  // namespace nav::app
