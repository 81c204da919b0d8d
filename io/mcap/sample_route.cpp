// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/mcap/sample_route.hpp"

#include <charconv>

#include "io/mcap/device_recorder.hpp"

namespace nav::io::mcap {
namespace {

const std::string* value_of(const Channel& channel, const char* key) {
  const auto found = channel.metadata.find(key);
  return found == channel.metadata.end() ? nullptr : &found->second;
}

std::optional<std::size_t> number_below(const std::string* text, std::size_t limit) {
  std::size_t number = 0;
  if (!text) return std::nullopt;
  const char* end = text->data() + text->size();
  const auto [stop, failure] = std::from_chars(text->data(), end, number);
  if (failure != std::errc() || stop != end || number >= limit) return std::nullopt;
  return number;
}

std::optional<StreamKind> stream_kind_of(const std::string& name) {
  if (name == "images") return StreamKind::kImages;
  if (name == "poses") return StreamKind::kPoses;
  if (name == "buttons") return StreamKind::kButtons;
  return std::nullopt;
}

/// False for a sample that a stream of this kind cannot have.
bool fits(SampleKind sample, StreamKind stream) {
  switch (sample) {
    case SampleKind::kPose:
      return stream == StreamKind::kPoses;
    case SampleKind::kButton:
      return stream == StreamKind::kButtons;
    case SampleKind::kImage:
    case SampleKind::kColourImage:
    case SampleKind::kMissingImage:
      break;
  }
  return stream == StreamKind::kImages;
}

std::optional<ToolRole> role_of(const std::string& name) {
  for (const ToolRole role : {ToolRole::kProbe, ToolRole::kReference, ToolRole::kNeedle,
                              ToolRole::kStylus, ToolRole::kPhantom, ToolRole::kOther}) {
    if (name == to_string(role)) return role;
  }
  return std::nullopt;
}

}  // namespace

std::string recording_of(const Channel& channel) {
  const std::string* id = value_of(channel, kRecordingKey);
  return id ? *id : "";
}

std::optional<SampleRoute> route_of(const Channel& channel, const Schema* schema,
                                    const std::string& recording_id) {
  if (!schema || recording_of(channel) != recording_id) return std::nullopt;
  const auto kind = sample_kind(schema->name);
  const auto device = number_below(value_of(channel, "device_number"), kMaxDevices);
  const auto stream = number_below(value_of(channel, "stream_number"), kMaxStreams);
  const std::string* device_id = value_of(channel, "device");
  const std::string* name = value_of(channel, "stream");
  const std::string* kind_name = value_of(channel, "stream_kind");
  const std::string* role_name = value_of(channel, "role");
  const std::string* action_name = value_of(channel, "action");
  if (!kind || !device || !stream || !device_id || !name || !kind_name || !role_name) {
    return std::nullopt;
  }
  const auto stream_kind = stream_kind_of(*kind_name);
  const auto role = role_of(*role_name);
  const auto action = action_name ? button_action_from(*action_name) : ButtonAction::kNone;
  if (!stream_kind || !role || !action || !fits(*kind, *stream_kind)) return std::nullopt;
  return SampleRoute{.device = *device,
                     .device_id = *device_id,
                     .stream = *stream,
                     .info = {*name, *stream_kind, *role, *action},
                     .kind = *kind};
}

const SampleRoute* SampleRouter::route(const Message& message) {
  if (message.definitions != definitions_) by_channel_.clear();
  definitions_ = message.definitions;
  const std::size_t id = message.head.channel;
  if (id >= by_channel_.size()) by_channel_.resize(id + 1);
  Known& known = by_channel_[id];
  if (!known.is_known) known = {true, route_of(*message.channel, message.schema, recording_id_)};
  return known.route ? &*known.route : nullptr;
}

}  // namespace nav::io::mcap
