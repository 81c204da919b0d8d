// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "registration/shape/shape_field.hpp"
#include "registration/twist.hpp"

/// Disagreement of points and a shape beyond noise: errors of the segmentation, the calibration of
/// the pointer, or a bone that bent. Neighbouring points share it, which separates it from noise.
namespace nav::registration {

/// Standard deviation along one axis of the smooth part of the offsets, mm. It comes from the
/// products of offsets of different points within 15 mm cubes (a variogram without its nugget;
/// Matheron 1963), and is assumed equal along the axes that the shape does not show. 0 if the
/// products are within two standard errors of those of independent offsets, or if no cube holds two
/// points.
double shape_discrepancy_mm(const std::vector<Eigen::Vector3d>& places_ct_mm,
                            const std::vector<Eigen::Vector3d>& offsets_mm, ShapeKind kind);

/// Σ g gᵀ with g the sum of the scores in one cube, for cubes of 20, 40 and 80 mm about the centre:
/// returns the largest by its trace through the inverse curvature. The size of discrepancies is
/// unknown; blocks that are smaller than a discrepancy count it as many independent errors.
Matrix6d widest_block_scatter(const std::vector<Eigen::Vector3d>& places_ct_mm,
                              const std::vector<Vector6d>& scores,
                              const Eigen::Vector3d& centre_ct_mm, const Matrix6d& inverse,
                              double lever_mm);

}  // namespace nav::registration
