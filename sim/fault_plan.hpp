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

/// What can go wrong with a stream. The last four are of poses only.
enum class FaultKind {
  kDrop,          ///< A burst of samples never arrives.
  kDuplicate,     ///< A sample arrives twice.
  kReorder,       ///< A sample arrives after its successor.
  kFutureStamp,   ///< One stamp lies in the future.
  kClockStep,     ///< The device's clock is set, and later set back.
  kStall,         ///< Nothing arrives for a while, then everything at once.
  kEmpty,         ///< A picture without pixels; of poses: a status without a pose.
  kNan,           ///< A number of the pose is NaN.
  kFlip,          ///< Markers are mistaken for each other: a half turn about the body.
  kMirror,        ///< A column changes its sign: a reflection.
  kDenormalised,  ///< The quaternion's norm is off, so the matrix scales.
};
const char* to_string(FaultKind kind);

/// When and how a stream fails: the chance of each fault at each sample, and its size. The same
/// plan does the same to the same stream. All chances are 0 by default.
struct FaultPlan {
  std::uint64_t seed = 1;
  double drop = 0, duplicate = 0, reorder = 0, future_stamp = 0, clock_step = 0, stall = 0,
         empty = 0, nan = 0, flip = 0, mirror = 0, denormalised = 0;
  int drop_samples = 8;                                    ///< Length of a burst, >= 1.
  Duration future = std::chrono::milliseconds(400);        ///< How far, > 0.
  Duration step = std::chrono::milliseconds(150);          ///< How far a clock is set; not 0.
  int step_samples = 40;                                   ///< Until it is set back, >= 1.
  Duration stall_length = std::chrono::milliseconds(300);  ///< > 0.
  double norm = 1.02;                                      ///< Of a de-normalised quaternion.

  /// Every fault with the same chance.
  static FaultPlan everything(double chance, std::uint64_t seed);
  /// From a command line: one chance for all ("0.01"), or each by name ("drop=0.02,nan=0.001").
  /// Refuses what is neither, with the names, and chances outside [0, 1].
  static Result<FaultPlan> from(std::string_view text, std::uint64_t seed);
};

/// A refusal that names the first value out of range.
Result<void> validate(const FaultPlan& plan);

/// A fault that was put into a stream.
struct FaultRecord {
  FaultKind kind;
  std::uint64_t sample;  ///< Of the untouched stream, from 0.
  Timestamp received;    ///< Of the untouched sample.
};

namespace detail {
/// Faults of one stream, for poses and pictures alike: what goes in comes out late, changed, twice
/// or never, in order of arrival.
template <class Item>
class FaultInjector {
 public:
  FaultInjector(const FaultPlan& plan, std::uint64_t stream) : plan_(plan), stream_(stream) {}
  void push(Item item);
  /// No more goes in: what was held back comes out.
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

/// A pose source with faults; rules of the source that it wraps. Not thread-safe.
class FaultyPoseSource final : public PoseStream {
 public:
  /// stream: tells sources with the same plan apart. Precondition: validate(plan).
  FaultyPoseSource(std::unique_ptr<PoseStream> source, const FaultPlan& plan,
                   std::uint64_t stream = 0);
  Result<RawPose> next(Deadline deadline) override;
  void stop() noexcept override { source_->stop(); }
  [[nodiscard]] const std::vector<FaultRecord>& faults() const { return injector_.faults(); }

 private:
  std::unique_ptr<PoseStream> source_;
  detail::FaultInjector<RawPose> injector_;
};

/// The same for pictures.
class FaultyFrameSource final : public ImageStream {
 public:
  FaultyFrameSource(std::unique_ptr<ImageStream> source, const FaultPlan& plan,
                    std::uint64_t stream = 100);
  Result<UltrasoundFrame> next(Deadline deadline) override;
  void stop() noexcept override { source_->stop(); }
  [[nodiscard]] const std::vector<FaultRecord>& faults() const { return injector_.faults(); }

 private:
  std::unique_ptr<ImageStream> source_;
  detail::FaultInjector<UltrasoundFrame> injector_;
};

}  // namespace nav::sim
