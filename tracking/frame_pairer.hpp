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

/// Options of the pairing of images and poses.
struct PairingOptions {
  /// Stamp of an image minus the stamp of a pose at the same moment. It is subtracted from the
  /// acquisition time of every image, here and nowhere else.
  Duration temporal_offset{0};
  /// Longest time that an image waits for its poses, from its reception.
  Duration max_wait = std::chrono::milliseconds(250);
  /// Longest time between two pose samples over which a pose is interpolated.
  Duration max_pose_gap = std::chrono::milliseconds(200);
  PoseGateOptions gate;
};

/// Rejects negative waits, gaps that are not positive, offsets beyond 10 s, and bad gate limits.
Result<void> validate(const PairingOptions& options);

/// Result of the pairing of one image.
struct PairedFrame {
  std::uint64_t sequence;
  std::optional<TrackedFrame> tracked;  ///< Absent when the image was rejected.
  std::string cause;                    ///< Stable name of the rejection; empty when paired.
};

/// Finds the pose of each image: reference_from_tracker(t) · tracker_from_probe(t) ·
/// probe_from_image, all on session time. It keeps the order and loses nothing: every image comes
/// out once, paired or rejected with a cause. Not thread-safe.
class FramePairer {
 public:
  /// \p fixed_reference_from_tracker: given when the patient is not tracked and the tracker itself
  /// was declared the reference. Precondition: validate(options), otherwise a Bug.
  FramePairer(
      const Transform<frames::Probe, frames::Image>& probe_from_image,
      std::optional<Transform<frames::Reference, frames::Tracker>> fixed_reference_from_tracker,
      const PairingOptions& options, Diagnostics& diagnostics);

  void add_probe_pose(const RawPose& raw);
  void add_reference_pose(const RawPose& raw);
  void add_frame(UltrasoundFrame frame);

  /// Images that are paired or rejected by \p now, in order of arrival. Pass end_of_stream at the
  /// end of a stream: images that still wait are then rejected, so that none is lost.
  std::vector<PairedFrame> take_ready(Timestamp now, bool end_of_stream = false);

  /// Number of poses that the gate rejected, by body and cause ("Probe.not_rigid").
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
