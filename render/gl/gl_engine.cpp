// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <vtkOpenGLRenderWindow.h>
#include <vtkRenderer.h>

#include "render/engine.hpp"
#include "render/gl/gl_device.hpp"
#include "render/gl/gl_volume_prop.hpp"
#include "render/vtk/vtk_offscreen.hpp"

namespace nav::render {
namespace {

/// Holds the thread's OpenGL context while one image is drawn.
class CurrentContext {
 public:
  explicit CurrentContext(OffscreenWindow& window) : window_(window) {
    window_.window().MakeCurrent();
  }
  ~CurrentContext() { window_.release_thread(); }
  CurrentContext(const CurrentContext&) = delete;
  CurrentContext& operator=(const CurrentContext&) = delete;

 private:
  OffscreenWindow& window_;
};

class GlEngine final : public Engine {
 public:
  GlEngine(std::unique_ptr<OffscreenWindow> window, const GlOptions& options)
      : options_(options), device_(window->device()) {
    use(std::move(window));
  }
  ~GlEngine() override { close(); }
  GlEngine(const GlEngine&) = delete;
  GlEngine& operator=(const GlEngine&) = delete;

  [[nodiscard]] std::string name() const override { return "gl"; }
  [[nodiscard]] std::string device() const override { return device_; }

  Result<RenderedImage> render_image(const Scene& scene, const Interrupt& interrupt) override {
    if (auto ok = validate(scene); !ok) return ok.error();
    const bool kept = window_ != nullptr;
    if (auto ok = open(); !ok) return ok.error();
    auto image = draw(scene, interrupt);
    if (!image && image.error().code == ErrorCode::kCancelled) return image;
    // A context that is lost, or that failed midway, is not worth keeping.
    if (!image) close();
    // A context lost since the last image is opened again, and its data sent again, once. A second
    // loss is reported.
    if (image || !kept || image.error().code != ErrorCode::kUnavailable) return image;
    if (auto ok = open(); !ok) return ok.error();
    image = draw(scene, interrupt);
    if (!image && image.error().code != ErrorCode::kCancelled) close();
    return image;
  }

 private:
  Result<void> open() {
    if (window_) return {};
    auto opened = OffscreenWindow::create(16, 16);
    if (!opened) return opened.error();
    use(std::move(opened).value());
    return {};
  }

  void use(std::unique_ptr<OffscreenWindow> window) {
    window_ = std::move(window);
    device_ = window_->device();
    view_ = std::make_unique<SceneView>(window_->window());
    if (options_.compute) view_->raycaster().set_compute(*options_.compute);
    window_->release_thread();
  }

  void close() {
    view_.reset();
    if (window_) window_->release_thread();
    window_.reset();
  }

  Result<RenderedImage> draw(const Scene& scene, const Interrupt& interrupt) {
    const CurrentContext current(*window_);
    if (!window_->window().IsCurrent()) {
      return Error{ErrorCode::kUnavailable, "OpenGL: the context of " + device_ + " is lost"};
    }
    window_->window().SetSize(scene.width, scene.height);
    // The view keeps neither beyond this call.
    view_->raycaster().set_interrupt(&interrupt);
    const auto drawn = view_->draw(std::shared_ptr<const Scene>(std::shared_ptr<void>(), &scene));
    view_->raycaster().set_interrupt(nullptr);
    if (!drawn) return drawn.error();
    std::vector<RgbaF> pixels = view_->raycaster().read();
    const Eigen::Vector3f background = scene.background_rgb.cast<float>();
    for (RgbaF& p : pixels) {
      const float rest = 1.0F - p.a;
      p = {p.r + rest * background.x(), p.g + rest * background.y(), p.b + rest * background.z(),
           1.0F};
      if (!std::isfinite(p.r + p.g + p.b)) {
        return Error{ErrorCode::kNumerical,
                     "OpenGL: expected finite pixels, found NaN or Inf on " + device()};
      }
    }
    return RenderedImage{{scene.width, scene.height, std::move(pixels)},
                         view_->raycaster().statistics()};
  }

  GlOptions options_;
  std::string device_;
  std::unique_ptr<OffscreenWindow> window_;
  std::unique_ptr<SceneView> view_;
};

}  // namespace

Result<std::unique_ptr<Engine>> make_gl_engine(Diagnostics& diagnostics, const GlOptions& options) {
  auto window = OffscreenWindow::create(16, 16);
  if (!window) return window.error();
  const std::string& device = (*window)->device();
  const bool software = runs_in_software(device);
  diagnostics.report(software ? Severity::kWarning : Severity::kInfo, "render.gl",
                     software
                         ? "OpenGL runs in software on " + device + "; the CPU engine is faster"
                         : "OpenGL device: " + device);
  return std::unique_ptr<Engine>(std::make_unique<GlEngine>(std::move(window).value(), options));
}

}  // namespace nav::render
