// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Compiled for x86-64-v4 and entered only through cpu_marches().
#include <ctime>

#include "render/cpu_kernel_cull.hpp"
#include "render/cpu_kernel_instances.hpp"
#include "render/cpu_kernel_project.hpp"
#include "render/cpu_kernel_rays.hpp"
#include "render/cpu_lanes_avx512.hpp"

namespace nav::render {
namespace {

/// Processor time of this thread, ns.
std::int64_t now_ns() {
  std::timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return std::int64_t{1000000000} * t.tv_sec + t.tv_nsec;
}

constexpr int kProbeSide = 16;  // Voxels: small enough to stay in the nearest cache.
constexpr int kProbeSlice = kProbeSide * kProbeSide;
constexpr int kProbeReads = 1000;
constexpr int kProbeRounds = 5;

/// Reads pairs of voxels all over a small volume, sixteen a time; the least time of some rounds.
template <class Read>
std::int64_t least_ns(const std::int16_t* voxels, const Read& read) {
  std::int64_t least = 1000000000;
  __m512i sum = _mm512_setzero_si512();
  for (int round = 0; round < kProbeRounds; ++round) {
    const std::int64_t start = now_ns();
    __m512i at = _mm512_setr_epi32(0, 1, 2, 3, 16, 17, 18, 19, 32, 33, 34, 35, 48, 49, 50, 51);
    for (int i = 0; i < kProbeReads; ++i) {
      sum = _mm512_add_epi32(sum, read(voxels, at));
      at = _mm512_and_si512(_mm512_add_epi32(at, _mm512_set1_epi32(kProbeSlice + 5)),
                            _mm512_set1_epi32(kProbeSide * kProbeSlice - 1));
    }
    const std::int64_t took = now_ns() - start;
    least = took < least ? took : least;
  }
  // The sum is needed, so the reads are.
  asm volatile("" : : "v"(sum));
  return least;
}

}  // namespace

bool avx512_gathers_pay() {
  // Sixteen lanes halve what is not a read: they pay as long as gathers take little more than what
  // Avx2 does.
  constexpr std::int64_t kWorstPerMille = 1250;
  alignas(64) static constexpr std::int16_t kVoxels[kProbeSide * kProbeSlice + 2] = {};
  const auto gather = [](const std::int16_t* p, __m512i at) {
    return Avx512::voxel_pair(p, Avx512::I{at});
  };
  const auto lane_by_lane = [](const std::int16_t* p, __m512i at) {
    const Avx512::Lanes lanes(Avx512::I{at});
    const auto pair = [&](int lane) {
      int word;
      __builtin_memcpy(&word, p + lanes.at[lane], sizeof word);
      return word;
    };
    __m512i out = _mm512_setzero_si512();
    const auto four = [&](int first) {
      __m128i c = _mm_cvtsi32_si128(pair(first));
      c = _mm_insert_epi32(c, pair(first + 1), 1);
      c = _mm_insert_epi32(c, pair(first + 2), 2);
      return _mm_insert_epi32(c, pair(first + 3), 3);
    };
    out = _mm512_inserti32x4(out, four(0), 0);
    out = _mm512_inserti32x4(out, four(4), 1);
    out = _mm512_inserti32x4(out, four(8), 2);
    return _mm512_inserti32x4(out, four(12), 3);
  };
  return 1000 * least_ns(kVoxels, gather) <= kWorstPerMille * least_ns(kVoxels, lane_by_lane);
}

MarchSet avx512_marches() {
  return {composite_march<Avx512>, project_march<Avx512>, cull_with<Avx512>,
          meet_with<Avx512>,       start_rays<Avx512>,    aim_cut_rays<Avx512>};
}

}  // namespace nav::render
