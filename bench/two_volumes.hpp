// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/measure.hpp"
#include "nav/result.hpp"
#include "render/scene.hpp"

namespace nav::bench {

/// The simulated carotid of bench/predicate_patient.hpp, side voxels along each axis, inside a CT
/// of the same patient of 1 mm: bone and arteries with the forked vessel by predicates, seen from
/// the left and the front. side in [16, 512].
Result<render::Scene> two_volumes_scene(int side, int width, int height);

/// One step of the CPU engine in that scene.
struct TwoVolumesRow {
  double step_voxels = 0;
  double ct_cpu_ms = 0;  ///< The CT alone.
  double ultrasound_cpu_ms = 0;
  double both_cpu_ms = 0;
  std::uint64_t ct_samples = 0;
  std::uint64_t ultrasound_samples = 0;
  std::uint64_t both_samples = 0;
  double rms = 0;  ///< Of both, against the double-precision reference at 1/16 voxel; [0, 1].
};

struct TwoVolumesReport {
  std::vector<TwoVolumesRow> rows;  ///< Coarse to fine.
  double reference_rms = 0;         ///< Of the reference at 1/8 against that at 1/16 voxel.
};

/// Run time against error at steps of 2 to 1/4 voxel; times with one thread at width × height,
/// errors at an eighth of that.
Result<TwoVolumesReport> measure_two_volumes(int side, int width, int height,
                                             const Repeats& repeats);

/// Plain-text table.
std::string to_text(const TwoVolumesReport& report);

}  // namespace nav::bench
