// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "nav/warning_memory.hpp"
#include "session/navigator.hpp"
#include "session/options.hpp"
#include "session/played_recording.hpp"
#include "session/pose_log.hpp"
#include "session/registration_file.hpp"
#include "session/session.hpp"

namespace nav::session {

/// A recording as a session on the virtual clock. Not thread-safe.
class RecordedSession {
 public:
  /// Opens recording and calibration; the recording is a PLUS sequence or one of devices (*.mcap).
  /// Without a named reference frame, "Reference" is taken if the recording has it, otherwise the
  /// tracker, with a warning. \p diagnostics must outlive it.
  static Result<RecordedSession> open(const SourceOptions& options, Diagnostics& diagnostics);

  /// Takes in the next samples and settles what can be paired; false at the end, when everything
  /// is settled.
  Result<bool> step(const Session::Listener& listener);
  /// Steps to the end.
  Result<void> play(const Session::Listener& listener);
  /// Back to the first frame, with a fresh clock, ledger, log and estimators; placement and a given
  /// outline are kept. Errors: those of reading the file again.
  Result<void> rewind();

  [[nodiscard]] Session& session() { return *session_; }
  [[nodiscard]] const Session& session() const { return *session_; }
  [[nodiscard]] Timestamp now() const { return session_->now(); }
  [[nodiscard]] Epoch refresh() { return session_->refresh(); }
  [[nodiscard]] Navigator& navigator() { return session_->navigator(); }
  [[nodiscard]] const Navigator& navigator() const { return session_->navigator(); }
  [[nodiscard]] const PoseLog& log() const { return session_->log(); }
  void set_placement(const CtPlacement& placement);
  /// Learns the sector of images that come without an outline, from the images so far. Goes back to
  /// the first frame. Without it, images keep what they bring: a registration needs one outline for
  /// all images of a sweep, and finds it itself.
  Result<void> learn_outline();
  /// Outline of the images that come without one; none: they are drawn whole.
  void set_outline(const std::optional<SectorOutline>& outline);
  [[nodiscard]] const std::optional<SectorOutline>& outline() const { return session_->outline(); }

  /// True when it tracks a needle that is drawn.
  [[nodiscard]] bool has_needle() const { return recording_->has_needle(); }
  /// Frames that the header declares.
  [[nodiscard]] std::int64_t total_images() const { return recording_->total_images(); }
  /// Time from the first to the last stamp of the frames read so far.
  [[nodiscard]] Duration length() const {
    return first_time() ? *last_time() - *first_time() : Duration(0);
  }
  /// Image stamps minus pose stamps, as configured.
  [[nodiscard]] Duration temporal_offset() const {
    return setup_.navigator.pairing.temporal_offset;
  }
  /// Precondition: an image was read, otherwise a Bug.
  [[nodiscard]] const Transform<frames::Probe, frames::Image>& probe_from_image() const {
    NAV_CHECK(session_->probe_from_image().has_value());
    return *session_->probe_from_image();
  }
  /// First and last stamp of the frames read so far; absent while no frame has one.
  [[nodiscard]] std::optional<Timestamp> first_time() const {
    return recording_->read().first_time;
  }
  [[nodiscard]] std::optional<Timestamp> last_time() const { return recording_->read().last_time; }
  /// Frames read so far.
  [[nodiscard]] std::int64_t frames_read() const { return recording_->read().frames; }
  /// Frames and transforms in use, for the report.
  [[nodiscard]] const std::string& description() const { return recording_->description(); }
  /// Which frame is taken as the patient's, and why.
  [[nodiscard]] const std::string& reference_statement() const { return reference_statement_; }
  /// Name of that frame in the recording.
  [[nodiscard]] const std::string& reference_frame() const { return reference_frame_; }
  /// Path of the recording, for messages.
  [[nodiscard]] const std::string& name() const { return name_; }
  /// Cause of the first image that could not be used; empty while there is none.
  [[nodiscard]] const std::string& first_rejection() const { return session_->first_rejection(); }
  /// Frames read so far whose data cannot be true, as in io::RecordingSource.
  [[nodiscard]] std::int64_t bad_frames() const { return recording_->read().bad_frames; }
  [[nodiscard]] std::string first_bad_frame() const { return recording_->read().first_bad_frame; }
  /// kMalformedData for a file that is cut short and cannot be played.
  [[nodiscard]] Result<void> check_complete() const { return recording_->check_complete(); }
  /// The first warning about a frame or pose; empty while there is none.
  [[nodiscard]] std::string first_warning() const { return diagnostics_->first(); }

 private:
  RecordedSession() = default;

  std::unique_ptr<WarningMemory> diagnostics_;  ///< Outlives what reports to it.
  std::unique_ptr<PlayedRecording> recording_;
  SessionSetup setup_;
  std::string reference_statement_;
  std::string name_;
  std::string reference_frame_;
  std::optional<CtPlacement> placement_;
  bool learns_outline_ = false;
  std::optional<std::optional<SectorOutline>> outline_;
  std::unique_ptr<Session> session_;
};

/// A finding about the bad frames of a recording that was played; absent without any.
std::optional<Finding> bad_frames_finding(const RecordedSession& session);

/// Facts of a sweep; only some of its images are kept.
struct SweepSurvey {
  RecordingRead recording;  ///< Set for a whole recording only.
  std::size_t paired = 0;
  Point<frames::Reference> centroid{{0, 0, 0}};
  Eigen::Vector3d lateral = Eigen::Vector3d::Zero();  ///< Sum of the images' x axes, Reference.
  Eigen::Vector3d deep = Eigen::Vector3d::Zero();     ///< Sum of their y axes, Reference.
  double image_extent_mm = 0;                         ///< Diagonal of the last image.
  std::vector<TrackedImage> spread;                   ///< About 60 images, evenly over the sweep.
  std::vector<Point<frames::Reference>> corners;      ///< Corners of all images, four each.
  /// One sentence if the temporal offset left more than a tenth of the images without a pose; else
  /// empty.
  std::string warning;
};
/// The survey of a sweep that consists of one image so far.
SweepSurvey survey_of(const TrackedImage& image);
/// The sector that the images show; absent if they bring an outline, come from a linear probe, or
/// have several sizes.
std::optional<SectorOutline> sector_of(const SweepSurvey& sweep);
/// Orthonormal mean axes of the images (columns x, y, z of Image in Reference); absent if the
/// images look in all directions and their axes cancel out.
std::optional<Eigen::Matrix3d> mean_axes(const SweepSurvey& sweep);
/// The recording and how it is read, as far as it is known before its end: without the number of
/// frames and the last stamp. \p image: any of its images.
RecordingRead recording_read(const RecordedSession& session, const UltrasoundImage& image);
/// The error of a recording of which no image could be paired, with the causes.
Error nothing_paired(const RecordedSession& session);
/// Rejects a recording with bad frames unless they are to be skipped.
Result<void> check_frames(const RecordedSession& session, bool skip_bad_frames);
/// Plays the whole recording once and rewinds it. kMalformedData when the file is cut short, or no
/// image could be paired; the message gives the causes.
Result<SweepSurvey> survey(RecordedSession& session, bool skip_bad_frames);

}  // namespace nav::session
