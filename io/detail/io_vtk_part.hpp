// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "io/detail/ct_readers.hpp"
#include "nav/triangle_mesh.hpp"

namespace nav::io::detail {

/// The functions of nav_io_vtk, as sonde-vtk.so exports them (nav_with_vtk_part in
/// cmake/NavLibrary.cmake).
struct VtkPart {
  Result<StoredVolume> (*read_ct_dicom)(const std::vector<std::filesystem::path>&,
                                        const std::string&, Diagnostics&, const VolumeReading&);
  Result<TriangleMesh> (*read_stl)(const std::filesystem::path&, std::string_view);
};

}  // namespace nav::io::detail
