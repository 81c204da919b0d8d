// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "nav/image.hpp"
#include "render/features/scribbles.hpp"
#include "render/predicates/predicate_scene.hpp"

namespace nav::app {

/// One part of a picture of predicates.
struct PredicatePanel {
  std::string title;
  Image2d<Rgba8> picture;
  std::optional<render::PredicateModel> model{};  ///< Its histogram (§3.3) is drawn below.
};

/// Panels side by side, their titles above, histograms below with a legend of every entry's name,
/// over four lines at most, and importance. The highest bar of all panels is as high as there is
/// room. Precondition: at least one panel, all of one size.
Image2d<Rgba8> predicate_picture(const std::vector<PredicatePanel>& panels);

/// The slices of a volume that strokes were painted on, up to 3 one above the other, more in a
/// grid; where they would be smaller than 64 pixels it says how many are left out. Voxels that are
/// marked to be shown are green, to be hidden red (Fig. 5 b). Precondition: strokes that
/// ScribbleMask takes, at least one.
Image2d<Rgba8> stroke_picture(const Volume& volume,
                              const render::PredicateScene::IntensityWindow& intensity,
                              const std::vector<render::features::Stroke>& strokes, int width,
                              int height);

}  // namespace nav::app
