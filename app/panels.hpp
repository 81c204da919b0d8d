// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "app/navigator.hpp"
#include "render/canvas.hpp"
#include "render/reslice.hpp"

namespace nav::app {

/// What the flat parts of a refresh show.
struct PanelContext {
  const Epoch& epoch;
  const Volume& ct;
  const std::optional<NeedlePlan>& plan;
  render::HuWindow window;
  const std::string& banner;
};

/// Puts the live ultrasound and the CT along the same plane beside the 3D view, and state and
/// numbers below. A stale picture is not drawn: its panel says so. The picture is 3/2 as wide as
/// the view's height more than the view, and one status bar higher.
Image2d<Rgba8> compose_panels(const Image2d<Rgba8>& view_3d, const PanelContext& context);

}  // namespace nav::app
