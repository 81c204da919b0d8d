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

/// One picture of a recording inside the CT.
struct PlacedPicture {
  render::UltrasoundPlane plane;
  /// At the time of the picture; absent where the session names no needle.
  std::optional<Transform<frames::Ct, frames::Needle>> ct_from_needle;
  bool registered = false;  ///< Otherwise the placement was only declared, or there was none.
};

/// Plays the session's recording up to a picture and places it as a replay does. number: from 0;
/// absent: the middle one. kUsage for a number that the recording does not have or whose picture
/// has no pose, kNotFound for a needle without one; the errors of a replay.
Result<PlacedPicture> placed_picture(const SessionConfig& config, const Volume& ct,
                                     std::optional<std::int64_t> number, Console& console);

}  // namespace nav::app
