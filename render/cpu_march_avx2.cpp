// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Compiled with -mavx2 -mfma and entered only through cpu_marches().
#include "render/cpu_kernel_cull.hpp"
#include "render/cpu_kernel_instances.hpp"
#include "render/cpu_kernel_project.hpp"
#include "render/cpu_kernel_rays.hpp"
#include "render/cpu_lanes_avx2.hpp"

namespace nav::render {

MarchSet avx2_marches() {
  return {composite_march<Avx2>, project_march<Avx2>, cull_with<Avx2>,
          meet_with<Avx2>,       start_rays<Avx2>,    aim_cut_rays<Avx2>};
}

}  // namespace nav::render
