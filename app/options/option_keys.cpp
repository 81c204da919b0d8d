// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/option_keys.hpp"

#include <string>

namespace nav::app {
namespace {

constexpr OptionOfKey kOptionsOfKeys[] = {
    {"output.engine", "--engine"},
    {"output.width_px", "--width"},
    {"output.height_px", "--height"},
    {"output.threads", "--threads"},
    {"output.step_voxels", "--step"},
    {"output.rms_error", "--rms-error"},
    {"output.pixel_error", "--pixel-error"},
    {"quality.classification", "--classification"},
    {"output.frames", "--frames"},
    {"source.needle_length_mm", "--needle-length-mm"},
    {"source.needle_diameter_mm", "--needle-diameter-mm"},
    {"view.azimuth_deg", "--azimuth"},
    {"view.elevation_deg", "--elevation"},
    {"view.distance_mm", "--distance"},
    {"view.fov_deg", "--fov"},
    {"look.plane_opacity", "--plane-opacity"},
    {"view.window_level", "--window-level"},
    {"view.window_width", "--window-width"},
    {"placement.follow", "--follow"},
    {"source.temporal_offset_ms", "--temporal-offset-ms"},
    {"look.style", "--shading"},
    {"look.emphasis", "--emphasis"},
    {"look.projection", "--projection"},
    {"look.grey_level_hu", "--grey-level"},
    {"look.grey_width_hu", "--grey-width"},
    {"look.cutaway.theta1_deg", "--cutaway-inner"},
    {"look.cutaway.theta1_deg", "--cutaway-outer"},
    {"look.cutaway.theta2_deg", "--cutaway-outer"},
    {"look.cutaway.overlay_mm", "--cutaway-overlay"},
    {"cutaway_objects", "--cutaway-mesh"},
    {"placement.ct_from_reference_mm", "--ct-from-reference"},
    {"predicates.phantom_side", "--phantom-side"},
    {"predicates.phantom", "--phantom"},
    {"predicates.set_up", "--predicates"},
    {"predicates.scribble_share", "--scribble-share"},
    {"predicates.black", "--black"},
    {"predicates.white", "--white"},
    {"predicates.opacity_length_mm", "--opacity-length-mm"},
    {"predicates.face_radius_mm", "--face-radius-mm"},
    {"predicates.smoothing_mm", "--smoothing-mm"},
    {"predicates.smallest_radius_mm", "--smallest-radius"},
    {"predicates.largest_radius_mm", "--largest-radius"},
    {"predicates.hue_mean", "--hue-mean"},
    {"predicates.unknown", "--unknown"},
    {"predicates.histogram.importance", "--importance"},
    {"predicates.histogram.hue_deg", "--colour"},
    {"predicates.histogram.saturation", "--colour"},
    {"predicates.histogram.importance", "--predicate-importance"},
    {"predicates.histogram.hue_deg", "--predicate-colour"},
    {"predicates.histogram.saturation", "--predicate-colour"},
    {"predicates.histogram", "--predicate-importance"},
    {"predicates.histogram", "--predicate-colour"},
    {"predicates.histogram", "--importance"},
    {"predicates.histogram", "--colour"},
    {"predicates.ct_importance", "--ct-importance"},
    {"predicates.scan_lines", "--scan-lines"},
    {"predicates.cache", "--cache"},
    {"predicates.layers", "--layers"},
    {"predicates.apex_mm", "--apex"},
    {"predicates.into", "--into"},
    {"predicates.face_mm", "--face"},
    {"predicates.from", "--from"},
    {"predicates.target_mm", "--target"},
    {"predicates.needle_mm", "--needle"}};

}  // namespace

std::span<const OptionOfKey> options_of_keys() { return kOptionsOfKeys; }

Result<void> as_given(const CLI::App& verb, Result<void> checked) {
  if (checked) return checked;
  const Error& said = checked.error();
  for (const auto& [key, option] : kOptionsOfKeys) {
    const std::string start = std::string(key) + ":";
    if (!said.message.starts_with(start)) continue;
    const CLI::Option* given = verb.get_option_no_throw(option);
    if (given == nullptr || given->count() == 0) continue;
    return Error{said.code,
                 std::string(option) + " (" + key + ")" + said.message.substr(start.size() - 1)};
  }
  return checked;
}

}  // namespace nav::app
