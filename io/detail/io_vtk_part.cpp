// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Part of sonde-vtk.so only.
#include "io/detail/io_vtk_part.hpp"

#include "io/detail/surface_cursor.hpp"

extern "C" __attribute__((visibility("default"))) const void* sonde_io_vtk_part() {
  static const nav::io::detail::VtkPart part{.read_ct_dicom = nav::io::detail::read_ct_dicom,
                                             .read_stl = nav::io::detail::read_stl};
  return &part;
}
