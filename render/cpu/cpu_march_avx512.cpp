// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Compiled for x86-64-v4 and called only through cpu_marches().
#include "render/cpu/cpu_kernel_instances.hpp"
#include "render/cpu/cpu_voxels_avx512.hpp"

namespace nav::render {

MarchSet avx512_marches() { return march_set<SamplingAvx512>(); }

}  // namespace nav::render
