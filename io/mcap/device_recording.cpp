// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/mcap/device_recording.hpp"

#include <algorithm>
#include <atomic>

#include "io/mcap/mcap_reader.hpp"
#include "io/mcap/recording_survey.hpp"
#include "io/mcap/sample_route.hpp"
#include "nav/check.hpp"

namespace nav::io::mcap {
namespace {

class FileDeviceSource final : public RecordedDeviceSource {
 public:
  FileDeviceSource(Reader reader, SampleRouter router, std::size_t device,
                   const RecordedDevice& description)
      : reader_(std::move(reader)),
        router_(std::move(router)),
        device_(device),
        id_(description.id),
        streams_(description.streams) {}

  [[nodiscard]] const std::vector<StreamInfo>& streams() const override { return streams_; }

  Result<Sample> next(Deadline deadline) override {
    if (!waiting_) {
      if (auto ok = fetch(); !ok) return ok.error();
    }
    if (stopped_) return Error{ErrorCode::kCancelled, name() + ": reading was stopped"};
    if (waiting_->received > deadline) {
      return Error{ErrorCode::kTimeout, name() + ": nothing more by the deadline"};
    }
    Sample sample = *std::move(waiting_);
    waiting_.reset();
    return sample;
  }

  void stop() noexcept override { stopped_ = true; }

  [[nodiscard]] std::string damage() const override {
    const std::string damage = reader_.damage();
    if (unreadable_ == 0) return damage;
    const std::string text = std::to_string(unreadable_) + " samples of an unknown layout";
    return damage.empty() ? name() + ": expected samples of known layouts, found " + text
                          : damage + "; " + text + " were left out";
  }

 private:
  [[nodiscard]] std::string name() const { return reader_.input().name() + ": " + id_; }

  /// Reads on until there is a sample of this device.
  Result<void> fetch() {
    while (!waiting_) {
      if (stopped_) return Error{ErrorCode::kCancelled, name() + ": reading was stopped"};
      const auto event = reader_.next();
      if (!event) return event.error();
      if (event->is_end()) {
        return Error{ErrorCode::kEndOfStream, name() + ": the recording has ended"};
      }
      if (event->message) take(*event->message);
    }
    return {};
  }

  void take(const Message& message) {
    const SampleRoute* route = router_.route(message);
    const bool is_ours = route && route->device == device_ && route->device_id == id_ &&
                         route->stream < streams_.size();
    if (!is_ours) return;
    waiting_ = decode(route->kind, message.data);
    if (waiting_) {
      waiting_->stream = route->stream;
    } else {
      ++unreadable_;
    }
  }

