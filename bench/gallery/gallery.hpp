// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "app/console.hpp"
#include "nav/result.hpp"

namespace nav::bench {

struct GalleryOptions {
  std::filesystem::path out;  ///< Folder for the images.
  std::string engine = "cpu";
  std::string only;  ///< Images whose name contains this; empty: all.
  int width = 600;   ///< Pixels, [16, 4096].
  int height = 450;  ///< Pixels, [16, 4096].
};

/// Draws the images of docs/gallery.md: Figures 2, 3, 5, 6, 7 and 8 of Burns et al. 2007
/// re-created on simulated patients and, where SONDE_DATA_DIR has it, a public CT angiography; then
/// draw_contextual_gallery(), draw_registration_gallery(), draw_simulator_gallery() and
/// draw_predicate_gallery(). kUsage if only is part of no image's name.
Result<void> run_gallery(const GalleryOptions& options, app::Console& console);

}  // namespace nav::bench
