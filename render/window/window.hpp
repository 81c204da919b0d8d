// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "nav/image.hpp"
#include "nav/result.hpp"
#include "render/window/window_input.hpp"

namespace nav::render {

/// Options for the behaviour of the window, not for its contents.
struct WindowOptions {
  std::string title = "Sonde";
  int width = 800;           ///< First size, pixels, at most that of the screen; >= 1.
  int height = 600;          ///< See width.
  int least_width = 1;       ///< Smallest size that the window asks its manager for, pixels.
  int least_height = 1;      ///< See least_width.
  double refresh_hz = 30;    ///< Rate at which the source is called, (0, 1000].
  double close_after_s = 0;  ///< Time until it closes by itself; 0: the user closes it.
  std::function<bool()> close_when{};  ///< Called as often as the source; true: closes. Null:
                                       ///< never.
};

/// Gives the image that the window shows from now on, top row first; its alpha is not used. An
/// empty image: nothing has changed. Called on the thread of the window, once per refresh and after
/// any input.
using ImageSource = std::function<Result<Image2d<Rgba8>>(const WindowInput&)>;

/// Shows images in an X11 window until it is closed: by q, by the window manager, or by the
/// options. An image is drawn pixel by pixel from the top left corner, without scaling; the rest of
/// the window is dark. Needs no OpenGL. Returns kUnavailable without an X display with 8 bits per
/// colour. An error of the source closes the window and is returned.
Result<void> show_window(const ImageSource& source, const WindowOptions& options = {});

}  // namespace nav::render
