// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu_kernel_cull.hpp"
#include "render/cpu_kernel_instances.hpp"
#include "render/cpu_kernel_project.hpp"
#include "render/cpu_kernel_rays.hpp"
#include "render/cpu_lanes_scalar.hpp"

namespace nav::render {

MarchSet portable_marches() {
  return {composite_march<Scalar>, project_march<Scalar>, cull_with<Scalar>,
          meet_with<Scalar>,       start_rays<Scalar>,    aim_cut_rays<Scalar>};
}

}  // namespace nav::render
