// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/recorded_session.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <sstream>

#include "registration/similarity/image_outline.hpp"

namespace nav::session {

Result<RecordedSession> RecordedSession::open(const SourceOptions& source,
                                              Diagnostics& diagnostics) {
  RecordedSession session;
  session.diagnostics_ = std::make_unique<WarningMemory>(diagnostics);
  auto opened = PlayedRecording::open(source, *session.diagnostics_);
  if (!opened) return opened.error();
  session.recording_ = *std::move(opened);
  session.diagnostics_->forget();  // They are not about frames.
  session.reference_frame_ = session.recording_->reference_frame();
  session.reference_statement_ = session.reference_frame_ + " is the patient's frame";
  if (session.reference_frame_.empty()) {
    session.reference_frame_ = source.tracker_frame;
    session.reference_statement_ = session.reference_frame_ + " is the patient's frame";
    if (source.reference_frame.empty()) {
      session.reference_statement_ = "nothing tracks the patient: the tracker itself (" +
                                     source.tracker_frame + ") is taken as the patient's frame";
      diagnostics.report(Severity::kWarning, "recording", session.reference_statement_);
    }
  }
  session.setup_ = session.recording_->setup();
  // A recording does not say at which rate it comes.
  session.setup_.navigator.frame_period.reset();
  session.setup_.navigator.needle_period.reset();
  session.setup_.images = QueuePolicy::kLossless;
  session.name_ = source.recording.string();
  if (auto ok = session.rewind(); !ok) return ok.error();
  return session;
}

Result<void> RecordedSession::rewind() {
  auto sources = recording_->rewind();
  if (!sources) return sources.error();
  setup_.learn_outline = learns_outline_;
  session_ = std::make_unique<Session>(setup_, *diagnostics_);
  for (const auto& source : *sources) session_->add(source);
  if (placement_) navigator().set_placement(*placement_);
  if (outline_) session_->set_outline(*outline_);
  return {};
}

void RecordedSession::set_placement(const CtPlacement& placement) {
  placement_ = placement;
  navigator().set_placement(placement);
}

Result<void> RecordedSession::learn_outline() {
  learns_outline_ = true;
  return rewind();
}

void RecordedSession::set_outline(const std::optional<SectorOutline>& outline) {
  outline_ = outline;
  session_->set_outline(outline);
}

Result<bool> RecordedSession::step(const Session::Listener& listener) {
  const auto next = session_->next_arrival();
  if (!next) return next.error();
  if (!*next) {
    session_->finish(listener);
    return false;
  }
  if (auto ok = session_->advance_to(**next, listener); !ok) return ok.error();
  return true;
}

Result<void> RecordedSession::play(const Session::Listener& listener) {
  for (;;) {
    const auto more = step(listener);
    if (!more) return more.error();
    if (!*more) return {};
  }
}

std::optional<Eigen::Matrix3d> mean_axes(const SweepSurvey& sweep) {
  constexpr double kClear = 1e-3;
  const auto count = static_cast<double>(sweep.paired);
  const Eigen::Vector3d lateral = sweep.lateral / count;
  const Eigen::Vector3d normal = lateral.cross(sweep.deep / count);
  if (!(lateral.norm() > kClear && normal.norm() > kClear)) return std::nullopt;
  Eigen::Matrix3d axes;
  axes.col(0) = lateral.normalized();
  axes.col(2) = normal.normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

std::optional<SectorOutline> sector_of(const SweepSurvey& sweep) {
  if (sweep.spread.empty() || sweep.spread.front().frame.outline) return std::nullopt;
  const auto some = Sweep::create(sweep.spread, "outline");
  if (!some) return std::nullopt;
  return registration::sector_of(*some);
}

std::optional<Finding> bad_frames_finding(const RecordedSession& session) {
  if (session.bad_frames() == 0) return std::nullopt;
  return Finding{.subject = session.name(),
                 .key = "frames",
                 .values = {std::to_string(session.bad_frames()) + " of " +
                            std::to_string(session.total_images()) +
                            " that are bad, the first: " + session.first_bad_frame()},
                 .used = "the others"};
}

Result<void> check_frames(const RecordedSession& session, bool skip_bad_frames) {
  if (session.bad_frames() == 0 || skip_bad_frames) return {};
  return Error{ErrorCode::kMalformedData,
               session.name() + ": " + session.first_bad_frame() + " (" +
                   std::to_string(session.bad_frames()) + " of " +
                   std::to_string(session.total_images()) +
                   " frames are bad; --skip-bad-frames plays the others)"};
}

namespace {

/// Number of images that the temporal offset moved out of the time of the poses.
std::uint64_t count_moved(const RecordedSession& session) {
  const Duration offset = session.temporal_offset();
  if (offset == Duration(0)) return 0;
  std::uint64_t moved = 0;
  for (const auto& [cause, count] : session.navigator().ledger().rejected()) {
    if (cause.ends_with(offset > Duration(0) ? ".before_first_pose" : ".no_pose_yet")) {
      moved += count;
    }
  }
  return moved;
}

/// Text with that number and by how much the images were moved past the poses; empty: none. An
/// image and its poses have one stamp in a recording.
std::string moved_past_poses(const RecordedSession& session) {
  const std::uint64_t moved = count_moved(session);
  if (moved == 0) return "";
  const Duration offset = session.temporal_offset();
  const bool before = offset > Duration(0);
  constexpr double kMs = 1e3;
  const double most_ms = kMs * std::abs(to_seconds(offset));
  const double least_ms = std::max(most_ms - kMs * to_seconds(session.length()), 0.0);
  std::ostringstream text;
  text << "by --temporal-offset-ms " << kMs * to_seconds(offset) << ", " << moved << " of "
       << session.total_images() << " images lie "
       << (before ? "before the first pose" : "after the last pose") << ", by " << least_ms
       << " to " << most_ms << " ms";
  return text.str();
}

/// SweepSurvey::warning of a session that was played.
std::string warning_of_moved(const RecordedSession& session) {
  constexpr double kMostShare = 0.1;
  const auto frames = static_cast<double>(session.total_images());
  if (!(static_cast<double>(count_moved(session)) > kMostShare * frames)) return "";
  return "images without a pose: " + moved_past_poses(session);
}

}  // namespace

RecordingRead recording_read(const RecordedSession& session, const UltrasoundImage& image) {
  constexpr double kMs = 1e3;
  const double right = image.pixels.width() - 1;
  const double bottom = image.pixels.height() - 1;
  const auto on_probe = [&](double column, double row) {
    return session.probe_from_image() * image.grid.at(column, row);
  };
  return {.name = std::filesystem::path(session.name()).filename().string(),
          .first_s = to_seconds(*session.first_time()),
          .temporal_offset_ms = kMs * to_seconds(session.temporal_offset()),
          .corners = {on_probe(0, 0), on_probe(right, 0), on_probe(0, bottom)}};
}

namespace {

void add_to(SweepSurvey& sweep, const TrackedImage& image, std::size_t stride) {
  const auto& pixels = image.frame.pixels;
  const auto centre = image.frame.grid.at(0.5 * (pixels.width() - 1), 0.5 * (pixels.height() - 1));
  const Eigen::Matrix3d axes = image.reference_from_image.rotation().toRotationMatrix();
  // The sum; survey() and survey_of() divide it.
  sweep.centroid.mm += (image.reference_from_image * centre).mm;
  sweep.lateral += axes.col(0);
  sweep.deep += axes.col(1);
  sweep.image_extent_mm = extent_mm(image.frame);
  if (sweep.paired++ % stride == 0) sweep.spread.push_back(image);
  for (const double column : {0.0, pixels.width() - 1.0}) {
    for (const double row : {0.0, pixels.height() - 1.0}) {
      sweep.corners.push_back(image.reference_from_image * image.frame.grid.at(column, row));
    }
  }
}

}  // namespace

Error nothing_paired(const RecordedSession& session) {
  std::string message = session.name() +
                        ": expected at least one image with a pose, found none of " +
                        std::to_string(session.total_images()) + " frames usable";
  const std::string moved = moved_past_poses(session);
  if (!moved.empty()) return {ErrorCode::kMalformedData, message + ": " + moved};
  message += "; the first: " + (session.first_rejection().empty() ? "there are no frames"
                                                                  : session.first_rejection());
  const std::string warning = session.first_warning();
  if (!warning.empty() && warning != session.first_rejection()) message += " (" + warning + ")";
  return {ErrorCode::kMalformedData, message};
}

SweepSurvey survey_of(const TrackedImage& image) {
  SweepSurvey sweep;
  add_to(sweep, image, 1);
  return sweep;
}

Result<SweepSurvey> survey(RecordedSession& session, bool skip_bad_frames) {
  constexpr std::int64_t kSpread = 60;
  const auto stride =
      static_cast<std::size_t>(std::max<std::int64_t>(1, session.total_images() / kSpread));
  if (const auto whole = session.check_complete(); !whole) return whole.error();
  SweepSurvey found;
  Session::Listener listener;
  listener.settled = [&](const tracking::PairedImage& paired) {
    if (paired.tracked) add_to(found, *paired.tracked, stride);
  };
  if (const auto played = session.play(listener); !played) return played.error();
  if (found.paired == 0) return nothing_paired(session);
  if (const auto ok = check_frames(session, skip_bad_frames); !ok) return ok.error();
  found.recording = recording_read(session, found.spread.front().frame);
  found.recording.frames = session.total_images();
  found.recording.last_s = to_seconds(*session.last_time());
  found.warning = warning_of_moved(session);
  found.centroid.mm /= static_cast<double>(found.paired);
  if (auto ok = session.rewind(); !ok) return ok.error();
  return found;
}

}  // namespace nav::session
