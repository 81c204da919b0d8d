// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/actions.hpp"

#include <gtest/gtest.h>

#include "tests/window/moments.hpp"

namespace nav::app {
namespace {

using test::kMs;
using test::kStart;

QKeyEvent press(int key, bool repeat = false) {
  return {QEvent::KeyPress, key, Qt::NoModifier, QString(), repeat};
}

TEST(ActionsTest, TwoQuickPressesOfAPedalCountOnce) {
  int runs = 0;
  Actions actions;
  actions.add({QStringLiteral("freeze"), {}, QKeySequence(Qt::Key_Space), [&] { ++runs; }});
  EXPECT_TRUE(actions.press(press(Qt::Key_Space), kStart));
  EXPECT_TRUE(actions.press(press(Qt::Key_Space), kStart + 149 * kMs));
  EXPECT_EQ(runs, 1);
  EXPECT_TRUE(actions.press(press(Qt::Key_Space), kStart + 300 * kMs));
  EXPECT_EQ(runs, 2);
}

TEST(ActionsTest, ARepeatedKeyIsIgnored) {
  int runs = 0;
  Actions actions;
  actions.add({QStringLiteral("freeze"), {}, QKeySequence(Qt::Key_Space), [&] { ++runs; }});
  EXPECT_TRUE(actions.press(press(Qt::Key_Space, true), kStart));
  EXPECT_EQ(runs, 0);
  EXPECT_FALSE(actions.press(press(Qt::Key_X), kStart)) << "no action has this key";
}

}  // namespace
}  // namespace nav::app
