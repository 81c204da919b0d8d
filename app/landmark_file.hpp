// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "nav/result.hpp"
#include "registration/landmarks.hpp"

namespace nav::app {

/// Reads landmark pairs from a comma-separated file with the header line
/// name,reference_x_mm,reference_y_mm,reference_z_mm,ct_x_mm,ct_y_mm,ct_z_mm and optionally
/// ,sigma_mm. CT points are LPS. Errors name file, line, column, expected and found.
Result<std::vector<registration::LandmarkPair>> read_landmarks(const std::filesystem::path& path);

}  // namespace nav::app
