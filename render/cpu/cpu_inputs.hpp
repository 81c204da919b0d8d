// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/cpu_cache.hpp"
#include "render/cpu/cpu_march.hpp"
#include "render/spec/ray_spec.hpp"

namespace nav::render {

/// What a scene is marched with: the variant that it needs.
MarchKey march_key(const Scene& scene, const CpuCache& cache, bool with_cutaway);

/// MarchInputs::cells_per_look.
int cells_per_look(const Quality& quality);
/// The same of cells in runs of kMarchRun: whole runs, since parts of one cost as much.
int cells_per_look_in_runs(const Quality& quality);

/// MarchInputs::prefetch.
MarchPrefetch march_prefetch(const VoxelGrid& grid, const Quality& quality);

/// How rays start. first_sample: where sample 0 of a ray lies in its cell 0, in cells.
RayInputs ray_inputs(const Scene& scene, double first_sample);

/// What the rays of a picture share. The cache, updated for the scene, must outlive it.
MarchInputs march_inputs(const Scene& scene, const CpuCache& cache, const MarchKey& key);

}  // namespace nav::render
