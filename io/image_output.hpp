// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "nav/image.hpp"
#include "nav/result.hpp"

namespace nav::io {

/// Writes an 8-bit RGBA PNG, atomically. Equal pixels give equal bytes. Rejects an empty image.
Result<void> write_png(const Image2d<Rgba8>& image, const std::filesystem::path& path);

/// Reads any PNG as 8-bit RGBA with straight alpha. Rejects more than 2^28 pixels.
Result<Image2d<Rgba8>> read_png(const std::filesystem::path& path);

struct AnimationOptions {
  bool lossless = false;
  float quality = 75;  ///< 0 (small) to 100; ignored when lossless.
};

/// Writes an animated WebP that repeats endlessly, atomically. Rejects an empty list, images of
/// different sizes, sides above 16383 pixels, and a duration outside [1, 60000] ms.
Result<void> write_animation(const std::vector<Image2d<Rgba8>>& frames, int frame_duration_ms,
                             const std::filesystem::path& path,
                             const AnimationOptions& options = {});

}  // namespace nav::io
