// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/cpu_marches.hpp"

namespace nav::render {
namespace {

bool has_avx2() {
  return __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0;
}

bool has_avx512() {
  return has_avx2() && __builtin_cpu_supports("avx512f") != 0 &&
         __builtin_cpu_supports("avx512bw") != 0 && __builtin_cpu_supports("avx512dq") != 0 &&
         __builtin_cpu_supports("avx512vl") != 0;
}

}  // namespace

CpuMarches cpu_marches(CpuLanes lanes) {
  if (lanes >= CpuLanes::kAvx512 && has_avx512()) {
    return {"AVX-512", avx512_marches(), avx512_predicate_marches()};
  }
  if (lanes >= CpuLanes::kAvx2 && has_avx2()) {
    return {"AVX2", avx2_marches(), avx2_predicate_marches()};
  }
  return {"portable", portable_marches(), portable_predicate_marches()};
}

}  // namespace nav::render
