// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "registration/shape/shape_evidence.hpp"
#include "registration/shape/shape_solver.hpp"

/// Other explanations of points by a shape: the shape turned end to end or about its axes, and its
/// mirror image, which is the other leg.
namespace nav::registration {

/// Searches rivals of a registration: from half turns about the principal axes of the shape and of
/// the points, from turns about the long axis and shifts along it, each with seeded variations, of
/// the points and of their mirror image; the best are solved to convergence with all points. The
/// initial pose is turned in the same way: a registration to the wrong shape may lie anywhere.
/// others: further minima of the points, which are rivals too. Deterministic. keep_going: asked
/// between solves; false ends the search early.
ShapeRivals shape_rivals(const ReferencePoints& points, const ShapeField& shape,
                         const Transform<frames::Ct, frames::Reference>& initial,
                         const Transform<frames::Ct, frames::Reference>& best,
                         const std::vector<Transform<frames::Ct, frames::Reference>>& others,
                         const ShapeNoise& noise, const ShapeRegistrationOptions& options,
                         const std::function<bool()>& keep_going);

}  // namespace nav::registration
