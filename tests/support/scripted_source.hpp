// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "nav/source.hpp"

namespace nav::test {

inline Timestamp at_ms(int value) { return Timestamp(std::chrono::milliseconds(value)); }

/// Identity pose of a tool at a position, mm, acquired and received at one time.
inline RawPose pose_at(int ms, const Eigen::Vector3d& position_mm = Eigen::Vector3d::Zero()) {
  RawPose raw{at_ms(ms), at_ms(ms), TrackingStatus::kOk, Eigen::Matrix4d::Identity()};
  raw.tracker_from_body.topRightCorner<3, 1>() = position_mm;
  return raw;
}

/// Image of 2 x 2 pixels, acquired and received at one time.
inline UltrasoundImage image_at(std::uint64_t sequence, int ms) {
  return {.acquired = at_ms(ms),
          .received = at_ms(ms),
          .sequence = sequence,
          .pixels = Image2d<std::uint8_t>(2, 2, {1, 2, 3, 4}),
          .grid = PixelGrid::centred(2, 1, 1)};
}

/// Source with samples that the test wrote down; then it ends, fails, or throws.
class ScriptedSource final : public Source {
 public:
  explicit ScriptedSource(std::vector<StreamInfo> streams) : streams_(std::move(streams)) {}

  /// Probe, reference and images.
  static ScriptedSource usual() {
    return ScriptedSource({{"Probe", StreamKind::kPoses, ToolRole::kProbe},
                           {"Reference", StreamKind::kPoses, ToolRole::kReference},
                           {"Image", StreamKind::kImages, ToolRole::kOther}});
  }
  template <class What>
  void add(std::size_t stream, int received_ms, What what) {
    samples_.push_back({.stream = stream,
                        .sequence = count_++,
                        .received = at_ms(received_ms),
                        .what = std::move(what)});
  }
  /// Adds a sample that the device stamped.
  template <class What>
  void add_stamped(std::size_t stream, Timestamp received, DeviceTime stamp, What what) {
    samples_.push_back({.stream = stream,
                        .sequence = count_++,
                        .received = received,
                        .device_time = stamp,
                        .what = std::move(what)});
  }
  void then(std::function<Error()> end) { end_ = std::move(end); }

  [[nodiscard]] const std::vector<StreamInfo>& streams() const override { return streams_; }
  Result<Sample> next(Deadline deadline) override {
    if (samples_.empty()) return end_();
    if (samples_.front().received > deadline) return Error{ErrorCode::kTimeout, "script: later"};
    Sample sample = std::move(samples_.front());
    samples_.pop_front();
    return sample;
  }
  void stop() noexcept override {}

 private:
  std::vector<StreamInfo> streams_;
  std::deque<Sample> samples_;
  std::uint64_t count_ = 0;
  std::function<Error()> end_ = [] { return Error{ErrorCode::kEndOfStream, "script: the end"}; };
};

}  // namespace nav::test
