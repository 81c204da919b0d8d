// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/recording_source.hpp"

#include <algorithm>
#include <iomanip>
#include <sstream>
#include <utility>

namespace nav::io {
namespace {

bool claims_a_pose(const RawPose& pose) {
  return pose.status == TrackingStatus::kOk || pose.status == TrackingStatus::kUnknown;
}

template <class Body>
std::string rigid_defect(const RawPose& pose) {
  if (!claims_a_pose(pose)) return "";
  const auto rigid = rigid_from_matrix<frames::Tracker, Body>(pose.tracker_from_body);
  return rigid ? "" : rigid.error().message;
}

}  // namespace

Result<std::unique_ptr<RecordingSource>> RecordingSource::open(
    const std::filesystem::path& sequence, const PlusConfig* config,
    const RecordingOptions& options, Diagnostics& diagnostics) {
  auto memory = std::make_unique<WarningMemory>(diagnostics);
  auto reader = RecordingReader::open(sequence, config, options, *memory);
  if (!reader) return reader.error();
  if (!reader->calibration()) {
    return Error{ErrorCode::kUnsupportedData,
                 sequence.string() + ": expected ultrasound images, found a recording without any"};
  }
  return std::unique_ptr<RecordingSource>(
      new RecordingSource(*std::move(reader), std::move(memory), sequence.string()));
}

RecordingSource::RecordingSource(RecordingReader reader, std::unique_ptr<WarningMemory> diagnostics,
                                 std::string name)
    : diagnostics_(std::move(diagnostics)), reader_(std::move(reader)), name_(std::move(name)) {
  for (const ToolRole role : {ToolRole::kProbe, ToolRole::kReference, ToolRole::kNeedle}) {
    streams_.push_back({to_string(role), StreamKind::kPoses, role});
  }
  streams_.push_back({"Image", StreamKind::kImages, ToolRole::kOther});
}

void RecordingSource::rewind() {
  reader_.rewind();
  waiting_.clear();
  now_ = {};
  frames_read_ = 0;
  first_time_.reset();
  last_time_.reset();
  bad_frames_ = 0;
  first_bad_frame_.clear();
}

Result<Sample> RecordingSource::next(Deadline deadline) {
  while (waiting_.empty()) {
    if (stopped_) return Error{ErrorCode::kCancelled, name_ + ": reading was stopped"};
    if (auto ok = read_frame(); !ok) return ok.error();
  }
  if (waiting_.front().received > deadline) {
    return Error{ErrorCode::kTimeout, name_ + ": nothing more by the deadline"};
  }
  Sample sample = std::move(waiting_.front());
  waiting_.pop_front();
  return sample;
}

/// The fault of a frame, or empty.
std::string RecordingSource::defect_of(const RecordingImage& frame) const {
  if (!frame.acquired) return "expected a Timestamp, found none";
  if (last_time_ && *frame.acquired <= *last_time_) {
    std::ostringstream text;
    text << std::setprecision(12) << "Timestamp: expected a time after " << to_seconds(*last_time_)
         << " s, found " << to_seconds(*frame.acquired) << " s";
    return text.str();
  }
  if (!frame.image && frame.image.error().code == ErrorCode::kMalformedData) {
    return frame.image.error().message;
  }
  if (auto defect = rigid_defect<frames::Probe>(frame.probe); !defect.empty()) return defect;
  if (frame.reference) {
    if (auto defect = rigid_defect<frames::Reference>(*frame.reference); !defect.empty()) {
      return defect;
    }
  }
  return frame.needle ? rigid_defect<frames::Needle>(*frame.needle) : "";
}

void RecordingSource::note_unknown_status(const RecordingImage& frame) {
  const bool unknown = frame.probe.status == TrackingStatus::kUnknown ||
                       (frame.reference && frame.reference->status == TrackingStatus::kUnknown);
  if (!unknown) return;
  diagnostics_->report("recording", {.subject = name_,
                                     .key = "status of poses",
                                     .values = {"none with some poses"},
                                     .used = "their images as degraded"});
}

/// Stamps of milliseconds, where PLUS has seconds, put images minutes apart.
void RecordingSource::note_long_periods() {
  constexpr std::int64_t kFrames = 3;
  constexpr double kLong_s = 5;
  if (frames_read_ != kFrames || !first_time_) return;
  const double period_s = to_seconds(*last_time_ - *first_time_) / (kFrames - 1);
  if (!(period_s > kLong_s)) return;
  std::ostringstream text;
  text << "images " << period_s << " s apart (are the stamps in milliseconds?)";
  diagnostics_->report(
      "recording",
      {.subject = name_, .key = "Timestamp", .values = {text.str()}, .used = "seconds"});
}

Result<void> RecordingSource::read_frame() {
  diagnostics_->take_newest();
  auto frame = reader_.next();
  if (!frame) return frame.error();
  ++frames_read_;
  std::string defect = diagnostics_->take_newest();
  if (defect.starts_with(name_ + ": ")) defect.erase(0, name_.size() + 2);
  if (defect.empty()) defect = defect_of(*frame);
  if (!defect.empty() && bad_frames_++ == 0) {
    const std::string number = "frame " + std::to_string(frame->index);
    first_bad_frame_ = defect.find(number) == std::string::npos ? number + ": " + defect : defect;
  }
  if (frame->acquired) {
    // Stamps may begin anywhere, also before the origin.
    if (!first_time_) now_ = *frame->acquired;
    now_ = std::max(now_, *frame->acquired);
    first_time_ = std::min(first_time_.value_or(*frame->acquired), *frame->acquired);
    last_time_ = std::max(last_time_.value_or(*frame->acquired), *frame->acquired);
  }
  note_unknown_status(*frame);
  note_long_periods();
  deliver(*std::move(frame));
  return {};
}

void RecordingSource::deliver(RecordingImage frame) {
  const auto sequence = static_cast<std::uint64_t>(frame.index);
  const auto add = [&](std::size_t stream, auto what) {
    waiting_.push_back(
        {.stream = stream, .sequence = sequence, .received = now_, .what = std::move(what)});
  };
  const std::size_t images = streams_.size() - 1;
  const auto missing = [&](const char* cause, const std::string& message) {
    add(images, MissingImage{cause, message});
  };
  if (!frame.acquired) {
    return missing("no_timestamp", frame.image ? "frame " + std::to_string(frame.index) +
                                                     ": expected a Timestamp, found none"
                                               : frame.image.error().message);
  }
  add(0, PoseSample{frame.probe});
  if (frame.reference) add(1, PoseSample{*frame.reference});
  if (frame.needle) add(2, PoseSample{*frame.needle});
  if (!frame.image) return missing("unusable_picture", frame.image.error().message);
  add(images, *std::move(frame.image));
}

}  // namespace nav::io
