// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/mcap/recording_survey.hpp"

#include <algorithm>
#include <utility>

#include "io/mcap/device_recorder.hpp"
#include "io/mcap/mcap_reader.hpp"

namespace nav::io::mcap {
namespace {

/// Most metadata records and attachments that are listed.
constexpr std::size_t kMostListed = 10'000;
/// Largest sum of the metadata that are kept, bytes.
constexpr std::size_t kMostMetadataBytes = std::size_t{16} << 20;

std::size_t bytes_in(const Metadata& record) {
  std::size_t sum = record.name.size();
  for (const auto& [key, value] : record.values) sum += key.size() + value.size();
  return sum;
}

Timestamp time_of(std::uint64_t log_time) {
  return Timestamp(Duration(static_cast<std::int64_t>(log_time)));
}

class Survey {
 public:
  Survey(const std::shared_ptr<const Input>& input, const RecordingAccess& access)
      : input_(input), access_(access) {}

  Result<RecordingContents> run() {
    for (const auto step : {&Survey::find_id, &Survey::read}) {
      if (auto ok = (this->*step)(); !ok) return ok.error();
    }
    if (contents_.id.empty()) {
      return Error{ErrorCode::kMalformedData,
                   input_->name() + ": expected a recording of Sonde (MCAP), found " +
                       (messages_ > 0 ? std::to_string(messages_) + " messages of another program"
                                      : "no intact part of one") +
                       (input_->size() == 0 ? ": the file is empty" : "")};
    }
    return std::move(contents_);
  }

 private:
  Result<Reader> reader(WalkFilter filter = {}) const {
    ReaderOptions options;
    options.use_index = access_.use_index;
    options.filter = std::move(filter);
    return Reader::open(input_, std::move(options));
  }

  /// Finds the id of the recording: in the index, else in the first part of the file that has one.
  Result<void> find_id() {
    auto open = reader();
    if (!open) return open.error();
    if (open->summary()) {
      for (const Channel& channel : open->summary()->channels) {
        if (contents_.id.empty()) contents_.id = recording_of(channel);
      }
    }
    while (contents_.id.empty()) {
      const auto event = open->next();
      if (!event) return event.error();
      if (event->is_end()) break;
      if (event->message) {
        ++messages_;
        contents_.id = recording_of(*event->message->channel);
      } else if (event->metadata && is_session(*event->metadata)) {
        contents_.id = event->metadata->values.at(kRecordingKey);
      }
    }
    return {};
  }

  Result<void> read() {
    // No channel is wanted when the index is believed: only attachments and metadata are read.
    auto open = reader();
    if (!open) return open.error();
    if (open->summary() && !access_.read_all) {
      take_counts(*open->summary());
      open = reader({true, std::vector<bool>(1, false)});
      if (!open) return open.error();
    }
    const bool counts = !open->summary() || access_.read_all;
    SampleRouter router(contents_.id);
    while (true) {
      const auto event = open->next();
      if (!event) return event.error();
      if (event->is_end()) break;
      if (event->message && counts) take(*event->message, router);
      if (event->metadata) take(*event->metadata);
      if (event->attachment) take(*event->attachment);
    }
    if (access_.read_all && open->summary()) take_streams(*open->summary());
    conclude(*open);
    return {};
  }

  void conclude(const Reader& reader) {
    contents_.is_finished = reader.is_finished();
    if (std::string damage = reader.damage(); !damage.empty()) {
      contents_.warnings.push_back(std::move(damage));
    }
    const auto warn = [&](std::uint64_t count, const char* text) {
      if (count == 0) return;
      contents_.warnings.push_back(input_->name() + ": expected only samples of this recording, " +
                                   "found " + std::to_string(count) + " " + text +
                                   ", which were left out");
    };
    warn(unreadable_, "samples of an unknown layout");
    warn(foreign_, "parts of another recording or program");
    warn(not_listed_, "metadata records and attachments above the limit");
  }

