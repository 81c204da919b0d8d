// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "nav/image.hpp"
#include "nav/result.hpp"
#include "render/scene.hpp"

namespace nav::bench {

/// VTK's volume mappers with a fair configuration: no automatic sampling distances, no jitter, one
/// ray per pixel unless fewer are requested, and the caller's step, camera, transfer function and
/// shading.
class VtkBaseline {
 public:
  enum class Mapper {
    kGpu,
    kGpuHalf,  ///< A ray for every second column and row, the rest interpolated by VTK.
    kFixedPoint
  };

  /// kUnavailable without an off-screen OpenGL context, or if the mapper rejects it. The scene's
  /// volume is shared.
  static Result<std::unique_ptr<VtkBaseline>> create(Mapper mapper, const render::Scene& scene);
  ~VtkBaseline();
  VtkBaseline(const VtkBaseline&) = delete;
  VtkBaseline& operator=(const VtkBaseline&) = delete;

  /// Draws like render(), but leaves the image on the device, which has finished drawing on return.
  void draw(const render::Scene& scene);
  /// Draws with the scene's camera, size, background and step; everything else stays as created.
  Image2d<Rgba8> render(const render::Scene& scene);
  /// The image as the mapper computed it. For the fixed-point mapper it is taken before VTK
  /// draws it as a textured rectangle, which smooths it; for the GPU mapper it is that of render().
  Image2d<Rgba8> render_unsmoothed(const render::Scene& scene);

 private:
  void draw_current(const render::Scene& scene);

  struct Impl;
  explicit VtkBaseline(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// "vtk-gpu", "vtk-gpu-half" or "vtk-fixedpoint".
std::string to_string(VtkBaseline::Mapper mapper);

}  // namespace nav::bench
