// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <gtest/gtest.h>

#include "render/engine.hpp"
#include "render/window/window.hpp"
#include "tests/support/matchers.hpp"

// A separate program, because EGL and X11 read these variables once per process.
namespace nav::render {
namespace {

TEST(GlContextTest, WithoutEglTheErrorNamesWhatIsMissing) {
  ::setenv("__EGL_VENDOR_LIBRARY_FILENAMES", "/nonexistent/vendor.json", 1);
  CollectingDiagnostics diagnostics;
  EXPECT_TRUE(test::rejects(make_gl_engine(diagnostics), ErrorCode::kUnavailable,
                            {"off-screen OpenGL", "an EGL display"}));
}

TEST(GlContextTest, WithoutADisplayTheWindowIsUnavailable) {
  const ImageSource nothing = [](const WindowInput&) { return Image2d<Rgba8>(); };
  ::unsetenv("DISPLAY");
  EXPECT_TRUE(test::rejects(show_window(nothing), ErrorCode::kUnavailable, {"DISPLAY not set"}));
  ::setenv("DISPLAY", ":4711", 1);
  EXPECT_TRUE(test::rejects(show_window(nothing), ErrorCode::kUnavailable, {"DISPLAY=:4711"}));
}

}  // namespace
}  // namespace nav::render
