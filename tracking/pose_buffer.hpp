// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "nav/pose.hpp"

namespace nav::tracking {

/// Reason why there is no pose at a time.
enum class PoseAbsence {
  kNotYet,      ///< Later than the newest sample: it may still arrive. Poses are never
                ///< extrapolated.
  kTooOld,      ///< Earlier than the oldest stored sample.
  kNotTracked,  ///< A neighbouring sample has no pose (occluded, rejected).
  kGap,         ///< The neighbouring samples are too far apart in time.
};
const char* to_string(PoseAbsence absence);

/// Pose at a time between two measured samples.
template <class Body>
struct PoseAt {
  Transform<frames::Tracker, Body> tracker_from_body;
  Duration gap;     ///< Time to the nearer measured sample, >= 0; 0: exact.
  PoseDoubt doubt;  ///< First doubt of the contributing samples that is not kNone.
};

/// Recent poses of one body, in time order. Poses are interpolated, never extrapolated. The memory
/// is fixed: no allocation after construction. Not thread-safe.
template <class Body>
class PoseBuffer {
 public:
  /// \p capacity >= 2 samples. \p max_gap > 0: longest time between neighbours that is
  /// interpolated.
  explicit PoseBuffer(std::size_t capacity = 512, Duration max_gap = std::chrono::milliseconds(200))
      : max_gap_(max_gap) {
    NAV_CHECK(capacity >= 2 && max_gap > Duration::zero(), capacity, max_gap.count());
    samples_.resize(capacity);
  }

  /// Precondition: later than every earlier sample, otherwise a Bug (the gate ensures it).
  void push(TrackedPose<Body> pose) {
    NAV_CHECK(size_ == 0 || pose.acquired > sample(size_ - 1).acquired);
    if (pose.tracker_from_body) ++admitted_;
    samples_[(begin_ + size_) % samples_.size()] = std::move(pose);
    if (size_ < samples_.size()) {
      ++size_;
    } else {
      begin_ = (begin_ + 1) % samples_.size();
    }
  }

  void set_max_gap(Duration max_gap) {
    NAV_CHECK(max_gap > Duration::zero(), max_gap.count());
    max_gap_ = max_gap;
  }

  /// Pose at \p time, or the reason why there is none.
  [[nodiscard]] std::variant<PoseAt<Body>, PoseAbsence> at(Timestamp time) const {
    if (size_ == 0 || time > sample(size_ - 1).acquired) return PoseAbsence::kNotYet;
    if (time < sample(0).acquired) return PoseAbsence::kTooOld;
    const std::size_t after = first_not_before(time);
    const TrackedPose<Body>& b = sample(after);
    if (b.acquired == time) {
      if (!b.tracker_from_body) return PoseAbsence::kNotTracked;
      PoseDoubt found = doubt(b);
      if (found == PoseDoubt::kNone && admitted_ == 1) found = PoseDoubt::kOnly;
      return PoseAt<Body>{*b.tracker_from_body, Duration::zero(), found};
    }
    const TrackedPose<Body>& a = sample(after - 1);
    if (!a.tracker_from_body || !b.tracker_from_body) return PoseAbsence::kNotTracked;
    const Duration span = b.acquired - a.acquired;
    if (span > max_gap_) return PoseAbsence::kGap;
    const Duration before = time - a.acquired;
    const double fraction = static_cast<double>(before.count()) / static_cast<double>(span.count());
    return PoseAt<Body>{interpolate(*a.tracker_from_body, *b.tracker_from_body, fraction),
                        std::min(before, span - before),
                        doubt(a) != PoseDoubt::kNone ? doubt(a) : doubt(b)};
  }

  [[nodiscard]] std::size_t size() const { return size_; }
  /// Newest sample with or without a pose; nothing when empty.
  [[nodiscard]] std::optional<TrackedPose<Body>> newest() const {
    if (size_ == 0) return std::nullopt;
    return sample(size_ - 1);
  }

 private:
  static PoseDoubt doubt(const TrackedPose<Body>& p) {
    if (p.doubt != PoseDoubt::kNone) return p.doubt;
    return p.status == TrackingStatus::kOk ? PoseDoubt::kNone : PoseDoubt::kNoStatus;
  }
  const TrackedPose<Body>& sample(std::size_t i) const {
    return *samples_[(begin_ + i) % samples_.size()];
  }
  std::size_t first_not_before(Timestamp time) const {
    std::size_t low = 0;
    std::size_t high = size_ - 1;
    while (low < high) {
      const std::size_t middle = (low + high) / 2;
      if (sample(middle).acquired < time) {
        low = middle + 1;
      } else {
        high = middle;
      }
    }
    return low;
  }

  Duration max_gap_;
  std::vector<std::optional<TrackedPose<Body>>> samples_;
  std::size_t begin_ = 0;
  std::size_t size_ = 0;
  std::uint64_t admitted_ = 0;  ///< Poses of the whole stream.
};

}  // namespace nav::tracking
