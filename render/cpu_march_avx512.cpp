// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Compiled for x86-64-v4 and entered only through cpu_marches().
#include "render/cpu_kernel_cull.hpp"
#include "render/cpu_kernel_instances.hpp"
#include "render/cpu_kernel_project.hpp"
#include "render/cpu_kernel_rays.hpp"
#include "render/cpu_voxels_avx512.hpp"

namespace nav::render {

MarchSet avx512_marches() {
  using V = SamplingAvx512<VoxelsByLane>;
  return {composite_march<V>, project_march<V>, cull_with<V>,
          meet_with<V>,       start_rays<V>,    aim_cut_rays<V>};
}

}  // namespace nav::render
