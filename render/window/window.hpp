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

/// A line of overlay text over the image of a window.
struct WindowWords {
  enum class Align { kLeft, kCentre, kRight };
  std::string words;  ///< UTF-8; empty: nothing is drawn.
  Rgba8 colour;       ///< Its alpha is not used.
  double x = 0;       ///< Aligned point from the left, as share of the window.
  double y = 0;       ///< Middle of the text from the top, as share of the window.
  Align align = Align::kLeft;
  int size_px = 15;
  /// Lines of one stack stand below (or above) one another, wrapped to the window, from the y of
  /// the first one on. placed_words() keeps them apart in pixels.
  enum class Stack { kNone, kDown, kUp };
  Stack stack = Stack::kNone;
};
/// Returns the overlay text for the image that a camera sees. Called on the thread of the window
/// whenever the window draws.
using WordsSource = std::function<std::vector<WindowWords>(const Camera&)>;

/// Options for the behaviour of the window, not for its contents.
struct WindowOptions {
  std::string title = "Sonde";
  double refresh_hz = 30;              ///< Rate at which the source is called, (0, 1000].
  double close_after_s = 0;            ///< Time until it closes by itself; 0: the user closes it.
  std::function<bool()> close_when{};  ///< Called as often as the source; true: closes. Null:
                                       ///< never.
  /// Draws faster while anything but ultrasound pixels changes and an image takes longer than 33
  /// ms: with fewer rays, and with fewer pixels if that is not enough, always of the newest scene.
  /// The full image follows within 300 ms of stillness if it takes no longer than 150 ms.
  bool progressive = true;
  WordsSource words{};  ///< Null: no overlay text.
};

/// Called once per refresh on the thread of the window. Null: nothing has changed, and nothing is
/// drawn. The camera of the first scene is the starting view; afterwards the user moves the camera.
using SceneSource = std::function<std::shared_ptr<const Scene>()>;

/// Shows scenes in an X11 window until it is closed. Left drag orbits about the look-at point,
/// middle drag pans, right drag and wheel zoom, q closes. The image is that of the GL engine.
/// Returns kUnavailable without an X display. An invalid scene closes the window, and its error is
/// returned.
Result<void> show_window(const SceneSource& source, const WindowOptions& options = {});
/// Shows one scene that never changes.
Result<void> show_window(const Scene& scene, const WindowOptions& options = {});

/// Draws a scene once in a real X11 window and reads its pixels back, top row first. The size is
/// that of the scene.
Result<Image2d<Rgba8>> capture_window(const Scene& scene,
                                      const std::vector<WindowWords>& words = {});

// The functions below turn a valid camera into a valid camera. A camera that would leave the
// positions that scenes allow (nav/places.hpp) does not move. A zoom ends at 0.1 mm and at 100 m.

/// Turns a camera about its look-at point: yaw about the view's up axis (positive: the eye moves
/// right), then pitch about its right axis (positive: the eye moves up), rad.
Camera orbited(const Camera& camera, double yaw_rad, double pitch_rad);
/// Moves eye and look-at point by fractions of the image height (right, up).
Camera panned(const Camera& camera, double right, double up);
/// Divides the distance to the look-at point, or the orthographic height, by a factor > 0.
Camera zoomed(const Camera& camera, double factor);

}  // namespace nav::render
