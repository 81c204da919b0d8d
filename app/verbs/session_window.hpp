// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "app/verbs/placed_view.hpp"
#include "session/driver.hpp"

namespace nav::app {

/// A session as a window plays it.
struct SessionWindow {
  /// The next epoch at a time of the window's clock; absent while none is due.
  std::function<Result<std::optional<session::Epoch>>(Timestamp)> next;
  /// Takes every epoch once. True if it has just drawn it by Presenter::present().
  std::function<Result<bool>(const session::Epoch&)> take;
  /// True when the window has to close.
  std::function<bool()> close_when;
  std::string ended;  ///< Cause that the last image shows when the sources have ended.
};

/// Makes an epoch that is still shown as old as it is by now. True if its state is another then.
bool has_aged(const session::Driver& driver, session::Epoch& epoch, Timestamp clock_now);

/// Plays a session in a window until it is closed, or Ctrl-C. The last image stays, as no longer
/// live. Errors: those of next() and take(), and of the window.
Result<void> play_in_window(const SessionWindow& play, PlacedView& view, session::Driver& driver,
                            Console& console);

}  // namespace nav::app
