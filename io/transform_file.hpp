// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>

#include "nav/result.hpp"

namespace nav::io {

/// True for a name that ends as transform files of ITK do: .tfm.
bool is_transform_file(const std::filesystem::path& path);

/// Transform of a patient's frame to a CT, as 3D Slicer saves its linear transform nodes in text
/// files of ITK (.tfm).
///
/// The node is the one that moves what is tracked into the CT, "ReferenceToRas" of SlicerIGT.
/// ITK stores the direction that resamples an image, from the parent of the node, so that the file
/// maps points of the CT to points of the patient's frame; and it stores both in LPS, while 3D
/// Slicer takes the coordinates of a tracker as RAS. With F = diag(-1, -1, 1, 1) and the matrix M
/// of the file: ct_from_reference = (F M)⁻¹. Source: "Transform files" in the developer guide of
/// 3D Slicer.
///
/// Reads one transform: AffineTransform, MatrixOffsetTransformBase, Euler3DTransform,
/// VersorRigid3DTransform, VersorTransform, TranslationTransform or IdentityTransform in three
/// dimensions, with their centre of rotation. Returns ct_from_reference, mm, CT in LPS, which
/// need not be rigid. Errors: kMalformedData and kUnsupportedData, which name file and key; those
/// of read_file().
Result<Eigen::Matrix4d> read_ct_from_reference(const std::filesystem::path& path);

/// Writes ct_from_reference so that read_ct_from_reference() and 3D Slicer read it, as an
/// AffineTransform_double_3_3. Precondition: a rigid matrix. Errors: those of write_file().
Result<void> write_ct_from_reference(const Eigen::Matrix4d& ct_from_reference,
                                     const std::filesystem::path& path);

}  // namespace nav::io
