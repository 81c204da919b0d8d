// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "nav/result.hpp"
#include "render/scene.hpp"

namespace nav::app {

/// How much of the live ultrasound plane is seen through the volume in front of it.
struct PlaneVisibility {
  double share = 1;    ///< Light that passes, of that without a volume, [0, 1].
  std::string hidden;  ///< Component of the CT that hides most of it; empty: none does alone.
  double without = 1;  ///< Share without that component, [0, 1].
};

/// Measures it in small images by the CPU engine. Needle, spheres and lines hide the same with and
/// without the volume. The component
/// is looked for only where less than kLeastPlaneShare is seen. Scenes whose plane is not drawn, or
/// lies outside the image, have the share 1.
Result<PlaneVisibility> plane_visibility(render::Scene scene);

/// Below this share the live plane counts as hidden.
inline constexpr double kLeastPlaneShare = 0.25;

/// Sentence about the component that hides the plane and about what helps; empty where enough of it
/// is seen.
std::string hidden_plane_words(const PlaneVisibility& found);

}  // namespace nav::app
