// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "nav/time.hpp"

namespace nav::devices {

/// Two presses within this time count once: contacts bounce, and a foot trembles.
inline constexpr Duration kPressesCountOnce = std::chrono::milliseconds(150);

/// Meaning of a reading of a contact.
enum class ButtonChange {
  kNone,    ///< The button is as it was.
  kChange,  ///< It went down, or came up.
  kBounce,  ///< A press that counts with the one before.
};

/// Turns the readings of the contact of one button into its changes. Not thread-safe.
class ButtonFilter {
 public:
  /// \p time: of the reading, in any order of equal or rising times.
  ButtonChange take(bool pressed, Timestamp time) {
    if (pressed == pressed_) return ButtonChange::kNone;
    if (pressed && pressed_at_ && time - *pressed_at_ < kPressesCountOnce) {
      return ButtonChange::kBounce;
    }
    pressed_ = pressed;
    if (pressed) pressed_at_ = time;
    return ButtonChange::kChange;
  }
  /// The button is not known any more, and taken as up.
  void forget() { pressed_ = false; }
  [[nodiscard]] bool pressed() const { return pressed_; }

 private:
  bool pressed_ = false;
  std::optional<Timestamp> pressed_at_;
};

}  // namespace nav::devices
