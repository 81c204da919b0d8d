// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "nav/image.hpp"
#include "render/features/scribbles.hpp"
#include "render/predicates/predicate_scene.hpp"
#include "render/slices/slice.hpp"

namespace nav::app {

/// One part of an image that compares renderings by predicates.
struct PredicatePanel {
  std::string title;
  Image2d<Rgba8> image;
  std::optional<render::PredicateModel> model{};  ///< Histogram (§3.3) to draw below.
  render::SliceLabels letters{};  ///< The patient's directions at the edges; may be empty.
};

/// Puts panels side by side, with titles above and histograms below. A legend gives the name of
/// every entry, over at most four lines, and its importance. The highest bar of all panels fills
/// the height. Precondition: at least one panel, all of one size.
Image2d<Rgba8> predicate_image(const std::vector<PredicatePanel>& panels);

/// Draws the slices of a volume on which strokes were painted: up to 3 one above the other, more in
/// a grid. Slices smaller than 64 pixels are left out, and a text gives their number. Voxels that
/// are marked to be shown are green, voxels to be hidden are red (Fig. 5 b). Precondition: at least
/// one stroke, all accepted by ScribbleMask.
Image2d<Rgba8> stroke_image(const StoredVolume& volume,
                            const render::PredicateScene::IntensityWindow& intensity,
                            const std::vector<render::features::Stroke>& strokes, int width,
                            int height);

}  // namespace nav::app
