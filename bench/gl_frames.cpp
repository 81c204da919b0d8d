// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/gl_frames.hpp"

#include <vtkOpenGLRenderWindow.h>
#include <vtkRenderer.h>

#include "render/gl_volume_prop.hpp"
#include "render/vtk_offscreen.hpp"

namespace nav::bench {

Result<std::unique_ptr<GlFrames>> GlFrames::create(const render::GlOptions& options) {
  auto window = render::OffscreenWindow::create(16, 16);
  if (!window) return window.error();
  return std::unique_ptr<GlFrames>(new GlFrames(std::move(window).value(), options));
}

GlFrames::GlFrames(std::unique_ptr<render::OffscreenWindow> window,
                   const render::GlOptions& options)
    : window_(std::move(window)), view_(std::make_unique<render::SceneView>(window_->window())) {
  if (options.compute) view_->raycaster().set_compute(*options.compute);
  window_->release_thread();
}

GlFrames::~GlFrames() {
  view_.reset();
  window_->release_thread();
}

Result<void> GlFrames::draw(const render::Scene& scene) {
  vtkOpenGLRenderWindow& window = window_->window();
  window.MakeCurrent();
  window.SetSize(scene.width, scene.height);
  const auto drawn =
      view_->draw(std::shared_ptr<const render::Scene>(std::shared_ptr<void>(), &scene));
  window.WaitForCompletion();
  window_->release_thread();
  if (!drawn) return drawn.error();
  return {};
}

}  // namespace nav::bench
