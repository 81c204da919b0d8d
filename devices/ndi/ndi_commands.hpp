// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nav/result.hpp"

namespace nav::devices {

/// "NAME:arguments", the CRC and CR, as sent.
std::string ndi_command(std::string_view name, std::string_view arguments = {});

/// Baud rates that trackers know, ascending.
const std::vector<int>& ndi_baud_rates();
/// Arguments of COMM for 8 bits, no parity, 1 stop bit, no handshake; absent for another rate.
std::optional<std::string> ndi_comm_arguments(int baud);
/// Rate that arguments of COMM ask for; absent for unknown ones.
std::optional<int> ndi_comm_baud(std::string_view arguments);

/// One entry of the reply to PHSR.
struct NdiHandle {
  std::uint8_t handle = 0;
  std::uint16_t status = 0;
};
/// Reads the reply to PHSR; kMalformedData where the count and the entries differ.
Result<std::vector<NdiHandle>> read_ndi_handles(std::string_view text);

/// Reply to PHINF:hh0021: what a tool is and where it is plugged in.
struct NdiToolInfo {
  std::string manufacturer;  ///< At most 12 characters.
  std::string serial;        ///< 8 characters.
  bool wired = false;
  unsigned port = 0;  ///< Number of the wired port, from 1.
  unsigned channel = 0;
};
Result<NdiToolInfo> read_ndi_tool_info(std::string_view text);

/// Reply to VER:0.
struct NdiVersion {
  std::string firmware;  ///< "Polaris Control Firmware, POLARIS Rev 020".
  std::string serial;    ///< "P4-03126"; empty if not given.
};
NdiVersion read_ndi_version(std::string_view text);

/// Longest tool definition that is read, bytes.
inline constexpr std::size_t kNdiMostRom = std::size_t{1} << 16;
/// Bytes of one PVWR.
inline constexpr std::size_t kNdiRomChunk = 64;

/// Reads a tool definition (.rom) and checks its beginning "NDI" and its sum, which both files
/// among the test data have: the sum of the bytes from the seventh on, modulo 65536, in bytes 5
/// and 6. Errors: kNotFound, kIo, kMalformedData.
Result<std::string> read_ndi_rom(const std::filesystem::path& file);
/// Arguments of the PVWR for one chunk, which begins at \p offset; the last is filled with zeros.
std::string ndi_rom_arguments(std::uint8_t handle, std::string_view rom, std::size_t offset);

}  // namespace nav::devices
