// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/played_recording.hpp"

#include <algorithm>
#include <utility>

#include "io/mcap/device_recording.hpp"
#include "io/recording_source.hpp"
#include "io/sequence.hpp"
#include "session/calibration_file.hpp"
#include "session/live_session.hpp"
#include "session/recorded_setup.hpp"

namespace nav::session {
namespace {

/// A PLUS sequence.
class SequenceRecording final : public PlayedRecording {
 public:
  SequenceRecording(const SourceOptions& options, std::shared_ptr<io::RecordingSource> source)
      : options_(options), source_(std::move(source)) {}

  Result<std::vector<std::shared_ptr<Source>>> rewind() override {
    source_->rewind();
    return std::vector<std::shared_ptr<Source>>{source_};
  }
  [[nodiscard]] SessionSetup setup() const override {
    SessionSetup setup;
    setup.calibration =
        ProbeCalibration{.probe_from_image = source_->calibration().probe_from_image,
                         .doubt = source_->calibration_doubt()};
    setup.navigator.pairing.temporal_offset = from_seconds(options_.temporal_offset_ms * 1e-3);
    if (source_->form() != io::RecordingForm::kTracked || reference_frame().empty()) {
      setup.fixed_reference.emplace(Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero());
    }
    return setup;
  }
  [[nodiscard]] std::int64_t total_images() const override { return source_->total_images(); }
  [[nodiscard]] ImagesRead read() const override {
    return {.frames = source_->frames_read(),
            .first_time = source_->first_time(),
            .last_time = source_->last_time(),
            .bad_frames = source_->bad_frames(),
            .first_bad_frame = source_->first_bad_frame()};
  }
  [[nodiscard]] std::string reference_frame() const override {
    const std::string& frame = source_->reference_frame();
    return frame == options_.tracker_frame ? "" : frame;
  }
  [[nodiscard]] bool has_needle() const override { return !options_.needle_frame.empty(); }
  [[nodiscard]] const std::string& description() const override { return source_->description(); }
  [[nodiscard]] Result<void> check_complete() const override {
    auto reader = io::SequenceReader::open(options_.recording);
    if (!reader) return reader.error();
    return io::check_complete(*reader);
  }

 private:
  SourceOptions options_;
  std::shared_ptr<io::RecordingSource> source_;
};

/// One device of a recording; counts its images as they are read.
class CountedSource final : public Source {
 public:
  CountedSource(std::unique_ptr<io::mcap::RecordedDeviceSource> source, std::string file,
                ImagesRead& read, Diagnostics& diagnostics)
      : source_(std::move(source)),
        file_(std::move(file)),
        read_(read),
        diagnostics_(diagnostics) {}

  [[nodiscard]] const std::vector<StreamInfo>& streams() const override {
    return source_->streams();
  }
  Result<Sample> next(Deadline deadline) override {
    auto sample = source_->next(deadline);
    if (!sample) {
      if (sample.error().code == ErrorCode::kEndOfStream && !source_->damage().empty()) {
        diagnostics_.report("recording", damage_finding(file_, {source_->damage()}));
      }
      return sample;
    }
    const bool image = streams()[sample->stream].kind == StreamKind::kImages;
    if (!image) return sample;
    ++read_.frames;
    read_.first_time = std::min(read_.first_time.value_or(sample->received), sample->received);
    read_.last_time = std::max(read_.last_time.value_or(sample->received), sample->received);
    return sample;
  }
  void stop() noexcept override { source_->stop(); }

 private:
  std::unique_ptr<io::mcap::RecordedDeviceSource> source_;
  std::string file_;
  ImagesRead& read_;
  Diagnostics& diagnostics_;
};

/// A recording of devices.
class DevicesRecording final : public PlayedRecording {
 public:
  DevicesRecording(io::mcap::DeviceRecording recording, SessionSetup setup,
                   std::string reference_frame, std::string description, Diagnostics& diagnostics)
      : recording_(std::move(recording)),
        setup_(std::move(setup)),
        reference_frame_(std::move(reference_frame)),
        description_(std::move(description)),
        diagnostics_(diagnostics) {}

  Result<std::vector<std::shared_ptr<Source>>> rewind() override {
    read_ = {};
    std::vector<std::shared_ptr<Source>> sources;
    for (std::size_t i = 0; i < recording_.devices().size(); ++i) {
      auto source = recording_.source(i);
      if (!source) return source.error();
      sources.push_back(std::make_shared<CountedSource>(*std::move(source), recording_.name(),
                                                        read_, diagnostics_));
    }
    return sources;
  }
  [[nodiscard]] SessionSetup setup() const override { return setup_; }
  [[nodiscard]] std::int64_t total_images() const override {
    std::uint64_t images = 0;
    for (const auto& device : recording_.devices()) {
      for (std::size_t i = 0; i < device.streams.size(); ++i) {
        if (device.streams[i].kind == StreamKind::kImages) images += device.samples[i];
      }
    }
    return static_cast<std::int64_t>(images);
  }
  [[nodiscard]] ImagesRead read() const override { return read_; }
  [[nodiscard]] std::string reference_frame() const override { return reference_frame_; }
  [[nodiscard]] bool has_needle() const override {
    for (const auto& device : recording_.devices()) {
      for (std::size_t i = 0; i < device.streams.size(); ++i) {
        if (device.streams[i].role == ToolRole::kNeedle && device.samples[i] > 0) return true;
      }
    }
    return false;
  }
  [[nodiscard]] const std::string& description() const override { return description_; }
  [[nodiscard]] Result<void> check_complete() const override { return {}; }

