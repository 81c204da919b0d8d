// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/recorded_session.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "io/plus_config.hpp"
#include "io/sequence.hpp"
#include "registration/similarity/picture_outline.hpp"

namespace nav::session {
namespace {

/// Median time between frames; 50 ms where the recording does not tell.
Result<Duration> frame_period(const std::filesystem::path& path) {
  auto reader = io::SequenceReader::open(path);
  if (!reader) return reader.error();
  if (const auto whole = io::check_complete(*reader); !whole) return whole.error();
  std::vector<double> gaps;
  std::optional<double> last;
  for (std::int64_t i = 0; i < reader->header().frame_count; ++i) {
    const auto frame = reader->frame_fields(i);
    if (!frame || !frame->timestamp_s) continue;
    if (last && *frame->timestamp_s > *last) gaps.push_back(*frame->timestamp_s - *last);
    last = frame->timestamp_s;
  }
  constexpr double kDefaultS = 0.05;
  if (gaps.empty()) return from_seconds(kDefaultS);
  const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2);
  std::nth_element(gaps.begin(), middle, gaps.end());
  return from_seconds(std::clamp(*middle, 1e-3, 10.0));
}

NavigatorOptions options_for(const SourceOptions& source, Duration period) {
  NavigatorOptions options;
  options.frame_period = period;
  options.needle_period = period;
  options.pairing.temporal_offset = from_seconds(source.temporal_offset_ms * 1e-3);
  // A recording holds one pose per picture, so its poses are as far apart as its pictures.
  options.pairing.max_pose_gap = std::max<Duration>(options.pairing.max_pose_gap, 2 * period);
  options.pairing.max_wait = std::max<Duration>(options.pairing.max_wait, 3 * period);
  // The pose of a picture that is stamped early comes so much later in the file.
  options.pairing.max_wait += std::max<Duration>(-options.pairing.temporal_offset, Duration(0));
  return options;
}

}  // namespace

Result<RecordedSession> RecordedSession::open(const SourceOptions& source,
                                              Diagnostics& diagnostics) {
  const auto period = frame_period(source.recording);
  if (!period) return period.error();
  std::optional<io::PlusConfig> plus;
  if (!source.plus_config.empty()) {
    auto read = io::read_plus_config(source.plus_config);
    if (!read) return read.error();
    plus = std::move(*read);
  }
  sim::ReplayOptions options{source.image_frame, source.probe_frame, source.tracker_frame,
                             source.reference_frame, source.needle_frame};
  const bool choose = source.reference_frame.empty();
  if (choose) options.reference_frame = "Reference";
  auto first_warning = std::make_unique<FirstWarning>(diagnostics);
  const auto open_with = [&] {
    return sim::ReplaySession::open(source.recording, plus ? &*plus : nullptr, options,
                                    *first_warning);
  };
  auto replay = open_with();
  std::string statement = options.reference_frame + " is the patient's frame";
  if (!replay && choose && replay.error().code == ErrorCode::kNotFound) {
    options.reference_frame = source.tracker_frame;
    statement = "nothing tracks the patient: the tracker itself (" + source.tracker_frame +
                ") is taken as the patient's frame";
    replay = open_with();
    if (replay) diagnostics.report(Severity::kWarning, "recording", statement);
  }
  if (!replay) return replay.error();
  if (!replay->calibration()) {
    return Error{ErrorCode::kUnsupportedData,
                 source.recording.string() +
                     ": expected ultrasound pictures, found a recording without any"};
  }
  const bool fixed = replay->form() != sim::ReplayForm::kTracked ||
                     options.reference_frame == source.tracker_frame;
  RecordedSession session(std::move(*replay), options_for(source, *period),
                          std::move(first_warning), fixed, statement);
  session.name_ = source.recording.string();
  session.reference_frame_ = options.reference_frame;
  return session;
}

RecordedSession::RecordedSession(sim::ReplaySession replay, NavigatorOptions options,
                                 std::unique_ptr<FirstWarning> diagnostics, bool fixed_reference,
                                 std::string reference_statement)
    : diagnostics_(std::move(diagnostics)),
      replay_(std::move(replay)),
      options_(options),
      fixed_reference_(fixed_reference),
      reference_statement_(std::move(reference_statement)) {
  rewind();
}

void RecordedSession::rewind() {
  replay_.rewind();
  std::optional<Transform<frames::Reference, frames::Tracker>> fixed;
  if (fixed_reference_) {
    fixed.emplace(Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero());
  }
  now_ = {};
  navigator_ = std::make_unique<Navigator>(replay_.calibration()->probe_from_image, fixed, options_,
                                           *diagnostics_);
  if (placement_) navigator_->set_placement(*placement_);
  log_ = PoseLog();
  frames_read_ = 0;
  first_refusal_.clear();
  bad_frames_ = 0;
  first_bad_frame_.clear();
  first_time_.reset();
  last_time_.reset();
  ended_ = false;
}

