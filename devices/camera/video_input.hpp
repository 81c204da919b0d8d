// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "nav/image.hpp"
#include "nav/result.hpp"
#include "nav/time.hpp"

namespace nav::devices {

/// A image of a camera.
struct VideoImage {
  Image2d<std::uint8_t> pixels;  ///< Brightness.
  /// Colours, of the size of pixels, which are their luma; empty: grey, or not asked for.
  Image2d<Rgb8> colours{};
  Duration age{0};  ///< Time since the driver stamped it; 0: it gives no stamp.
};

/// An open camera, or a film. Not thread-safe.
class VideoInput {
 public:
  virtual ~VideoInput() = default;
  /// Waits for the next image of a camera, at most so long (not negative). Absent: none came. A
  /// film gives its next image at once. Errors: kEndOfStream at the end of a film; kUnavailable
  /// for a camera that is gone.
  virtual Result<std::optional<VideoImage>> next(Duration longest) = 0;
  /// Time between two images of a film; 0 for a camera.
  [[nodiscard]] virtual Duration period() const = 0;
  /// "1280 x 720 pixels, 30 images a second, YUYV".
  [[nodiscard]] virtual std::string description() const = 0;
};

struct VideoOptions {
  /// Path of a video device (/dev/video0), of a film, or of numbered images (frame_%03d.png).
  std::string path{};
  bool is_device = true;  ///< False: a film or images.
  int width = 0;          ///< Asked of a camera; 0: as it is.
  int height = 0;
  double rate_hz = 0;    ///< Asked of a camera; pace of a film. 0: as it is.
  bool colours = false;  ///< Keep the colours.
};
/// Errors name the path: kNotFound, kUnavailable (permission, in use, not a camera, a format that
/// was not granted, a build without cameras).
Result<std::unique_ptr<VideoInput>> open_video(const VideoOptions& options);

}  // namespace nav::devices
