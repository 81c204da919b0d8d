// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Part of sonde-vtk.so only.
#include "render/vtk/render_vtk_part.hpp"

extern "C" __attribute__((visibility("default"))) const void* sonde_render_vtk_part() {
  static const nav::render::VtkPart part{.make_gl_engine = nav::render::make_gl_engine,
                                         .rasterise_text = nav::render::rasterise_text,
                                         .is_drawn = nav::render::is_drawn,
                                         .drawable_text = nav::render::drawable_text};
  return &part;
}
