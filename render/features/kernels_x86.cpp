// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/kernels.hpp"

namespace nav::render::features {

const Kernels& avx2_kernels();

const Kernels& kernels() {
  static const bool modern =
      __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0;
  return modern ? avx2_kernels() : portable_kernels();
}

}  // namespace nav::render::features
