// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/openigtlink/openigtlink_source.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <sstream>

#include "devices/openigtlink/igtl_image.hpp"
#include "devices/openigtlink/igtl_messages.hpp"
#include "devices/openigtlink/igtl_pixels.hpp"
#include "devices/openigtlink/igtl_poses.hpp"
#include "nav/check.hpp"

namespace nav::devices {
namespace {

constexpr std::size_t kLeastRoom = std::size_t{1} << 16;
constexpr std::size_t kMostRoom = std::size_t{1} << 22;
constexpr std::size_t kMostNames = 64;

std::string_view wire_name(std::string_view name) { return name.substr(0, kIgtlDeviceBytes); }

/// Counts under a name; names beyond the limit share one entry.
void count_named(OpenIgtLinkHealth::Counts& counts, std::string_view name) {
  if (const auto found = counts.find(name); found != counts.end()) {
    ++found->second;
  } else if (counts.size() < kMostNames) {
    counts.emplace(name, 1);
  } else {
    ++counts["(others)"];
  }
}

std::string seconds_text(Duration duration) {
  std::ostringstream text;
  text << to_seconds(duration) << " s";
  return text.str();
}

/// Status of a single pose; PLUS reads the shorter key itself.
TrackingStatus status_of(const IgtlMetadata& metadata) {
  auto text = metadata.find("TransformStatus");
  if (!text) text = metadata.find("Status");
  return text ? igtl_tracking_status(*text) : TrackingStatus::kUnknown;
}

/// Status of one tool of several: PLUS writes it under the tool's name and "Status".
TrackingStatus status_of_tool(const IgtlMetadata& metadata, std::string_view tool) {
  constexpr std::string_view kEnd = "Status";
  TrackingStatus status = TrackingStatus::kUnknown;
  metadata.for_each([&](const IgtlMetadataEntry& entry) {
    if (entry.key.size() == tool.size() + kEnd.size() && entry.key.starts_with(tool) &&
        entry.key.ends_with(kEnd)) {
      status = igtl_tracking_status(entry.value);
    }
  });
  return status;
}

Error usage(const std::string& what) {
  return {ErrorCode::kUsage, "OpenIGTLink: expected " + what};
}

Result<void> validate_streams(const std::vector<OpenIgtLinkStream>& streams) {
  if (streams.empty()) return usage("at least one stream, found none");
  for (std::size_t i = 0; i < streams.size(); ++i) {
    const std::string& name = streams[i].device;
    if (name.empty()) return usage("a name for every stream, found an empty one");
    for (std::size_t j = 0; j < i; ++j) {
      if (streams[i].kind != streams[j].kind) continue;
      if (wire_name(name) != wire_name(streams[j].device)) continue;
      return usage("names that differ in their first 20 characters, found " + streams[j].device +
                   " and " + name);
    }
  }
  return {};
}

}  // namespace

std::string plus_transform_name(std::string_view from, std::string_view to) {
  return std::string(from) + "To" + std::string(to);
}

Result<void> validate(const OpenIgtLinkOptions& o) {
  if (o.port == 0) return usage("a port of 1 to 65535, found 0");
  for (const Duration time : {o.connect_timeout, o.first_retry, o.longest_retry, o.silence}) {
    if (time <= Duration(0) || time > std::chrono::hours(1)) {
      return usage("times above 0 and up to one hour, found " + seconds_text(time));
    }
  }
  if (o.longest_retry < o.first_retry) {
    return usage("a longest retry of at least " + seconds_text(o.first_retry) + ", found " +
                 seconds_text(o.longest_retry));
  }
  return validate_streams(o.streams);
}

const char* to_string(OpenIgtLinkState state) {
  switch (state) {
    case OpenIgtLinkState::kWaiting:
      return "waiting";
    case OpenIgtLinkState::kConnecting:
      return "connecting";
    case OpenIgtLinkState::kConnected:
      return "connected";
    case OpenIgtLinkState::kSilent:
      return "silent";
    case OpenIgtLinkState::kStopped:
      return "stopped";
  }
  return "unknown";
}

Result<std::unique_ptr<OpenIgtLinkSource>> OpenIgtLinkSource::create(OpenIgtLinkOptions options,
                                                                     const Clock& clock,
                                                                     Diagnostics& diagnostics) {
  if (const auto ok = validate(options); !ok) return ok.error();
  auto peer = resolve_tcp(options.host, options.port);
  if (!peer) return peer.error();
  return std::unique_ptr<OpenIgtLinkSource>(
      new OpenIgtLinkSource(std::move(options), *std::move(peer), clock, diagnostics));
}

OpenIgtLinkSource::OpenIgtLinkSource(OpenIgtLinkOptions options, TcpEndpoint peer,
                                     const Clock& clock, Diagnostics& diagnostics)
    : PolledSource(clock, diagnostics, "devices.openigtlink"),
      options_(std::move(options)),
      peer_(std::move(peer)),
      parser_(options_.parser),
      due_(clock.now()),
      retry_(options_.first_retry, options_.longest_retry) {
  for (const OpenIgtLinkStream& stream : options_.streams) {
    add_stream({stream.device, stream.kind, stream.role});
  }
  health_.samples.resize(streams().size());
  scales_.resize(streams().size());
}

OpenIgtLinkHealth OpenIgtLinkSource::account() const {
  const std::lock_guard lock(mutex_);
  OpenIgtLinkHealth health = health_;
  if (is_stopped()) health.state = OpenIgtLinkState::kStopped;
  return health;
}

SourceHealth OpenIgtLinkSource::health() const {
  const OpenIgtLinkHealth own = account();
  SourceHealth health;
  health.cause = own.cause;
  health.reconnects = own.connections > 0 ? own.connections - 1 : 0;
  health.bytes = own.stream.bytes;
  for (std::size_t i = 0; i < kIgtlFaults; ++i) {
    if (own.stream.faults[i] == 0) continue;
    health.bad_messages[to_string(static_cast<IgtlFault>(i))] = own.stream.faults[i];
  }
  for (const auto& [type, count] : own.rejected) health.bad_messages["rejected_" + type] = count;
  switch (own.state) {
    case OpenIgtLinkState::kWaiting:
    case OpenIgtLinkState::kConnecting:
      health.state = SourceState::kWaiting;
      break;
    case OpenIgtLinkState::kConnected:
      health.state = own.stream.messages > 0 ? SourceState::kStreaming : SourceState::kStarting;
      break;
    case OpenIgtLinkState::kSilent:
      health.state = SourceState::kSilent;
      break;
    case OpenIgtLinkState::kStopped:
      health.state = SourceState::kEnded;
      break;
  }
  return health;
}

/// Does what is due: begins or gives up an attempt, notices silence.
void OpenIgtLinkSource::advance(Timestamp now) {
  if (!socket_.is_open()) {
    auto begun = begin_tcp_connect(peer_);
    if (!begun) {
      lose({"error", begun.error().message});
      return;
    }
    socket_ = *std::move(begun);
    due_ = now + options_.connect_timeout;
    const std::lock_guard lock(mutex_);
    health_.state = OpenIgtLinkState::kConnecting;
  } else if (health_.state == OpenIgtLinkState::kConnecting) {
    lose({"connect_timeout", "no answer within " + seconds_text(options_.connect_timeout)});
  } else if (health_.state == OpenIgtLinkState::kConnected) {
    {
      const std::lock_guard lock(mutex_);
      health_.state = OpenIgtLinkState::kSilent;
      ++health_.silences;
    }
    report(Severity::kWarning, "nothing has come for " + seconds_text(options_.silence));
  }
}

/// Time at which advance() has something to do. The state is changed by this thread only.
Timestamp OpenIgtLinkSource::wake_time() const {
  switch (health_.state) {
    case OpenIgtLinkState::kConnected:
      return heard_ + options_.silence;
    case OpenIgtLinkState::kSilent:
      return Timestamp::max();
    default:
      return due_;
  }
}

Watched OpenIgtLinkSource::watched() const {
  const bool connecting = health_.state == OpenIgtLinkState::kConnecting;
  return {.fd = socket_.get(), .read = !connecting, .write = connecting};
}

void OpenIgtLinkSource::attend(bool readable, bool writable) {
  if (!socket_.is_open()) return;
  if (health_.state == OpenIgtLinkState::kConnecting) {
    if (!writable) return;
    if (const auto failure = finish_tcp_connect(socket_)) {
      lose(*failure);
    } else {
      connected(clock().now());
    }
  } else if (readable) {
    receive();
  }
}

void OpenIgtLinkSource::connected(Timestamp now) {
  {
    const std::lock_guard lock(mutex_);
    health_.state = OpenIgtLinkState::kConnected;
    ++health_.connections;
  }
  heard_ = now;
  reported_loss_.clear();
  report(Severity::kInfo, "connected");
  std::vector<std::byte> questions;
  if (options_.announce_version_2) {
    append_igtl_message(questions, {.version = 2, .type = "GET_STATUS", .device = "Sonde"}, {});
  }
  if (options_.request_tdata_ms) {
    std::vector<std::byte> content;
    append_igtl_start_tracking(content, *options_.request_tdata_ms);
    const std::uint16_t version = options_.announce_version_2 ? 2 : 1;
    append_igtl_message(questions, {.version = version, .type = "STT_TDATA", .device = "Sonde"},
                        content);
  }
  if (questions.empty()) return;
  const TcpTransfer sent = send_now(socket_, questions);
  if (sent.failure) {
    lose(*sent.failure);
  } else if (sent.bytes != questions.size()) {
    lose({"error", "the peer took only a part of the first message"});
  }
}

void OpenIgtLinkSource::receive() {
  const std::size_t least = std::clamp(parser_.wanted(), kLeastRoom, kMostRoom);
  const TcpTransfer got = receive_now(socket_, parser_.prepare(least));
  const Timestamp received = clock().now();
  if (got.bytes > 0) {
    parser_.commit(got.bytes);
    heard_ = received;
    const std::uint64_t before = parser_.counts().messages;
    const std::lock_guard lock(mutex_);
    if (health_.state == OpenIgtLinkState::kSilent) {
      report(Severity::kInfo, "bytes come again");
      health_.state = OpenIgtLinkState::kConnected;
    }
    read_messages(received);
    if (parser_.counts().messages > before) retry_.reset();
    health_.stream = parser_.counts();
    report_faults();
  }
  if (got.failure) lose(*got.failure);
}

void OpenIgtLinkSource::lose(const TcpFailure& failure) {
  const bool was_connected =
      health_.state == OpenIgtLinkState::kConnected || health_.state == OpenIgtLinkState::kSilent;
  socket_.close();
  parser_.reset();
  {
    const std::lock_guard lock(mutex_);
    health_.state = OpenIgtLinkState::kWaiting;
    health_.cause = failure.cause;
    health_.stream = parser_.counts();
    count_named(health_.losses, failure.cause);
  }
  const Duration wait = retry_.take();
  due_ = clock().now() + wait;
  if (was_connected || reported_loss_ != failure.cause) {
    reported_loss_ = failure.cause;
    report(Severity::kWarning, (was_connected ? "the connection is lost: " : "cannot connect: ") +
                                   failure.message + "; trying again in " + seconds_text(wait));
  }
}

void OpenIgtLinkSource::read_messages(Timestamp received) {
  while (const auto message = parser_.next()) take_message(*message, received);
}

void OpenIgtLinkSource::take_message(const IgtlMessage& message, Timestamp received) {
  const std::string_view type = message.header.type_name();
  if (type == "TRANSFORM") {
    const auto pose = decode_igtl_transform(message.content);
    if (!pose) return reject(message, pose.error().message);
    take_pose(message.header.device_name(), pose->matrix(), status_of(message.metadata), message,
              received);
  } else if (type == "POSITION" || type == "QTRANS") {
    const auto pose = decode_igtl_position(message.content);
    if (!pose) return reject(message, pose.error().message);
    take_pose(message.header.device_name(), pose->matrix(), status_of(message.metadata), message,
              received);
  } else if (type == "TDATA" || type == "QTDATA") {
    take_tools(message, received);
  } else if (type == "IMAGE") {
    take_image(message, received);
  } else if (type == "STATUS") {
    const auto status = decode_igtl_status(message.content);
    if (!status) return reject(message, status.error().message);
    if (status->code == 1) return;
    report_once(Severity::kWarning, "status",
                "the peer reports status " + std::to_string(status->code) + ", " +
                    igtl_escaped(status->error_name) + ": " + igtl_escaped(status->message, 200));
  } else {
    count_named(health_.skipped, type);
  }
}

void OpenIgtLinkSource::take_tools(const IgtlMessage& message, Timestamp received) {
  const auto take_all = [&](const auto& tools) {
    if (!tools) return reject(message, tools.error().message);
    for (std::size_t i = 0; i < tools->size(); ++i) {
      const auto tool = (*tools)[i];
      take_pose(tool.name, tool.pose.matrix(), status_of_tool(message.metadata, tool.name), message,
                received);
    }
  };
  if (message.header.type_name() == "TDATA") {
    take_all(decode_igtl_tdata(message.content));
  } else {
    take_all(decode_igtl_qtdata(message.content));
  }
}

void OpenIgtLinkSource::take_pose(std::string_view device, const Eigen::Matrix4d& matrix,
                                  TrackingStatus status, const IgtlMessage& message,
                                  Timestamp received) {
  const auto stream = stream_of(device, StreamKind::kPoses);
  if (!stream) return note_undeclared(device, message);
  PoseSample sample;
  sample.pose.acquired = received;
  sample.pose.received = received;
  sample.pose.status = status;
  sample.pose.tracker_from_body = matrix;
  add(*stream, message, received, std::move(sample));
}

void OpenIgtLinkSource::take_image(const IgtlMessage& message, Timestamp received) {
  const auto stream = stream_of(message.header.device_name(), StreamKind::kImages);
  if (!stream) return note_undeclared(message.header.device_name(), message);
  const auto missing = [&](const char* cause, const std::string& why) {
    add(*stream, message, received, MissingImage{cause, message.header.description() + ": " + why});
  };
  if (message.content.empty()) return missing("empty_image", "expected pixels, found none");
  const auto image = decode_igtl_image(message.content);
  if (!image) {
    reject(message, image.error().message);
    return missing("malformed_image", image.error().message);
  }
  UltrasoundImage frame;
  GreyScale& scale = scales_[*stream];
  const GreyScale before = scale;
  if (const auto ok = set_pixels(frame, *image, scale); !ok) {
    return missing("unsupported_image_type", ok.error().message);
  }
  say_scale(message.header.description(), before, scale);
  const Eigen::Vector3d spacing = image->spacing_mm();
  frame.acquired = received;
  frame.received = received;
  frame.sequence = health_.samples[*stream];
  frame.grid = PixelGrid::centred(image->size[0], spacing.x(), spacing.y());
  if (const auto ok = validate(frame.grid); !ok) {
    return missing("invalid_pixel_grid", ok.error().message);
  }
  add(*stream, message, received, std::move(frame));
}

void OpenIgtLinkSource::say_scale(const std::string& image, const GreyScale& before,
                                  const GreyScale& now) {
  const std::string white = std::to_string(now.white);
  if (now.white != before.white) {
    report(Severity::kInfo, image + ": samples of 16 bits, found up to " +
                                std::to_string(now.largest) + "; 0 to " + white +
                                " become 0 to 255, in all images");
  }
  if (now.largest > now.white && before.largest <= before.white) {
    report(Severity::kWarning, image + ": expected samples up to " + white + ", found " +
                                   std::to_string(now.largest) + ": larger ones are drawn white");
  }
}

void OpenIgtLinkSource::add(std::size_t stream, const IgtlMessage& message, Timestamp received,
                            decltype(Sample::what) what) {
  Sample sample;
  sample.stream = stream;
  sample.sequence = health_.samples[stream]++;
  sample.received = received;
  sample.device_time = message.header.device_time();
  sample.what = std::move(what);
  deliver(std::move(sample));
}

std::optional<std::size_t> OpenIgtLinkSource::stream_of(std::string_view device,
                                                        StreamKind kind) const {
  for (std::size_t i = 0; i < streams().size(); ++i) {
    if (streams()[i].kind == kind && wire_name(streams()[i].name) == device) return i;
  }
  return std::nullopt;
}

void OpenIgtLinkSource::note_undeclared(std::string_view device, const IgtlMessage& message) {
  const std::string name = igtl_escaped(message.header.type_name()) + " " + igtl_escaped(device);
  count_named(health_.undeclared, name);
  // Transforms that nobody needs are usual; an image is likely the one that is missed.
  const bool image = message.header.type_name() == "IMAGE";
  report_once(image ? Severity::kWarning : Severity::kInfo, name,
              "the peer sends " + name + ", which no stream declares");
}

void OpenIgtLinkSource::reject(const IgtlMessage& message, const std::string& why) {
  count_named(health_.rejected, message.header.type_name());
  report_once(Severity::kWarning, why, message.header.description() + ": " + why);
}

void OpenIgtLinkSource::report_faults() {
  const IgtlStreamCounts& counts = parser_.counts();
  for (std::size_t i = 0; i < kIgtlFaults; ++i) {
    if (counts.faults[i] == 0 || reported_faults_.faults[i] != 0) continue;
    report(Severity::kWarning,
           std::string("a broken message was skipped: ") + to_string(static_cast<IgtlFault>(i)));
  }
  reported_faults_ = counts;
}

}  // namespace nav::devices
