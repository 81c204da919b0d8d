// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "registration/shape/shape_evidence.hpp"
#include "registration/shape/shape_solver.hpp"

/// Explanations of the residuals of points that a rigid pose leaves: a surface of another size or
/// form, and an offset from the surface that all points share.
namespace nav::registration {

/// least_mm: least sigma_mm, > 0.
ShapeNoise shape_noise(const ShapeCurvature& at, double discrepancy_mm, double least_mm);

ShapeStrain shape_strain(const ReferencePoints& points, const ShapeField& shape,
                         const Transform<frames::Ct, frames::Reference>& pose,
                         const ShapeCurvature& at, const ShapeNoise& noise);

}  // namespace nav::registration
