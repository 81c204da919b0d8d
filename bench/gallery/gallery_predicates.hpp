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
std::vector<std::string> predicate_gallery_names();

/// Draws the images of docs/gallery.md that show 3D ultrasound by predicates: Figures 1 and 5 to 9
/// of Schulte zu Berge et al. 2014 on simulated patients, and the same ideas on recorded volumes
/// where SONDE_DATA_DIR has them. Each part is 0.7 of the width and 0.8 of the height of an image.
Result<void> draw_predicate_gallery(const GalleryOptions& options, app::OutputFolder& folder,
                                    app::Console& console);

}  // namespace nav::bench
