// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "sim/streams.hpp"
#include "sim/procedure.hpp"

namespace nav::sim {

enum class TrackedBody { kProbe, kReference, kNeedle };

/// Poses of one body of a procedure on the virtual clock: no threads, no sleeping. next(deadline)
/// returns the next pose whose arrival is not after the deadline, else kTimeout; kEndOfStream after
/// the last. Occluded samples carry a status and NaN, never an old pose or identity. The stream
/// begins half a second before the first picture and ends as long after the last; kCancelled after
/// stop(). Not thread-safe.
class SimulatedTracker final : public PoseStream {
 public:
  /// Noise, latency and seed come from the procedure's options.
  SimulatedTracker(const Procedure& procedure, TrackedBody body);
  Result<RawPose> next(Deadline deadline) override;
  void stop() noexcept override { stopped_ = true; }
  /// When the next pose arrives; Timestamp::max() after the last.
  [[nodiscard]] Timestamp next_arrival() const;

 private:
  std::vector<RawPose> poses_;  ///< In order of arrival.
  std::size_t position_ = 0;
  bool stopped_ = false;
};

/// Pictures of a procedure on the virtual clock; rules as SimulatedTracker. The needle is visible
/// in the approach.
class SimulatedProbe final : public ImageStream {
 public:
  /// The procedure must outlive the source.
  explicit SimulatedProbe(const Procedure& procedure);
  Result<UltrasoundFrame> next(Deadline deadline) override;
  void stop() noexcept override { stopped_ = true; }
  /// When the next picture arrives; Timestamp::max() after the last.
  [[nodiscard]] Timestamp next_arrival() const;
  [[nodiscard]] const UltrasoundSimulator& simulator() const { return simulator_; }

 private:
  const Procedure* procedure_;
  UltrasoundSimulator simulator_;
  int position_ = 0;
  bool stopped_ = false;
};

}  // namespace nav::sim
