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

/// The one place where project values become VTK objects and back. World space of VTK is Ct, mm.
namespace nav::render {

/// Makes a VTK camera project exactly as ours; its clipping range is left to the renderer.
void apply(const Camera& camera, vtkCamera& vtk);

/// Voxels on a grid with unit directions and origin zero (VTK's mappers ignore directions): place
/// it with ct_from_vtk_image(). Shares the voxels of the volume, which must outlive it.
vtkSmartPointer<vtkImageData> vtk_image(const Volume& volume);
/// Rigid (or mirrored) matrix that places vtk_image() in Ct.
vtkSmartPointer<vtkMatrix4x4> ct_from_vtk_image(const Volume& volume);

/// Colours and opacity per mm (unit distance 1 mm) sampled densely, because VTK interpolates
/// opacity where we interpolate extinction; linear interpolation of voxels; shading as given.
vtkSmartPointer<vtkVolumeProperty> vtk_property(const TransferFunction& transfer,
                                                const Shading& shading);

/// What the window shows after Render(), top row first, alpha 255.
Image2d<Rgba8> read_pixels(vtkRenderWindow& window);

}  // namespace nav::render
