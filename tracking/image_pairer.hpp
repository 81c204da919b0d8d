// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "nav/diagnostics.hpp"
#include "nav/probe_calibration.hpp"
#include "nav/sweep.hpp"
#include "tracking/repeated_images.hpp"
#include "tracking/tool_poses.hpp"

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
struct PairedImage {
  std::uint64_t sequence;
  std::optional<TrackedImage> tracked;  ///< Absent when the image was rejected.
  std::string cause;                    ///< Stable name of the rejection; empty when paired.
};

/// Finds the pose of each image: reference_from_tracker(t) · tracker_from_probe(t) ·
/// probe_from_image, all on session time. It keeps the order and loses nothing: every image comes
/// out once, paired or rejected with a cause. Not thread-safe.
class ImagePairer {
 public:
  /// \p calibration: absent until add_calibration(). \p fixed_reference_from_tracker: given when
  /// the patient is not tracked and the tracker itself was declared the reference. Precondition:
  /// validate(options), otherwise a Bug.
  ImagePairer(
      const std::optional<ProbeCalibration>& calibration,
      std::optional<Transform<frames::Reference, frames::Tracker>> fixed_reference_from_tracker,
      const PairingOptions& options, Diagnostics& diagnostics);

  void add_probe_pose(const RawPose& raw) { probe_.add(raw); }
  void add_reference_pose(const RawPose& raw) { reference_.add(raw); }
  void reject_probe_pose(const std::string& cause) { probe_.reject(cause); }
  void reject_reference_pose(const std::string& cause) { reference_.reject(cause); }
  /// Another calibration, for images that no earlier one fits.
  void add_calibration(const ProbeCalibration& calibration) {
    calibrations_.push_back(calibration);
  }
  /// Waits for a stream of this period: an image waits three periods, and poses up to two periods
  /// apart are bridged, if that is longer than the options say.
  void expect_period(Duration period);
  void add_frame(UltrasoundImage frame);

  /// Images that are paired or rejected by \p now, in order of arrival. Pass end_of_stream at the
  /// end of a stream: images that still wait are then rejected, so that none is lost.
  std::vector<PairedImage> take_ready(Timestamp now, bool end_of_stream = false);

  [[nodiscard]] const ToolPoses<frames::Probe>& probe() const { return probe_; }
  [[nodiscard]] const ToolPoses<frames::Reference>& reference() const { return reference_; }
  /// One sentence while the newest image has a geometry that no calibration fits; else empty.
  [[nodiscard]] const std::string& without_calibration() const { return without_calibration_; }

 private:
  struct Waiting {
    UltrasoundImage frame;
    bool clock_believed;
    bool clock_off;  ///< Stamps are off the session clock by more than the tolerance.
  };
  std::optional<PairedImage> settle(const Waiting& waiting, Timestamp now, bool end_of_stream);

  std::vector<ProbeCalibration> calibrations_;
  std::optional<Transform<frames::Reference, frames::Tracker>> fixed_reference_from_tracker_;
  PairingOptions options_;
  Duration max_wait_;
  ToolPoses<frames::Probe> probe_;
  ToolPoses<frames::Reference> reference_;
  std::deque<Waiting> waiting_;
  ClockModel frame_clock_;
  RepeatedImages images_;
  std::optional<Timestamp> newest_frame_;
  std::string without_calibration_;
};

}  // namespace nav::tracking