  [[nodiscard]] static bool is_session(const Metadata& record) {
    return record.name == kSessionMetadata && check(record) == MetadataCheck::kIntact &&
           record.values.count(kRecordingKey) > 0;
  }

  /// The device and stream of a route, which are added if they are new; null: its number belongs to
  /// another device.
  RecordedDevice* device_of(const SampleRoute& route) {
    auto& devices = contents_.devices;
    if (route.device >= devices.size()) devices.resize(route.device + 1);
    RecordedDevice& device = devices[route.device];
    if (device.id.empty()) device.id = route.device_id;
    if (device.id != route.device_id) return nullptr;
    if (route.stream >= device.streams.size()) {
      device.streams.resize(route.stream + 1);
      device.samples.resize(route.stream + 1);
    }
    device.streams[route.stream] = route.info;
    return &device;
  }

  void take_streams(const Summary& summary) {
    for (const Channel& channel : summary.channels) {
      if (const auto route = route_in(summary, channel, contents_.id)) device_of(*route);
    }
  }

  void take_counts(const Summary& summary) {
    for (const Channel& channel : summary.channels) {
      const auto count = summary.statistics.channel_messages.find(channel.id);
      const std::uint64_t messages =
          count == summary.statistics.channel_messages.end() ? 0 : count->second;
      const auto route = route_in(summary, channel, contents_.id);
      RecordedDevice* device = route ? device_of(*route) : nullptr;
      (device ? device->samples[route->stream] : foreign_) += messages;
    }
    if (summary.statistics.messages == 0) return;
    contents_.first_time = time_of(summary.statistics.start_time);
    contents_.last_time = time_of(summary.statistics.end_time);
  }

  void take(const Message& message, SampleRouter& router) {
    ++messages_;
    const SampleRoute* route = router.route(message);
    RecordedDevice* device = route ? device_of(*route) : nullptr;
    if (!device) {
      ++(recording_of(*message.channel) == contents_.id ? unreadable_ : foreign_);
      return;
    }
    const auto sample = decode(route->kind, message.data);
    if (!sample) {
      ++unreadable_;
      return;
    }
    ++device->samples[route->stream];
    const Timestamp at = sample->received;
    contents_.first_time = std::min(contents_.first_time.value_or(at), at);
    contents_.last_time = std::max(contents_.last_time.value_or(at), at);
  }

  void take(const Metadata& record) {
    if (check(record) != MetadataCheck::kIntact) {
      ++foreign_;
      return;
    }
    if (is_session(record)) {
      const bool is_ours = record.values.at(kRecordingKey) == contents_.id;
      if (is_ours && contents_.session.empty()) contents_.session = without_checksum(record).values;
      foreign_ += is_ours ? 0 : 1;
      return;
    }
    metadata_bytes_ += bytes_in(record);
    if (contents_.metadata.size() < kMostListed && metadata_bytes_ <= kMostMetadataBytes) {
      contents_.metadata.push_back(without_checksum(record));
    } else {
      ++not_listed_;
    }
  }

  void take(const AttachmentIndex& attachment) {
    if (contents_.attachments.size() < kMostListed) {
      contents_.attachments.push_back(attachment);
    } else {
      ++not_listed_;
    }
  }

  std::shared_ptr<const Input> input_;
  RecordingAccess access_;
  RecordingContents contents_;
  std::size_t metadata_bytes_ = 0;
  std::uint64_t messages_ = 0, unreadable_ = 0, foreign_ = 0, not_listed_ = 0;
};

}  // namespace

std::optional<SampleRoute> route_in(const Summary& summary, const Channel& channel,
                                    const std::string& recording_id) {
  const auto schema =
      std::find_if(summary.schemas.begin(), summary.schemas.end(),
                   [&](const Schema& candidate) { return candidate.id == channel.schema; });
  return route_of(channel, schema == summary.schemas.end() ? nullptr : &*schema, recording_id);
}

Result<RecordingContents> survey(const std::shared_ptr<const Input>& input,
                                 const RecordingAccess& access) {
  return Survey(input, access).run();
}

}  // namespace nav::io::mcap
