// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicate_march.hpp"

namespace nav::render {

PredicateMarchSet avx2_predicate_marches() { return {nullptr}; }

}  // namespace nav::render
