// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/export.hpp"

#include <filesystem>
#include <utility>

#include "app/verbs/simulate/simulated_recording.hpp"
#include "io/sequence_writer.hpp"
#include "session/recorded_session.hpp"

namespace nav::app {
namespace {

/// Writes the images of one recording.
class Export {
 public:
  /// \p colours: write RGB also if the first image is grey.
  Export(const ExportOptions& options, const session::RecordedSession& session, bool has_reference,
         bool colours)
      : options_(options), session_(session), has_reference_(has_reference), colours_(colours) {}

  Result<void> add(const tracking::PairedImage& paired) {
    if (!paired.tracked) {
      ++left_out_;
      return {};
    }
    const bool in_colours = !paired.tracked->frame.colours.empty();
    if (!held_ && !writer_) colours_ = colours_ || in_colours;
    lost_colours_ += !colours_ && in_colours ? 1U : 0U;
    if (auto ok = write_held(); !ok) return ok;
    held_ = paired.tracked->frame;
    return {};
  }

  /// Images that have colours and are written in grey.
  [[nodiscard]] std::uint64_t lost_colours() const { return lost_colours_; }

  void add(const session::PressedButton& press) { presses_.push_back(press); }

  Result<void> finish(Console& console) {
    if (auto ok = write_held(); !ok) return ok;
    if (written_presses_ < presses_.size()) {
      console.report(Severity::kWarning, "export",
                     std::to_string(presses_.size() - written_presses_) +
                         " presses of buttons after the last image are left out; sonde info lists "
                         "them");
    }
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
    if (lost_colours_ > 0) {
      console.report(Severity::kWarning, "export",
                     std::to_string(lost_colours_) +
                         " images with colours are written in grey, like the first: a pipe can be "
                         "read only once");
    }
    const auto written = writer_->frame_count();
    if (auto ok = writer_->finish(); !ok) return ok;
    console.end();
    console.say(options_.out.string() + ": " + std::to_string(written) + " frames");
    return {};
  }

 private:
  /// Writes the image before: by now, all poses at its time have come.
  Result<void> write_held() {
    if (!held_) return {};
    const UltrasoundImage image = *std::exchange(held_, std::nullopt);
    if (!writer_) {
      if (auto ok = begin(image); !ok) return ok;
    }
    if (image.pixels.width() != width_ || image.pixels.height() != height_) {
      ++other_size_;
      return {};
    }
    io::SequenceImage frame;
    frame.timestamp_s = to_seconds(image.acquired);
    frame.unfiltered_timestamp_s = frame.timestamp_s;
    frame.image_valid = true;
    frame.pixels = samples_of(image);
    add_pose(frame, "ProbeToTracker", ToolRole::kProbe, image.acquired);
    if (has_reference_) add_pose(frame, "ReferenceToTracker", ToolRole::kReference, image.acquired);
    const auto& navigator = session_.navigator();
    if (navigator.ledger(ToolRole::kNeedle).received() > 0) {
      add_pose(frame, "NeedleTipToTracker", ToolRole::kNeedle, image.acquired);
    }
    io::set_transform(frame, {"ImageToProbe",
                              session_.probe_from_image().matrix() * image_from_pixels(image.grid),
                              TrackingStatus::kOk});
    add_presses(frame, image.acquired);
    return writer_->append(frame);
  }

  /// Field "ButtonPresses" of the first frame at or after a press: "mark left" for the action and
  /// the button, several separated by "; ".
  void add_presses(io::SequenceImage& frame, Timestamp time) {
    std::string text;
    for (; written_presses_ < presses_.size(); ++written_presses_) {
      const session::PressedButton& press = presses_[written_presses_];
      if (press.acquired > time) break;
      text.append(text.empty() ? "" : "; ").append(to_string(press.action));
      text.append(" ").append(without_controls(press.button));
    }
    if (!text.empty()) frame.fields["ButtonPresses"] = text;
  }

  /// Samples as the file has them.
  [[nodiscard]] std::vector<std::byte> samples_of(const UltrasoundImage& image) const {
    const auto grey = std::as_bytes(image.pixels.pixels());
    if (!colours_) return {grey.begin(), grey.end()};
    const auto rgb = std::as_bytes(image.colours.pixels());
    if (!rgb.empty()) return {rgb.begin(), rgb.end()};
    std::vector<std::byte> samples;
    samples.reserve(3 * grey.size());
    for (const std::byte value : grey) samples.insert(samples.end(), 3, value);
    return samples;
  }

  Result<void> begin(const UltrasoundImage& image) {
    io::SequenceHeader header;
    if (colours_) {
      header.components = 3;
      header.image_type = "RGB_COLOR";
    }
    width_ = header.width = image.pixels.width();
    height_ = header.height = image.pixels.height();
    header.compressed = options_.compress;
    auto writer = io::SequenceWriter::create(options_.out, header);
    if (!writer) return writer.error();
    writer_ = *std::move(writer);
    return {};
  }

  void add_pose(io::SequenceImage& frame, const char* name, ToolRole role, Timestamp time) const {
    const auto pose = session_.navigator().tracker_from(role, time);
    io::set_transform(frame, {name, pose.value_or(Eigen::Matrix4d::Identity()),
                              pose ? TrackingStatus::kOk : TrackingStatus::kInvalid});
  }

  const ExportOptions& options_;
  const session::RecordedSession& session_;
  bool has_reference_;
  bool colours_;
  std::optional<io::SequenceWriter> writer_;
  int width_ = 0, height_ = 0;
  std::optional<UltrasoundImage> held_;
  std::uint64_t left_out_ = 0, other_size_ = 0, lost_colours_ = 0;
  std::vector<session::PressedButton> presses_;
  std::size_t written_presses_ = 0;
};

/// Plays the session and writes its images. False: not finished, because images with colours follow
/// a grey one and need \p colours; never from a pipe.
Result<bool> write_images(session::RecordedSession& session, const SessionConfig& config,
                          const ExportOptions& options, bool colours, Console& console) {
  Export exported(options, session, session.reference_frame() != config.source.tracker_frame,
                  colours);
  const bool again = !std::filesystem::is_fifo(config.source.recording);
  std::optional<Error> failure;
  session::Session::Listener listener;
  listener.settled = [&](const tracking::PairedImage& paired) {
    if (failure) return;
    if (auto added = exported.add(paired); !added) failure = added.error();
  };
  listener.pressed = [&](const session::PressedButton& press) { exported.add(press); };
  for (bool more = true; more && !failure;) {
    const auto stepped = session.step(listener);
    if (!stepped) return stepped.error();
    more = *stepped;
    if (again && exported.lost_colours() > 0) return false;
    console.progress(static_cast<double>(session.frames_read()) /
                     static_cast<double>(std::max<std::int64_t>(session.total_images(), 1)));
  }
  if (failure) return *failure;
  if (auto ok = exported.finish(console); !ok) return ok.error();
  return true;
}

}  // namespace

Result<void> run_export(const SessionConfig& config, const ExportOptions& options,
                        Console& console) {
  if (auto ok = require_path(config.source.recording, "recording", "a recording"); !ok) return ok;
  auto session = session::RecordedSession::open(config.source, console);
  if (!session) return session.error();
  console.begin("export");
  for (bool colours = false;; colours = true) {
    const auto written = write_images(*session, config, options, colours, console);
    if (!written) return written.error();
    if (*written) return {};
    if (auto ok = session->rewind(); !ok) return ok;
  }
}

}  // namespace nav::app
