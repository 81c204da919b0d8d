// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vtkSmartPointer.h>

#include "nav/image.hpp"
#include "render/scene.hpp"

class vtkCamera;
class vtkImageData;
class vtkMatrix4x4;
class vtkRenderWindow;
class vtkVolumeProperty;

/// The only file that converts project values to VTK objects and back. The world frame of VTK is
/// Ct, mm.
namespace nav::render {

/// Makes a VTK camera project exactly like ours. The renderer sets its clipping range.
void apply(const Camera& camera, vtkCamera& vtk);

/// Voxels on a grid with unit directions and origin zero, because VTK's mappers ignore directions;
/// place it with ct_from_vtk_image(). Shares the voxels of the volume, which must outlive it.
vtkSmartPointer<vtkImageData> vtk_image(const StoredVolume& volume);
/// The rigid (or mirrored) matrix that places vtk_image() in Ct.
vtkSmartPointer<vtkMatrix4x4> ct_from_vtk_image(const StoredVolume& volume);

/// Colours and opacity per mm (unit distance 1 mm), sampled densely, because VTK interpolates
/// opacity and we interpolate extinction. Voxels are interpolated linearly. Shading as given.
vtkSmartPointer<vtkVolumeProperty> vtk_property(const TransferFunction& transfer,
                                                const Shading& shading);

/// The pixels of the window after Render(), top row first, alpha 255.
Image2d<Rgba8> read_pixels(vtkRenderWindow& window);

}  // namespace nav::render
