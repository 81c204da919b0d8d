// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// In place of nav_render_vtk: each function loads sonde-vtk.so and calls its own there.
#include "nav/on_demand.hpp"
#include "render/vtk/render_vtk_part.hpp"

namespace nav::render {
namespace {

const Result<const void*>& loaded() {
  static const Result<const void*> part = functions_on_demand(
      library_of_program("sonde-vtk.so", SONDE_VTK_FOLDER), "sonde_render_vtk_part");
  return part;
}
/// For functions that cannot return an error.
const VtkPart& part() {
  if (!loaded()) throw PartMissing(loaded().error().message);
  return *static_cast<const VtkPart*>(*loaded());
}

}  // namespace

Result<std::unique_ptr<Engine>> make_gl_engine(Diagnostics& diagnostics, const GlOptions& options) {
  if (!loaded()) return loaded().error();
  return part().make_gl_engine(diagnostics, options);
}

TextMask rasterise_text(const std::string& words, int size_px) {
  return part().rasterise_text(words, size_px);
}

bool is_drawn(const Letter& letter) { return part().is_drawn(letter); }

std::string drawable_text(const std::string& words) { return part().drawable_text(words); }

}  // namespace nav::render
