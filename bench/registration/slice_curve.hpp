// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "bench/registration/effort_curve.hpp"
#include "nav/volume.hpp"

namespace nav::bench {

/// Averages every \p slices slices to one, like a scanner that collects over the whole thickness;
/// rounded to whole HU. Leftover slices at the end are dropped. slices: [1, number of slices],
/// otherwise a Bug.
Volume with_thick_slices(const Volume& ct, int slices);

struct SliceOptions {
  std::uint64_t first_seed = 1;
  /// One sweep of each patient, along different paths for consecutive patients.
  int patients = 20;
  /// Number of slices of 1 mm that are averaged to one.
  std::vector<int> thickness_mm{1, 2, 3, 5};
  bool keep = false;  ///< True: patients stay in the store; false: at most one stays.
  registration::ImageRegistrationOptions local;
};

/// Points of axis "slices", by thickness in mm: local registration from 5 mm with CTs of these
/// slices. Anatomy, noise before averaging, sweep and start are the same for all. One thread.
std::vector<EffortPoint> measure_slices(const SliceOptions& options, CaseStore& store,
                                        const std::function<void(double)>& progress = {});

}  // namespace nav::bench
