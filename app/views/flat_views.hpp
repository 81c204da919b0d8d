// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "app/views/panels.hpp"
#include "app/views/plane_view.hpp"

namespace nav::app {

/// A flat view of an epoch, without text.
struct FlatView {
  Image2d<Rgba8> image;
  /// Position of the ultrasound plane in the image; absent where nothing of it is shown.
  std::optional<PlaneView> plane;
};

/// The CT laid over an ultrasound image, to compare them.
struct CtOverlay {
  enum class Mode { kNone, kBlend, kCheckerboard, kWipe };
  Mode mode = Mode::kNone;
  /// [0, 1]. Blend: weight of the CT; wipe: share of the width that shows the CT, from the left.
  double share = 0.5;
};

/// The live ultrasound image of an epoch, with needle and target where they meet it. Empty (dark)
/// unless the image is valid or degraded. size: pixels, >= 1. The overlay needs a placed image that
/// is valid or degraded; otherwise there is none.
FlatView draw_ultrasound_view(const PanelContext& context, PixelSize size,
                              const CtOverlay& overlay = {});

/// The CT along the plane of the live ultrasound image, at the same scale. Empty unless the placed
/// image is valid or degraded.
FlatView draw_ct_view(const PanelContext& context, PixelSize size);

}  // namespace nav::app
