// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu_march.hpp"

namespace nav::render {

March vector_march() {
  if (__builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0) return march_avx2;
  return nullptr;
}

}  // namespace nav::render
