// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "devices/camera/video_input.hpp"
#include "devices/reopened_source.hpp"

namespace nav::devices {

/// Opens a camera; called for every attempt.
using VideoOpener = std::function<Result<std::unique_ptr<VideoInput>>()>;

/// Times of a camera.
struct ImageTimes {
  Duration silence = std::chrono::milliseconds(500);  ///< Without an image it is silent, > 0.
  Duration lost = std::chrono::seconds(3);            ///< Without an image it is lost, > silence.
  Duration first_retry = std::chrono::seconds(1);     ///< > 0; doubles with every failure.
  Duration longest_retry = std::chrono::seconds(5);   ///< >= first_retry.
};
/// Rejects times out of range.
Result<void> validate(const ImageTimes& times);

/// A camera, or a film that plays once at its own pace: connection, retries and times, for the
/// kinds of devices behind one. A film that has ended stays *ended*.
class CameraImageSource : public ReopenedSource {
 protected:
  CameraImageSource(std::string name, const ImageTimes& times, VideoOpener open, const Clock& clock,
                    Diagnostics& diagnostics, const char* reporter);

  /// Takes an image; next() alone calls it, on its thread. \p acquired: by the driver's stamp.
  virtual void take(VideoImage image, Timestamp acquired, Timestamp received) = 0;

 private:
  void advance(Timestamp now) final;
  [[nodiscard]] Watched watched() const final { return {.fd = -1}; }
  void attend(bool /*readable*/, bool /*writable*/) final {}
  void close() noexcept final { video_.reset(); }
  [[nodiscard]] bool is_open() const final { return video_ != nullptr; }
  void open_video_now(Timestamp now);
  void read_image(Timestamp now);

  ImageTimes times_;
  VideoOpener open_;

  // Used by next() only.
  std::unique_ptr<VideoInput> video_;  ///< Null: it is not open.
  Timestamp heard_{};                  ///< When an image came last, or the camera was opened.
  bool gave_image_ = false;            ///< This connection; only then does it count.
};

}  // namespace nav::devices
