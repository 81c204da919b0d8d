// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "nav/result.hpp"
#include "nav/volume.hpp"
#include "registration/shape/shape.hpp"

namespace nav::registration {

/// CT value that separates bone from soft tissue, HU: half way from the commonest value of soft
/// tissue to the median of what is far brighter, 150 to 700. Absent if hardly a voxel is bone.
std::optional<double> bone_threshold_hu(const Volume& ct);

/// The outer surface of all bone in a CT: one piece with its outward normal (against the gradient)
/// where an edge between neighbouring voxels crosses the threshold, by linear interpolation. Outer
/// is what the largest connected part of the rest touches, so that walls of marrow do not count.
/// Pieces outside within are left out. Errors: kMalformedData if the CT shows no bone there.
Result<Shape> bone_surface(const Volume& ct, double threshold_hu,
                           const std::pair<Eigen::Vector3d, Eigen::Vector3d>& within_ct_mm);

/// Turns the normals of a closed mesh's pieces outwards: the sign of its volume decides.
/// Precondition: the mesh was accepted by surface_shape().
Result<Shape> outward_shape(const TriangleMesh& mesh, double spacing_mm);

}  // namespace nav::registration
