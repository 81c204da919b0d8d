// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "bench/registration/effort_curve.hpp"
#include "nav/volume.hpp"

namespace nav::bench {

/// Every so many slices averaged to one, as a scanner does that collects over the whole thickness;
/// rounded to whole HU. Slices that are left over at the end are dropped. slices: [1, those there
/// are], otherwise a Bug.
Volume with_thick_slices(const Volume& ct, int slices);

struct SliceOptions {
  std::uint64_t first_seed = 1;
  int patients = 20;  ///< One sweep of each, of another path than the one before.
  /// How many slices of 1 mm are averaged to one.
  std::vector<int> thickness_mm{1, 2, 3, 5};
  bool keep = false;  ///< Patients stay in the store; false: no more than one.
  registration::ImageRegistrationOptions local;
};

/// Points of axis "slices", by thickness in mm: local from 5 mm with CTs of such slices, otherwise
/// alike: anatomy, noise before averaging, sweep and start. One thread.
std::vector<EffortPoint> measure_slices(const SliceOptions& options, CaseStore& store,
                                        const std::function<void(double)>& progress = {});

}  // namespace nav::bench
