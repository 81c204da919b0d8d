// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/plan.hpp"
#include "nav/result.hpp"
#include "sim/anatomy/anatomy.hpp"
#include "sim/probe_model.hpp"

namespace nav::sim {

/// Straight path from the skin beside the probe to one of the patient's targets that meets neither
/// bone nor gas. As far as possible it is in the image plane, at about 45 degrees to the beam, and
/// 0.6 times as long as the image is deep; 10 to 140 mm. Vessels and other organs are not avoided.
/// kUsage when there is none.
Result<NeedlePlan> needle_path(const Anatomy& patient,
                               const Transform<frames::Ct, frames::Image>& ct_from_image,
                               const ProbeModel& probe);

}  // namespace nav::sim
