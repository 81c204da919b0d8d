// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu_march.hpp"

namespace nav::render {

MarchSet vector_marches() { return {}; }

}  // namespace nav::render
