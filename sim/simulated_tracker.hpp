// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "sim/procedure.hpp"
#include "sim/streams.hpp"

namespace nav::sim {

enum class TrackedBody { kProbe, kReference, kNeedle };

/// Poses of one body of a procedure on the virtual clock: no threads, no waiting. next(deadline)
/// returns the next pose that arrives by the deadline, else kTimeout; kEndOfStream after the last,
/// kCancelled after stop(). Occluded samples have a status and NaN, never an old pose or identity.
/// The stream begins half a second before the first image and ends half a second after the last.
/// Not thread-safe.
class SimulatedTracker final : public PoseStream {
 public:
  /// Uses the noise, latency and seed of the procedure's options.
  SimulatedTracker(const Procedure& procedure, TrackedBody body);
  Result<RawPose> next(Deadline deadline) override;
  void stop() noexcept override { stopped_ = true; }
  /// Arrival of the next pose; Timestamp::max() after the last.
  [[nodiscard]] Timestamp next_arrival() const;

 private:
  std::vector<RawPose> poses_;  ///< Poses in order of arrival.
  std::size_t position_ = 0;
  bool stopped_ = false;
};

/// Images of a procedure on the virtual clock; the rules of SimulatedTracker apply. The needle is
/// visible during the approach.
class SimulatedProbe final : public ImageStream {
 public:
  /// The procedure must outlive the source.
  explicit SimulatedProbe(const Procedure& procedure);
  Result<UltrasoundFrame> next(Deadline deadline) override;
  void stop() noexcept override { stopped_ = true; }
  /// Arrival of the next image; Timestamp::max() after the last.
  [[nodiscard]] Timestamp next_arrival() const;
  [[nodiscard]] const UltrasoundSimulator& simulator() const { return simulator_; }

 private:
  const Procedure* procedure_;
  UltrasoundSimulator simulator_;
  int position_ = 0;
  bool stopped_ = false;
};

}  // namespace nav::sim
