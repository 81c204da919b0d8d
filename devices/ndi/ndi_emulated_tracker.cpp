// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/ndi/ndi_emulated_tracker.hpp"

#include <algorithm>
#include <utility>

#include "devices/ndi/ndi_commands.hpp"
#include "devices/ndi/ndi_crc.hpp"
#include "devices/ndi/ndi_encode.hpp"
#include "devices/ndi/ndi_hex.hpp"

namespace nav::devices {
namespace {

constexpr const char* kOkay = "OKAY";
constexpr const char* kUnknownCommand = "ERROR01";
constexpr const char* kBadCrc = "ERROR04";
constexpr const char* kNoSpeed = "ERROR06";
constexpr const char* kWrongParameters = "ERROR07";
constexpr const char* kNoSuchPort = "ERROR08";
constexpr const char* kNotNow = "ERROR0C";
constexpr const char* kPortNotInitialised = "ERROR0E";
constexpr const char* kTrackerNotInitialised = "ERROR10";
constexpr const char* kToolFails = "ERROR13";

std::string padded(std::string text, std::size_t size) {
  text.resize(size, ' ');
  return text;
}

}  // namespace

NdiEmulatedTracker::NdiEmulatedTracker(NdiEmulatedOptions options) : options_(std::move(options)) {
  for (const NdiEmulatedTool& tool : options_.tools) plugged_.push_back(tool.plugged);
}

std::vector<std::byte> NdiEmulatedTracker::reset() {
  ports_.clear();
  initialised_ = tracking_ = false;
  number_ = 0;
  return ndi_text_reply("RESET");
}

void NdiEmulatedTracker::plug(std::size_t tool, bool in) {
  plugged_[tool] = in;
  news_of_ports_ = news_of_ports_ || in;
  if (in) return;
  for (auto& [handle, one] : ports_) {
    if (one.wired && one.tool == tool) one.gone = true;
  }
}

std::vector<std::byte> NdiEmulatedTracker::answer(std::string_view command) {
  constexpr std::size_t kCrcDigits = 4;
  const auto split = command.find_first_of(": ");
  if (split == std::string_view::npos) return ndi_text_reply(kUnknownCommand);
  if (command[split] == ':') {
    if (command.size() < split + 1 + kCrcDigits) return ndi_text_reply(kBadCrc);
    const auto given = ndi_from_hex<std::uint16_t>(command.substr(command.size() - kCrcDigits));
    command.remove_suffix(kCrcDigits);
    if (given != ndi_crc(command)) return ndi_text_reply(kBadCrc);
  }
  const Command read{command.substr(0, split), command.substr(split + 1)};
  const bool poses = read.name == "TX" || (read.name == "BX" && options_.knows_bx) ||
                     (read.name == "BX2" && options_.knows_bx2);
  if (!poses) return ndi_text_reply(text_answer(read));
  if (!tracking_) return ndi_text_reply(kNotNow);
  const NdiReadings readings = look();
  if (read.name == "TX") return ndi_text_reply(ndi_tx_text(readings));
  return ndi_binary_reply(read.name == "BX" ? ndi_bx_body(readings) : ndi_bx2_body(readings));
}

std::string NdiEmulatedTracker::text_answer(const Command& command) {
  static const std::map<std::string_view, Answer> answers = {
      {"INIT", &NdiEmulatedTracker::begin},        {"VER", &NdiEmulatedTracker::version},
      {"COMM", &NdiEmulatedTracker::change_speed}, {"PHSR", &NdiEmulatedTracker::list_ports},
      {"PHRQ", &NdiEmulatedTracker::request_port}, {"PHF", &NdiEmulatedTracker::free_port},
      {"PVWR", &NdiEmulatedTracker::load},         {"PINIT", &NdiEmulatedTracker::initialise},
      {"PENA", &NdiEmulatedTracker::enable},       {"PDIS", &NdiEmulatedTracker::disable},
      {"PHINF", &NdiEmulatedTracker::describe},    {"TSTART", &NdiEmulatedTracker::start},
      {"TSTOP", &NdiEmulatedTracker::stop}};
  const auto found = answers.find(command.name);
  if (found == answers.end()) return kUnknownCommand;
  const bool always = command.name == "INIT" || command.name == "VER" || command.name == "COMM";
  if (!initialised_ && !always) return kTrackerNotInitialised;
  if (tracking_ && command.name != "TSTOP") return kNotNow;
  return (this->*found->second)(command.arguments);
}

std::string NdiEmulatedTracker::begin(std::string_view /*arguments*/) {
  initialised_ = true;
  return kOkay;
}

std::string NdiEmulatedTracker::version(std::string_view /*arguments*/) {
  return options_.firmware + "\nNDI S/N: " + options_.serial + "\nFreeze Tag: EMULATED\n";
}

std::string NdiEmulatedTracker::change_speed(std::string_view arguments) {
  const auto baud = ndi_comm_baud(arguments);
  return baud && *baud <= options_.most_baud ? kOkay : kNoSpeed;
}

std::string NdiEmulatedTracker::start(std::string_view /*arguments*/) {
  tracking_ = true;
  return kOkay;
}

std::string NdiEmulatedTracker::stop(std::string_view /*arguments*/) {
  if (!tracking_) return kNotNow;
  tracking_ = false;
  return kOkay;
}

/// Tools that are plugged in get a handle by themselves.
void NdiEmulatedTracker::allocate_plugged() {
  for (std::size_t i = 0; i < options_.tools.size(); ++i) {
    if (!options_.tools[i].rom.empty() || !plugged_[i]) continue;
    const bool has = std::ranges::any_of(ports_, [&](const auto& entry) {
      return entry.second.wired && entry.second.tool == i && !entry.second.gone;
    });
    std::uint8_t handle = 0x0A;
    while (ports_.contains(handle)) ++handle;
    if (!has) ports_[handle] = {.tool = i, .wired = true};
  }
}

std::string NdiEmulatedTracker::list_ports(std::string_view which) {
  allocate_plugged();
  news_of_ports_ = false;
  std::string entries;
  std::size_t count = 0;
  for (const auto& [handle, one] : ports_) {
    const bool listed = which == "00" || (which == "01" && one.gone) ||
                        (which == "02" && !one.gone && !one.initialised) ||
                        (which == "03" && one.initialised && !one.enabled) ||
                        (which == "04" && one.enabled);
    if (!listed) continue;
    const unsigned status =
        (one.gone ? 0U : 1U) | (one.initialised ? 1U << 4 : 0U) | (one.enabled ? 1U << 5 : 0U);
    entries += ndi_to_hex(handle, 2) + ndi_to_hex(status, 3);
    ++count;
  }
  return ndi_to_hex(count, 2) + entries;
}

std::string NdiEmulatedTracker::request_port(std::string_view arguments) {
  constexpr std::size_t kArguments = 14;
  if (arguments.size() != kArguments) return kWrongParameters;
  std::uint8_t handle = 1;
  while (ports_.contains(handle)) ++handle;
  ports_[handle] = {};
  return ndi_to_hex(handle, 2);
}

NdiEmulatedTracker::Port* NdiEmulatedTracker::port(std::string_view handle) {
  const auto number = ndi_from_hex<std::uint8_t>(handle.substr(0, 2));
  const auto found = number ? ports_.find(*number) : ports_.end();
  return found == ports_.end() ? nullptr : &found->second;
}

std::string NdiEmulatedTracker::free_port(std::string_view arguments) {
  const auto number = ndi_from_hex<std::uint8_t>(arguments);
  return number && ports_.erase(*number) > 0 ? kOkay : kNoSuchPort;
}

std::string NdiEmulatedTracker::load(std::string_view arguments) {
  Port* const one = port(arguments);
  if (one == nullptr) return kNoSuchPort;
  if (arguments.size() != 6 + 2 * kNdiRomChunk) return kWrongParameters;
  const auto address = ndi_from_hex<std::uint16_t>(arguments.substr(2, 4));
  if (!address) return kWrongParameters;
  one->rom.resize(std::max(one->rom.size(), std::size_t{*address} + kNdiRomChunk));
  for (std::size_t i = 0; i < kNdiRomChunk; ++i) {
    const auto byte = ndi_from_hex<std::uint8_t>(arguments.substr(6 + 2 * i, 2));
    if (!byte) return kWrongParameters;
    one->rom[*address + i] = static_cast<char>(*byte);
  }
  return kOkay;
}

std::string NdiEmulatedTracker::initialise(std::string_view arguments) {
  Port* const one = port(arguments);
  if (one == nullptr) return kNoSuchPort;
  for (std::size_t i = 0; !one->wired && i < options_.tools.size(); ++i) {
    const std::string& rom = options_.tools[i].rom;
    // Two ports may hold the same tool definition only if two tools have it.
    const bool used = std::ranges::any_of(
        ports_, [&](const auto& entry) { return &entry.second != one && entry.second.tool == i; });
    if (!rom.empty() && !used && one->rom.starts_with(rom)) one->tool = i;
  }
  if (!one->tool || options_.tools[*one->tool].wrong_memory) return kToolFails;
  one->initialised = true;
  return kOkay;
}

std::string NdiEmulatedTracker::enable(std::string_view arguments) {
  Port* const one = port(arguments);
  if (one == nullptr || arguments.size() != 3) return kNoSuchPort;
  if (!one->initialised) return kPortNotInitialised;
  one->enabled = true;
  return kOkay;
}

std::string NdiEmulatedTracker::disable(std::string_view arguments) {
  Port* const one = port(arguments);
  if (one == nullptr) return kNoSuchPort;
  one->enabled = false;
  return kOkay;
}

std::string NdiEmulatedTracker::describe(std::string_view arguments) {
  const Port* const one = port(arguments);
  if (one == nullptr) return kNoSuchPort;
  if (!arguments.ends_with("0021")) return kWrongParameters;
  if (one->gone) return "UNOCCUPIED";
  const std::string tool = "01000000" + padded("Sonde", 12) + "000" + "00000001" + "31";
  const unsigned number = one->wired ? options_.tools[*one->tool].port : 0U;
  return tool + padded(options_.serial, 8) + "0" + (one->wired ? "0" : "1") +
         ndi_to_hex(number, 2) + "00";
}

NdiReadings NdiEmulatedTracker::look() {
  constexpr std::int64_t kHz = 60;
  constexpr std::int64_t kSecond = 1'000'000'000;
  if (!std::exchange(hold_, false)) ++number_;
  NdiReadings readings;
  readings.system_status = news_of_ports_ ? kNdiPortOccupied : std::uint16_t{0};
  for (const auto& [handle, one] : ports_) {
    if (!one.enabled) continue;
    NdiToolReading reading{.presence = NdiPresence::kUnoccupied};
    if (!one.gone) reading = options_.see(*one.tool, number_);
    reading.handle = handle;
    reading.status = 0x31;
    if (!reading.number) {
      reading.number = number_;
      reading.time = DeviceTime(std::chrono::nanoseconds(std::int64_t{number_} * kSecond / kHz));
    }
    readings.tools.push_back(reading);
  }
  return readings;
}

}  // namespace nav::devices
