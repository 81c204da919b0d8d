// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>

#include "nav/diagnostics.hpp"
#include "tracking/pose_buffer.hpp"
#include "tracking/pose_gate.hpp"
#include "tracking/stream_ledger.hpp"

namespace nav::tracking {

/// The recent poses of one tracked body: one gate that judges each pose once, one buffer, one
/// ledger. Not thread-safe.
template <class Body>
class ToolPoses {
 public:
  /// \p max_gap: longest time between neighbours that may be bridged, > 0. \p diagnostics must
  /// outlive it.
  ToolPoses(const PoseGateOptions& gate, Duration max_gap, Diagnostics& diagnostics)
      : gate_(gate), buffer_(kCapacity, max_gap), diagnostics_(diagnostics) {}

  void add(const RawPose& raw) {
    ledger_.receive();
    const Admission<Body> admission = gate_.admit(raw);
    if (admission.rejection) {
      ledger_.reject(to_string(*admission.rejection));
    } else {
      ledger_.deliver();
    }
    if (!admission.message.empty()) {
      diagnostics_.report(Severity::kWarning, "tracking.gate", admission.message);
    }
    if (admission.finding) diagnostics_.report("tracking.gate", *admission.finding);
    // A pose at a time that is taken already, or not believed, says nothing new. Any other absence
    // is kept, so that nothing is interpolated across it.
    if (has_usable_time(admission.rejection)) buffer_.push(admission.pose);
  }

  /// Counts a pose whose time stamp is of no use.
  void reject(const std::string& cause) {
    ledger_.receive();
    ledger_.reject(cause);
  }

  [[nodiscard]] const PoseBuffer<Body>& buffer() const { return buffer_; }
  void set_max_gap(Duration max_gap) { buffer_.set_max_gap(max_gap); }
  [[nodiscard]] const StreamLedger& ledger() const { return ledger_; }

 private:
  static constexpr std::size_t kCapacity = 1024;

  PoseGate<Body> gate_;
  PoseBuffer<Body> buffer_;
  Diagnostics& diagnostics_;
  StreamLedger ledger_;
};

}  // namespace nav::tracking
