// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/can/can_button_source.hpp"

#include <cstring>
#include <set>
#include <tuple>
#include <utility>

namespace nav::devices {
namespace {

constexpr std::uint32_t kMostStandardId = 0x7FF;
constexpr std::uint32_t kMostExtendedId = 0x1FFFFFFF;

Error can_button_error(const std::string& what) {
  return {ErrorCode::kUsage, "CAN buttons: expected " + what};
}

std::vector<StreamInfo> streams_of_can(const std::vector<CanButton>& buttons) {
  std::vector<StreamInfo> streams;
  for (const CanButton& button : buttons) {
    streams.push_back({button.name, StreamKind::kButtons, ToolRole::kOther, button.action});
  }
  return streams;
}

}  // namespace

CanButtonReading read_can_button(const CanButton& button, const CanFrame& frame) {
  const bool ours = !frame.error && !frame.remote && frame.extended == button.extended &&
                    frame.id == button.frame;
  if (!ours) return CanButtonReading::kForeign;
  if (button.byte >= frame.size) return CanButtonReading::kShort;
  const unsigned value = frame.data[static_cast<std::size_t>(button.byte)];
  const bool set = ((value >> button.bit) & 1U) != 0;
  return set != button.pressed_when_zero ? CanButtonReading::kDown : CanButtonReading::kUp;
}

Result<void> validate(const CanButtonOptions& options) {
  if (options.buttons.empty()) return can_button_error("at least one button, found none");
  std::set<std::string> names;
  std::set<std::tuple<bool, std::uint32_t, int, int>> bits;
  for (const CanButton& button : options.buttons) {
    if (button.name.empty()) return can_button_error("a name of each button, found none");
    if (!names.insert(button.name).second) {
      return can_button_error("a name of its own for each button, found '" + button.name +
                              "' twice");
    }
    const std::uint32_t most = button.extended ? kMostExtendedId : kMostStandardId;
    if (button.frame > most) {
      return can_button_error("a frame of '" + button.name + "' from 0 to " + std::to_string(most) +
                              (button.extended ? "" : " (29 bits: extended = true)") + ", found " +
                              std::to_string(button.frame));
    }
    for (const auto& [what, value] : {std::pair{"byte", button.byte}, {"bit", button.bit}}) {
      if (value >= 0 && value <= 7) continue;
      return can_button_error(std::string("a ") + what + " of '" + button.name +
                              "' from 0 to 7, found " + std::to_string(value));
    }
    if (!bits.emplace(button.extended, button.frame, button.byte, button.bit).second) {
      return can_button_error("a bit of its own for each button, found that of '" + button.name +
                              "' twice");
    }
  }
  return validate(options.times);
}

Result<std::unique_ptr<CanButtonSource>> CanButtonSource::create(CanButtonOptions options,
                                                                 std::string name,
                                                                 ButtonOpener open,
                                                                 const Clock& clock,
                                                                 Diagnostics& diagnostics) {
  if (const auto ok = validate(options); !ok) return ok.error();
  return std::unique_ptr<CanButtonSource>(new CanButtonSource(std::move(options), std::move(name),
                                                              std::move(open), clock, diagnostics));
}

ButtonOpener CanButtonSource::on_interface(const std::string& interface,
                                           const std::vector<CanButton>& buttons) {
  std::vector<CanFilter> filters;
  for (const CanButton& button : buttons) {
    filters.push_back({.id = button.frame,
                       .mask = button.extended ? kMostExtendedId : kMostStandardId,
                       .extended = button.extended});
  }
  return [interface, filters] { return open_can(interface, filters); };
}

CanButtonSource::CanButtonSource(CanButtonOptions options, std::string name, ButtonOpener open,
                                 const Clock& clock, Diagnostics& diagnostics)
    : ButtonSource(std::move(name), streams_of_can(options.buttons), options.times, std::move(open),
                   clock, diagnostics, "devices.can_buttons"),
      options_(std::move(options)) {}

void CanButtonSource::read_device() {
  constexpr int kMostFrames = 1000;
  for (int i = 0; i < kMostFrames && device().is_open(); ++i) {
    const CanReceive got = receive_can(device());
    if (got.failure) return lose(*got.failure);
    if (got.malformed) {
      count("malformed");
    } else if (got.received) {
      take(*got.received);
    } else {
      return;
    }
  }
}

void CanButtonSource::take(const CanReceived& received) {
  if (received.dropped != dropped_) {
    count("kernel_drops", received.dropped - dropped_);
    dropped_ = received.dropped;
  }
  if (received.frame.error) return take_errors(received.frame);
  bool ours = false;
  for (std::size_t i = 0; i < options_.buttons.size(); ++i) {
    const CanButtonReading reading = read_can_button(options_.buttons[i], received.frame);
    if (reading == CanButtonReading::kForeign) continue;
    if (reading == CanButtonReading::kShort) {
      count("short_frame");
      report_once(Severity::kWarning, "short " + options_.buttons[i].name,
                  "expected at least " + std::to_string(options_.buttons[i].byte + 1) +
                      " bytes in the frame of '" + options_.buttons[i].name + "', found " +
                      std::to_string(received.frame.size));
      continue;
    }
    if (!std::exchange(ours, true)) heard(kCanFrameBytes);
    take_contact(i, reading == CanButtonReading::kDown, clock().now() - received.age);
  }
}

void CanButtonSource::take_errors(const CanFrame& frame) {
  for (const char* cause : can_error_causes(frame)) {
    count(cause);
    if (std::strcmp(cause, "bus_off") == 0) {
      return lose({"bus_off",
                   "the controller left the bus (bus-off): check the cable, its termination and "
                   "the bit rate"});
    }
    report_once(Severity::kWarning, std::string("the controller reports ") + cause);
  }
}

}  // namespace nav::devices
