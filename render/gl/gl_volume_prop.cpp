// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/gl/gl_state.hpp"
// GLEW comes first, because every other GL header depends on it.
#include <algorithm>
#include <limits>
#include <vtkCamera.h>
#include <vtkCullerCollection.h>
#include <vtkMatrix4x4.h>
#include <vtkObjectFactory.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkOpenGLShaderCache.h>
#include <vtkPropCollection.h>
#include <vtkRenderer.h>

#include "render/gl/gl_volume_prop.hpp"
#include "render/quality/refinement.hpp"
#include "render/vtk/vtk_convert.hpp"

namespace nav::render {
namespace {

bool has_other_props(vtkRenderer& renderer, const vtkProp* own) {
  vtkPropCollection* props = renderer.GetViewProps();
  vtkCollectionSimpleIterator iterator;
  props->InitTraversal(iterator);
  while (const vtkProp* prop = props->GetNextProp(iterator)) {
    if (prop != own && const_cast<vtkProp*>(prop)->GetVisibility()) return true;
  }
  return false;
}

}  // namespace

vtkStandardNewMacro(GlVolumeProp)

    void GlVolumeProp::set_scene(std::shared_ptr<const Scene> scene, int coarse_factor) {
  scene_ = std::move(scene);
  coarse_factor_ = coarse_factor;
  this->Modified();
}

double* GlVolumeProp::GetBounds() {
  if (!scene_) return nullptr;
  const VoxelGrid& grid = scene_->ct->grid();
  constexpr double kFar = std::numeric_limits<double>::max();
  bounds_ = {kFar, -kFar, kFar, -kFar, kFar, -kFar};
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3d index;
    for (int axis = 0; axis < 3; ++axis) {
      const int last = grid.size[static_cast<std::size_t>(axis)] - 1;
      index(axis) = (corner >> axis & 1) != 0 ? last + 0.5 : -0.5;
    }
    const Eigen::Vector3d p = grid.at(index).mm;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double value = p(static_cast<Eigen::Index>(axis));
      bounds_[2 * axis] = std::min(bounds_[2 * axis], value);
      bounds_[2 * axis + 1] = std::max(bounds_[2 * axis + 1], value);
    }
  }
  return bounds_.data();
}

std::optional<SharedDepth> GlVolumeProp::depth_of_others(vtkRenderer& renderer,
                                                         const std::array<int, 4>& at) {
  if (!has_other_props(renderer, this)) return {};
  const GlStateGuard guard;
  GLint drawn = 0;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &drawn);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, static_cast<GLuint>(drawn));
  glActiveTexture(GL_TEXTURE0 + 20);
  glBindTexture(GL_TEXTURE_2D, depth_.id());
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glCopyTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT32F, at[0], at[1], at[2], at[3], 0);
  glBindTexture(GL_TEXTURE_2D, 0);
  const vtkMatrix4x4* projection = renderer.GetActiveCamera()->GetProjectionTransformMatrix(
      renderer.GetTiledAspectRatio(), -1, 1);
  return SharedDepth{depth_.id(),
                     {projection->GetElement(2, 2), projection->GetElement(2, 3),
                      projection->GetElement(3, 2), projection->GetElement(3, 3)}};
}

int GlVolumeProp::RenderVolumetricGeometry(vtkViewport* viewport) {
  auto* renderer = vtkRenderer::SafeDownCast(viewport);
  auto* window =
      renderer ? vtkOpenGLRenderWindow::SafeDownCast(renderer->GetRenderWindow()) : nullptr;
  if (!scene_ || !window) return 0;
  window->GetShaderCache()->ReleaseCurrentShader();
  // Errors of others are not reported here.
  while (glGetError() != GL_NO_ERROR) {
  }
  std::array<int, 4> at{};  // x, y, width, height
  renderer->GetTiledSizeAndOrigin(&at[2], &at[3], &at[0], &at[1]);
  if (at[2] < 1 || at[3] < 1) return 0;
  Scene scene = *scene_;
  const auto depth = depth_of_others(*renderer, at);
  drawn_factor_ = depth ? 1 : coarse_factor_;
  scene.width = at[2];
  scene.height = at[3];
  outcome_ = raycaster_.draw(with_fewer_pixels(std::move(scene), drawn_factor_), depth);
  if (outcome_) outcome_ = raycaster_.composite(at);
  return outcome_ ? 1 : 0;
}

void GlVolumeProp::ReleaseGraphicsResources(vtkWindow* window) {
  raycaster_.release();
  depth_.release();
  this->Superclass::ReleaseGraphicsResources(window);
}

SceneView::SceneView(vtkRenderWindow& window)
    : window_(window),
      renderer_(vtkSmartPointer<vtkRenderer>::New()),
      prop_(vtkSmartPointer<GlVolumeProp>::New()) {
  // A culler would drop the prop, with plane and needle, when only the CT is out of sight.
  renderer_->GetCullers()->RemoveAllItems();
  renderer_->AddViewProp(prop_);
  window_.AddRenderer(renderer_);
}

SceneView::~SceneView() {
  window_.MakeCurrent();
  prop_->ReleaseGraphicsResources(&window_);
  window_.RemoveRenderer(renderer_);
}

Result<SceneView::Drawn> SceneView::draw(std::shared_ptr<const Scene> scene, int coarse_factor) {
  apply(scene->camera, *renderer_->GetActiveCamera());
  const Eigen::Vector3d& background = scene->background_rgb;
  renderer_->SetBackground(background.x(), background.y(), background.z());
  prop_->set_scene(std::move(scene), coarse_factor);
  renderer_->ResetCameraClippingRange();
  window_.Render();
  if (!prop_->outcome()) return prop_->outcome().error();
  return Drawn{raycaster().cast_s(), prop_->drawn_factor(), raycaster().is_provisional()};
}

}  // namespace nav::render
