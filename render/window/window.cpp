// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/window/window.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <vtkInteractorStyle.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkRenderWindow.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>

#include "render/gl/gl_volume_prop.hpp"
#include "render/quality/refinement.hpp"
#include "render/vtk/vtk_convert.hpp"
#include "render/window/vtk_words.hpp"
// Included last, because X11 defines macros with everyday names.
#include <X11/Xlib.h>

namespace nav::render {
namespace {

struct CloseDisplay {
  void operator()(Display* display) const { XCloseDisplay(display); }
};
using DisplayConnection = std::unique_ptr<Display, CloseDisplay>;

/// Opens the X display. VTK aborts the process if it cannot open the display, so VTK gets an open
/// one. The connection must outlive the window.
Result<DisplayConnection> connect_display() {
  DisplayConnection display(XOpenDisplay(nullptr));
  if (display) return display;
  const char* name = std::getenv("DISPLAY");
  return Error{ErrorCode::kUnavailable,
               "window: expected an X display, found " +
                   (name && *name ? "DISPLAY=" + std::string(name) + ", which does not answer"
                                  : std::string("DISPLAY not set"))};
}

/// Turns mouse events into cameras and asks for scenes. Draws only if something changed.
class SceneStyle final : public vtkInteractorStyle {
 public:
  static SceneStyle* New();
  vtkTypeMacro(SceneStyle, vtkInteractorStyle)

      void start(SceneView& view, WordsLayer& layer, const SceneSource& source,
                 const WindowOptions& options) {
    view_ = &view;
    layer_ = &layer;
    words_ = options.words;
    close_when_ = options.close_when;
    source_ = source;
    ProgressiveOptions progressive;
    if (!options.progressive) progressive.budget_s = std::numeric_limits<double>::infinity();
    refinement_ = Refinement(progressive);
    if (options.close_after_s > 0) {
      const std::chrono::duration<double> open_for(options.close_after_s);
      close_at_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(open_for);
    }
    OnTimer();
  }
  [[nodiscard]] const Result<void>& outcome() const { return outcome_; }
  [[nodiscard]] const Scene* scene() const { return scene_.get(); }

  void OnTimer() override {
    if (close_at_ && Clock::now() >= *close_at_) return close();
    if (close_when_ && close_when_()) return close();
    if (std::shared_ptr<const Scene> next = source_()) {
      scene_ = std::move(next);
      if (!camera_) camera_ = scene_->camera;
      changed_ = true;
    }
    if (refinement_.wants_refinement(clock_.now())) changed_ = true;
    draw();
  }
  void OnExpose() override {
    changed_ = true;
    draw();
  }
  void OnConfigure() override { OnExpose(); }
  void OnChar() override {
    const char key = this->Interactor->GetKeyCode();
    if (key == 'q' || key == 'Q') close();
  }
  void OnLeftButtonDown() override { drag_ = Drag::kOrbit; }
  void OnMiddleButtonDown() override { drag_ = Drag::kPan; }
  void OnRightButtonDown() override { drag_ = Drag::kZoom; }
  void OnLeftButtonUp() override { drag_ = Drag::kNone; }
  void OnMiddleButtonUp() override { drag_ = Drag::kNone; }
  void OnRightButtonUp() override { drag_ = Drag::kNone; }
  void OnMouseWheelForward() override {
    change([](const Camera& c) { return zoomed(c, 1.1); });
  }
  void OnMouseWheelBackward() override {
    change([](const Camera& c) { return zoomed(c, 1 / 1.1); });
  }
  void OnMouseMove() override {
    const int* now = this->Interactor->GetEventPosition();
    const int* before = this->Interactor->GetLastEventPosition();
    const double height = std::max(1, this->Interactor->GetRenderWindow()->GetSize()[1]);
    const double right = (now[0] - before[0]) / height;
    const double up = (now[1] - before[1]) / height;
    // Dragging moves the scene with the mouse, so the eye moves the other way.
    switch (drag_) {
      case Drag::kOrbit:
        return change([&](const Camera& c) { return orbited(c, -M_PI * right, -M_PI * up); });
      case Drag::kPan:
        return change([&](const Camera& c) { return panned(c, -right, -up); });
      case Drag::kZoom:
        return change([&](const Camera& c) { return zoomed(c, std::exp(2 * up)); });
      case Drag::kNone:
        return;
    }
  }

 private:
  using Clock = std::chrono::steady_clock;
  enum class Drag { kNone, kOrbit, kPan, kZoom };

