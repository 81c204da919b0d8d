// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "app/report.hpp"
#include "nav/result.hpp"
#include "nav/volume.hpp"

namespace nav::app {

/// SHA-256 of a CT's grid and voxels: what a registration belongs to.
std::string ct_digest(const Volume& ct);

/// A registration that was accepted.
struct ReadRegistration {
  Transform<frames::Ct, frames::Reference> ct_from_reference;
  std::vector<std::string> warnings;  ///< Empty unless it was accepted with warnings.
};

/// Reads the JSON that 'sonde register' wrote. Refuses a file that is not one, a registration that
/// was not accepted, one of another CT, a verdict that is unknown or is not as `accepted` says, and
/// a matrix that is not rigid; one with the breath, whose pose is that of rest, unless the CT
/// follows the tissue from there. A file without a verdict has no warnings.
Result<ReadRegistration> read_registration(const std::filesystem::path& path, const Volume& ct,
                                           const std::string& reference_frame,
                                           bool follows = false);

}  // namespace nav::app