void RecordedSession::set_placement(const CtPlacement& placement) {
  placement_ = placement;
  navigator_->set_placement(placement);
}

/// What cannot be true about a frame, or nothing.
std::string RecordedSession::defect_of(const sim::ReplayEvent& event) const {
  if (!event.acquired) return "expected a Timestamp, found none";
  if (last_time_ && *event.acquired <= *last_time_) {
    std::ostringstream text;
    text << std::setprecision(12) << "Timestamp: expected a time after " << to_seconds(*last_time_)
         << " s, found " << to_seconds(*event.acquired) << " s";
    return text.str();
  }
  if (!event.picture && event.picture.error().code == ErrorCode::kMalformedData) {
    return event.picture.error().message;
  }
  const auto claimed = [](const RawPose& pose) {
    return pose.status == TrackingStatus::kOk || pose.status == TrackingStatus::kUnknown;
  };
  if (claimed(event.probe)) {
    const auto rigid =
        rigid_from_matrix<frames::Tracker, frames::Probe>(event.probe.tracker_from_body);
    if (!rigid) return rigid.error().message;
  }
  if (event.reference && claimed(*event.reference)) {
    const auto rigid =
        rigid_from_matrix<frames::Tracker, frames::Reference>(event.reference->tracker_from_body);
    if (!rigid) return rigid.error().message;
  }
  if (event.needle && claimed(*event.needle)) {
    const auto rigid =
        rigid_from_matrix<frames::Tracker, frames::Needle>(event.needle->tracker_from_body);
    if (!rigid) return rigid.error().message;
  }
  return "";
}

void RecordedSession::note_degraded(const sim::ReplayEvent& event) {
  const bool unknown = event.probe.status == TrackingStatus::kUnknown ||
                       (event.reference && event.reference->status == TrackingStatus::kUnknown);
  if (!unknown) return;
  diagnostics_->report(Severity::kWarning, "recording",
                       name_ +
                           ": expected a status with every pose, found some without: their "
                           "pictures are drawn as degraded");
}

void RecordedSession::feed(sim::ReplayEvent event) {
  const auto sequence = static_cast<std::uint64_t>(event.index);
  const auto missing = [&](const std::string& cause, const std::string& message) {
    if (first_refusal_.empty()) first_refusal_ = message;
    log_.add_missing(sequence, cause);
    navigator_->on_event({now_, MissingFrame{sequence, cause, message}});
  };
  if (!event.acquired) {
    missing("no_timestamp", event.picture ? "frame " + std::to_string(event.index) +
                                                ": expected a Timestamp, found none"
                                          : event.picture.error().message);
    return;
  }
  // Stamps that run backwards are refused below, by the pairing; the clock never runs backwards.
  now_ = std::max(now_, *event.acquired);
  navigator_->on_event({now_, ProbePose{event.probe}});
  if (event.reference) navigator_->on_event({now_, ReferencePose{*event.reference}});
  if (event.needle) navigator_->on_event({now_, NeedlePose{*event.needle}});
  if (!event.picture) {
    missing("unusable_picture", event.picture.error().message);
    return;
  }
  if (!event.picture->outline) event.picture->outline = outline_;
  navigator_->on_event({now_, std::move(*event.picture)});
}

Result<bool> RecordedSession::step(const Listener& listener) {
  if (ended_) return false;
  const auto settle = [&](bool end) {
    navigator_->settle(now_, end, [&](const tracking::PairedFrame& paired) {
      if (!paired.tracked && first_refusal_.empty()) {
        first_refusal_ = "frame " + std::to_string(paired.sequence) + ": " + paired.cause;
      }
      log_.add(paired);
      listener(paired);
    });
  };
  const std::size_t warnings = diagnostics_->count();
  auto event = replay_.next();
  if (!event) {
    if (event.error().code != ErrorCode::kEndOfStream) return event.error();
    ended_ = true;
    settle(true);
    return false;
  }
  ++frames_read_;
  const std::string defect =
      diagnostics_->count() > warnings ? diagnostics_->last() : defect_of(*event);
  if (!defect.empty() && bad_frames_++ == 0) {
    const std::string frame = "frame " + std::to_string(event->index);
    first_bad_frame_ = defect.find(frame) == std::string::npos ? frame + ": " + defect : defect;
  }
  if (event->acquired) {
    // Stamps may begin anywhere, before the origin too.
    if (!first_time_) now_ = *event->acquired;
    first_time_ = std::min(first_time_.value_or(*event->acquired), *event->acquired);
    last_time_ = std::max(last_time_.value_or(*event->acquired), *event->acquired);
  }
  note_degraded(*event);
  feed(std::move(*event));
  settle(false);
  return true;
}