  Reader reader_;
  SampleRouter router_;
  std::size_t device_;
  std::string id_;
  std::vector<StreamInfo> streams_;
  std::optional<Sample> waiting_;
  std::uint64_t unreadable_ = 0;
  std::atomic<bool> stopped_{false};
};

/// The channels of a device in a summary, by number.
std::vector<bool> channels_of(const Summary& summary, std::size_t device, const std::string& id) {
  std::vector<bool> wanted(1, false);
  for (const Channel& channel : summary.channels) {
    const auto route = route_in(summary, channel, id);
    if (!route || route->device != device) continue;
    if (channel.id >= wanted.size()) wanted.resize(std::size_t{channel.id} + 1, false);
    wanted[channel.id] = true;
  }
  return wanted;
}

}  // namespace

MergedRecording::MergedRecording(std::vector<std::unique_ptr<RecordedDeviceSource>> sources)
    : sources_(std::move(sources)), waiting_(sources_.size()), ended_(sources_.size(), false) {}

Result<DeviceSample> MergedRecording::next() {
  std::optional<std::size_t> first;
  for (std::size_t device = 0; device < sources_.size(); ++device) {
    auto& waiting = waiting_[device];
    if (!waiting && !ended_[device]) {
      auto sample = sources_[device]->next(Deadline::max());
      ended_[device] = !sample && sample.error().code == ErrorCode::kEndOfStream;
      if (!sample && !ended_[device]) return sample.error();
      if (sample) waiting = *std::move(sample);
    }
    if (waiting && (!first || waiting->received < waiting_[*first]->received)) first = device;
  }
  if (!first) return Error{ErrorCode::kEndOfStream, "the recording has ended"};
  DeviceSample next{*first, *std::move(waiting_[*first])};
  waiting_[*first].reset();
  return next;
}

std::vector<std::string> MergedRecording::damage() const {
  std::vector<std::string> sentences;
  for (const auto& source : sources_) {
    const std::string sentence = source->damage();
    const bool is_new = std::find(sentences.begin(), sentences.end(), sentence) == sentences.end();
    if (!sentence.empty() && is_new) sentences.push_back(sentence);
  }
  return sentences;
}

Result<DeviceRecording> DeviceRecording::open(const std::filesystem::path& path,
                                              const RecordingAccess& access) {
  auto input = open_input(path);
  if (!input) return input.error();
  return open(*std::move(input), access);
}

Result<DeviceRecording> DeviceRecording::open(std::shared_ptr<const Input> input,
                                              const RecordingAccess& access) {
  auto contents = survey(input, access);
  if (!contents) return contents.error();
  DeviceRecording recording;
  recording.input_ = std::move(input);
  recording.access_ = access;
  recording.contents_ = *std::move(contents);
  return recording;
}

std::optional<std::size_t> DeviceRecording::find(const std::string& id) const {
  for (std::size_t device = 0; device < devices().size(); ++device) {
    if (devices()[device].id == id) return device;
  }
  return std::nullopt;
}

Result<std::unique_ptr<RecordedDeviceSource>> DeviceRecording::source(std::size_t device) const {
  NAV_CHECK(device < devices().size(), device, devices().size());
  ReaderOptions options;
  options.use_index = access_.use_index;
  options.filter.attachments_and_metadata = false;
  if (access_.use_index) {
    const auto summary = read_summary(*input_);
    if (!summary) return summary.error();
    if (*summary) options.filter.channels = channels_of(**summary, device, id());
  }
  auto reader = Reader::open(input_, options);
  if (!reader) return reader.error();
  return std::unique_ptr<RecordedDeviceSource>(std::make_unique<FileDeviceSource>(
      *std::move(reader), SampleRouter(id()), device, devices()[device]));
}

Result<MergedRecording> DeviceRecording::merged() const {
  std::vector<std::unique_ptr<RecordedDeviceSource>> sources;
  for (std::size_t device = 0; device < devices().size(); ++device) {
    auto added = source(device);
    if (!added) return added.error();
    sources.push_back(*std::move(added));
  }
  return MergedRecording(std::move(sources));
}

Result<std::vector<std::byte>> DeviceRecording::read(const AttachmentIndex& attachment,
                                                     std::uint64_t max_bytes) const {
  const AttachmentHead& head = attachment.head;
  const std::string name = input_->name() + ": attachment " + head.name;
  if (head.data_bytes > max_bytes || head.data_bytes > input_->size()) {
    return Error{ErrorCode::kUnsupportedData, name + ": expected at most " +
                                                  std::to_string(max_bytes) + " bytes, found " +
                                                  std::to_string(head.data_bytes)};
  }
  std::vector<std::byte> bytes(static_cast<std::size_t>(head.data_bytes));
  const auto got =
      input_->read_at(attachment.offset + kPrefixBytes + attachment_head_bytes(head), bytes);
  if (!got) return got.error();
  if (*got != bytes.size()) {
    return Error{ErrorCode::kIo, name + ": expected " + std::to_string(bytes.size()) +
                                     " bytes, found " + std::to_string(*got)};
  }
  return bytes;
}

std::uint64_t DeviceRecording::samples() const {
  std::uint64_t sum = 0;
  for (const RecordedDevice& device : devices()) {
    for (const std::uint64_t count : device.samples) sum += count;
  }
  return sum;
}

Duration DeviceRecording::duration() const {
  return first_time() ? *last_time() - *first_time() : Duration{};
}

}  // namespace nav::io::mcap
