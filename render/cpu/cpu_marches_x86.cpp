// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cpuid.h>

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

/// True for Intel processors since Sapphire Rapids, detected by AVX512-FP16. On older ones,
/// microcode against gather data sampling slows gathers down. On AMD processors gathers are slow
/// (ADR 44).
bool has_fast_gathers() {
  constexpr unsigned kAvx512Fp16 = 1U << 23;
  unsigned a = 0;
  unsigned b = 0;
  unsigned c = 0;
  unsigned d = 0;
  return __builtin_cpu_is("intel") != 0 && __get_cpuid_count(7, 0, &a, &b, &c, &d) != 0 &&
         (d & kAvx512Fp16) != 0;
}

}  // namespace

CpuMarches cpu_marches(CpuLanes lanes) {
  if (lanes >= CpuLanes::kAvx512 && has_avx512()) {
    if (lanes == CpuLanes::kAvx512Gathers || (lanes == CpuLanes::kFastest && has_fast_gathers())) {
      return {"AVX-512 with gathers", avx512_gathers_marches(), avx512_gathers_predicate_marches()};
    }
    return {"AVX-512", avx512_marches(), avx512_predicate_marches()};
  }
  if (lanes >= CpuLanes::kAvx2 && has_avx2()) {
    return {"AVX2", avx2_marches(), avx2_predicate_marches()};
  }
  return {"portable", portable_marches(), portable_predicate_marches()};
}

}  // namespace nav::render