Result<void> RecordedSession::play(const Listener& listener) {
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

Result<void> check_frames(const RecordedSession& session, bool skip_bad_frames) {
  if (session.bad_frames() == 0 || skip_bad_frames) return {};
  return Error{ErrorCode::kMalformedData,
               session.name() + ": " + session.first_bad_frame() + " (" +
                   std::to_string(session.bad_frames()) + " of " +
                   std::to_string(session.total_frames()) +
                   " frames are bad; --skip-bad-frames plays the others)"};
}

namespace {

/// How many pictures the temporal offset moved out of the time that poses are of.
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

/// The same in words, and by how much; empty: none. Frames hold a picture and its poses by one
/// stamp.
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
       << session.total_frames() << " pictures lie "
       << (before ? "before the first pose" : "after the last pose") << ", by " << least_ms
       << " to " << most_ms << " ms";
  return text.str();
}

/// SweepSurvey::warning of a session that was played.
std::string warning_of_moved(const RecordedSession& session) {
  constexpr double kMostShare = 0.1;
  const auto frames = static_cast<double>(session.total_frames());
  if (!(static_cast<double>(count_moved(session)) > kMostShare * frames)) return "";
  return "pictures without a pose: " + moved_past_poses(session);
}

/// Of a session that was played; any picture of it.
RecordingRead recording_read(const RecordedSession& session, const UltrasoundFrame& picture) {
  constexpr double kMs = 1e3;
  const double right = picture.pixels.width() - 1;
  const double bottom = picture.pixels.height() - 1;
  const auto on_probe = [&](double column, double row) {
    return session.probe_from_image() * picture.grid.at(column, row);
  };
  return {std::filesystem::path(session.name()).filename().string(),
          session.total_frames(),
          to_seconds(*session.first_time()),
          to_seconds(*session.last_time()),
          kMs * to_seconds(session.temporal_offset()),
          {on_probe(0, 0), on_probe(right, 0), on_probe(0, bottom)}};
}

}  // namespace

Result<SweepSurvey> survey(RecordedSession& session, bool skip_bad_frames) {
  constexpr std::int64_t kSpread = 60;
  const auto stride =
      static_cast<std::size_t>(std::max<std::int64_t>(1, session.total_frames() / kSpread));
  SweepSurvey found;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const auto add = [&](const tracking::PairedFrame& paired) {
    if (!paired.tracked) return;
    const TrackedFrame& tracked = *paired.tracked;
    const auto& pixels = tracked.frame.pixels;
    const auto centre =
        tracked.frame.grid.at(0.5 * (pixels.width() - 1), 0.5 * (pixels.height() - 1));
    const Eigen::Matrix3d axes = tracked.reference_from_image.rotation().toRotationMatrix();
    sum += (tracked.reference_from_image * centre).mm;
    found.lateral += axes.col(0);
    found.deep += axes.col(1);
    found.picture_extent_mm = extent_mm(tracked.frame);
    if (found.paired++ % stride == 0) found.spread.push_back(tracked);
    for (const double column : {0.0, pixels.width() - 1.0}) {
      for (const double row : {0.0, pixels.height() - 1.0}) {
        found.corners.push_back(tracked.reference_from_image * tracked.frame.grid.at(column, row));
      }
    }
  };
  if (const auto played = session.play(add); !played) return played.error();
  if (found.paired == 0) {
    std::string message = session.name() +
                          ": expected at least one picture with a pose, found none of " +
                          std::to_string(session.total_frames()) + " frames usable";
    const std::string moved = moved_past_poses(session);
    if (!moved.empty()) return Error{ErrorCode::kMalformedData, message + ": " + moved};
    message += "; the first: " +
               (session.first_refusal().empty() ? "there are no frames" : session.first_refusal());
    const std::string& warning = session.first_warning();
    if (!warning.empty() && warning != session.first_refusal()) message += " (" + warning + ")";
    return Error{ErrorCode::kMalformedData, message};
  }
  if (const auto ok = check_frames(session, skip_bad_frames); !ok) return ok.error();
  found.recording = recording_read(session, found.spread.front().frame);
  found.warning = warning_of_moved(session);
  found.centroid.mm = sum / static_cast<double>(found.paired);
  session.rewind();
  return found;
}

}  // namespace nav::session
