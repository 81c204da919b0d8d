// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "app/console.hpp"
#include "app/options/session_config.hpp"
#include "nav/volume.hpp"
#include "render/scene.hpp"

namespace nav::app {

/// One ultrasound image of a recording, placed in the CT.
struct PlacedImage {
  render::UltrasoundPlane plane;
  /// Pose at the time of the image; absent when the session names no needle.
  std::optional<Transform<frames::Ct, frames::Needle>> ct_from_needle;
  bool registered = false;  ///< False: the placement was declared, or there was none.
};

/// Plays the session's recording up to an image and places it as a replay does. number: from 0;
/// absent: the middle image. Returns kUsage for a number that the recording does not have or whose
/// image has no pose, kNotFound for a needle without a pose, and the errors of a replay.
Result<PlacedImage> placed_image(const SessionConfig& config, const Volume& ct,
                                 std::optional<std::int64_t> number, Console& console);

}  // namespace nav::app
