// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/cpu_cache.hpp"
#include "render/cpu/cpu_march.hpp"
#include "render/spec/ray_spec.hpp"

namespace nav::render {

/// The variant of the march that a scene needs.
MarchKey march_key(const Scene& scene, const CpuCache& cache, bool with_cutaway);

/// Sets the parameters of shading that do not depend on the view.
void set_light(const Shading& shading, MarchInputs& in);

/// Sets the thresholds of the cutaway's fade.
void set_thresholds(const Cutaway& cutaway, MarchInputs& in);

/// Value for MarchInputs::cells_per_test.
int cells_per_test(const Quality& quality);
/// The value for cells in runs of kMarchRun: whole runs, because a part of a run costs as much.
int cells_per_test_in_runs(const Quality& quality);

/// Value for MarchInputs::prefetch.
MarchPrefetch march_prefetch(const VoxelGrid& grid, const Quality& quality);

/// Inputs for starting rays. \p first_sample: position of sample 0 of a ray in its cell 0, in
/// cells.
RayInputs ray_inputs(const Scene& scene, double first_sample);

/// The data that all rays of an image share. The cache must be updated for the scene and outlive
/// the result.
MarchInputs march_inputs(const Scene& scene, const CpuCache& cache, const MarchKey& key);

}  // namespace nav::render
