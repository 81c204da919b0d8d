// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/vtk_baseline.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vtkFixedPointRayCastImage.h>
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

#include "render/vtk/vtk_convert.hpp"
#include "render/vtk/vtk_offscreen.hpp"

namespace nav::bench {
namespace {

vtkSmartPointer<vtkOpenGLGPUVolumeRayCastMapper> gpu_mapper(float image_sample_distance) {
  auto mapper = vtkSmartPointer<vtkOpenGLGPUVolumeRayCastMapper>::New();
  mapper->SetAutoAdjustSampleDistances(0);
  mapper->SetLockSampleDistanceToInputSpacing(0);
  mapper->SetUseJittering(0);
  mapper->SetImageSampleDistance(image_sample_distance);
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

/// The mapper's own image: 15-bit colours, premultiplied, bottom row first, in the part that the
/// volume covers.
Image2d<Rgba8> image_of(vtkFixedPointRayCastImage& image, const render::Scene& scene) {
  const int* memory = image.GetImageMemorySize();
  const int* used = image.GetImageInUseSize();
  const int* origin = image.GetImageOrigin();
  const unsigned short* values = image.GetImage();
  constexpr double kOne = 32767;
  std::vector<Rgba8> pixels;
  for (int y = scene.height - 1; y >= 0; --y) {
    for (int x = 0; x < scene.width; ++x) {
      const int column = x - origin[0];
      const int row = y - origin[1];
      std::array<double, 4> rgba{};
      if (column >= 0 && column < used[0] && row >= 0 && row < used[1]) {
        const unsigned short* p = values + 4 * (std::ptrdiff_t{row} * memory[0] + column);
        for (std::size_t c = 0; c < 4; ++c) rgba[c] = p[c] / kOne;
      }
      std::array<std::uint8_t, 3> rgb{};
      for (std::size_t c = 0; c < 3; ++c) {
        const double over =
            rgba[c] + (1 - rgba[3]) * scene.background_rgb[static_cast<Eigen::Index>(c)];
        rgb[c] = static_cast<std::uint8_t>(std::lround(255 * std::clamp(over, 0.0, 1.0)));
      }
      pixels.push_back({rgb[0], rgb[1], rgb[2], 255});
    }
  }
  return {scene.width, scene.height, std::move(pixels)};
}

double step_mm(const render::Scene& scene) {
  return scene.quality.step_voxels * scene.ct->grid().spacing_mm.minCoeff();
}

}  // namespace

struct VtkBaseline::Impl {
  std::shared_ptr<const StoredVolume> ct;
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
  if (mapper != Mapper::kFixedPoint) {
    impl->gpu = gpu_mapper(mapper == Mapper::kGpuHalf ? 2.0F : 1.0F);
    impl->gpu->SetInputData(image);
    vtkGPUVolumeRayCastMapper& checked = *impl->gpu;  // Public only in the base class.
    if (!checked.IsRenderSupported(&impl->window->window(), property)) {
      return Error{ErrorCode::kUnavailable,
                   "VTK: its GPU volume mapper does not support " + impl->window->device()};
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

void VtkBaseline::draw(const render::Scene& scene) {
  draw_current(scene);
  impl_->window->window().WaitForCompletion();
  impl_->window->release_thread();
}

Image2d<Rgba8> VtkBaseline::render(const render::Scene& scene) {
  draw_current(scene);
  Image2d<Rgba8> pixels = render::read_pixels(impl_->window->window());
  impl_->window->release_thread();
  return pixels;
}

/// Leaves the context current on return.
void VtkBaseline::draw_current(const render::Scene& scene) {
  vtkOpenGLRenderWindow& window = impl_->window->window();
  window.MakeCurrent();
  window.SetSize(scene.width, scene.height);
  render::apply(scene.camera, *impl_->renderer->GetActiveCamera());
  impl_->renderer->SetBackground(scene.background_rgb.data());
  impl_->renderer->ResetCameraClippingRange();
  if (impl_->gpu) impl_->gpu->SetSampleDistance(static_cast<float>(step_mm(scene)));
  if (impl_->fixed_point) impl_->fixed_point->SetSampleDistance(static_cast<float>(step_mm(scene)));
  window.Render();
}

Image2d<Rgba8> VtkBaseline::render_unsmoothed(const render::Scene& scene) {
  Image2d<Rgba8> drawn = render(scene);
  if (impl_->gpu) return drawn;
  return image_of(*impl_->fixed_point->GetRayCastImage(), scene);
}

std::string to_string(VtkBaseline::Mapper mapper) {
  switch (mapper) {
    case VtkBaseline::Mapper::kGpu:
      return "vtk-gpu";
    case VtkBaseline::Mapper::kGpuHalf:
      return "vtk-gpu-half";
    case VtkBaseline::Mapper::kFixedPoint:
      break;
  }
  return "vtk-fixedpoint";
}

}  // namespace nav::bench
