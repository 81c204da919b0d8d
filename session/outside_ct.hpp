// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "nav/diagnostics.hpp"
#include "nav/plan.hpp"
#include "nav/volume.hpp"

namespace nav::session {

/// How far a thing lies outside of a CT, mm: between the box about its points along the CT's axes
/// and the box of the voxels; 0 where these meet. Precondition: at least one point, otherwise a
/// Bug.
double mm_outside(const Volume& ct, std::span<const Point<frames::Ct>> points);

/// Warns, by its name, of a thing that lies farther than slack_mm outside of the CT: most likely it
/// is in another frame (RAS instead of LPS).
void warn_outside(const std::string& name, std::span<const Point<frames::Ct>> points,
                  double slack_mm, const Volume& ct, Diagnostics& diagnostics);

/// Warns of a target that does not meet the CT, and of an entry that lies more than a few
/// centimetres outside of it: the skin may lie beside a CT of the organ.
void warn_outside(const NeedlePlan& plan, const Volume& ct, Diagnostics& diagnostics);

}  // namespace nav::session
