// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "nav/image.hpp"
#include "nav/result.hpp"

namespace nav::io {

/// Writes an 8-bit RGBA PNG, atomically. Same pixels, same bytes. Refuses an empty picture.
Result<void> write_png(const Image2d<Rgba8>& picture, const std::filesystem::path& path);

/// Reads any PNG as 8-bit RGBA with straight alpha. Refuses more than 2^28 pixels.
Result<Image2d<Rgba8>> read_png(const std::filesystem::path& path);

struct AnimationOptions {
  bool lossless = false;
  float quality = 75;  ///< 0 (small) to 100; ignored when lossless.
};

/// Writes an endless animated WebP, atomically. Refuses no frames, frames of different size, sides
/// beyond 16383 pixels, a duration outside [1, 60000] ms.
Result<void> write_animation(const std::vector<Image2d<Rgba8>>& frames, int frame_duration_ms,
                             const std::filesystem::path& path,
                             const AnimationOptions& options = {});

}  // namespace nav::io
