// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/actions.hpp"

namespace nav::app {
namespace {

constexpr auto kBounce = std::chrono::milliseconds(150);

}  // namespace

bool Actions::press(const QKeyEvent& event, Timestamp now) {
  // '?' and '+' need Shift on most keyboards, and the keypad has digits too.
  auto modifiers = event.modifiers() & ~Qt::KeypadModifier;
  if (event.key() == Qt::Key_Question || event.key() == Qt::Key_Plus)
    modifiers &= ~Qt::ShiftModifier;
  const QKeySequence pressed(QKeyCombination(modifiers, static_cast<Qt::Key>(event.key())));
  for (const Action& action : all_) {
    if (action.key != pressed) continue;
    if (event.isAutoRepeat()) return true;
    const bool bounced = last_ && last_->action == &action && now - last_->at < kBounce;
    last_ = Pressed{&action, now};
    if (!bounced) action.run();
    return true;
  }
  return false;
}

}  // namespace nav::app
