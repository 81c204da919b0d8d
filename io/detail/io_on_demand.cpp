// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// In place of nav_io_vtk: each function loads sonde-vtk.so and calls its own there.
#include "io/detail/io_vtk_part.hpp"
#include "io/detail/surface_cursor.hpp"
#include "nav/on_demand.hpp"

namespace nav::io::detail {
namespace {

const Result<const void*>& loaded() {
  static const Result<const void*> part = functions_on_demand(
      library_of_program("sonde-vtk.so", SONDE_VTK_FOLDER), "sonde_io_vtk_part");
  return part;
}
const VtkPart& part() { return *static_cast<const VtkPart*>(*loaded()); }

}  // namespace

Result<StoredVolume> read_ct_dicom(const std::vector<std::filesystem::path>& files,
                                   const std::string& name, Diagnostics& diagnostics,
                                   const VolumeReading& options) {
  if (!loaded()) return loaded().error();
  return part().read_ct_dicom(files, name, diagnostics, options);
}

Result<TriangleMesh> read_stl(const std::filesystem::path& path, std::string_view content) {
  if (!loaded()) return loaded().error();
  return part().read_stl(path, content);
}

}  // namespace nav::io::detail
