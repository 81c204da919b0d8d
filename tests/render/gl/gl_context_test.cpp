// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <gtest/gtest.h>

#include "render/engine.hpp"
#include "tests/support/matchers.hpp"

// A separate program, because EGL reads this variable once per process.
namespace nav::render {
namespace {

TEST(GlContextTest, WithoutEglTheErrorNamesWhatIsMissing) {
  ::setenv("__EGL_VENDOR_LIBRARY_FILENAMES", "/nonexistent/vendor.json", 1);
  CollectingDiagnostics diagnostics;
  EXPECT_TRUE(test::rejects(make_gl_engine(diagnostics), ErrorCode::kUnavailable,
                            {"off-screen OpenGL", "an EGL display"}));
}

}  // namespace
}  // namespace nav::render
