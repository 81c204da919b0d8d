// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "devices/camera/camera_image_source.hpp"
#include "devices/camera/marker_finder.hpp"

namespace nav::devices {

/// A body that a camera tracks by its markers.
struct MarkerStream {
  std::string name;  ///< Name of its stream.
  ToolRole role = ToolRole::kOther;
};

struct MarkerSourceOptions {
  std::vector<MarkerStream> streams{};  ///< Bodies, in the order of the tools of the finder.
  ImageTimes times{};
  double most_residual_px = 2;  ///< A pose whose corners lie farther off is no pose, > 0.
};
/// Rejects no bodies, empty names, and numbers out of range.
Result<void> validate(const MarkerSourceOptions& options);

/// Poses of printed markers in the images of one camera, whose frame is the tracker: x to the
/// right, y down, z along the view, mm. A sample of every body for every image:
///   - kOk with the error by the residuals of the corners;
///   - kUnknown, so that it is degraded, where the pose is ambiguous: a flat pattern that is seen
///     from the front may be tilted either way ("ambiguous");
///   - kOccluded without a matrix where no marker of the body is seen; kInvalid where the corners
///   do
///     not fit any pose ("bad_fit").
/// An image that equals the one before to the last byte is not new: it gives no samples
/// ("repeated_image"). It has no thread of its own: call next() from a thread that does nothing
/// else.
class MarkerSource final : public CameraImageSource {
 public:
  /// \p name: of the camera in messages, such as "/dev/video0". Errors: those of validate().
  static Result<std::unique_ptr<MarkerSource>> create(MarkerSourceOptions options, std::string name,
                                                      VideoOpener open,
                                                      std::unique_ptr<MarkerFinder> finder,
                                                      const Clock& clock, Diagnostics& diagnostics);

 private:
  MarkerSource(MarkerSourceOptions options, std::string name, VideoOpener open,
               std::unique_ptr<MarkerFinder> finder, const Clock& clock, Diagnostics& diagnostics);
  void take(VideoImage image, Timestamp acquired, Timestamp received) override;
  PoseSample pose_of(std::size_t body, const MarkerReading& reading);

  MarkerSourceOptions options_;
  std::unique_ptr<MarkerFinder> finder_;
  Image2d<std::uint8_t> before_;
  std::uint64_t sequence_ = 0;
};

}  // namespace nav::devices
