// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nav/result.hpp"
#include "sim/anatomy/anatomy.hpp"
#include "sim/probe_model.hpp"

namespace nav::sim {

struct PatientOptions {
  std::uint64_t seed = 1;  ///< Another seed, another patient.
  Contrast contrast = Contrast::kPortal;
};

/// How a sonographer would hold the probe to see something.
struct StandardView {
  std::string name;
  ProbeModel probe;
  Transform<frames::Ct, frames::Image> ct_from_image;
};

/// A patient of a family with what is usually looked at. Copies share the anatomy.
struct Patient {
  std::string family;
  std::shared_ptr<const Anatomy> anatomy;
  std::vector<StandardView> views;  ///< At least one; the first shows what the family is about.
  /// Of the CT; absent: a recorded CT has its own.
  std::optional<Contrast> contrast = std::nullopt;
};

struct PatientFamily {
  std::string name;         ///< As on command lines.
  std::string description;  ///< One line.
  Patient (*make)(const PatientOptions& options);
};

/// Every family, in the order of listings.
const std::vector<PatientFamily>& patient_families();

/// A patient by the name of the family; refuses unknown names with the list of known ones.
Result<Patient> make_patient(const std::string& family, const PatientOptions& options = {});

}  // namespace nav::sim
