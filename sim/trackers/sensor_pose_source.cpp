// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/trackers/sensor_pose_source.hpp"

#include <algorithm>
#include <cmath>

#include "nav/check.hpp"
#include "sim/random.hpp"

namespace nav::sim {
namespace {

constexpr std::uint64_t kJitterStream = 0x6a697474;
constexpr std::uint64_t kLossStream = 0x6c6f7373;

/// Time stamp of the device's clock at a session time.
Timestamp stamp(const TrackerTiming& timing, Timestamp begin, Timestamp time) {
  const Duration drift = from_seconds(1e-6 * timing.drift_ppm * to_seconds(time - begin));
  const Timestamp exact = time + timing.clock_offset + drift;
  if (timing.stamp_step == Duration(0)) return exact;
  const double steps = to_seconds(exact) / to_seconds(timing.stamp_step);
  return Timestamp(static_cast<std::int64_t>(std::llround(steps)) * timing.stamp_step);
}

}  // namespace

Result<void> validate(const TrackerTiming& timing) {
  const auto reject = [](const char* what) {
    return Error{ErrorCode::kUsage, std::string("tracker timing: expected ") + what};
  };
  if (!(timing.rate_hz > 0 && timing.rate_hz <= 10000)) return reject("rate_hz in (0, 10000]");
  if (timing.latency < Duration(0)) return reject("latency >= 0");
  if (timing.jitter < Duration(0)) return reject("jitter >= 0");
  if (timing.stamp_step < Duration(0)) return reject("stamp_step >= 0");
  if (!(std::abs(timing.drift_ppm) <= 1e4)) return reject("a drift within 10 000 ppm");
  if (!(timing.loss_begins >= 0 && timing.loss_begins <= 1)) return reject("loss_begins in [0, 1]");
  if (!(timing.loss_ends > 0 && timing.loss_ends <= 1)) return reject("loss_ends in (0, 1]");
  return {};
}

SensorPoseSource::SensorPoseSource(const SensorStream& stream) {
  const auto ok = validate(stream.timing);
  NAV_CHECK(ok.has_value(), ok.has_value() ? "" : ok.error().message);
  NAV_CHECK(stream.sensor && stream.truth);
  const TrackerTiming& timing = stream.timing;
  bool lost = false;
  for (std::uint64_t i = 0;; ++i) {
    const Timestamp time = stream.begin + from_seconds(static_cast<double>(i) / timing.rate_hz);
    if (time > stream.end) break;
    const auto unit = [&](std::uint64_t of) {
      return unit_from_bits(hash_bits(stream.seed, of + stream.body, i));
    };
    RawPose pose;
    pose.acquired = stamp(timing, stream.begin, time);
    pose.received =
        time + timing.latency + from_seconds(unit(kJitterStream) * to_seconds(timing.jitter));
    lost = lost ? unit(kLossStream) > timing.loss_ends : unit(kLossStream) <= timing.loss_begins;
    pose.status = TrackingStatus::kOccluded;
    if (!lost) {
      const Observation seen = stream.sensor->observe(stream.truth(time), stream.body, i);
      pose.status = seen.status;
      pose.tracker_from_body = seen.pose;
    }
    poses_.push_back(pose);
  }
  std::ranges::stable_sort(poses_, {}, &RawPose::received);
}

Timestamp SensorPoseSource::next_arrival() const {
  return position_ < poses_.size() ? poses_[position_].received : Timestamp::max();
}

Result<RawPose> SensorPoseSource::next(Deadline deadline) {
  constexpr const char* kName = "simulated tracker: ";
  if (stopped_) return Error{ErrorCode::kCancelled, std::string(kName) + "stopped"};
  if (position_ >= poses_.size()) {
    return Error{ErrorCode::kEndOfStream, std::string(kName) + "the recording time has ended"};
  }
  if (next_arrival() > deadline) {
    return Error{ErrorCode::kTimeout, std::string(kName) + "no sample before the deadline"};
  }
  return poses_[position_++];
}

}  // namespace nav::sim
