// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nav/plan.hpp"
#include "nav/result.hpp"
#include "sim/anatomy/anatomy.hpp"
#include "sim/probe_model.hpp"

namespace nav::sim {

struct PatientOptions {
  std::uint64_t seed = 1;  ///< Each seed gives another patient.
  Contrast contrast = Contrast::kPortal;
};

/// Pose in which a sonographer holds the probe to show a structure.
struct StandardView {
  std::string name;
  ProbeModel probe;
  Transform<frames::Ct, frames::Image> ct_from_image;
};

/// Patient of a family with its usual views. Copies share the anatomy.
struct Patient {
  std::string family;
  std::shared_ptr<const Anatomy> anatomy;
  std::vector<StandardView> views;  ///< At least one; the first shows the main structure.
  /// Contrast of the CT; absent: a recorded CT has its own.
  std::optional<Contrast> contrast = std::nullopt;
  /// Planned path of a needle to a lesion; absent: the patient has no lesion with a free path.
  std::optional<NeedlePlan> plan = std::nullopt;
};

struct PatientFamily {
  std::string name;         ///< Name on command lines.
  std::string description;  ///< Description in one line.
  Patient (*make)(const PatientOptions& options);
};

/// All families, in the order of listings.
const std::vector<PatientFamily>& patient_families();

/// Makes a patient by the name of the family; rejects unknown names with the list of known ones.
Result<Patient> make_patient(const std::string& family, const PatientOptions& options = {});

}  // namespace nav::sim
