// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/result.hpp"
#include "render/scene.hpp"

namespace nav::render {

/// A grey window for a projection, and flags for projections that cannot show anything.
struct ProjectionWindow {
  GreyWindow window;
  bool only_air = false;   ///< The values are Hounsfield units, and all are air.
  bool one_value = false;  ///< All rays find the same value, or no ray finds any.
};

/// Computes the window from the darkest to the brightest value that the rays through the volume
/// find. Two percent are left out at each end; the result has two digits. In Hounsfield units air
/// does not count: values below -950 HU, and for a maximum values below -200 HU, which occur where
/// a ray only grazes the rim of the body. A maximum is white from 1000 HU on at the latest. The
/// window does not depend on the quality. It is computed from a small image without plane, needle,
/// spheres, lines and cutaway. Precondition: a projection other than kComposite. Errors as in
/// validate().
Result<ProjectionWindow> window_of_projection(Scene scene);

}  // namespace nav::render
