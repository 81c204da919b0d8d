// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "nav/result.hpp"
#include "render/engine.hpp"
#include "render/scene.hpp"

namespace nav::render {
class OffscreenWindow;
class SceneView;
}  // namespace nav::render

namespace nav::bench {

/// Draws scenes with the GL engine into a window nobody sees, as an application does: the picture
/// stays on the device.
class GlFrames {
 public:
  /// kUnavailable without OpenGL.
  static Result<std::unique_ptr<GlFrames>> create(const render::GlOptions& options = {});
  ~GlFrames();
  GlFrames(const GlFrames&) = delete;
  GlFrames& operator=(const GlFrames&) = delete;

  /// Returns when the device has drawn it. Precondition: a validated scene.
  Result<void> draw(const render::Scene& scene);

 private:
  GlFrames(std::unique_ptr<render::OffscreenWindow> window, const render::GlOptions& options);

  std::unique_ptr<render::OffscreenWindow> window_;
  std::unique_ptr<render::SceneView> view_;
};

}  // namespace nav::bench
