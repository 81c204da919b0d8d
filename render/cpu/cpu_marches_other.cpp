// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/cpu_marches.hpp"

namespace nav::render {

CpuMarches cpu_marches(CpuLanes /*lanes*/) {
  return {"portable", portable_marches(), portable_predicate_marches()};
}

}  // namespace nav::render
