// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/live_buttons.hpp"

#include <utility>

#include "devices/buttons/foot_switch_source.hpp"
#include "devices/can/can_button_source.hpp"
#include "session/device_address.hpp"

namespace nav::session {
namespace {

constexpr const char* kFootSwitchKind = "footswitch";
constexpr const char* kCanButtonsKind = "can-buttons";
constexpr double kMostSilenceMs = 3'600'000;

/// Buttons as the devices take them; keys and actions were checked before.
devices::FootSwitchOptions foot_switch_of(const DeviceOptions& device) {
  devices::FootSwitchOptions options;
  for (const DeviceButton& button : device.buttons) {
    options.buttons.push_back(
        {.name = button.name,
         .key = devices::evdev_key(button.key).value_or(0),
         .action = button_action_from(button.action).value_or(ButtonAction::kNone)});
  }
  return options;
}

devices::CanButtonOptions can_buttons_of(const DeviceOptions& device) {
  devices::CanButtonOptions options;
  for (const DeviceButton& button : device.buttons) {
    options.buttons.push_back(
        {.name = button.name,
         .frame = button.frame,
         .extended = button.extended,
         .byte = button.byte,
         .bit = button.bit,
         .pressed_when_zero = button.pressed_when_zero,
         .action = button_action_from(button.action).value_or(ButtonAction::kNone)});
  }
  options.times.silence = from_seconds(1e-3 * device.silence_ms);
  return options;
}

constexpr Duration kSimulatedPress = std::chrono::milliseconds(200);

/// False unless each press of a simulated button has ended before the next one.
bool are_separate(const std::vector<double>& times_s) {
  for (std::size_t i = 0; i < times_s.size(); ++i) {
    const double before_s = i == 0 ? 0 : times_s[i - 1] + to_seconds(kSimulatedPress);
    if (!(times_s[i] >= before_s && times_s[i] <= 3600)) return false;
  }
  return true;
}

template <class Opened>
Result<LiveDevice> opened_device(const DeviceOptions& device, Opened opened) {
  if (!opened) return opened.error();
  return LiveDevice{.options = device, .source = *std::move(opened)};
}

}  // namespace

bool is_button_device(const DeviceOptions& device) {
  return device.kind == kFootSwitchKind || device.kind == kCanButtonsKind;
}

std::vector<ButtonSample> simulated_changes(const DeviceButton& button) {
  std::vector<ButtonSample> changes;
  for (const double time_s : button.pressed_at_s) {
    const Timestamp down(from_seconds(time_s));
    changes.push_back({.acquired = down, .pressed = true});
    changes.push_back({.acquired = down + kSimulatedPress, .pressed = false});
  }
  return changes;
}

Result<void> validate_buttons(const DeviceOptions& device, const std::string& name) {
  const auto reject = [&](const std::string& key, const std::string& expected,
                          const std::string& found) {
    return Error{ErrorCode::kUsage,
                 name + "." + key + ": expected " + expected + ", found '" + found + "'"};
  };
  const bool foot = device.kind == kFootSwitchKind;
  const bool can = device.kind == kCanButtonsKind;
  if (foot && !hid_address(device.address) && !input_address(device.address)) {
    return reject("address", "hid:VENDOR:PRODUCT (hid:05f3:00ff) or input:/dev/input/event…",
                  device.address);
  }
  if (can && !can_address(device.address)) {
    return reject("address", "can:INTERFACE", device.address);
  }
  if (!(device.silence_ms >= 0 && device.silence_ms <= kMostSilenceMs)) {
    return reject("silence_ms", "0 to 3600000 ms", std::to_string(device.silence_ms));
  }
  for (std::size_t i = 0; i < device.buttons.size(); ++i) {
    const DeviceButton& button = device.buttons[i];
    const std::string key = "buttons[" + std::to_string(i) + "].";
    if (!button_action_from(button.action)) {
      return reject(key + "action", "capture, freeze, mark or none", button.action);
    }
    if (foot && !devices::evdev_key(button.key)) {
      return reject(key + "key", "the name of a key (BTN_0, KEY_A, …) or its number up to 767",
                    button.key);
    }
    if (button.name.empty()) return reject(key + "name", "a name", "");
    if (!are_separate(button.pressed_at_s)) {
      return reject(key + "pressed_at_s", "rising times from 0 to 3600 s, at least 0.2 s apart",
                    "other times");
    }
  }
  if (!foot && !can) return {};
  const auto ok = foot ? validate(foot_switch_of(device)) : validate(can_buttons_of(device));
  if (!ok) return Error{ErrorCode::kUsage, name + ".buttons: " + ok.error().message};
  return {};
}

Result<LiveDevice> open_buttons(const DeviceOptions& device, const Clock& clock,
                                Diagnostics& diagnostics) {
  if (device.kind == kFootSwitchKind) {
    auto options = foot_switch_of(device);
    const auto id = hid_address(device.address);
    auto open = id ? devices::FootSwitchSource::with_id({id->vendor, id->product}, options.buttons)
                   : devices::FootSwitchSource::at_path(*input_address(device.address));
    return opened_device(device,
                         devices::FootSwitchSource::create(std::move(options), device.address,
                                                           std::move(open), clock, diagnostics));
  }
  auto options = can_buttons_of(device);
  const std::string interface = *can_address(device.address);
  auto open = devices::CanButtonSource::on_interface(interface, options.buttons);
  return opened_device(
      device, devices::CanButtonSource::create(std::move(options), interface, std::move(open),
                                               clock, diagnostics));
}

}  // namespace nav::session
