// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "sim/streams.hpp"

namespace nav::sim {

/// Kinds of faults of a stream. The last four exist only for poses.
enum class FaultKind {
  kDrop,          ///< Several samples in a row never arrive.
  kDuplicate,     ///< A sample arrives twice.
  kReorder,       ///< A sample arrives after its successor.
  kFutureStamp,   ///< One stamp is in the future.
  kClockStep,     ///< The device's clock is set, and later set back.
  kStall,         ///< Nothing arrives for a while, then everything at once.
  kEmpty,         ///< An image without pixels; for poses: a status without a pose.
  kNan,           ///< A number of the pose is NaN.
  kFlip,          ///< Markers are confused: a half turn about the body.
  kMirror,        ///< A column changes its sign, which gives a reflection.
  kDenormalised,  ///< The quaternion's norm is wrong, so the matrix scales.
};
const char* to_string(FaultKind kind);

/// Probability of each fault at each sample, and its size. The same plan has the same effect on the
/// same stream. All probabilities are 0 by default.
struct FaultPlan {
  std::uint64_t seed = 1;
  double drop = 0, duplicate = 0, reorder = 0, future_stamp = 0, clock_step = 0, stall = 0,
         empty = 0, nan = 0, flip = 0, mirror = 0, denormalised = 0;
  int drop_samples = 8;                                    ///< Length of a burst, >= 1.
  Duration future = std::chrono::milliseconds(400);        ///< Shift of a stamp, > 0.
  Duration step = std::chrono::milliseconds(150);          ///< Step of the clock; not 0.
  int step_samples = 40;                                   ///< Samples until set back, >= 1.
  Duration stall_length = std::chrono::milliseconds(300);  ///< > 0.
  double norm = 1.02;                                      ///< Norm of a wrong quaternion.

  /// Plan with the same probability for every fault.
  static FaultPlan everything(double chance, std::uint64_t seed);
  /// Parses a command line: one probability for all ("0.01"), or each by name
  /// ("drop=0.02,nan=0.001"). Rejects other texts, with the list of names, and probabilities
  /// outside [0, 1].
  static Result<FaultPlan> from(std::string_view text, std::uint64_t seed);
};

/// Rejects a plan with a value out of range; the message names the first one.
Result<void> validate(const FaultPlan& plan);

/// A fault that was inserted into a stream.
struct FaultRecord {
  FaultKind kind;
  std::uint64_t sample;  ///< Number in the unchanged stream, from 0.
  Timestamp received;    ///< Reception of the unchanged sample.
};

namespace detail {
/// Inserts faults into one stream of poses or images: each item comes out late, changed, twice or
/// never, in order of arrival.
template <class Item>
class FaultInjector {
 public:
  FaultInjector(const FaultPlan& plan, std::uint64_t stream) : plan_(plan), stream_(stream) {}
  void push(Item item);
  /// Releases the items that were held back; to be called at the end of the stream.
  void flush();
  [[nodiscard]] const Item* front() const { return ready_.empty() ? nullptr : &ready_.front(); }
  Item pop();
  [[nodiscard]] const std::vector<FaultRecord>& faults() const { return faults_; }

 private:
  [[nodiscard]] bool happens(FaultKind kind, double chance, Timestamp received);
  void spoil(Item& item);
  void spoil_time(Item& item, Timestamp received);
  void release(Item item);

  FaultPlan plan_;
  std::uint64_t stream_;
  std::uint64_t sample_ = 0;
  int dropping_ = 0;
  int stepped_ = 0;
  Timestamp stalled_until_ = Timestamp::min();
  std::deque<Item> held_;
  std::deque<Item> ready_;
  std::vector<FaultRecord> faults_;
};
}  // namespace detail

/// Pose source with faults; the rules of the wrapped source apply. Not thread-safe.
class FaultyPoseSource final : public PoseStream {
 public:
  /// \p stream distinguishes sources with the same plan. Precondition: validate(plan).
  FaultyPoseSource(std::unique_ptr<PoseStream> source, const FaultPlan& plan,
                   std::uint64_t stream = 0);
  Result<RawPose> next(Deadline deadline) override;
  void stop() noexcept override { source_->stop(); }
  [[nodiscard]] const std::vector<FaultRecord>& faults() const { return injector_.faults(); }

 private:
  std::unique_ptr<PoseStream> source_;
  detail::FaultInjector<RawPose> injector_;
};

/// Source of images with faults; see FaultyPoseSource.
class FaultyImageSource final : public ImageStream {
 public:
  FaultyImageSource(std::unique_ptr<ImageStream> source, const FaultPlan& plan,
                    std::uint64_t stream = 100);
  Result<UltrasoundImage> next(Deadline deadline) override;
  void stop() noexcept override { source_->stop(); }
  [[nodiscard]] const std::vector<FaultRecord>& faults() const { return injector_.faults(); }

 private:
  std::unique_ptr<ImageStream> source_;
  detail::FaultInjector<UltrasoundImage> injector_;
};

}  // namespace nav::sim
