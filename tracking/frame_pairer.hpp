// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "nav/diagnostics.hpp"
#include "nav/sweep.hpp"
#include "tracking/pose_buffer.hpp"
#include "tracking/pose_gate.hpp"

namespace nav::tracking {

/// How pictures meet poses.
struct PairingOptions {
  /// By how much picture stamps are later than pose stamps of the same moment. Subtracted from
  /// every picture's acquisition time, here and nowhere else.
  Duration temporal_offset{0};
  /// How long a picture waits, from its reception, for poses to arrive.
  Duration max_wait = std::chrono::milliseconds(250);
  /// Longest distance between two pose samples that may be bridged.
  Duration max_pose_gap = std::chrono::milliseconds(200);
  PoseGateOptions gate;
};

/// Refuses negative waits, gaps that are not positive, offsets beyond 10 s, bad gate limits.
Result<void> validate(const PairingOptions& options);

/// What became of one picture.
struct PairedFrame {
  std::uint64_t sequence;
  std::optional<TrackedFrame> tracked;  ///< Absent when rejected.
  std::string cause;                    ///< Stable name of the rejection; empty when paired.
};

/// Gives each picture the pose of its moment: reference_from_tracker(t) · tracker_from_probe(t) ·
/// probe_from_image, all on session time. Lossless and in order: every picture that goes in comes
/// out once, paired or rejected with a cause. Not thread-safe.
class FramePairer {
 public:
  /// fixed_reference_from_tracker: given when nothing tracks the patient and the tracker itself
  /// was declared to be the reference. Precondition: validate(options), otherwise a Bug.
  FramePairer(
      const Transform<frames::Probe, frames::Image>& probe_from_image,
      std::optional<Transform<frames::Reference, frames::Tracker>> fixed_reference_from_tracker,
      const PairingOptions& options, Diagnostics& diagnostics);

  void add_probe_pose(const RawPose& raw);
  void add_reference_pose(const RawPose& raw);
  void add_frame(UltrasoundFrame frame);

  /// Pictures whose fate is known at now, in order of arrival. At the end of a stream, pass
  /// end_of_stream: what still waits is rejected rather than lost.
  std::vector<PairedFrame> take_ready(Timestamp now, bool end_of_stream = false);

  /// Poses that the gate turned away, by body and cause ("Probe.not_rigid").
  [[nodiscard]] const std::map<std::string, std::uint64_t>& rejected_poses() const {
    return rejected_poses_;
  }

 private:
  struct Waiting {
    UltrasoundFrame frame;
    bool clock_believed;
  };
  template <class Body>
  void admit(PoseGate<Body>& gate, PoseBuffer<Body>& buffer, const RawPose& raw);
  std::optional<PairedFrame> settle(const Waiting& waiting, Timestamp now, bool end_of_stream);

  Transform<frames::Probe, frames::Image> probe_from_image_;
  std::optional<Transform<frames::Reference, frames::Tracker>> fixed_reference_from_tracker_;
  PairingOptions options_;
  Diagnostics& diagnostics_;
  PoseGate<frames::Probe> probe_gate_;
  PoseGate<frames::Reference> reference_gate_;
  PoseBuffer<frames::Probe> probe_poses_;
  PoseBuffer<frames::Reference> reference_poses_;
  std::deque<Waiting> waiting_;
  DelayWatch frame_delay_;
  std::optional<Timestamp> newest_frame_;
  std::map<std::string, std::uint64_t> rejected_poses_;
};

}  // namespace nav::tracking
