// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/kernels.hpp"

namespace nav::render::features {
namespace {
#include "render/features/kernels_body.hpp"
constexpr Kernels kPortable = make_kernels("portable");
}  // namespace

const Kernels& portable_kernels() { return kPortable; }

}  // namespace nav::render::features