 private:
  io::mcap::DeviceRecording recording_;
  SessionSetup setup_;
  std::string reference_frame_, description_;
  Diagnostics& diagnostics_;
  ImagesRead read_;
};

Result<std::unique_ptr<PlayedRecording>> open_sequence(const SourceOptions& options,
                                                       Diagnostics& diagnostics) {
  auto source = open_recording_source(options.recording, options, diagnostics);
  if (!source) return source.error();
  return std::unique_ptr<PlayedRecording>(
      std::make_unique<SequenceRecording>(options, *std::move(source)));
}

Result<std::unique_ptr<PlayedRecording>> open_devices(const SourceOptions& options,
                                                      Diagnostics& diagnostics) {
  std::error_code ignored;
  if (std::filesystem::is_fifo(options.recording, ignored)) {
    return Error{ErrorCode::kIo, options.recording.string() +
                                     ": expected a file, because a recording of devices is read "
                                     "through its index at the end, found a pipe (store it first)"};
  }
  auto recording = io::mcap::DeviceRecording::open(options.recording);
  if (!recording) return recording.error();
  const std::string name = recording->name();
  if (!recording->warnings().empty()) {
    diagnostics.report("recording", damage_finding(name, recording->warnings()));
  }
  std::map<std::string, std::string> facts;
  for (const auto& metadata : recording->metadata()) {
    if (metadata.name == kSetupMetadata) facts = metadata.values;
  }
  // A needle without its calibration would be drawn elsewhere, so nothing replaces the setup.
  if (facts.empty() && !recording->warnings().empty()) {
    return Error{ErrorCode::kMalformedData, name + ": expected the setup of the session (" +
                                                kSetupMetadata + "), found it damaged or missing"};
  }
  auto setup = setup_from(facts, name);
  if (!setup) return setup.error();
  if (options.temporal_offset_ms != 0) {
    setup->navigator.pairing.temporal_offset = from_seconds(options.temporal_offset_ms * 1e-3);
  }
  if (!options.plus_config.empty()) {
    const auto pixels = probe_from_pixels(options);
    if (!pixels) return pixels.error();
    if (setup->calibration || setup->probe_from_pixels) {
      diagnostics.report(Severity::kInfo, "recording",
                         name + ": the calibration of " + options.plus_config.string() +
                             " replaces that of the recording");
    }
    setup->calibration.reset();
    setup->probe_from_pixels = *pixels;
  }
  if (!setup->calibration && !setup->probe_from_pixels) {
    return Error{ErrorCode::kUsage, name +
                                        ": expected a calibration of the probe in the recording "
                                        "or by --config, found none"};
  }
  std::string reference =
      facts.contains("reference_frame") ? facts["reference_frame"] : "Reference";
  if (setup->fixed_reference) reference.clear();
  const std::string description =
      facts.contains("calibration") ? facts["calibration"] : "calibration by --config";
  return std::unique_ptr<PlayedRecording>(std::make_unique<DevicesRecording>(
      *std::move(recording), *std::move(setup), reference, description, diagnostics));
}

}  // namespace

Finding damage_finding(const std::string& recording, const std::vector<std::string>& damage) {
  std::string all;
  for (const std::string& sentence : damage) {
    const bool names = sentence.starts_with(recording + ": ");
    all += (all.empty() ? "" : "; ") + (names ? sentence.substr(recording.size() + 2) : sentence);
  }
  return {.subject = recording,
          .key = "data of the recording",
          .values = {std::move(all)},
          .used = "what can be read"};
}

Result<std::unique_ptr<PlayedRecording>> PlayedRecording::open(const SourceOptions& options,
                                                               Diagnostics& diagnostics) {
  return is_device_recording(options.recording) ? open_devices(options, diagnostics)
                                                : open_sequence(options, diagnostics);
}

Result<std::shared_ptr<io::RecordingSource>> open_recording_source(
    const std::filesystem::path& sequence, const SourceOptions& options, Diagnostics& diagnostics) {
  std::optional<io::PlusConfig> plus;
  if (!options.plus_config.empty()) {
    auto read = read_calibrations(options);
    if (!read) return read.error();
    plus = std::move(*read);
  }
  const io::RecordingOptions names{.image_frame = options.image_frame,
                                   .probe_frame = options.probe_frame,
                                   .tracker_frame = options.tracker_frame,
                                   .reference_frame = options.reference_frame,
                                   .needle_frame = options.needle_frame};
  auto source = io::RecordingSource::open(sequence, plus ? &*plus : nullptr, names, diagnostics);
  if (!source) return source.error();
  return std::shared_ptr<io::RecordingSource>(*std::move(source));
}

bool is_device_recording(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) {
    return static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  });
  return extension == ".mcap";
}

}  // namespace nav::session
