// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/cpu_kernel_instances.hpp"
#include "render/cpu/cpu_lanes_scalar.hpp"

namespace nav::render {

MarchSet portable_marches() { return march_set<Scalar>(); }

}  // namespace nav::render
