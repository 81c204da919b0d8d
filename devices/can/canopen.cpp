// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/can/canopen.hpp"

#include <array>
#include <cstdio>

#include "nav/check.hpp"

namespace nav::devices {
namespace {

// Function codes: the upper four bits of an identifier (CiA 301, predefined connection set).
constexpr std::uint32_t kNmtId = 0x000, kSyncId = 0x080, kEmergencyId = 0x080, kPdo1Id = 0x180,
                        kPdo2Id = 0x280, kSdoReplyId = 0x580, kSdoRequestId = 0x600,
                        kHeartbeatId = 0x700;
constexpr std::uint8_t kSdoAbort = 0x80, kSdoRead = 0x40, kSdoWritten = 0x60;

CanFrame frame_of(std::uint32_t id, std::initializer_list<std::uint8_t> bytes) {
  CanFrame frame{.id = id};
  for (const std::uint8_t byte : bytes) frame.data[frame.size++] = byte;
  return frame;
}

std::uint32_t of_node(std::uint32_t function, int node) {
  NAV_CHECK(node >= 1 && node <= kMostCanNodes, "a node has a number of 1 to 127");
  return function + static_cast<std::uint32_t>(node);
}

CanFrame sdo_frame(std::uint32_t id, std::uint8_t command, CanObject object, std::uint32_t value) {
  CanFrame frame = frame_of(id, {command, static_cast<std::uint8_t>(object.index & 0xFF),
                                 static_cast<std::uint8_t>(object.index >> 8), object.sub});
  for (int i = 0; i < 4; ++i)
    frame.data[frame.size++] = static_cast<std::uint8_t>(value >> (8 * i));
  return frame;
}

CanObject object_in(const CanFrame& frame) {
  return {static_cast<std::uint16_t>(frame.data[1] | frame.data[2] << 8), frame.data[3]};
}

/// A number of 1 to 4 bytes, from a byte on.
std::uint32_t number_in(const CanFrame& frame, std::size_t from, std::size_t bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < bytes; ++i) {
    value |= static_cast<std::uint32_t>(frame.data[from + i]) << (8 * i);
  }
  return value;
}

std::string in_hex(std::uint32_t value, int digits) {
  std::array<char, 16> text{};
  (void)std::snprintf(text.data(), text.size(), "0x%0*X", digits, value);
  return text.data();
}

/// Bytes of an expedited transfer by its first byte; 0: it is none, or does not say.
std::size_t expedited_bytes(std::uint8_t command) {
  const bool expedited = (command & 0x02) != 0, sized = (command & 0x01) != 0;
  if (!expedited) return 0;
  return sized ? 4U - ((command >> 2) & 3U) : 4U;
}

}  // namespace

CanFrame can_nmt(NmtCommand command, int node) {
  return frame_of(kNmtId, {static_cast<std::uint8_t>(command), static_cast<std::uint8_t>(node)});
}

CanFrame can_sync() { return {.id = kSyncId}; }

CanFrame can_sdo_read(int node, CanObject object) {
  return sdo_frame(of_node(kSdoRequestId, node), kSdoRead, object, 0);
}

CanFrame can_sdo_write(int node, CanObject object, std::uint32_t value, int bytes) {
  NAV_CHECK(bytes >= 1 && bytes <= 4, "an expedited transfer has 1 to 4 bytes");
  const auto command = static_cast<std::uint8_t>(0x23 | (4 - bytes) << 2);
  return sdo_frame(of_node(kSdoRequestId, node), command, object, value);
}

CanOpenMessage classify_canopen(const CanFrame& frame) {
  if (frame.error || frame.extended || frame.remote || frame.id > 0x7FF) return {};
  const std::uint32_t function = frame.id & ~0x7FU;
  const int node = static_cast<int>(frame.id & 0x7FU);
  if (frame.id == kNmtId) return {CanOpenKind::kNmt, 0};
  if (frame.id == kSyncId) return {CanOpenKind::kSync, 0};
  if (node == 0) return {};
  switch (function) {
    case kEmergencyId:
      return {CanOpenKind::kEmergency, node};
    case kPdo1Id:
      return {CanOpenKind::kPdo1, node};
    case kPdo2Id:
      return {CanOpenKind::kPdo2, node};
    case kSdoReplyId:
      return {CanOpenKind::kSdoReply, node};
    case kSdoRequestId:
      return {CanOpenKind::kSdoRequest, node};
    case kHeartbeatId:
      return {CanOpenKind::kHeartbeat, node};
    default:
      return {};
  }
}

