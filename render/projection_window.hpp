// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/result.hpp"
#include "render/scene.hpp"

namespace nav::render {

/// A grey window for a projection, and whether it can show anything.
struct ProjectionWindow {
  GreyWindow window;
  bool only_air = false;   ///< Of Hounsfield units: no ray finds anything else.
  bool one_value = false;  ///< All rays find the same, or there is none.
};

/// The window from the darkest to the brightest of what the rays of a scene find that meet its
/// volume, two of a hundred left out at each end, to two digits. In Hounsfield units air does not
/// count: what is below -950 HU, of a maximum below -200 HU, where a ray meets but the rim of a
/// body; and a maximum is white from 1000 HU on at the latest. The same at any quality. Asked of a
/// small picture without plane, needle and the like. Precondition: a projection other than
/// kComposite. Refuses as validate().
Result<ProjectionWindow> window_of_projection(Scene scene);

}  // namespace nav::render
