// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/display_check.hpp"

#include <cstdlib>
#include <string>
// Included last, because X11 defines macros with everyday names.
#include <X11/Xlib.h>

namespace nav::app {
namespace {

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

}  // namespace

Result<void> check_display() {
  const std::string platform = variable("QT_QPA_PLATFORM");
  if (!platform.empty() && !platform.starts_with("xcb")) return {};
  if (!variable("WAYLAND_DISPLAY").empty()) return {};
  const std::string display = variable("DISPLAY");
  if (Display* open = XOpenDisplay(nullptr); open != nullptr) {
    XCloseDisplay(open);
    return {};
  }
  return Error{ErrorCode::kUnavailable,
               "window: expected a display, found " +
                   (display.empty() ? std::string("DISPLAY not set")
                                    : "DISPLAY=" + display + ", which does not answer")};
}

}  // namespace nav::app
