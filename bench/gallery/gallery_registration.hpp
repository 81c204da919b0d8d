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
std::vector<std::string> registration_gallery_names();

/// Draws the images of docs/gallery.md that show a registration from a start 40 mm off, without
/// landmarks: checkerboards of ultrasound and CT along the sweep, before and after, and the
/// expected target error over CT slices. Says the numbers of the captions. Simulated.
Result<void> draw_registration_gallery(const GalleryOptions& options, app::OutputFolder& folder,
                                       app::Console& console);

}  // namespace nav::bench
