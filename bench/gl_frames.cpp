// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/gl_frames.hpp"

#include <vtkOpenGLRenderWindow.h>
#include <vtkRenderer.h>

#include "render/gl/gl_volume_prop.hpp"
#include "render/vtk/vtk_offscreen.hpp"

namespace nav::bench {
namespace {

class GlFrames final : public render::Engine {
 public:
  GlFrames(std::unique_ptr<render::OffscreenWindow> window, const render::GlOptions& options)
      : window_(std::move(window)), view_(std::make_unique<render::SceneView>(window_->window())) {
    if (options.compute) view_->raycaster().set_compute(*options.compute);
    window_->release_thread();
  }
  ~GlFrames() override {
    view_.reset();
    window_->release_thread();
  }
  GlFrames(const GlFrames&) = delete;
  GlFrames& operator=(const GlFrames&) = delete;

  [[nodiscard]] std::string name() const override { return "gl"; }
  [[nodiscard]] std::string device() const override { return window_->device(); }

  Result<render::RenderedImage> render_image(const render::Scene& scene,
                                             const render::Interrupt& /*interrupt*/) override {
    if (auto ok = validate(scene); !ok) return ok.error();
    vtkOpenGLRenderWindow& window = window_->window();
    window.MakeCurrent();
    window.SetSize(scene.width, scene.height);
    const auto drawn =
        view_->draw(std::shared_ptr<const render::Scene>(std::shared_ptr<void>(), &scene));
    window.WaitForCompletion();
    window_->release_thread();
    if (!drawn) return drawn.error();
    return render::RenderedImage{blank_.of(scene.width, scene.height),
                                 view_->raycaster().timings()};
  }

 private:
  std::unique_ptr<render::OffscreenWindow> window_;
  std::unique_ptr<render::SceneView> view_;
  BlankImage blank_;
};

}  // namespace

Result<std::unique_ptr<render::Engine>> make_gl_frames(const render::GlOptions& options) {
  auto window = render::OffscreenWindow::create(16, 16);
  if (!window) return window.error();
  return std::unique_ptr<render::Engine>(
      std::make_unique<GlFrames>(std::move(window).value(), options));
}

}  // namespace nav::bench
