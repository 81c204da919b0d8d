// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "nav/diagnostics.hpp"
#include "nav/result.hpp"
#include "registration/landmarks/anisotropic_landmarks.hpp"
#include "registration/landmarks/landmarks.hpp"

namespace nav::app {

/// Contents of a landmark file.
struct LandmarkList {
  std::vector<registration::LandmarkPair> pairs;
  std::vector<registration::AnisotropicLandmark> shaped;  ///< All pairs again; empty without axes.
  bool sigmas_given = false;  ///< False: every pair has the default sigma of 1 mm.
};

/// Reads landmark pairs from a comma-separated file with the header line
/// name,reference_x_mm,reference_y_mm,reference_z_mm,ct_x_mm,ct_y_mm,ct_z_mm and optionally
/// ,sigma_mm (per axis, of the pair) or the standard deviations along the axes of both frames:
/// ,reference_sigma_x_mm,…_y_mm,…_z_mm,ct_sigma_x_mm,…_y_mm,…_z_mm.
/// CT points are LPS. Errors name file, line, column, expected and found.
Result<LandmarkList> read_landmarks(const std::filesystem::path& path);

/// Reads landmark pairs from two Markups files of 3D Slicer (io::read_markups). \p reference:
/// points of the patient's frame, whose coordinates 3D Slicer takes as RAS. \p ct: points of the
/// CT. Pairs have the same label, or equal positions in the lists where no label is in both files.
/// A pair of which a point has no position is left out. What was found goes to the diagnostics.
Result<LandmarkList> read_landmark_markups(const std::filesystem::path& reference,
                                           const std::filesystem::path& ct,
                                           Diagnostics& diagnostics);

/// Rejects points whose extent is not that of a part of a patient in mm: within 1 mm of their
/// centre, or more than 2 m from it. \p what: "Ct points".
Result<void> check_unit(const std::vector<Eigen::Vector3d>& points, const std::string& what);

}  // namespace nav::app
