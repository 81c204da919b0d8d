// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/derived/kernels.hpp"

namespace nav::render::derived {

const Kernels& kernels() { return portable_kernels(); }

}  // namespace nav::render::derived
