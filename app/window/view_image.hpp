// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QImage>
#include <cstdint>
#include <optional>

#include "app/views/plane_view.hpp"
#include "app/views/slice_view.hpp"
#include "app/window/moment.hpp"
#include "nav/image.hpp"
#include "render/scene.hpp"

namespace nav::app {

/// A finished image of one view, made by an engine on its own thread. Format RGB32: a widget paints
/// it without a conversion.
struct ViewImage {
  SharedMoment moment{};  ///< The moment that it shows.
  QImage image{};
  std::optional<PlaneView> plane{};      ///< Flat views: position of the ultrasound plane.
  std::optional<SliceGeometry> slice{};  ///< Slices and bull's-eye; absent: nothing is shown.
  Point<frames::Ct> cursor{Eigen::Vector3d::Zero()};  ///< Flat views: the cursor of all of them.
  render::HuWindow window{};                          ///< Flat views: grey window of the CT.
  bool of_ultrasound = false;                         ///< Slices: of the 3D ultrasound, not the CT.
  render::Camera camera{};                            ///< 3D view.
  bool refined = true;                                ///< False: coarse, because something moves.
  int factor = 1;           ///< 3D view: it was drawn with 1 / factor of the pixels per side.
  std::uint64_t asked = 0;  ///< Number of the newest order of the camera, or of the slices.
  double draw_ms = 0;       ///< Time of the engine.
  double convert_ms = 0;    ///< Time to RGB32.
};

/// Colours as RGB32; alpha is not used.
QImage to_rgb32(const Image2d<Rgba8>& image);
/// Rounds as render::to_8bit() does: round(255 · clamp(x, 0, 1)).
QImage to_rgb32(const Image2d<RgbaF>& image);
/// The image enlarged to a size, as render::enlarged() does it, without a copy in between.
QImage to_rgb32(const Image2d<RgbaF>& image, PixelSize size);

/// Draws a heartbeat into the lower right corner: a dot that moves with every image, so that an
/// image that stands still is seen to stand still.
void draw_heartbeat(QImage& image, std::uint64_t beat);

}  // namespace nav::app
