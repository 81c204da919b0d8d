// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Compiled for x86-64-v4 and called only through cpu_marches().
#include "render/cpu/predicate_lanes_avx512.hpp"

namespace nav::render {

PredicateMarchSet avx512_predicate_marches() { return {predicate_march<PredicateAvx512>}; }

}  // namespace nav::render
