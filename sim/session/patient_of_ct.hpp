// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/anatomy/ct_patient.hpp"
#include "sim/anatomy/patient.hpp"

namespace nav::sim {

/// make_ct_patient() with a view of its targets by an abdominal convex probe, from the position
/// where sound reaches them most freely. The family is "ct". Errors: those of make_ct_patient() and
/// free_view().
Result<Patient> make_patient_of_ct(const Volume& ct, const CtPatientOptions& options = {});

}  // namespace nav::sim
