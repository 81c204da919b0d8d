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
std::vector<std::string> contextual_gallery_names();

/// Draws the images of docs/gallery.md by the default appearance: the cutaway of Burns et al. 2007,
/// Figure 5, on the recorded CT of an abdomen and on the recorded CT angiography, about a coronal
/// slice of themselves; vessels as fixed windows and fitted to the scan; an MR in which fat is
/// important and one in which it is not. Recorded volumes are skipped, with a warning, where
/// SONDE_DATA_DIR lacks them.
Result<void> draw_contextual_gallery(const GalleryOptions& options, app::OutputFolder& folder,
                                     app::Console& console);

}  // namespace nav::bench
