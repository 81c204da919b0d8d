// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vtkProp3D.h>
#include <vtkSmartPointer.h>

#include "nav/result.hpp"
#include "render/gl/gl_raycaster.hpp"
#include "render/scene.hpp"

class vtkOpenGLRenderWindow;
class vtkRenderer;
class vtkRenderWindow;

namespace nav::render {

/// A scene as a VTK prop. It is drawn after VTK's opaque geometry, which stops the rays, and
/// blended into VTK's framebuffer. The world frame is Ct, mm. The renderer's camera must be the
/// scene's: see SceneView. The image has the size of the renderer's viewport, whatever the scene
/// says.
class GlVolumeProp final : public vtkProp3D {
 public:
  static GlVolumeProp* New();
  vtkTypeMacro(GlVolumeProp, vtkProp3D)

      /// Sets the scene; precondition: it is validated. coarse_factor, >= 1: draws
      /// 1 / coarse_factor of the pixels per side and enlarges them, unless there is other
      /// geometry, whose depth has every pixel.
      void set_scene(std::shared_ptr<const Scene> scene, int coarse_factor = 1);
  /// The outcome of the last drawing.
  [[nodiscard]] const Result<void>& outcome() const { return outcome_; }
  /// The factor of the last drawing: it had 1 / factor of the pixels per side.
  [[nodiscard]] int drawn_factor() const { return drawn_factor_; }
  [[nodiscard]] GlRaycaster& raycaster() { return raycaster_; }

  double* GetBounds() override;
  int RenderVolumetricGeometry(vtkViewport* viewport) override;
  vtkTypeBool HasTranslucentPolygonalGeometry() override { return 0; }
  void ReleaseGraphicsResources(vtkWindow* window) override;

 protected:
  GlVolumeProp() = default;

 private:
  std::optional<SharedDepth> depth_of_others(vtkRenderer& renderer, const std::array<int, 4>& at);

  std::shared_ptr<const Scene> scene_;
  int coarse_factor_ = 1;
  int drawn_factor_ = 1;
  GlRaycaster raycaster_;
  GlTexture depth_;
  Result<void> outcome_;
  std::array<double, 6> bounds_{};
};

/// The one arrangement of renderer and prop that the engine and the windows share.
class SceneView {
 public:
  /// Adds a renderer to a window.
  explicit SceneView(vtkRenderWindow& window);
  /// Removes the renderer; the window must still exist.
  ~SceneView();
  SceneView(const SceneView&) = delete;
  SceneView& operator=(const SceneView&) = delete;
  /// Facts about how a scene was drawn.
  struct Drawn {
    double cast_s;     ///< Time of the rays, s.
    int factor;        ///< The image had 1 / factor of the pixels per side.
    bool provisional;  ///< See RenderStatistics::provisional.
  };
  /// Draws a validated scene with its own camera and background. renderer() may hold other props.
  /// coarse_factor: see GlVolumeProp.
  Result<Drawn> draw(std::shared_ptr<const Scene> scene, int coarse_factor = 1);
  [[nodiscard]] vtkRenderer& renderer() { return *renderer_; }
  [[nodiscard]] GlRaycaster& raycaster() { return prop_->raycaster(); }

 private:
  vtkRenderWindow& window_;
  vtkSmartPointer<vtkRenderer> renderer_;
  vtkSmartPointer<GlVolumeProp> prop_;
};

}  // namespace nav::render
