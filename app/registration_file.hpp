// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "app/report.hpp"
#include "nav/result.hpp"
#include "nav/volume.hpp"

namespace nav::app {

/// SHA-256 of a CT's grid and voxels: what a registration belongs to.
std::string ct_digest(const Volume& ct);

/// Reads the JSON that 'sonde register' wrote. Refuses a file that is not one, a registration that
/// was not accepted, one of another CT, and a matrix that is not rigid.
Result<Transform<frames::Ct, frames::Reference>> read_registration(
    const std::filesystem::path& path, const Volume& ct, const std::string& reference_frame);

}  // namespace nav::app
