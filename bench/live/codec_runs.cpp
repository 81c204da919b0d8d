// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/live/codec_runs.hpp"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <iomanip>
#include <memory>
#include <span>
#include <sstream>
#include <utility>

#include "bench/measure.hpp"
#include "devices/can/canopen.hpp"
#include "devices/ndi/ndi_encode.hpp"
#include "devices/ndi/ndi_reply.hpp"
#include "devices/openigtlink/igtl_image.hpp"
#include "devices/openigtlink/igtl_parser.hpp"
#include "devices/openigtlink/igtl_poses.hpp"
#include "devices/usb/polhemus_codec.hpp"

namespace nav::bench {
namespace {

using Bytes = std::vector<std::byte>;

/// A codec and the messages that it is given again and again.
struct Work {
  std::string codec;
  std::size_t bytes;            ///< Bytes of all messages of one round.
  std::size_t messages;         ///< In one round.
  std::function<bool()> round;  ///< Decodes all messages once; false: some were not understood.
  std::string goal{};
};

/// Bytes are copied into the parser's buffer, as a socket does.
Work openigtlink(const std::string& codec, Bytes stream, std::size_t messages,
                 std::function<bool(const devices::IgtlMessage&)> decode, std::string goal) {
  const std::size_t bytes = stream.size();
  return {codec, bytes, messages,
          [stream = std::move(stream), messages, decode = std::move(decode),
           parser = std::make_shared<devices::IgtlParser>()] {
            parser->feed(stream);
            std::size_t understood = 0;
            while (const auto message = parser->next()) understood += decode(*message) ? 1 : 0;
            return understood == messages;
          },
          std::move(goal)};
}

Work openigtlink_images() {
  constexpr std::uint16_t kColumns = 820, kRows = 616;
  const Bytes pixels(std::size_t{kColumns} * kRows, std::byte{77});
  devices::IgtlImage image;
  image.size = image.part_size = {kColumns, kRows, 1};
  image.steps_mm = {{{0.1F, 0, 0}, {0, 0.1F, 0}, {0, 0, 1}}};
  image.pixels = pixels;
  Bytes content, stream;
  devices::append_igtl_image(content, image);
  devices::append_igtl_message(stream, {.type = "IMAGE", .device = "Image"}, content);
  return openigtlink(
      "openigtlink image", std::move(stream), 1,
      [](const devices::IgtlMessage& message) {
        return devices::decode_igtl_image(message.content).has_value();
      },
      ">= 1500 MB/s");
}

Work openigtlink_poses() {
  constexpr std::size_t kMessages = 100;
  Bytes content, stream;
  devices::IgtlWriter writer(content);
  devices::IgtlTransform::from(Eigen::Matrix4d::Identity()).write(writer);
  const devices::IgtlMetadataEntry status{.key = "TransformStatus", .value = "OK"};
  for (std::size_t i = 0; i < kMessages; ++i) {
    devices::append_igtl_message(stream,
                                 {.version = 2,
                                  .type = "TRANSFORM",
                                  .device = "ProbeToTracker",
                                  .metadata = std::span(&status, 1)},
                                 content);
  }
  return openigtlink(
      "openigtlink transform", std::move(stream), kMessages,
      [](const devices::IgtlMessage& message) {
        return devices::decode_igtl_transform(message.content).has_value() &&
               message.metadata.find("TransformStatus").has_value();
      },
      "");
}

/// Three tools, as a procedure has: probe, reference, needle.
devices::NdiReadings three_tools() {
  devices::NdiReadings readings;
  for (std::uint16_t handle = 1; handle <= 3; ++handle) {
    readings.tools.push_back({.handle = handle,
                              .presence = devices::NdiPresence::kMeasured,
                              .rotation_wxyz = {0.8, 0.6, 0, 0},
                              .translation_mm = {-113.27, 52.1, -1204.75},
                              .error_mm = 0.12,
                              .number = 7700});
  }
  return readings;
}

Work ndi(const std::string& codec, Bytes reply,
         std::function<Result<void>(const devices::NdiReply&, devices::NdiReadings&)> read,
         std::string goal) {
  const std::size_t bytes = reply.size();
  return {codec, bytes, 1,
          [reply = std::move(reply), read = std::move(read),
           out = std::make_shared<devices::NdiReadings>()] {
            const auto framing = devices::frame_ndi_reply(reply);
            return framing.size == reply.size() && !framing.fault &&
                   read(framing.reply, *out).has_value() && out->tools.size() == 3;
          },
          std::move(goal)};
}

Work can_positions() {
  constexpr std::size_t kFrames = 100;
  std::vector<devices::CanFrame> frames;
  for (std::uint32_t i = 0; i < kFrames; ++i) {
    frames.push_back(devices::can_position(1 + static_cast<int>(i % 6), 1000 + i));
  }
  constexpr std::size_t kFrameBytes = 16;  // The kernel's struct.
  return {"can position", kFrames * kFrameBytes, kFrames,
          [frames = std::move(frames)] {
            std::size_t understood = 0;
            for (const devices::CanFrame& frame : frames) {
              const auto message = devices::classify_canopen(frame);
              understood += message.kind != devices::CanOpenKind::kOther && message.node > 0 &&
                                    devices::read_position(frame).has_value()
                                ? 1
                                : 0;
            }
            return understood == frames.size();
          },
          ">= 1e6 messages/s"};
}

Work polhemus_records() {
  constexpr std::size_t kRecords = 100;
  Bytes transfer;
  for (std::size_t i = 0; i < kRecords; ++i) {
    devices::append_polhemus_record(transfer, {.station = 1 + static_cast<int>(i % 3),
                                               .time_ms = static_cast<std::uint32_t>(4 * i),
                                               .frame = static_cast<std::uint32_t>(i),
                                               .position_cm = {10, -20, 30},
                                               .rotation_wxyz = {1, 0, 0, 0}});
  }
  const std::size_t bytes = transfer.size();
  return {"polhemus record", bytes, kRecords,
          [transfer = std::move(transfer), parser = std::make_shared<devices::PolhemusParser>()] {
            std::size_t understood = 0;
            parser->take(transfer, [&](const devices::PolhemusNews& news) {
              understood += news.kind == devices::PolhemusNews::Kind::kRecord ? 1 : 0;
            });
            return understood == kRecords;
          }};
}

Result<CodecRun> run_of(const Work& work, double seconds) {
  std::size_t rounds = 0;
  double taken_s = 0;
  const double begun_s = process_time_s();
  // The first round makes buffers grow.
  for (std::size_t batch = 1; taken_s < seconds; batch = std::min<std::size_t>(2 * batch, 4096)) {
    for (std::size_t i = 0; i < batch; ++i) {
      if (!work.round()) {
        return Error{ErrorCode::kMalformedData,
                     work.codec + ": expected every message to be decoded"};
      }
    }
    rounds += batch;
    taken_s = process_time_s() - begun_s;
  }
  const double messages = static_cast<double>(rounds * work.messages);
  return CodecRun{work.codec, work.bytes / work.messages, messages / taken_s,
                  1e-6 * static_cast<double>(rounds * work.bytes) / taken_s, work.goal};
}

}  // namespace

Result<std::vector<CodecRun>> measure_codecs(double seconds) {
  if (!(seconds > 0 && seconds <= 60)) {
    return Error{ErrorCode::kUsage,
                 "codecs: expected more than 0 to 60 s, found " + std::to_string(seconds)};
  }
  const devices::NdiReadings tools = three_tools();
  const std::vector<Work> all{
      openigtlink_images(),
      openigtlink_poses(),
      ndi(
          "ndi TX", devices::ndi_text_reply(devices::ndi_tx_text(tools)),
          [](const devices::NdiReply& reply, devices::NdiReadings& out) {
            return devices::read_ndi_tx(reply.text, out);
          },
          ">= 2e5 messages/s"),
      ndi(
          "ndi BX2", devices::ndi_binary_reply(devices::ndi_bx2_body(tools)),
          [](const devices::NdiReply& reply, devices::NdiReadings& out) {
            return devices::read_ndi_bx2(reply.body, out);
          },
          ">= 1e6 messages/s"),
      can_positions(),
      polhemus_records()};
  std::vector<CodecRun> rows;
  for (const Work& work : all) {
    auto row = run_of(work, seconds);
    if (!row) return row.error();
    rows.push_back(*std::move(row));
  }
  return rows;
}

std::string to_text(const std::vector<CodecRun>& rows) {
  std::ostringstream text;
  text << "codecs, one core: messages found, checked and decoded\n"
       << std::left << std::setw(24) << "codec" << std::right << std::setw(9) << "bytes"
       << std::setw(14) << "messages/s" << std::setw(9) << "MB/s"
       << "  goal\n"
       << std::fixed << std::setprecision(0);
  for (const CodecRun& r : rows) {
    text << std::left << std::setw(24) << r.codec << std::right << std::setw(9) << r.bytes
         << std::setw(14) << r.per_second << std::setw(9) << r.mb_per_second << "  " << r.goal
         << '\n';
  }
  return text.str();
}

}  // namespace nav::bench
