// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "nav/image.hpp"
#include "nav/result.hpp"
#include "render/scene.hpp"

namespace nav::render {

/// A line of words that stands over the picture of a window.
struct WindowWords {
  enum class Align { kLeft, kCentre, kRight };
  std::string words;  ///< UTF-8; empty: nothing is drawn.
  Rgba8 colour;       ///< Its alpha is not used.
  double x = 0;       ///< Of the aligned point, shares of the window, from its left …
  double y = 0;       ///< … and of the words' middle, from its top.
  Align align = Align::kLeft;
  int size_px = 15;
  /// Words of one stack are lines below (or above) one another, wrapped to the window, from the
  /// first one's y on; placed_words() keeps them apart in pixels.
  enum class Stack { kNone, kDown, kUp };
  Stack stack = Stack::kNone;
};
/// What stands over the picture that is seen by a camera; asked on the thread of the window
/// whenever it draws.
using WordsSource = std::function<std::vector<WindowWords>(const Camera&)>;

/// How the window behaves; never what it shows.
struct WindowOptions {
  std::string title = "Sonde";
  double refresh_hz = 30;              ///< How often the source is asked, in (0, 1000].
  double close_after_s = 0;            ///< Closes by itself; 0: when the user closes it.
  std::function<bool()> close_when{};  ///< Asked as often as the source: closes it. Null: never.
  /// While anything but ultrasound pixels changes and a picture takes longer than 33 ms, it is
  /// drawn with fewer rays, where that is not enough with fewer pixels, always of the newest scene,
  /// and in full within 300 ms of stillness where that takes no longer than 150 ms.
  bool progressive = true;
  WordsSource words{};  ///< Null: none.
};

/// Asked once per refresh on the thread of the window; null: nothing has changed, nothing is drawn.
/// The camera of the first scene is the starting view; later the user owns the camera.
using SceneSource = std::function<std::shared_ptr<const Scene>()>;

/// Shows scenes in an X11 window until it is closed: left drag orbits about the look-at point,
/// middle drag pans, right drag and wheel zoom, q closes. Same picture as the GL engine.
/// kUnavailable without an X display; an invalid scene closes the window with its error.
Result<void> show_window(const SceneSource& source, const WindowOptions& options = {});
/// The same with one scene that never changes.
Result<void> show_window(const Scene& scene, const WindowOptions& options = {});

/// Draws once in a real X11 window and reads its pixels back, top row first; size of the scene.
Result<Image2d<Rgba8>> capture_window(const Scene& scene,
                                      const std::vector<WindowWords>& words = {});

// Whatever the mouse does, a camera that a scene may have stays one: what would leave the places of
// scenes (nav/places.hpp) does not move, and a zoom ends at 0.1 mm and at 100 m.

/// Camera after turning about the look-at point: yaw about the view's up axis (positive: the eye
/// moves right), then pitch about its right axis (positive: the eye moves up), rad.
Camera orbited(const Camera& camera, double yaw_rad, double pitch_rad);
/// Camera after moving eye and look-at point by fractions of the picture height (right, up).
Camera panned(const Camera& camera, double right, double up);
/// Camera with the distance to the look-at point, or the orthographic height, divided by a factor
/// > 0.
Camera zoomed(const Camera& camera, double factor);

}  // namespace nav::render
