// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/ndi/ndi_commands.hpp"

#include <algorithm>
#include <fstream>
#include <iterator>

#include "devices/ndi/ndi_crc.hpp"
#include "devices/ndi/ndi_hex.hpp"

namespace nav::devices {
namespace {

struct NdiRate {
  int baud;
  char code;
};
constexpr NdiRate kRates[] = {{9600, '0'},   {14400, '1'},  {19200, '2'},
                              {38400, '3'},  {57600, '4'},  {115200, '5'},
                              {230400, 'A'}, {921600, '6'}, {1228739, '7'}};

Error malformed(const std::string& what) { return {ErrorCode::kMalformedData, "NDI: " + what}; }

std::string trimmed(std::string_view text) {
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  return std::string(text);
}

/// Rest of the line that begins with a word.
std::string line_after(std::string_view text, std::string_view begin) {
  const auto at = text.find(begin);
  if (at == std::string_view::npos) return {};
  const std::string_view rest = text.substr(at + begin.size());
  return trimmed(rest.substr(0, rest.find('\n')));
}

unsigned byte_at(std::string_view text, std::size_t i) {
  return static_cast<unsigned char>(text[i]);
}

Result<void> check_rom(std::string_view rom, const std::string& name) {
  constexpr std::string_view kBegin("NDI\0", 4);
  constexpr std::size_t kSummed = 6;
  const auto reject = [&](const std::string& what) {
    return Error{ErrorCode::kMalformedData,
                 name + ": expected a tool definition of NDI, found " + what};
  };
  if (rom.size() < kSummed || !rom.starts_with(kBegin)) return reject("another file");
  if (rom.size() > kNdiMostRom) return reject("more than 65536 bytes");
  unsigned sum = 0;
  for (std::size_t i = kSummed; i < rom.size(); ++i) sum += byte_at(rom, i);
  if ((sum & 0xFFFF) != byte_at(rom, 4) + 256 * byte_at(rom, 5)) return reject("a damaged one");
  return {};
}

}  // namespace

std::string ndi_command(std::string_view name, std::string_view arguments) {
  std::string text(name);
  text.append(":").append(arguments);
  text += ndi_to_hex(ndi_crc(text), 4);
  return text + '\r';
}

const std::vector<int>& ndi_baud_rates() {
  static const std::vector<int> rates = [] {
    std::vector<int> all;
    for (const NdiRate& rate : kRates) all.push_back(rate.baud);
    return all;
  }();
  return rates;
}

std::optional<std::string> ndi_comm_arguments(int baud) {
  const auto* found = std::ranges::find(kRates, baud, &NdiRate::baud);
  if (found == std::end(kRates)) return std::nullopt;
  return found->code + std::string("0000");
}

std::optional<int> ndi_comm_baud(std::string_view arguments) {
  if (arguments.size() != 5) return std::nullopt;
  const auto* found = std::ranges::find(kRates, arguments[0], &NdiRate::code);
  if (found == std::end(kRates)) return std::nullopt;
  return found->baud;
}

Result<std::vector<NdiHandle>> read_ndi_handles(std::string_view text) {
  constexpr std::size_t kEntry = 5;
  const auto count = ndi_from_hex<std::uint8_t>(text.substr(0, 2));
  if (!count || text.size() != 2 + kEntry * *count) {
    return malformed("reply to PHSR: expected a number and as many ports, found something else");
  }
  std::vector<NdiHandle> handles;
  for (std::size_t at = 2; at < text.size(); at += kEntry) {
    const auto handle = ndi_from_hex<std::uint8_t>(text.substr(at, 2));
    const auto status = ndi_from_hex<std::uint16_t>(text.substr(at + 2, 3));
    if (!handle || !status)
      return malformed("reply to PHSR: expected digits, found something else");
    handles.push_back({*handle, *status});
  }
  return handles;
}

Result<NdiToolInfo> read_ndi_tool_info(std::string_view text) {
  constexpr std::size_t kTool = 33;
  constexpr std::size_t kPlace = 14;
  if (text.size() != kTool + kPlace) {
    return malformed("reply to PHINF: expected 47 characters, found " +
                     std::to_string(text.size()));
  }
  const auto port = ndi_from_hex<std::uint8_t>(text.substr(kTool + 10, 2));
  const auto channel = ndi_from_hex<std::uint8_t>(text.substr(kTool + 12, 2));
  if (!port || !channel)
    return malformed("reply to PHINF: expected the port, found something else");
  return NdiToolInfo{.manufacturer = trimmed(text.substr(8, 12)),
                     .serial = trimmed(text.substr(23, 8)),
                     .wired = text[kTool + 9] == '0',
                     .port = *port,
                     .channel = *channel};
}

NdiVersion read_ndi_version(std::string_view text) {
  NdiVersion version;
  version.firmware = trimmed(text.substr(0, text.find('\n')));
  if (const auto tag = line_after(text, "Freeze Tag:"); !tag.empty())
    version.firmware += ", " + tag;
  version.serial = line_after(text, "NDI S/N:");
  return version;
}

Result<std::string> read_ndi_rom(const std::filesystem::path& file) {
  const std::string name = file.string();
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    return Error{ErrorCode::kNotFound,
                 name + ": expected a tool definition (.rom), found no such file"};
  }
  std::ifstream stream(file, std::ios::binary);
  std::string rom(kNdiMostRom + 1, '\0');
  stream.read(rom.data(), static_cast<std::streamsize>(rom.size()));
  if (!stream.is_open() || stream.bad()) {
    return Error{ErrorCode::kIo, name + ": expected to be readable, found an error of reading"};
  }
  rom.resize(static_cast<std::size_t>(stream.gcount()));
  if (const auto ok = check_rom(rom, name); !ok) return ok.error();
  return rom;
}

std::string ndi_rom_arguments(std::uint8_t handle, std::string_view rom, std::size_t offset) {
  std::string text = ndi_to_hex(handle, 2) + ndi_to_hex(offset, 4);
  for (std::size_t i = offset; i < offset + kNdiRomChunk; ++i) {
    text += ndi_to_hex(i < rom.size() ? byte_at(rom, i) : 0U, 2);
  }
  return text;
}

}  // namespace nav::devices
