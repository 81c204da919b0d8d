// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/kernels.hpp"

namespace nav::render::features {

const Kernels& kernels() { return portable_kernels(); }

}  // namespace nav::render::features
