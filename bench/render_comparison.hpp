// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bench/error_curve.hpp"
#include "bench/measure.hpp"
#include "bench/scene_set.hpp"
#include "nav/diagnostics.hpp"
#include "nav/result.hpp"
#include "render/quality/step_search.hpp"

namespace nav::bench {

/// A quality, with or without fewer rays than pixels.
struct SparsePoint {
  double step_voxels;
  double pixel_error;  ///< 0: a ray for every pixel.
};

/// Options of the comparison.
struct RenderBenchOptions {
  /// In units of the smallest spacing; for every engine.
  std::vector<double> step_voxels{2, 1, 0.5, 0.25};
  /// Additional steps for Sonde's engines only, so that their curves span the errors of VTK's.
  std::vector<double> own_step_voxels{4, 0.125};
  /// Additional qualities with fewer rays: quality.pixel_error. Not for an engine on a device.
  std::vector<SparsePoint> own_sparse{{1, 0.3},     {1, 0.15},    {1, 0.08},
                                      {0.5, 0.15},  {0.5, 0.08},  {0.5, 0.04},
                                      {0.25, 0.08}, {0.25, 0.04}, {0.25, 0.02}};
  /// Errors at which curves are compared, in addition to VTK's own points, rms.
  std::vector<double> levels{2e-2, 1e-2, 5e-3, 2e-3};
  Repeats repeats;  ///< Repeats of the timed images, engines in turn.
  /// Size of the reference image, pixels. Those of the scenes are an odd multiple, so that the
  /// middles of the reference's pixels are middles of theirs, where their error is measured.
  int reference_width = 64;
  int reference_height = 48;
  double reference_step = 1.0 / 16;  ///< Step of the double-precision reference, voxels.
  bool gl = true;                    ///< Sonde's OpenGL engine; on a device, fragment shaders too.
  std::optional<bool> of_device;     ///< Replaces the decision by the device's name; for tests.
  bool vtk_gpu = true;               ///< vtkOpenGLGPUVolumeRayCastMapper.
  bool vtk_gpu_half = true;          ///< GPU mapper with a ray for every second column and row.
  bool vtk_fixed_point = true;       ///< vtkFixedPointVolumeRayCastMapper.
};

/// One engine on one scene at one step.
struct RenderBenchRow {
  std::string scene;
  std::string engine;  ///< "cpu", "gl", "gl-fragment", "vtk-gpu", "vtk-gpu-half", "vtk-fixedpoint".
  double step = 0;     ///< Voxels.
  double pixel_error = 0;  ///< Sonde's engines: quality.pixel_error.
  double cpu_s = 0;        ///< Median process time per image, user and system, all threads.
  double wall_s = 0;       ///< Median.
  double rms = 0;  ///< RMS error of 8-bit colour against the reference, all pixels and channels.
  double max = 0;
  /// VTK: the same against its own image at the reference's step, which removes differences between
  /// the models (its lights, its gradients); NaN for Sonde's engines.
  double rms_own = 0;
  /// Error for the curves: rms; for VTK the smaller of rms and rms_own.
  [[nodiscard]] double error() const { return rms_own < rms ? rms_own : rms; }
};

/// Comparison of Sonde's engine with VTK's mapper in one scene, along their curves.
struct RenderBenchRatio {
  std::string scene;
  /// "cpu_vs_vtk_gpu", "gl_vs_vtk_gpu", "cpu_vs_vtk_fixedpoint": VTK with a ray for every pixel.
  /// "cpu_vs_vtk_gpu_any", "gl_vs_vtk_gpu_any": VTK's mapper also with half of the rays along each
  /// axis, whichever is faster. "gl-fragment_…": without compute shaders, on a device.
  /// "cpu_dense_vs_vtk_gpu", "gl_dense_vs_vtk_gpu": a ray for every pixel on both sides.
  std::string name;
  bool shaded = false;
  std::vector<ErrorLevelRatio> levels;
  /// Sonde's time to reach an rms of 5e-3 over the time of VTK's cheapest image; NaN: not reached.
  double fine_over_their_cheapest = 0;
};

/// Accuracy of the reference of a scene.
struct SceneTruth {
  std::string scene;
  /// RMS difference between the reference at its step and at twice that step.
  double self_convergence;
};

/// The step and pixel error that the CPU engine chooses itself.
struct ChosenStep {
  std::string scene;
  render::StepChoice choice;
  double search_cpu_s = 0;  ///< Process time to find it, once for a volume and an appearance.
  /// RMS error of 8-bit colour over the whole image, against that of the same engine at an eighth
  /// of the step without early termination. The reference has few pixels and misses most edges,
  /// where errors are largest.
  double rms_whole = 0;
};

struct RenderBenchReport {
  std::string gl_device;
  /// True if OpenGL has its own device: curves then use the wall time of an image that stays on it,
  /// instead of process time.
  bool of_device = false;
  int reference_width = 0;
  int reference_height = 0;
  double reference_step = 0;
  std::vector<SceneTruth> truths;
  std::vector<RenderBenchRow> rows;
  std::vector<RenderBenchRatio> ratios;
  std::vector<ChosenStep> chosen;  ///< Empty on a device.
};

/// Runs all engines in turn in one process with the same camera, image size, transfer function,
/// shading and step; VTK without automatic sampling distances and without jitter. Calls progress
/// with the number of scenes done. Rejects scenes with anything but a CT, which VTK's mappers
/// cannot draw.
Result<RenderBenchReport> compare_renderers(const std::vector<NamedScene>& scenes,
                                            const RenderBenchOptions& options,
                                            Diagnostics& diagnostics,
                                            const std::function<void(std::size_t)>& progress = {});

/// The images that form a curve.
struct RenderBenchCurve {
  std::vector<std::string> engines;
  bool sparse;  ///< Includes images with quality.pixel_error.
};
ErrorCurve curve_of(const RenderBenchReport& report, const std::string& scene,
                    const RenderBenchCurve& curve);

/// Rejects an image size that is not an odd multiple of the reference's.
Result<void> check_image(const RenderBenchOptions& options, int width, int height);

/// The row of an engine in a scene at a quality; null if there is none.
const RenderBenchRow* find_row(const RenderBenchReport& report, const std::string& scene,
                               const std::string& engine, const SparsePoint& quality);
/// find_row() with a ray for every pixel.
const RenderBenchRow* find_row(const RenderBenchReport& report, const std::string& scene,
                               const std::string& engine, double step);

/// Plain-text tables of a report.
std::string to_text(const RenderBenchReport& report);

}  // namespace nav::bench
