// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/cpu_march.hpp"
#include "render/cpu/predicate_march.hpp"
#include "render/engine.hpp"

namespace nav::render {

/// The marches of the CPU engine, compiled for one instruction set.
struct CpuMarches {
  const char* name;  ///< "AVX-512", "AVX2" or "portable".
  MarchSet rays;
  PredicateMarchSet predicates;
};

/// The requested marches, or those of a lower instruction set if the processor does not support it.
/// Thread-safe.
CpuMarches cpu_marches(CpuLanes lanes);

}  // namespace nav::render
