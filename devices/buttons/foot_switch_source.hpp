// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "devices/buttons/button_source.hpp"
#include "devices/buttons/evdev_codec.hpp"
#include "devices/buttons/input_device.hpp"

namespace nav::devices {

/// A button of a foot switch.
struct FootSwitchButton {
  std::string name;  ///< Name of its stream; unique.
  std::uint16_t key = 0;
  ButtonAction action = ButtonAction::kNone;
};

struct FootSwitchOptions {
  std::vector<FootSwitchButton> buttons{};  ///< At least one; each with a key of its own.
  ButtonTimes times{};
  /// Tells which keys are down, after the kernel has lost events; keys_down() of the kernel.
  std::function<std::optional<std::vector<std::uint8_t>>(const FileDescriptor&)> down = keys_down;
};
/// Rejects no buttons, empty or equal names, equal keys and times out of range.
Result<void> validate(const FootSwitchOptions& options);

/// A foot switch, or any input device of the kernel with keys (evdev). Each button is a stream: a
/// sample for each time that it goes down or comes up, with the kernel's time of it. Repeats of a
/// key that is held do not count, and two presses within kPressesCountOnce count once ("bounce").
/// Keys that are no button are named once. It has no thread of its own: call next() from a thread
/// that does nothing else.
class FootSwitchSource final : public ButtonSource {
 public:
  /// \p name: of the device in messages, such as "hid:05f3:00ff". Errors: those of validate().
  static Result<std::unique_ptr<FootSwitchSource>> create(FootSwitchOptions options,
                                                          std::string name, ButtonOpener open,
                                                          const Clock& clock,
                                                          Diagnostics& diagnostics);
  /// Opens an input device by its path.
  static ButtonOpener at_path(std::filesystem::path path);
  /// Finds and opens the input device with these numbers; it may have another path each time.
  static ButtonOpener with_id(const HidId& id, const std::vector<FootSwitchButton>& buttons);

 private:
  FootSwitchSource(FootSwitchOptions options, std::string name, ButtonOpener open,
                   const Clock& clock, Diagnostics& diagnostics);
  void read_device() override;
  void restart() override { parser_.restart(); }
  void take(const EvdevNews& news);
  void ask_keys();

  FootSwitchOptions options_;
  EvdevParser parser_;
};

}  // namespace nav::devices
