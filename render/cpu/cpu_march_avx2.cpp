// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Compiled with -mavx2 -mfma and called only through cpu_marches().
#include "render/cpu/cpu_kernel_instances.hpp"
#include "render/cpu/cpu_lanes_avx2.hpp"

namespace nav::render {

MarchSet avx2_marches() { return march_set<Avx2>(); }

}  // namespace nav::render
