// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/vtk_baseline.hpp"

#include <vtkFixedPointVolumeRayCastMapper.h>
#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkOpenGLGPUVolumeRayCastMapper.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkVolume.h>
#include <vtkVolumeProperty.h>

#include "render/vtk_convert.hpp"
#include "render/vtk_offscreen.hpp"

namespace nav::bench {
namespace {

vtkSmartPointer<vtkOpenGLGPUVolumeRayCastMapper> gpu_mapper() {
  auto mapper = vtkSmartPointer<vtkOpenGLGPUVolumeRayCastMapper>::New();
  mapper->SetAutoAdjustSampleDistances(0);
  mapper->SetLockSampleDistanceToInputSpacing(0);
  mapper->SetUseJittering(0);
  mapper->SetImageSampleDistance(1);
  mapper->SetBlendModeToComposite();
  return mapper;
}

vtkSmartPointer<vtkFixedPointVolumeRayCastMapper> fixed_point_mapper() {
  auto mapper = vtkSmartPointer<vtkFixedPointVolumeRayCastMapper>::New();
  mapper->SetAutoAdjustSampleDistances(0);
  mapper->SetLockSampleDistanceToInputSpacing(0);
  mapper->SetImageSampleDistance(1);
  mapper->SetBlendModeToComposite();
  return mapper;
}

double step_mm(const render::Scene& scene) {
  return scene.quality.step_voxels * scene.ct->grid().spacing_mm.minCoeff();
}

}  // namespace

struct VtkBaseline::Impl {
  std::shared_ptr<const Volume> ct;
  std::unique_ptr<render::OffscreenWindow> window;
  vtkNew<vtkRenderer> renderer;
  vtkNew<vtkVolume> volume;
  vtkSmartPointer<vtkOpenGLGPUVolumeRayCastMapper> gpu;
  vtkSmartPointer<vtkFixedPointVolumeRayCastMapper> fixed_point;
};

VtkBaseline::VtkBaseline(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

VtkBaseline::~VtkBaseline() {
  impl_->window->window().MakeCurrent();
  impl_->window->window().RemoveRenderer(impl_->renderer);
}

Result<std::unique_ptr<VtkBaseline>> VtkBaseline::create(Mapper mapper,
                                                         const render::Scene& scene) {
  auto impl = std::make_unique<Impl>();
  auto window = render::OffscreenWindow::create(scene.width, scene.height);
  if (!window) return window.error();
  impl->window = std::move(window).value();
  impl->ct = scene.ct;
  impl->volume->SetUserMatrix(render::ct_from_vtk_image(*scene.ct));
  const auto property = render::vtk_property(scene.transfer, scene.shading);
  impl->volume->SetProperty(property);
  const auto image = render::vtk_image(*scene.ct);
  if (mapper == Mapper::kGpu) {
    impl->gpu = gpu_mapper();
    impl->gpu->SetInputData(image);
    vtkGPUVolumeRayCastMapper& checked = *impl->gpu;  // Public only in the base class.
    if (!checked.IsRenderSupported(&impl->window->window(), property)) {
      return Error{ErrorCode::kUnavailable,
                   "VTK: expected support of its GPU volume mapper, found none on " +
                       impl->window->device()};
    }
    impl->volume->SetMapper(impl->gpu);
  } else {
    impl->fixed_point = fixed_point_mapper();
    impl->fixed_point->SetInputData(image);
    impl->volume->SetMapper(impl->fixed_point);
  }
  impl->renderer->AddVolume(impl->volume);
  impl->window->window().AddRenderer(impl->renderer);
  return std::unique_ptr<VtkBaseline>(new VtkBaseline(std::move(impl)));
}

Image2d<Rgba8> VtkBaseline::render(const render::Scene& scene) {
  vtkOpenGLRenderWindow& window = impl_->window->window();
  window.MakeCurrent();
  window.SetSize(scene.width, scene.height);
  render::apply(scene.camera, *impl_->renderer->GetActiveCamera());
  impl_->renderer->SetBackground(scene.background_rgb.data());
  impl_->renderer->ResetCameraClippingRange();
  if (impl_->gpu) impl_->gpu->SetSampleDistance(static_cast<float>(step_mm(scene)));
  if (impl_->fixed_point) impl_->fixed_point->SetSampleDistance(static_cast<float>(step_mm(scene)));
  window.Render();
  Image2d<Rgba8> pixels = render::read_pixels(window);
  impl_->window->release_thread();
  return pixels;
}

std::string to_string(VtkBaseline::Mapper mapper) {
  return mapper == VtkBaseline::Mapper::kGpu ? "vtk-gpu" : "vtk-fixedpoint";
}

}  // namespace nav::bench
