// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Compiled with -mavx2 -mfma and called only through kernels().
#include <immintrin.h>

#include "render/features/kernels.hpp"

namespace nav::render::features {
namespace {
#include "render/features/kernels_body.hpp"
constexpr Kernels kAvx2 = make_kernels("avx2");
}  // namespace

const Kernels& avx2_kernels() { return kAvx2; }

}  // namespace nav::render::features
