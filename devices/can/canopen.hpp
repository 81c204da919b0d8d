// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "devices/can/can_socket.hpp"

namespace nav::devices {

/// Messages of CANopen (CiA 301) as far as an encoder (CiA 406) needs them. Numbers are little
/// endian. A node has a number of 1 to 127.
inline constexpr int kMostCanNodes = 127;

/// An entry of a node's object dictionary.
struct CanObject {
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  friend bool operator==(const CanObject&, const CanObject&) = default;
};
inline constexpr CanObject kDeviceType{0x1000, 0};        ///< Low word: number of the profile.
inline constexpr CanObject kHeartbeatTime{0x1017, 0};     ///< ms, 16 bits; 0: no heartbeat.
inline constexpr CanObject kPdo2Transmission{0x1801, 2};  ///< 1: with every SYNC.
inline constexpr CanObject kCountsPerTurn{0x6501, 0};
inline constexpr std::uint16_t kEncoderProfile = 406;

enum class NmtCommand : std::uint8_t {
  kStart = 0x01,
  kStop = 0x02,
  kPreOperational = 0x80,
  kResetNode = 0x81,
  kResetCommunication = 0x82,
};
CanFrame can_nmt(NmtCommand command, int node);
CanFrame can_sync();
/// Asks for an entry of up to 4 bytes.
CanFrame can_sdo_read(int node, CanObject object);
/// Writes an entry of 1 to 4 bytes.
CanFrame can_sdo_write(int node, CanObject object, std::uint32_t value, int bytes);

enum class CanOpenKind {
  kNmt,
  kSync,
  kEmergency,
  kPdo1,
  kPdo2,
  kSdoReply,
  kSdoRequest,
  kHeartbeat,
  kOther
};
struct CanOpenMessage {
  CanOpenKind kind = CanOpenKind::kOther;
  int node = 0;  ///< 0: of no node.
};
/// Meaning of a frame by its identifier. Remote, extended and error frames are kOther.
CanOpenMessage classify_canopen(const CanFrame& frame);

/// Reply of a node to can_sdo_read() or can_sdo_write().
struct SdoReply {
  CanObject object;
  bool is_abort = false;
  std::uint32_t value = 0;  ///< The value that was read, or the code of the abort.
};
/// Absent for replies that are no expedited ones, and for frames of less than 8 bytes.
std::optional<SdoReply> read_sdo_reply(const CanFrame& frame);
/// Code of an abort: the node has no such object.
inline constexpr std::uint32_t kSdoNoObject = 0x06020000;
/// "the object does not exist (0x06020000)".
std::string sdo_abort_sentence(std::uint32_t code);

struct CanEmergency {
  std::uint16_t code = 0;  ///< 0: the errors are gone.
  std::uint8_t error_register = 0;
};
/// Absent for frames of less than 3 bytes.
std::optional<CanEmergency> read_emergency(const CanFrame& frame);
/// "a temperature is out of range (0x4200)".
std::string emergency_sentence(const CanEmergency& emergency);

enum class CanNodeState { kBooting, kStopped, kOperational, kPreOperational, kUnknown };
/// State that a heartbeat or a boot-up message tells.
CanNodeState read_heartbeat(const CanFrame& frame);

/// Position of an encoder: the first 4 bytes of a PDO; absent for a shorter one.
std::optional<std::uint32_t> read_position(const CanFrame& frame);

// Frames that a node sends, for tests and the emulator.
CanFrame can_heartbeat(int node, CanNodeState state);
CanFrame can_position(int node, std::uint32_t counts);
CanFrame can_emergency(int node, const CanEmergency& emergency);
CanFrame can_sdo_reply(int node, const SdoReply& reply, bool written);
/// A request as a node reads it.
struct SdoRequest {
  CanObject object;
  bool writes = false;
  std::uint32_t value = 0;
};
std::optional<SdoRequest> read_sdo_request(const CanFrame& frame);

}  // namespace nav::devices
