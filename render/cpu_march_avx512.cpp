// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Compiled for x86-64-v4 and entered only through cpu_marches().
#include "render/cpu_kernel_cull.hpp"
#include "render/cpu_kernel_instances.hpp"
#include "render/cpu_kernel_project.hpp"
#include "render/cpu_kernel_rays.hpp"
#include "render/cpu_lanes_avx512.hpp"

namespace nav::render {

MarchSet avx512_marches() {
  return {composite_march<Avx512>, project_march<Avx512>, cull_with<Avx512>,
          meet_with<Avx512>,       start_rays<Avx512>,    aim_cut_rays<Avx512>};
}

}  // namespace nav::render
