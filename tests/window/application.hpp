// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QApplication>
#include <cstdlib>

namespace nav::test {

/// The one application of a test program, without an X server.
inline QApplication& application() {
  static const bool offscreen = [] {
    setenv("QT_QPA_PLATFORM", "offscreen", 1);
    return true;
  }();
  static int argc = offscreen ? 1 : 0;
  static char name[] = "window_test";
  static char* argv[] = {name, nullptr};
  // Never destroyed: what it uses may be gone at the end of the program.
  static auto* made = new QApplication(argc, argv);
  return *made;
}

}  // namespace nav::test
