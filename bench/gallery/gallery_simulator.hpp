// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "app/console.hpp"
#include "app/output_folder.hpp"
#include "bench/gallery/gallery.hpp"

namespace nav::bench {

/// Names of its images.
std::vector<std::string> simulator_gallery_names();

/// Draws the images of docs/simulator.md: simulated ultrasound by both acoustic models beside a
/// recorded image of like anatomy at the same scale. If SONDE_DATA_DIR lacks the recording its
/// panel says so.
Result<void> draw_simulator_gallery(const GalleryOptions& options, app::OutputFolder& folder,
                                    app::Console& console);

}  // namespace nav::bench
