// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "devices/buttons/button_source.hpp"
#include "devices/can/can_socket.hpp"

namespace nav::devices {

/// A button on a CAN bus: one bit of the data of one frame.
struct CanButton {
  std::string name;         ///< Name of its stream; unique.
  std::uint32_t frame = 0;  ///< Identifier, 11 or 29 bits.
  bool extended = false;    ///< The identifier has 29 bits.
  int byte = 0;             ///< 0 to 7.
  int bit = 0;              ///< 0 (lowest) to 7.
  bool pressed_when_zero = false;
  ButtonAction action = ButtonAction::kNone;
};

/// Reading of a button in a frame.
enum class CanButtonReading {
  kForeign,  ///< It is another frame, or a remote one.
  kShort,    ///< The frame has no such byte.
  kUp,
  kDown,
};
CanButtonReading read_can_button(const CanButton& button, const CanFrame& frame);

struct CanButtonOptions {
  std::vector<CanButton> buttons{};  ///< At least one; each with a bit of its own.
  ButtonTimes times{};
};
/// Rejects no buttons, empty or equal names, equal bits, and numbers out of range.
Result<void> validate(const CanButtonOptions& options);

/// Buttons on a CAN bus (SocketCAN). It only listens, on a socket of its own: an arm of encoders
/// may be on the same bus. Each button is a stream: a sample for each time that it goes down or
/// comes up. The first frame that shows a button down counts as a press. Two presses within
/// kPressesCountOnce count once ("bounce"). It has no thread of its own: call next() from a thread
/// that does nothing else.
class CanButtonSource final : public ButtonSource {
 public:
  /// \p name: of the bus in messages, such as "can0". Errors: those of validate().
  static Result<std::unique_ptr<CanButtonSource>> create(CanButtonOptions options, std::string name,
                                                         ButtonOpener open, const Clock& clock,
                                                         Diagnostics& diagnostics);
  /// Opens an interface of the kernel, for the frames of these buttons.
  static ButtonOpener on_interface(const std::string& interface,
                                   const std::vector<CanButton>& buttons);

 private:
  CanButtonSource(CanButtonOptions options, std::string name, ButtonOpener open, const Clock& clock,
                  Diagnostics& diagnostics);
  void read_device() override;
  void restart() override { dropped_ = 0; }
  void take(const CanReceived& received);
  void take_errors(const CanFrame& frame);

  CanButtonOptions options_;
  std::uint32_t dropped_ = 0;
};

}  // namespace nav::devices
