// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "app/views/presenter.hpp"
#include "render/quality/progressive.hpp"
#include "render/window/window_input.hpp"

namespace nav::app {

/// Images of a session for a window: the presenter's whole image, in the size of the window, with a
/// 3D view by a camera that the user moves. The 3D view is coarse while it changes faster than the
/// engine can follow, and full once it rests. Not thread-safe.
class LiveView {
 public:
  /// The presenter must outlive this. Its camera is the first camera.
  explicit LiveView(Presenter& presenter, const render::ProgressiveOptions& options = {});

  /// Takes the input of a window: its size, and movements of the camera; r returns to the first
  /// camera. Call it with movements only after the presenter has its facts. True if the image has
  /// to be drawn again.
  bool apply(const render::WindowInput& input);
  /// True if the last image was coarse and would now be drawn in full. Times are of one clock that
  /// does not run backwards.
  [[nodiscard]] bool wants_refinement(Timestamp now) const {
    return renderer_.wants_refinement(now);
  }
  /// Draws the whole image of an epoch. ended: no new data will come.
  Result<Image2d<Rgba8>> draw(const session::Epoch& epoch, Timestamp now, bool ended);
  /// Draws the whole image of an epoch that Presenter::present() has just drawn; its 3D view is
  /// used again if camera and size are the same.
  Result<Image2d<Rgba8>> draw_presented(const session::Epoch& epoch, Timestamp now);

 private:
  Presenter& presenter_;
  render::ProgressiveRenderer renderer_;
  PixelSize view_size_;                   ///< Size of the 3D view.
  std::optional<render::Camera> camera_;  ///< Absent: the presenter's, not moved.
};

}  // namespace nav::app
