// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/vtk/vtk_convert.hpp"

#include <algorithm>
#include <cmath>
#include <vtkCamera.h>
#include <vtkColorTransferFunction.h>
#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkPiecewiseFunction.h>
#include <vtkPointData.h>
#include <vtkRenderWindow.h>
#include <vtkShortArray.h>
#include <vtkUnsignedCharArray.h>
#include <vtkVolumeProperty.h>

namespace nav::render {

void apply(const Camera& camera, vtkCamera& vtk) {
  vtk.SetPosition(camera.eye_ct.mm.data());
  vtk.SetFocalPoint(camera.look_at_ct.mm.data());
  vtk.SetViewUp(camera.up_ct.v.data());
  vtk.SetViewAngle(camera.vertical_fov_rad * 180.0 / M_PI);
  vtk.SetParallelProjection(camera.orthographic);
  vtk.SetParallelScale(0.5 * camera.orthographic_height_mm);
}

vtkSmartPointer<vtkImageData> vtk_image(const StoredVolume& volume) {
  const VoxelGrid& grid = volume.grid();
  auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetDimensions(grid.size.data());
  image->SetSpacing(grid.spacing_mm.data());
  vtkNew<vtkShortArray> voxels;
  // VTK wants a mutable pointer but does not write through it; 1 keeps VTK from freeing it.
  voxels->SetArray(const_cast<std::int16_t*>(volume.values().data()),
                   static_cast<vtkIdType>(volume.values().size()), 1);
  image->GetPointData()->SetScalars(voxels);
  return image;
}

vtkSmartPointer<vtkMatrix4x4> ct_from_vtk_image(const StoredVolume& volume) {
  auto matrix = vtkSmartPointer<vtkMatrix4x4>::New();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      matrix->SetElement(row, column, volume.grid().directions(row, column));
    }
    matrix->SetElement(row, 3, volume.grid().origin_mm(row));
  }
  return matrix;
}

vtkSmartPointer<vtkVolumeProperty> vtk_property(const TransferFunction& transfer,
                                                const Shading& shading) {
  // Equidistant points, every HU if that is affordable: VTK makes its tables as fine as the
  // smallest interval between points.
  constexpr double kMaxSamples = 8192;
  const double first = transfer.values().front();
  const double range = transfer.values().back() - first;
  const int intervals = static_cast<int>(std::clamp(std::ceil(range), 1024.0, kMaxSamples));
  vtkNew<vtkColorTransferFunction> colour;
  vtkNew<vtkPiecewiseFunction> opacity;
  for (int i = 0; i <= intervals; ++i) {
    const double hu = first + range * i / intervals;
    const TransferSample sample = transfer.at(hu);
    colour->AddRGBPoint(hu, sample.rgb.x(), sample.rgb.y(), sample.rgb.z());
    opacity->AddPoint(hu, -std::expm1(-sample.tau_per_mm));
  }
  auto property = vtkSmartPointer<vtkVolumeProperty>::New();
  property->SetColor(colour);
  property->SetScalarOpacity(opacity);
  property->SetScalarOpacityUnitDistance(1.0);
  property->SetInterpolationTypeToLinear();
  property->SetShade(shading.enabled);
  property->SetAmbient(shading.ambient);
  property->SetDiffuse(shading.diffuse);
  property->SetSpecular(shading.specular);
  property->SetSpecularPower(shading.shininess);
  return property;
}

Image2d<Rgba8> read_pixels(vtkRenderWindow& window) {
  const int* size = window.GetSize();
  const int width = size[0];
  const int height = size[1];
  vtkNew<vtkUnsignedCharArray> bytes;
  window.GetPixelData(0, 0, width - 1, height - 1, 0, bytes, 0);
  NAV_CHECK(bytes->GetNumberOfValues() == vtkIdType{3} * width * height, width, height);
  std::vector<Rgba8> pixels;
  pixels.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int row = height - 1; row >= 0; --row) {
    const unsigned char* p = bytes->GetPointer(vtkIdType{3} * row * width);
    for (int column = 0; column < width; ++column, p += 3) {
      pixels.push_back({p[0], p[1], p[2], 255});
    }
  }
  return {width, height, std::move(pixels)};
}

}  // namespace nav::render
