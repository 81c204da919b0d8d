// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bench/measure.hpp"
#include "nav/result.hpp"
#include "render/engine.hpp"

namespace nav::bench {

/// The simulated carotid of sim/predicate_patient.hpp, side voxels along each axis, inside a CT
/// of the same patient of 1 mm. It shows bone and arteries with the forked vessel by predicates,
/// seen from the left and the front. side in [16, 512].
Result<render::Scene> two_volumes_scene(int side, int width, int height);

/// One step of an engine in that scene. Times of an image are those of the process, or those of the
/// device if an engine has one.
struct TwoVolumesRow {
  double step_voxels = 0;
  double ct_ms = 0;  ///< The CT alone.
  double ultrasound_ms = 0;
  double both_ms = 0;
  std::uint64_t ct_samples = 0;
  std::uint64_t ultrasound_samples = 0;
  std::uint64_t both_samples = 0;
  /// RMS error of both against the double-precision reference at 1/16 voxel; [0, 1].
  double rms = 0;
};

struct TwoVolumesReport {
  std::string engine;
  std::string device;
  int width = 0;
  int height = 0;
  std::vector<TwoVolumesRow> rows;  ///< Coarse to fine.
  double reference_rms = 0;  ///< Difference of the reference at 1/8 voxel from that at 1/16 voxel.
  double edit_ms = 0;  ///< Wall time before the first ray after a new importance of the CT; median.
};

/// Makes an engine to be measured.
using EngineMaker = std::function<Result<std::unique_ptr<render::Engine>>()>;

/// Run time against error at steps of 2 to 1/4 voxel, one report for each kind of engine. Times are
/// measured at width × height, or half of it if OpenGL runs in software; errors are measured at an
/// eighth.
Result<std::vector<TwoVolumesReport>> measure_two_volumes(int side, int width, int height,
                                                          const Repeats& repeats,
                                                          const std::vector<EngineMaker>& engines);

/// Plain-text table.
std::string to_text(const TwoVolumesReport& report);

}  // namespace nav::bench
