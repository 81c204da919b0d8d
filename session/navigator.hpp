// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>

#include "nav/plan.hpp"
#include "nav/probe_calibration.hpp"
#include "nav/safety.hpp"
#include "nav/sample.hpp"
#include "nav/sweep.hpp"
#include "tracking/image_pairer.hpp"
#include "tracking/period_estimator.hpp"
#include "tracking/pose_plausibility.hpp"
#include "tracking/stream_ledger.hpp"

namespace nav::session {

/// Pose of the CT, and how far it is believed.
struct CtPlacement {
  Transform<frames::Ct, frames::Reference> ct_from_reference;
  Safety safety;
};

/// Everything that one display refresh shows: all its views and numbers come from here.
struct Epoch {
  Timestamp now;
  std::optional<TrackedImage> frame;  ///< The newest paired image, however old.
  bool frame_is_new = false;          ///< True in the first refresh that has this image.
  Safety ultrasound;                  ///< Freshness and tracking of the image.
  Safety placement;                   ///< State of the CT's pose.
  Safety plane;                       ///< The image inside the CT: the worst of both.
  std::optional<Transform<frames::Ct, frames::Image>> ct_from_image;
  Safety needle;
  std::optional<Transform<frames::Ct, frames::Needle>> ct_from_needle;
  /// The instant at which needle and reference were composed: the newest that both have a pose for.
  std::optional<Timestamp> needle_acquired;
  /// Present only while the whole chain is valid; otherwise withdrawn.
  std::optional<NeedleGuidance> guidance;
  /// The tracker's own figure of the error of needle and reference together, RMS in mm, of their
  /// newest poses; absent: the tracker gives none for one of them.
  std::optional<double> tracker_error_mm{};
  /// Times at which the image and the needle become stale if nothing newer comes; absent without
  /// them.
  std::optional<Timestamp> ultrasound_until{}, needle_until{};
};

/// State of a tracked image apart from its age.
Safety tracking_safety(const TrackedImage& frame);
/// The epoch when no more samples come: live inputs become stale, lost inputs stay lost, and
/// numbers are withdrawn.
Epoch ended(Epoch epoch, const std::string& cause);

struct NavigatorOptions {
  tracking::PairingOptions pairing;
  /// Expected time between images and between needle poses; it decides when they are stale. Absent:
  /// learned from the stamps, and 50 ms until two have come.
  std::optional<Duration> frame_period = std::chrono::milliseconds(50);
  std::optional<Duration> needle_period = std::chrono::milliseconds(20);
};

/// The live part of a session: takes images and poses in, gives epochs out, and accounts for every
/// sample. It knows only what has arrived. One thread; time is an argument.
class Navigator {
 public:
  /// \p calibration: absent until add_calibration().
  Navigator(const std::optional<ProbeCalibration>& calibration,
            std::optional<Transform<frames::Reference, frames::Tracker>> fixed_reference,
            const NavigatorOptions& options, Diagnostics& diagnostics);

  /// Samples in order of arrival.
  void add_image(UltrasoundImage image);
  /// Role: kProbe, kReference or kNeedle; poses of other tools are of no use here.
  /// tracker_error_mm: the tracker's own figure of the error of this pose; absent: it gives none.
  void add_pose(ToolRole role, const RawPose& pose,
                std::optional<double> tracker_error_mm = std::nullopt);
  void add_missing(const MissingImage& missing);
  /// An image that a newer one superseded before it came here: it tells about the period.
  void saw_image(Timestamp acquired) { image_period_.add(acquired); }
  /// Trouble of the device that gives the images, or the poses of a tool; empty: none. Safety
  /// states that are not valid say it.
  void set_trouble(bool images, ToolRole role, const std::string& trouble) {
    (images ? images_trouble_ : poses_trouble_[role]) = trouble;
  }
  /// Counts a pose that cannot be used because of its time stamp.
  void reject_pose(ToolRole role, const std::string& cause);
  /// Another calibration of the probe, for images of another geometry.
  void add_calibration(const ProbeCalibration& calibration) {
    pairer_.add_calibration(calibration);
  }
  /// A stream has failed for good: whatever depends on it is lost from now on, by this cause.
  void lose_images(const std::string& cause) { images_lost_ = cause; }
  void lose_poses(ToolRole role, const std::string& cause) { poses_lost_[role] = cause; }

  /// Pairs the images that can be paired by now. Every settled image goes to the listener, in
  /// order.
  void settle(Timestamp now, bool end_of_stream,
              const std::function<void(const tracking::PairedImage&)>& listener);
  /// One display refresh. A new image counts as delivered; images between two refreshes count as
  /// superseded.
  Epoch refresh(Timestamp now);
  /// The epoch at a later time, if nothing came until then: old inputs are stale or lost, and their
  /// numbers are withdrawn.
  [[nodiscard]] Epoch aged(Epoch epoch, Timestamp now) const;
  /// Pose of the needle at a time; absent if it had none.
  [[nodiscard]] std::optional<Transform<frames::Ct, frames::Needle>> needle_at(
      Timestamp time) const;
  /// Pose of a tracked body at a time, as it was measured: interpolated, after clock and gate.
  /// Absent if it had none. Role as in add_pose().
  [[nodiscard]] std::optional<Eigen::Matrix4d> tracker_from(ToolRole role, Timestamp time) const;
  /// Ends the session: an image that no refresh has shown counts as superseded.
  void finish();

  void set_placement(CtPlacement placement) { placement_ = std::move(placement); }
  void set_plan(const NeedlePlan& plan) { plan_ = plan; }
  /// Accounts for the images.
  [[nodiscard]] const tracking::StreamLedger& ledger() const { return ledger_; }
  /// Accounts for the poses of a tool; role as in add_pose().
  [[nodiscard]] const tracking::StreamLedger& ledger(ToolRole role) const;
  /// Rejected poses by body and cause ("Probe.not_rigid").
  [[nodiscard]] std::map<std::string, std::uint64_t> rejected_poses() const;

 private:
  void refresh_needle(Epoch& epoch) const;
  [[nodiscard]] std::optional<double> tracker_error_mm() const;
  [[nodiscard]] Safety explained(Safety safety, bool images, ToolRole tool) const;
  [[nodiscard]] Duration frame_period() const;
  [[nodiscard]] Duration needle_period() const;
  /// Loss of a stream that the ultrasound or the needle depends on.
  [[nodiscard]] std::optional<Safety> loss(bool images, ToolRole tool) const;

  NavigatorOptions options_;
  Diagnostics& diagnostics_;
  tracking::ImagePairer pairer_;
  tracking::ToolPoses<frames::Needle> needle_;
  tracking::PosePlausibility plausibility_;
  tracking::PeriodEstimator image_period_, pose_period_;
  std::optional<Transform<frames::Reference, frames::Tracker>> fixed_reference_;
  tracking::StreamLedger ledger_;
  std::string images_lost_;
  std::string images_trouble_;
  std::map<ToolRole, std::string> poses_trouble_;
  std::map<ToolRole, std::optional<double>> tracker_errors_mm_;  ///< Figures of the newest poses.
  std::string newest_rejection_;  ///< Cause, while the newest image was rejected.
  std::map<ToolRole, std::string> poses_lost_;
  std::optional<TrackedImage> newest_;
  bool newest_shown_ = false;
  std::optional<CtPlacement> placement_;
  std::optional<NeedlePlan> plan_;
};

}  // namespace nav::session
