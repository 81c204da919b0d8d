// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/session/patient_of_ct.hpp"

#include "sim/session/free_view.hpp"

namespace nav::sim {

Result<Patient> make_patient_of_ct(const Volume& ct, const CtPatientOptions& options) {
  auto anatomy = make_ct_patient(ct, options);
  if (!anatomy) return anatomy.error();
  const ProbeModel probe = convex_abdominal();
  const auto view = free_view(**anatomy, press_mm(probe));
  if (!view) return view.error();
  return Patient{"ct", *std::move(anatomy), {{"free view", probe, *view}}};
}

}  // namespace nav::sim
