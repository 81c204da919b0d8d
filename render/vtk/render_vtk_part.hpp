// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "render/engine.hpp"
#include "render/vtk/vtk_text.hpp"

namespace nav::render {

/// The functions of nav_render_vtk, as sonde-vtk.so exports them (nav_with_vtk_part in
/// cmake/NavLibrary.cmake).
struct VtkPart {
  Result<std::unique_ptr<Engine>> (*make_gl_engine)(Diagnostics&, const GlOptions&);
  TextMask (*rasterise_text)(const std::string&, int);
  bool (*is_drawn)(const Letter&);
  std::string (*drawable_text)(const std::string&);
};

}  // namespace nav::render
