// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/export.hpp"

#include <cstring>
#include <utility>

#include "app/verbs/simulate/simulated_recording.hpp"
#include "io/sequence_writer.hpp"
#include "session/recorded_session.hpp"

namespace nav::app {
namespace {

/// Writes the images of one recording.
class Export {
 public:
  Export(const ExportOptions& options, const session::RecordedSession& session, bool has_reference)
      : options_(options), session_(session), has_reference_(has_reference) {}

  Result<void> add(const tracking::PairedFrame& paired) {
    if (!paired.tracked) {
      ++left_out_;
      return {};
    }
    if (auto ok = write_held(); !ok) return ok;
    held_ = paired.tracked->frame;
    return {};
  }

  Result<void> finish(Console& console) {
    if (auto ok = write_held(); !ok) return ok;
    if (!writer_) return session::nothing_paired(session_);
    if (left_out_ > 0) {
      console.report(Severity::kWarning, "export",
                     std::to_string(left_out_) + " images without a pose are left out");
    }
    if (other_size_ > 0) {
      console.report(Severity::kWarning, "export",
                     std::to_string(other_size_) +
                         " images of another size than the first are left out: a sequence has one");
    }
    const auto written = writer_->frame_count();
    if (auto ok = writer_->finish(); !ok) return ok;
    console.say(options_.out.string() + ": " + std::to_string(written) + " frames");
    return {};
  }

 private:
  /// Writes the image before: by now, all poses at its time have come.
  Result<void> write_held() {
    if (!held_) return {};
    const UltrasoundFrame image = *std::exchange(held_, std::nullopt);
    if (!writer_) {
      if (auto ok = begin(image); !ok) return ok;
    }
    if (image.pixels.width() != width_ || image.pixels.height() != height_) {
      ++other_size_;
      return {};
    }
    io::SequenceFrame frame;
    frame.timestamp_s = to_seconds(image.acquired);
    frame.unfiltered_timestamp_s = frame.timestamp_s;
    frame.image_valid = true;
    frame.pixels.resize(image.pixels.pixels().size());
    std::memcpy(frame.pixels.data(), image.pixels.pixels().data(), frame.pixels.size());
    add_pose(frame, "ProbeToTracker", ToolRole::kProbe, image.acquired);
    if (has_reference_) add_pose(frame, "ReferenceToTracker", ToolRole::kReference, image.acquired);
    const auto& navigator = session_.navigator();
    if (navigator.ledger(ToolRole::kNeedle).received() > 0) {
      add_pose(frame, "NeedleTipToTracker", ToolRole::kNeedle, image.acquired);
    }
    io::set_transform(frame, {"ImageToProbe",
                              session_.probe_from_image().matrix() * image_from_pixels(image.grid),
                              TrackingStatus::kOk});
    return writer_->append(frame);
  }

  Result<void> begin(const UltrasoundFrame& image) {
    io::SequenceHeader header;
    width_ = header.width = image.pixels.width();
    height_ = header.height = image.pixels.height();
    header.compressed = options_.compress;
    auto writer = io::SequenceWriter::create(options_.out, header);
    if (!writer) return writer.error();
    writer_ = *std::move(writer);
    return {};
  }

  void add_pose(io::SequenceFrame& frame, const char* name, ToolRole role, Timestamp time) const {
    const auto pose = session_.navigator().tracker_from(role, time);
    io::set_transform(frame, {name, pose.value_or(Eigen::Matrix4d::Identity()),
                              pose ? TrackingStatus::kOk : TrackingStatus::kInvalid});
  }

  const ExportOptions& options_;
  const session::RecordedSession& session_;
  bool has_reference_;
  std::optional<io::SequenceWriter> writer_;
  int width_ = 0, height_ = 0;
  std::optional<UltrasoundFrame> held_;
  std::uint64_t left_out_ = 0, other_size_ = 0;
};

}  // namespace

Result<void> run_export(const SessionConfig& config, const ExportOptions& options,
                        Console& console) {
  if (auto ok = require_path(config.source.recording, "recording", "a recording"); !ok) return ok;
  auto session = session::RecordedSession::open(config.source, console);
  if (!session) return session.error();
  console.begin("export");
  Export exported(options, *session, session->reference_frame() != config.source.tracker_frame);
  std::optional<Error> failure;
  session::Session::Listener listener;
  listener.settled = [&](const tracking::PairedFrame& paired) {
    if (failure) return;
    if (auto added = exported.add(paired); !added) failure = added.error();
  };
  for (bool more = true; more && !failure;) {
    const auto stepped = session->step(listener);
    if (!stepped) return stepped.error();
    more = *stepped;
    console.progress(static_cast<double>(session->frames_read()) /
                     static_cast<double>(std::max<std::int64_t>(session->total_frames(), 1)));
  }
  console.end();
  if (failure) return *failure;
  return exported.finish(console);
}

}  // namespace nav::app
