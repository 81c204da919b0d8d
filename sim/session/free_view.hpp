// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/result.hpp"
#include "nav/transform.hpp"
#include "sim/anatomy/anatomy.hpp"

namespace nav::sim {

/// A view of the patient's targets from the skin, free of what sound does not pass as far as there
/// is one: the probe pressed press_mm into the skin, its picture across the body. kUsage when the
/// patient has no skin around the targets.
Result<Transform<frames::Ct, frames::Image>> free_view(const Anatomy& patient, double press_mm);

}  // namespace nav::sim
