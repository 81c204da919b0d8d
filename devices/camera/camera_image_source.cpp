// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/camera/camera_image_source.hpp"

#include <algorithm>
#include <utility>

namespace nav::devices {
namespace {

/// Longest wait for a camera: stop() takes no longer.
constexpr Duration kCameraWait = std::chrono::milliseconds(20);

/// A driver that does not wait is asked no more often.
constexpr Duration kLeastWait = std::chrono::milliseconds(5);

}  // namespace

Result<void> validate(const ImageTimes& times) {
  const bool good = times.silence > Duration(0) && times.lost > times.silence &&
                    times.first_retry > Duration(0) && times.longest_retry >= times.first_retry;
  if (good) return {};
  return Error{ErrorCode::kUsage,
               "camera: expected times above 0, a time of loss longer than that of silence, and a "
               "longest retry of at least the first"};
}

CameraImageSource::CameraImageSource(std::string name, const ImageTimes& times, VideoOpener open,
                                     const Clock& clock, Diagnostics& diagnostics,
                                     const char* reporter)
    : ReopenedSource(std::move(name), {times.first_retry, times.longest_retry}, clock, diagnostics,
                     reporter),
      times_(times),
      open_(std::move(open)) {}

void CameraImageSource::advance(Timestamp now) {
  if (state() == SourceState::kEnded) {
    set_due(Timestamp::max());
  } else if (video_ == nullptr) {
    open_video_now(now);
  } else {
    read_image(now);
  }
}

void CameraImageSource::open_video_now(Timestamp now) {
  auto opened = open_();
  if (!opened) return lose({"unavailable", without_name(opened.error().message)});
  video_ = *std::move(opened);
  gave_image_ = false;
  heard_ = now;
  set_due(now);
  report(Severity::kInfo, video_->description());
  set_state(SourceState::kStarting);
}

void CameraImageSource::read_image(Timestamp now) {
  auto image = video_->next(kCameraWait);
  if (!image && image.error().code == ErrorCode::kEndOfStream) {
    video_.reset();
    set_cause("film_ended");
    set_state(SourceState::kEnded);
    set_due(Timestamp::max());
    return;
  }
  if (!image) return lose({"unplugged", without_name(image.error().message)});
  const Timestamp received = clock().now();
  if (!*image) {
    if (received - heard_ >= times_.lost) {
      const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(times_.lost).count();
      return lose({"silent", "no image has come for " + std::to_string(ms) + " ms"});
    }
    if (received - heard_ >= times_.silence) set_state(SourceState::kSilent);
    set_due(std::max(received, now + kLeastWait));
    return;
  }
  heard_ = received;
  const Duration period = video_->period();
  set_due(period > Duration(0) ? std::max(due(), now - period) + period : received);
  if (!std::exchange(gave_image_, true)) connected();
  count_bytes((*image)->pixels.pixels().size() + (*image)->colours.pixels().size_bytes());
  set_state(SourceState::kStreaming);
  const Timestamp acquired = received - (*image)->age;
  take(**std::move(image), acquired, received);
}

}  // namespace nav::devices
