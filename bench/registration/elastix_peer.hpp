// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bench/registration/cohort.hpp"
#include "nav/result.hpp"

/// elastix (Klein et al. 2010) as a peer: Mattes mutual information, rigid, on the compounded
/// sweep.
namespace nav::bench {

/// elastix in PATH, or nothing.
std::optional<std::filesystem::path> find_elastix();

/// One way to run it.
struct ElastixEffort {
  int iterations;       ///< Of each resolution.
  int samples;          ///< Spatial samples of an iteration.
  int resolutions = 4;  ///< Of its pyramid, each half of the next.
};

struct ElastixRun {
  CtPose found;
  double cpu_s;  ///< User and system time of the whole process, its reading and pyramids included.
  double reading_s;  ///< Of the images, as its log has it, s.
};

/// Processor time that elastix takes to say its version, s: what every run of it begins with.
double startup_s(const std::filesystem::path& elastix);

/// Sweep and CT as files that elastix reads: the sweep compounded to 1 mm voxels (mean of the
/// pixels that fall into one) with a mask of the voxels that a picture passed, shadows left out as
/// we leave them out. The folder's owner removes it.
Result<void> write_elastix_case(const Patient& patient, const RecordedSweep& recorded,
                                const std::filesystem::path& folder);

/// Registers the case in a folder, one thread. kRefused: elastix gave up; the message says where
/// its log lies.
Result<ElastixRun> run_elastix(const std::filesystem::path& elastix,
                               const std::filesystem::path& folder, const CtPose& start,
                               const ElastixEffort& effort);

}  // namespace nav::bench