  template <class Move>
  void change(const Move& move) {
    if (!camera_) return;
    camera_ = move(*camera_);
    changed_ = true;
    draw();
  }
  void draw() {
    if (!changed_ || !scene_) return;
    changed_ = false;
    Scene scene = *scene_;
    scene.camera = *camera_;
    outcome_ = validate(scene);
    if (outcome_) outcome_ = draw(scene);
    if (!outcome_) close();
  }
  Result<void> draw(const Scene& scene) {
    if (words_) layer_->set(words_(scene.camera));
    Refinement::Plan plan = refinement_.plan(scene, clock_.now());
    const auto drawn =
        view_->draw(std::make_shared<const Scene>(std::move(plan.scene)), plan.factor);
    if (!drawn) return drawn.error();
    refinement_.drawn(drawn->cast_s, drawn->factor, drawn->provisional);
    return {};
  }
  void close() {
    if (this->Interactor) this->Interactor->TerminateApp();
  }

  SceneView* view_ = nullptr;
  WordsLayer* layer_ = nullptr;
  WordsSource words_;
  std::function<bool()> close_when_;
  SceneSource source_;
  std::shared_ptr<const Scene> scene_;
  std::optional<Camera> camera_;
  std::optional<Clock::time_point> close_at_;
  MonotonicClock clock_;
  Refinement refinement_;
  Drag drag_ = Drag::kNone;
  bool changed_ = false;
  Result<void> outcome_;
};
vtkStandardNewMacro(SceneStyle)

}  // namespace

Result<void> show_window(const SceneSource& source, const WindowOptions& options) {
  if (!(options.refresh_hz > 0 && options.refresh_hz <= 1000)) {
    return Error{ErrorCode::kUsage, "window.refresh_hz: expected a value in (0, 1000], found " +
                                        std::to_string(options.refresh_hz)};
  }
  const auto display = connect_display();
  if (!display) return display.error();
  const std::shared_ptr<const Scene> first = source();
  if (!first) return Error{ErrorCode::kUsage, "window: expected a first scene, found none"};
  if (auto ok = validate(*first); !ok) return ok;
  vtkNew<vtkRenderWindow> window;
  window->SetDisplayId(display->get());
  window->SetMultiSamples(0);
  window->SetSize(first->width, first->height);
  window->SetWindowName(options.title.c_str());
  SceneView view(*window);
  WordsLayer layer(*window);
  vtkNew<vtkRenderWindowInteractor> interactor;
  interactor->SetRenderWindow(window);
  vtkNew<SceneStyle> style;
  interactor->SetInteractorStyle(style);
  interactor->Initialize();
  bool asked = false;
  style->start(
      view, layer,
      [&]() {
        if (asked) return source();
        asked = true;
        return first;
      },
      options);
  if (style->outcome()) {
    interactor->CreateRepeatingTimer(
        static_cast<unsigned long>(std::max(1.0, 1000.0 / options.refresh_hz)));
    interactor->Start();
  }
  const Result<void> outcome = style->outcome();
  window->Finalize();
  return outcome;
}

Result<void> show_window(const Scene& scene, const WindowOptions& options) {
  std::shared_ptr<const Scene> once = std::make_shared<const Scene>(scene);
  return show_window([&once]() { return std::exchange(once, nullptr); }, options);
}

Result<Image2d<Rgba8>> capture_window(const Scene& scene, const std::vector<WindowWords>& words) {
  if (auto ok = validate(scene); !ok) return ok.error();
  const auto display = connect_display();
  if (!display) return display.error();
  vtkNew<vtkRenderWindow> window;
  window->SetDisplayId(display->get());
  window->SetMultiSamples(0);
  window->SetSize(scene.width, scene.height);
  SceneView view(*window);
  WordsLayer layer(*window);
  layer.set(words);
  auto drawn = view.draw(std::shared_ptr<const Scene>(std::shared_ptr<void>(), &scene));
  if (!drawn) return drawn.error();
  const int* size = window->GetSize();
  if (size[0] != scene.width || size[1] != scene.height) {
    return Error{ErrorCode::kUnavailable,
                 "window: expected " + std::to_string(scene.width) + " x " +
                     std::to_string(scene.height) + " pixels on this display, found " +
                     std::to_string(size[0]) + " x " + std::to_string(size[1])};
  }
  Image2d<Rgba8> pixels = read_pixels(*window);
  window->Finalize();
  return pixels;
}

}  // namespace nav::render
