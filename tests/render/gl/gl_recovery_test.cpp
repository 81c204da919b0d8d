// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <EGL/egl.h>
#include <cstring>
#include <gtest/gtest.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtk_glew.h>

#include "render/engine.hpp"
#include "render/gl/gl_program.hpp"
#include "render/vtk/vtk_offscreen.hpp"
#include "tests/render/gl/gl_scenes.hpp"
#include "tests/support/matchers.hpp"

// A separate program, because it ends the display of the whole process.
namespace nav::render {
namespace {

TEST(GlRecoveryTest, AProgramThatDoesNotLinkReportsTheReason) {
  auto window = OffscreenWindow::create(8, 8);
  ASSERT_TRUE(test::has_value(window));
  const auto linked =
      GlProgram::link(assembled_shader("fullscreen.vert"),
                      "#version 410 core\nvec4 missing();\nlayout(location = 0) out vec4 colour;\n"
                      "void main() { colour = missing(); }\n");
  EXPECT_TRUE(test::rejects(linked, ErrorCode::kUnsupportedData, {"shader", "the driver says"}));
}

TEST(GlRecoveryTest, ALostContextIsReplaced) {
  CollectingDiagnostics diagnostics;
  auto gl = make_gl_engine(diagnostics);
  ASSERT_TRUE(test::has_value(gl));
  const Scene scene = test::ball_scene(test::cube_grid(16, 1.0));
  const auto before = (*gl)->render(scene);
  ASSERT_TRUE(test::has_value(before));
  {
    // All contexts of a process share one display. It ends here for all of them.
    auto other = OffscreenWindow::create(8, 8);
    ASSERT_TRUE(test::has_value(other));
    EGLDisplay display = eglGetCurrentDisplay();
    ASSERT_NE(display, EGL_NO_DISPLAY);
    (*other)->release_thread();
    ASSERT_TRUE(eglTerminate(display));
  }
  const auto after = (*gl)->render(scene);
  ASSERT_TRUE(test::has_value(after));
  const auto a = before->pixels.pixels();
  const auto b = after->pixels.pixels();
  EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size_bytes()), 0);
}

}  // namespace
}  // namespace nav::render
