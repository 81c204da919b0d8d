// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace nav::devices {

/// Messages of a Polhemus Liberty in its binary format (Liberty user manual, URM03PH156): a header
/// "LY", station, initiating command, error, a reserved byte and the size of what follows, then a
/// body. Numbers are little endian. This file does no I/O.
inline constexpr std::uint16_t kPolhemusVendor = 0x0F44;
inline constexpr std::uint16_t kLibertyProduct = 0xFF20;
inline constexpr std::uint8_t kLibertyOut = 0x04, kLibertyIn = 0x88;  ///< Endpoints.
inline constexpr std::size_t kPolhemusHeaderBytes = 8;
/// Body of a record as it is set up by polhemus_setup(): time, frame, distortion, position,
/// rotation.
inline constexpr std::size_t kPolhemusRecordBytes = 40;
inline constexpr int kMostPolhemusStations = 16;

/// Stops the output, whatever the device was told before.
inline constexpr const char* kPolhemusStop = "\rp\r";
inline constexpr const char* kPolhemusContinuous = "c\r";
inline constexpr const char* kPolhemusSingle = "p";  ///< Also ends the continuous output.
/// Commands that set the format of all stations: binary, centimetres, the items of a record, and
/// the half of space in which the sensors are, a vector from the source.
std::vector<std::string> polhemus_setup(const std::array<double, 3>& hemisphere);

/// One measurement of one station.
struct PolhemusRecord {
  int station = 0;         ///< From 1.
  std::uint8_t error = 0;  ///< In words by polhemus_error().
  std::uint32_t time_ms = 0;
  std::uint32_t frame = 0;  ///< Equal for all stations that were measured together.
  std::int32_t distortion =
      0;  ///< Distortion of the field; the device's own scale, 0: none was found.
  std::array<float, 3> position_cm{};
  std::array<float, 4> rotation_wxyz{};  ///< From the sensor to the source.
};
/// Name of what is wrong with the numbers of a record: "not_finite", "no_rotation" (its quaternion
/// has another length than 1 by more than 1 %), "out_of_range" (further than 10 m); null: nothing.
const char* polhemus_trouble(const PolhemusRecord& record);
/// The error of a header in words; absent: none (0 or a space).
std::optional<std::string> polhemus_error(std::uint8_t error);

/// A piece of news from the wire.
struct PolhemusNews {
  enum class Kind {
    kRecord,
    kReply,  ///< Answer to a command; only its header is kept.
    kBad,    ///< Bytes that cannot be used.
  };
  Kind kind = Kind::kBad;
  PolhemusRecord record{};
  char command = '\0';     ///< Command of a reply.
  std::uint8_t error = 0;  ///< Error of a reply.
  /// Cause of kBad: "magic" (no header where one should be), "size", "station", "cut" (a message
  /// ended too early).
  const char* cause = "";
};

/// Takes messages out of the transfers of a device. A broken message costs itself only: the next
/// header that makes sense is searched for.
class PolhemusParser {
 public:
  using Take = std::function<void(const PolhemusNews&)>;
  /// Takes the bytes of one transfer. A message may go on in the next transfer, unless that begins
  /// with a header.
  void take(std::span<const std::byte> transfer, const Take& out);
  void restart();

 private:
  bool take_message(const Take& out);
  void reject(const char* cause, std::size_t bytes, const Take& out);

  std::vector<std::byte> bytes_;
  bool in_step_ = true;  ///< False: bytes are skipped until the next header; they were counted.
};

// Messages that a device sends, for tests and the emulator.
void append_polhemus_header(std::vector<std::byte>& out, int station, char command,
                            std::uint8_t error, std::size_t size);
void append_polhemus_record(std::vector<std::byte>& out, const PolhemusRecord& record);

}  // namespace nav::devices
