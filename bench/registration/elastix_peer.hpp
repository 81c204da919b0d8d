// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bench/registration/cohort.hpp"
#include "nav/result.hpp"

/// elastix (Klein et al. 2010) as a comparison: Mattes mutual information, rigid, on the compounded
/// sweep.
namespace nav::bench {

/// elastix in PATH; empty if there is none.
std::optional<std::filesystem::path> find_elastix();

/// One effort of elastix.
struct ElastixEffort {
  int iterations;       ///< Iterations of each resolution.
  int samples;          ///< Spatial samples of an iteration.
  int resolutions = 4;  ///< Resolutions of its pyramid, each half of the next.
};

struct ElastixRun {
  CtPose found;
  double cpu_s;      ///< User and system time of the whole process, including reading and pyramids.
  double reading_s;  ///< Time to read the images, from its log, s.
};

/// Processor time that elastix takes to print its version, s: the fixed part of every run.
double startup_s(const std::filesystem::path& elastix);

/// Writes sweep and CT as files for elastix: the sweep is compounded to 1 mm voxels (mean of the
/// pixels in each voxel), with a mask of the voxels that an image passed; shadows are left out with
/// the same method as ours. The caller removes the folder.
Result<void> write_elastix_case(const Patient& patient, const RecordedSweep& recorded,
                                const std::filesystem::path& folder);

/// Registers the case in a folder, one thread. kRefused: elastix gave up; the message gives the
/// path of its log.
Result<ElastixRun> run_elastix(const std::filesystem::path& elastix,
                               const std::filesystem::path& folder, const CtPose& start,
                               const ElastixEffort& effort);

}  // namespace nav::bench
