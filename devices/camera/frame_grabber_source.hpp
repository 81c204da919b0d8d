// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "devices/camera/camera_image_source.hpp"

namespace nav::devices {

/// A rectangle of an image, pixels.
struct PixelArea {
  int left = 0, top = 0, width = 0, height = 0;
};

struct FrameGrabberOptions {
  std::string image = "Image";  ///< Name of the stream.
  std::optional<PixelArea>
      crop{};  ///< Part of the screen that is the ultrasound image; absent: all of it.
  ImageTimes times{};
};
/// Rejects an empty name, an empty or negative crop, and times out of range.
Result<void> validate(const FrameGrabberOptions& options);

/// The screen of a scanner by a frame grabber. The pixel spacing is 1 mm, which says that it is not
/// known: a calibration gives it. Colours are those of the screen. An image that does not hold the
/// crop is a missing image
/// ("crop"). It has no thread of its own: call next() from a thread that does nothing else.
class FrameGrabberSource final : public CameraImageSource {
 public:
  /// \p name: of the grabber in messages, such as "/dev/video0". Errors: those of validate().
  static Result<std::unique_ptr<FrameGrabberSource>> create(FrameGrabberOptions options,
                                                            std::string name, VideoOpener open,
                                                            const Clock& clock,
                                                            Diagnostics& diagnostics);

 private:
  FrameGrabberSource(FrameGrabberOptions options, std::string name, VideoOpener open,
                     const Clock& clock, Diagnostics& diagnostics);
  void take(VideoImage image, Timestamp acquired, Timestamp received) override;

  FrameGrabberOptions options_;
  std::uint64_t sequence_ = 0;
};

}  // namespace nav::devices
