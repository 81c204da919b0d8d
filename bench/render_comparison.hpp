// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "nav/diagnostics.hpp"
#include "nav/result.hpp"
#include "render/scene.hpp"

namespace nav::bench {

/// A scene and what it is called in the table.
struct NamedScene {
  std::string name;
  render::Scene scene;  ///< CT and transfer function only: VTK's mappers know no plane or needle.
};

/// How the comparison is run.
struct RenderBenchOptions {
  std::vector<double> step_voxels{2, 1, 0.5, 0.25};  ///< Of the smallest spacing.
  int frames = 3;            ///< Timed frames of each engine, interleaved; >= 1.
  int reference_width = 80;  ///< Size of the picture whose error is measured, pixels.
  int reference_height = 60;
  double reference_step = 0.125;  ///< Of the double-precision reference, voxels.
  bool vtk_gpu = true;            ///< vtkOpenGLGPUVolumeRayCastMapper.
  bool vtk_fixed_point = true;    ///< vtkFixedPointVolumeRayCastMapper.
};

/// One engine on one scene at one step.
struct RenderBenchRow {
  std::string scene;
  std::string engine;  ///< "cpu", "gl", "vtk-gpu", "vtk-fixedpoint".
  double step = 0;     ///< Voxels.
  double cpu_s = 0;    ///< Process time per frame, user and system, all threads; median.
  double wall_s = 0;   ///< Median.
  double rms = 0;      ///< Colour error against the reference, all pixels and channels.
  double max = 0;
};

/// Time of ours over time of theirs turned round: 5 means that ours took a fifth, by process time.
struct RenderBenchRatio {
  std::string scene;
  std::string name;    ///< "cpu_vs_vtk_gpu", "gl_vs_vtk_gpu", "cpu_vs_vtk_fixedpoint".
  double step = 0;     ///< Step of the VTK row.
  double same_step;    ///< At the same step; NaN when one is missing.
  double equal_error;  ///< Our cheapest row with rms not above VTK's; NaN when there is none.
};

struct RenderBenchReport {
  std::string gl_device;
  int reference_width = 0;  ///< Size of the pictures whose error was measured.
  int reference_height = 0;
  std::vector<RenderBenchRow> rows;
  std::vector<RenderBenchRatio> ratios;
};

/// Runs all engines interleaved in one process: same camera, picture size, transfer function,
/// shading and step; VTK without automatic sampling distances and without jitter. Refuses scenes
/// with a plane, needle or spheres, which VTK's mappers cannot draw.
Result<RenderBenchReport> compare_renderers(const std::vector<NamedScene>& scenes,
                                            const RenderBenchOptions& options,
                                            Diagnostics& diagnostics);

/// Plain-text table of a report.
std::string to_text(const RenderBenchReport& report);

}  // namespace nav::bench