std::optional<SdoReply> read_sdo_reply(const CanFrame& frame) {
  if (frame.size < 8) return std::nullopt;
  const std::uint8_t command = frame.data[0];
  SdoReply reply{.object = object_in(frame)};
  if (command == kSdoAbort) {
    reply.is_abort = true;
    reply.value = number_in(frame, 4, 4);
    return reply;
  }
  if (command == kSdoWritten) return reply;
  const std::size_t bytes = expedited_bytes(command);
  if ((command & 0xE0) != kSdoRead || bytes == 0) return std::nullopt;
  reply.value = number_in(frame, 4, bytes);
  return reply;
}

std::string sdo_abort_sentence(std::uint32_t code) {
  const char* text = "the node rejects the request";
  switch (code) {
    case 0x05040000:
      text = "the transfer timed out";
      break;
    case 0x06010001:
      text = "the object cannot be read";
      break;
    case 0x06010002:
      text = "the object cannot be written";
      break;
    case kSdoNoObject:
      text = "the object does not exist";
      break;
    case 0x06070010:
      text = "the object has another size";
      break;
    case 0x06090011:
      text = "the object has no such part";
      break;
    case 0x06090030:
      text = "the value is out of range";
      break;
    case 0x08000022:
      text = "the node is in a state that does not allow it";
      break;
    default:
      break;
  }
  return std::string(text) + " (" + in_hex(code, 8) + ")";
}

std::optional<CanEmergency> read_emergency(const CanFrame& frame) {
  if (frame.size < 3) return std::nullopt;
  return CanEmergency{static_cast<std::uint16_t>(number_in(frame, 0, 2)), frame.data[2]};
}

std::string emergency_sentence(const CanEmergency& emergency) {
  const char* text = "it reports an error";
  switch (emergency.code >> 12) {
    case 0:
      text = "its errors are gone";
      break;
    case 2:
      text = "a current is out of range";
      break;
    case 3:
      text = "a voltage is out of range";
      break;
    case 4:
      text = "a temperature is out of range";
      break;
    case 5:
      text = "its hardware has failed; the position is not to be trusted";
      break;
    case 6:
      text = "its software has failed";
      break;
    case 8:
      text = "its bus communication is disturbed";
      break;
    default:
      break;
  }
  return std::string(text) + " (" + in_hex(emergency.code, 4) + ")";
}

CanNodeState read_heartbeat(const CanFrame& frame) {
  if (frame.size < 1) return CanNodeState::kUnknown;
  switch (frame.data[0] & 0x7F) {
    case 0x00:
      return CanNodeState::kBooting;
    case 0x04:
      return CanNodeState::kStopped;
    case 0x05:
      return CanNodeState::kOperational;
    case 0x7F:
      return CanNodeState::kPreOperational;
    default:
      return CanNodeState::kUnknown;
  }
}

std::optional<std::uint32_t> read_position(const CanFrame& frame) {
  if (frame.size < 4) return std::nullopt;
  return number_in(frame, 0, 4);
}

CanFrame can_heartbeat(int node, CanNodeState state) {
  std::uint8_t byte = 0x7F;
  if (state == CanNodeState::kBooting) byte = 0x00;
  if (state == CanNodeState::kStopped) byte = 0x04;
  if (state == CanNodeState::kOperational) byte = 0x05;
  return frame_of(of_node(kHeartbeatId, node), {byte});
}

CanFrame can_position(int node, std::uint32_t counts) {
  CanFrame frame{.id = of_node(kPdo2Id, node)};
  for (int i = 0; i < 4; ++i) {
    frame.data[frame.size++] = static_cast<std::uint8_t>(counts >> (8 * i));
  }
  return frame;
}

CanFrame can_emergency(int node, const CanEmergency& emergency) {
  CanFrame frame =
      frame_of(of_node(kEmergencyId, node),
               {static_cast<std::uint8_t>(emergency.code & 0xFF),
                static_cast<std::uint8_t>(emergency.code >> 8), emergency.error_register});
  frame.size = 8;
  return frame;
}

CanFrame can_sdo_reply(int node, const SdoReply& reply, bool written) {
  const std::uint8_t command = reply.is_abort ? kSdoAbort : written ? kSdoWritten : 0x43;
  return sdo_frame(of_node(kSdoReplyId, node), command, reply.object,
                   written && !reply.is_abort ? 0 : reply.value);
}

std::optional<SdoRequest> read_sdo_request(const CanFrame& frame) {
  if (frame.size < 8) return std::nullopt;
  const std::uint8_t command = frame.data[0];
  if (command == kSdoRead) return SdoRequest{.object = object_in(frame)};
  const std::size_t bytes = expedited_bytes(command);
  if ((command & 0xE0) != 0x20 || bytes == 0) return std::nullopt;
  return SdoRequest{
      .object = object_in(frame), .writes = true, .value = number_in(frame, 4, bytes)};
}

}  // namespace nav::devices
