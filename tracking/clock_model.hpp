// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "nav/sample.hpp"
#include "nav/time.hpp"

namespace nav::tracking {

/// How the samples of a device are timed.
enum class ClockKind {
  kDevice,   ///< The device stamps its samples by a clock of its own.
  kCounter,  ///< The device counts its samples: device time is the count times the nominal period.
};

struct ClockModelOptions {
  ClockKind kind = ClockKind::kDevice;
  /// Largest difference from the usual delay of a sample, > 0. A larger one means that the clock
  /// was set, or that the sample was held up.
  Duration tolerance = std::chrono::milliseconds(60);
};

/// Fault of the time of one sample, which then says nothing about the clock.
enum class ClockFault {
  kRepeated,  ///< Device time equal to that of the sample before.
  kDisorder,  ///< A device time before that of the sample before.
  kEarly,     ///< Received sooner after its device time than the delay allows: the clock was set.
  kLate,      ///< Received later than usual: it was held up, or the clock was set back.
  kHeldUp,    ///< In time, but too soon after a late sample to be sure.
};
/// Stable name, for the ledger and reports.
const char* to_string(ClockFault fault);

enum class ClockState {
  kUnknown,   ///< No sample yet.
  kDegraded,  ///< The first two seconds of an epoch: offset and drift are not sure yet.
  kKnown,
};

/// Maps the clock of a device to the session clock. A sample is received some delay after its
/// device time. The delay has a floor and a long tail, so the model is the line below all samples
/// of the last two minutes that is nearest to them: an edge of their lower convex hull (Zhang, Liu
/// and Xia, "Clock synchronization algorithms for network measurements", INFOCOM 2002). Drift of up
/// to 500 ppm is followed. A lasting change of the delay, or a clock that was set, suspended or
/// restarted, begins a new epoch.
///
/// No clock model can see a constant delay between acquisition and reception: the mapped times are
/// late by the least delay. It is part of the temporal calibration.
///
/// A sample takes bounded time and no memory is allocated. Not thread-safe.
class ClockModel {
 public:
  /// Precondition: tolerance > 0, otherwise a Bug.
  explicit ClockModel(const ClockModelOptions& options = {});

  /// Result for one sample.
  struct Reading {
    Timestamp acquired;               ///< The device time on the session clock.
    std::optional<ClockFault> fault;  ///< Absent: the time can be believed.
    bool began_epoch = false;         ///< True for the sample that confirmed a new epoch.
  };
  /// Judges and maps a sample. Call it once for each sample, in order of reception.
  Reading add(DeviceTime device, Timestamp received);

  [[nodiscard]] ClockState state() const;
  /// The device time on the session clock. Precondition: state() is not kUnknown, otherwise a Bug.
  [[nodiscard]] Timestamp map(DeviceTime device) const;
  /// Session time minus device time, at the newest sample; includes the least delay.
  [[nodiscard]] Duration offset() const;
  /// Rate of the session clock relative to the device's clock minus 1, in parts per million.
  [[nodiscard]] double skew_ppm() const { return 1e6 * slope_; }
  /// Half width of the 95 % interval of skew_ppm(); infinite before two seconds.
  [[nodiscard]] double skew_ci95_ppm() const;
  /// 95th percentile of the delays above the floor, of the last 256 samples.
  [[nodiscard]] Duration residual_p95() const;
  /// Usual delay of a sample above the floor.
  [[nodiscard]] Duration usual_residual() const;
  /// Number of epochs after the first.
  [[nodiscard]] int steps() const { return steps_; }
  /// Sum of the changes of the offset at the beginnings of epochs, and by drift: offset() now minus
  /// that of the first sample's epoch at its beginning.
  [[nodiscard]] Duration change() const;

 private:
  /// A sample relative to the epoch's origin: device time, and delay, s.
  struct Point {
    double x = 0;
    double y = 0;
  };
  static constexpr std::size_t kBuckets = 240;
  static constexpr double kBucketSeconds = 0.5;
  static constexpr std::size_t kRun = 64;

  [[nodiscard]] Point point(DeviceTime device, Timestamp received) const;
  [[nodiscard]] double floor_at(double x) const { return base_ + slope_ * x; }
  void begin_epoch(DeviceTime device, Timestamp received);
  void learn(const Point& p);
  void fit();
  bool confirm_epoch(DeviceTime device, Timestamp received);

  struct RunSample {
    DeviceTime device;
    Timestamp received;
  };

  ClockModelOptions options_;
  double tolerance_s_;
  // The epoch.
  bool begun_ = false;
  DeviceTime device_origin_{};
  Timestamp origin_{};
  double span_s_ = 0;  ///< Device time from the epoch's first sample to its newest.
  std::uint64_t learned_ = 0;
  double base_ = 0;   ///< Floor of the delay at the epoch's origin, s.
  double slope_ = 0;  ///< Its slope.
  double usual_ = 0;  ///< Running median of the delays above the floor, s.
  // Least delays of the last two minutes.
  std::array<Point, kBuckets> buckets_{};
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  std::int64_t bucket_ = 0;  ///< Number of the newest bucket.
  std::array<float, 256> residuals_{};
  // The newest sample that fits, and the newest ones that do not.
  DeviceTime newest_{};
  bool late_ = false;
  std::optional<Timestamp> in_time_since_;
  std::array<RunSample, kRun> run_{};
  std::size_t run_count_ = 0;
  DeviceTime run_newest_{};
  int steps_ = 0;
  double changed_s_ = 0;      ///< Change of the floor from the first epoch's origin to the epoch's.
  double first_floor_s_ = 0;  ///< Floor at the first epoch's origin.
};

/// Extends a counter or clock that wraps to 64 bits. Not thread-safe.
class TickUnwrapper {
 public:
  /// \p bits: width of the device's counter, 1 to 64. \p tick: duration of a tick.
  TickUnwrapper(int bits, std::chrono::duration<double, std::nano> tick);
  /// Device time of a reading; from the one before by at most half a turn in either direction.
  DeviceTime add(std::uint64_t ticks);

 private:
  std::uint64_t mask_;
  std::chrono::duration<double, std::nano> tick_;
  std::optional<std::uint64_t> last_;
  std::int64_t total_ = 0;
};

}  // namespace nav::tracking
