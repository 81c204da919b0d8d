// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu_march.hpp"

namespace nav::render {

MarchSet vector_marches() {
  if (__builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0) {
    return avx2_marches();
  }
  return {};
}

}  // namespace nav::render
