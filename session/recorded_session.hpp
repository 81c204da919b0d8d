// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "nav/diagnostics.hpp"
#include "session/navigator.hpp"
#include "session/options.hpp"
#include "session/pose_log.hpp"
#include "session/registration_file.hpp"
#include "sim/replay.hpp"

namespace nav::session {

/// Passes reports on and remembers the first warning of a part.
class FirstWarning final : public Diagnostics {
 public:
  explicit FirstWarning(Diagnostics& outer) : outer_(outer) {}
  void report(Severity severity, std::string_view source, std::string_view message) override {
    if (severity != Severity::kInfo) {
      if (first_.empty()) first_ = message;
      last_ = message;
      ++count_;
    }
    outer_.report(severity, source, message);
  }
  [[nodiscard]] const std::string& message() const { return first_; }
  [[nodiscard]] const std::string& last() const { return last_; }
  [[nodiscard]] std::size_t count() const { return count_; }

 private:
  Diagnostics& outer_;
  std::string first_;
  std::string last_;
  std::size_t count_ = 0;
};

/// A recording played through the live pipeline, one frame at a time, on the virtual clock.
/// Not thread-safe.
class RecordedSession {
 public:
  using Listener = std::function<void(const tracking::PairedFrame&)>;

  /// Opens recording and calibration. Without a named reference frame, "Reference" is taken where
  /// the recording has it; otherwise the tracker, which is reported. diagnostics must outlive it.
  static Result<RecordedSession> open(const SourceOptions& source, Diagnostics& diagnostics);

  /// Feeds one frame and settles what can be paired; false at the end, when everything is settled.
  Result<bool> step(const Listener& listener);
  /// Steps to the end.
  Result<void> play(const Listener& listener);
  /// Back to the first frame, with a fresh clock, ledger and log; the placement is kept.
  void rewind();

  /// Virtual time: of the newest of what went in so far.
  [[nodiscard]] Timestamp now() const { return now_; }
  [[nodiscard]] Epoch refresh() { return navigator_->refresh(now_); }
  [[nodiscard]] Navigator& navigator() { return *navigator_; }
  [[nodiscard]] const Navigator& navigator() const { return *navigator_; }
  [[nodiscard]] const PoseLog& log() const { return log_; }
  void set_placement(const CtPlacement& placement);
  /// Of the pictures from now on that say none themselves.
  void set_outline(const SectorOutline& outline) { outline_ = outline; }
  [[nodiscard]] const std::optional<SectorOutline>& outline() const { return outline_; }

  [[nodiscard]] std::int64_t total_frames() const { return replay_.total_frames(); }
  /// From the first to the last stamp of the frames that went in so far.
  [[nodiscard]] Duration length() const {
    return first_time_ ? *last_time_ - *first_time_ : Duration(0);
  }
  /// Picture stamps minus pose stamps, as configured.
  [[nodiscard]] Duration temporal_offset() const { return options_.pairing.temporal_offset; }
  [[nodiscard]] const Transform<frames::Probe, frames::Image>& probe_from_image() const {
    return replay_.calibration()->probe_from_image;
  }
  /// Stamps of the first and last of the frames that went in so far; absent while none has one.
  [[nodiscard]] std::optional<Timestamp> first_time() const { return first_time_; }
  [[nodiscard]] std::optional<Timestamp> last_time() const { return last_time_; }
  /// Frames that went in so far.
  [[nodiscard]] std::int64_t frames_read() const { return frames_read_; }
  /// Which frames and transforms are in use, for the report.
  [[nodiscard]] const std::string& description() const { return replay_.description(); }
  /// What is taken as the patient's frame, and why.
  [[nodiscard]] const std::string& reference_statement() const { return reference_statement_; }
  /// Name of that frame in the recording.
  [[nodiscard]] const std::string& reference_frame() const { return reference_frame_; }
  /// The recording's path, for messages.
  [[nodiscard]] const std::string& name() const { return name_; }
  /// Why the first picture that could not be used was refused; empty while there is none.
  [[nodiscard]] const std::string& first_refusal() const { return first_refusal_; }
  /// Frames whose data cannot be true (times that do not increase, poses or calibrations that are
  /// not rigid or not numbers), as opposed to frames that say themselves that nothing was tracked
  /// or seen.
  [[nodiscard]] std::int64_t bad_frames() const { return bad_frames_; }
  /// What is wrong with the first of them, one sentence; empty while there is none.
  [[nodiscard]] const std::string& first_bad_frame() const { return first_bad_frame_; }
  /// The first warning about a frame or pose; empty while there is none.
  [[nodiscard]] const std::string& first_warning() const { return diagnostics_->message(); }

 private:
  RecordedSession(sim::ReplaySession replay, NavigatorOptions options,
                  std::unique_ptr<FirstWarning> diagnostics, bool fixed_reference,
                  std::string reference_statement);
  void feed(sim::ReplayEvent event);
  [[nodiscard]] std::string defect_of(const sim::ReplayEvent& event) const;
  void note_degraded(const sim::ReplayEvent& event);

  std::unique_ptr<FirstWarning> diagnostics_;  ///< Outlives what reports to it.
  sim::ReplaySession replay_;
  NavigatorOptions options_;
  bool fixed_reference_;
  std::string reference_statement_;
  std::string name_;
  std::string reference_frame_;
  std::optional<CtPlacement> placement_;
  std::optional<SectorOutline> outline_;
  Timestamp now_{};  ///< The latest stamp so far; the origin while there is none.
  std::unique_ptr<Navigator> navigator_;
  PoseLog log_;
  std::int64_t frames_read_ = 0;
  std::string first_refusal_;
  std::int64_t bad_frames_ = 0;
  std::string first_bad_frame_;
  std::optional<Timestamp> first_time_, last_time_;
  bool ended_ = false;
};

/// What is known of a recording beforehand; of its pictures only some are kept.
struct SweepSurvey {
  RecordingRead recording;
  std::size_t paired = 0;
  Point<frames::Reference> centroid{{0, 0, 0}};
  Eigen::Vector3d lateral = Eigen::Vector3d::Zero();  ///< Sum of the pictures' x axes, Reference.
  Eigen::Vector3d deep = Eigen::Vector3d::Zero();     ///< Sum of their y axes, Reference.
  double picture_extent_mm = 0;                       ///< Diagonal of the last picture.
  std::vector<TrackedFrame> spread;                   ///< Evenly over the recording, about 60.
  std::vector<Point<frames::Reference>> corners;      ///< Of all pictures, four each.
  /// What to warn of where the temporal offset left more than a tenth of the pictures without a
  /// pose, one sentence; empty: nothing.
  std::string warning;
};
/// The sector that the pictures of a recording show; absent where they say one themselves, are of a
/// linear probe, or of several sizes.
std::optional<SectorOutline> sector_of(const SweepSurvey& sweep);
/// Orthonormal mean axes of the pictures (columns x, y, z of Image in Reference); absent where the
/// pictures look every way and their axes cancel out.
std::optional<Eigen::Matrix3d> mean_axes(const SweepSurvey& sweep);
/// Refuses a recording with bad frames unless they are to be skipped.
Result<void> check_frames(const RecordedSession& session, bool skip_bad_frames);
/// Plays the whole recording once and rewinds it. kMalformedData when no picture could be paired;
/// the message gives the causes.
Result<SweepSurvey> survey(RecordedSession& session, bool skip_bad_frames);

}  // namespace nav::session
