// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string_view>

#include "nav/transform.hpp"
#include "sim/abdomen_phantom.hpp"

namespace nav::sim {

/// Who lies on the table.
using Patient = AbdomenPhantom;

/// The one place where the name of a family becomes a patient. kUsage for a name that is none.
Result<std::shared_ptr<const Patient>> make_patient(std::string_view family, std::uint64_t seed,
                                                    Contrast contrast);

/// A view of the patient's targets from the skin, free of what sound does not pass as far as there
/// is one: the probe pressed press_mm into the skin, its picture across the body. kUsage when the
/// patient has no skin around the targets.
Result<Transform<frames::Ct, frames::Image>> free_view(const Patient& patient, double press_mm);

}  // namespace nav::sim
