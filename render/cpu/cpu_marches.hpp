// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/cpu_march.hpp"
#include "render/cpu/predicate_march.hpp"
#include "render/engine.hpp"

namespace nav::render {

/// What the CPU engine marches with, compiled for one instruction set.
struct CpuMarches {
  const char* name;  ///< "AVX-512 with gathers", "AVX-512", "AVX2" or "portable".
  MarchSet rays;
  PredicateMarchSet predicates;
};

/// Those asked for, or less where the processor has less. Thread-safe.
CpuMarches cpu_marches(CpuLanes lanes);

}  // namespace nav::render
