// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "nav/result.hpp"
#include "nav/volume.hpp"

namespace nav::render {

/// A CT without what lies beside the body: the table, clothes, cables and pillows.
struct BodyOnly {
  std::shared_ptr<const Volume> ct;  ///< The CT itself if nothing was removed.
  double removed_ml = 0;             ///< Volume of the voxels that became air.
};

/// Finds the body: the largest component (connected by faces) of the voxels above -300 HU, after
/// the mask was eroded by about 4 mm, so that a table that touches the body is a component of its
/// own, and what such a component encloses in an axial slice (lungs, bowel gas). Voxels farther
/// than about 8 mm from it and above -900 HU become air (-1024 HU). Slices whose border the body
/// covers by more than a half are left as they are: there is no room for a table. Deterministic.
/// Takes about 4 bytes for each voxel.
BodyOnly without_table(const std::shared_ptr<const Volume>& ct);

}  // namespace nav::render
