// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/mcap/device_recorder.hpp"

#include <algorithm>
#include <cstdio>
#include <random>
#include <utility>

#include "nav/check.hpp"

namespace nav::io::mcap {
namespace {

/// Longest cause or message of a missing image, bytes.
constexpr std::size_t kMaxText = std::size_t{64} << 10;

std::string random_id() {
  std::random_device device;
  char text[17];
  std::snprintf(text, sizeof text, "%08x%08x", device(), device());
  return text;
}

/// Name of the kind in a channel.
std::string name_of(StreamKind kind) { return std::string(to_string(kind)) + "s"; }

/// Kind of the samples of a stream, but for missing images and those in colours.
SampleKind sample_kind_of(StreamKind kind) {
  switch (kind) {
    case StreamKind::kImages:
      return SampleKind::kImage;
    case StreamKind::kPoses:
      return SampleKind::kPose;
    case StreamKind::kButtons:
      break;
  }
  return SampleKind::kButton;
}

/// Part of a topic, without its separators.
std::string topic_part(std::string name) {
  std::replace(name.begin(), name.end(), '/', '_');
  return name;
}

std::uint64_t time_in_file(std::int64_t ns) { return ns > 0 ? static_cast<std::uint64_t>(ns) : 0; }

bool is_too_long(const Sample& sample) {
  const auto* missing = std::get_if<MissingImage>(&sample.what);
  return missing && std::max(missing->cause.size(), missing->message.size()) > kMaxText;
}

}  // namespace

std::uint64_t log_time(Timestamp time) { return time_in_file(time.time_since_epoch().count()); }

Result<std::unique_ptr<DeviceRecorder>> DeviceRecorder::create(const std::filesystem::path& path,
                                                               RecorderOptions options) {
  auto writer = Writer::create(path, options.writer);
  if (!writer) return writer.error();
  std::string id = options.id.empty() ? random_id() : std::move(options.id);
  options.session[kRecordingKey] = id;
  // First of all, so that what follows can be told to be of this recording.
  if (auto ok = writer->add_metadata({kSessionMetadata, std::move(options.session)}); !ok) {
    return ok.error();
  }
  return std::unique_ptr<DeviceRecorder>(new DeviceRecorder(*std::move(writer), std::move(id)));
}

DeviceRecorder::DeviceRecorder(Writer writer, std::string id)
    : id_(std::move(id)), writer_(std::move(writer)) {}

DeviceRecorder::~DeviceRecorder() { static_cast<void>(finish()); }

Result<std::uint16_t> DeviceRecorder::schema(SampleKind kind) {
  auto& known = schemas_[static_cast<std::size_t>(kind)];
  if (known) return *known;
  auto added = writer_.add_schema({0, schema_name(kind), "sonde", schema_text(kind)});
  if (added) known = *added;
  return added;
}

/// The channel of a stream and kind, which is added at its first use.
Result<std::uint16_t> DeviceRecorder::channel(std::size_t device, std::size_t stream,
                                              SampleKind kind) {
  const Device& owner = devices_[device];
  Stream& of = devices_[device].streams[stream];
  auto& known = of.channels[static_cast<std::size_t>(kind)];
  if (known) return *known;
  const auto schema_id = schema(kind);
  if (!schema_id) return schema_id;
  Channel channel;
  channel.schema = *schema_id;
  channel.topic = "/" + topic_part(owner.id) + "/" + topic_part(of.info.name) +
                  (kind == SampleKind::kMissingImage  ? "/missing"
                   : kind == SampleKind::kColourImage ? "/colour"
                                                      : "");
  channel.message_encoding = "sonde";
  channel.metadata = {{kRecordingKey, id_},
                      {"device", owner.id},
                      {"device_number", std::to_string(device)},
                      {"stream", of.info.name},
                      {"stream_number", std::to_string(stream)},
                      {"stream_kind", name_of(of.info.kind)},
                      {"role", to_string(of.info.role)}};
  if (of.info.kind == StreamKind::kButtons) channel.metadata["action"] = to_string(of.info.action);
  auto added = writer_.add_channel(std::move(channel));
  if (added) known = *added;
  return added;
}

Result<std::size_t> DeviceRecorder::add_device(const std::string& id,
                                               const std::vector<StreamInfo>& streams) {
  const std::lock_guard lock(mutex_);
  const bool taken = std::any_of(devices_.begin(), devices_.end(),
                                 [&](const Device& device) { return device.id == id; });
  if (id.empty() || taken) {
    return Error{ErrorCode::kUsage, "device '" + id + "': expected a new name, found " +
                                        (taken ? "that of another device" : "an empty one")};
  }
  if (devices_.size() >= kMaxDevices || streams.size() > kMaxStreams) {
    return Error{ErrorCode::kUsage, "device '" + id + "': expected at most " +
                                        std::to_string(kMaxDevices) + " devices of " +
                                        std::to_string(kMaxStreams) + " streams, found more"};
  }
  devices_.push_back({id, {}});
  for (const StreamInfo& info : streams) devices_.back().streams.push_back({info, {}});
  const std::size_t device = devices_.size() - 1;
  for (std::size_t stream = 0; stream < streams.size(); ++stream) {
    const auto added = channel(device, stream, sample_kind_of(streams[stream].kind));
    if (!added) return added.error();
  }
  return device;
}

Result<void> DeviceRecorder::record(std::size_t device, const Sample& sample) {
  const std::lock_guard lock(mutex_);
  NAV_CHECK(!finished_ && device < devices_.size(), device, devices_.size());
  NAV_CHECK(sample.stream < devices_[device].streams.size(), devices_[device].id, sample.stream);
  if (is_too_long(sample)) {
    return Error{ErrorCode::kUsage, devices_[device].id + ": expected at most " +
                                        std::to_string(kMaxText) +
                                        " bytes of text about a missing image, found more"};
  }
  const auto id = channel(device, sample.stream, kind_of(sample));
  if (!id) return id.error();
  MessageHead head;
  head.channel = *id;
  head.sequence = static_cast<std::uint32_t>(sample.sequence);
  head.log_time = log_time(sample.received);
  head.publish_time = sample.device_time
                          ? time_in_file(sample.device_time->time_since_epoch().count())
                          : head.log_time;
  const EncodedSample encoded = encode(sample, buffer_);
  return writer_.write(head, encoded.fields, encoded.pixels);
}

Result<void> DeviceRecorder::advance_to(Timestamp now) {
  const std::lock_guard lock(mutex_);
  return writer_.advance_to(log_time(now));
}

Result<void> DeviceRecorder::flush() {
  const std::lock_guard lock(mutex_);
  return writer_.flush();
}

Result<void> DeviceRecorder::attach(const std::string& name, const std::string& media_type,
                                    Timestamp now, std::span<const std::byte> bytes) {
  const std::lock_guard lock(mutex_);
  return writer_.attach({log_time(now), log_time(now), name, media_type, 0}, bytes);
}

Result<void> DeviceRecorder::add_metadata(const std::string& name, TextMap values) {
  const std::lock_guard lock(mutex_);
  return writer_.add_metadata({name, std::move(values)});
}

Result<void> DeviceRecorder::finish() {
  const std::lock_guard lock(mutex_);
  if (std::exchange(finished_, true)) {
    return writer_.stopped() ? Result<void>(*writer_.stopped()) : Result<void>();
  }
  return writer_.finish();
}

std::optional<Error> DeviceRecorder::stopped() const {
  const std::lock_guard lock(mutex_);
  return writer_.stopped();
}

RecorderCounts DeviceRecorder::counts() const {
  const std::lock_guard lock(mutex_);
  return {writer_.messages(), writer_.size(), writer_.chunks()};
}

}  // namespace nav::io::mcap
