// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "nav/result.hpp"

class vtkOpenGLRenderWindow;

namespace nav::render {

/// A VTK render window on a surfaceless EGL context; needs no X server. Belongs to the thread that
/// created it. Only for render/ and its tests: VTK types do not leave this folder otherwise.
class OffscreenWindow {
 public:
  /// Creates a window. Returns kUnavailable with the name of what is missing: EGL display, OpenGL
  /// 4.1 core or GLEW entry points.
  static Result<std::unique_ptr<OffscreenWindow>> create(int width, int height);
  ~OffscreenWindow();
  OffscreenWindow(const OffscreenWindow&) = delete;
  OffscreenWindow& operator=(const OffscreenWindow&) = delete;

  /// The window, ready for Render(), without multisampling.
  [[nodiscard]] vtkOpenGLRenderWindow& window();
  /// Releases the thread's context: as long as an EGL context is current, GLX (an X11 window)
  /// cannot make its own current. VTK takes the context again by itself.
  void release_thread();
  /// GL_RENDERER of the context, for example "llvmpipe (LLVM 15.0.6, 256 bits)".
  [[nodiscard]] const std::string& device() const;

 private:
  struct Impl;
  explicit OffscreenWindow(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace nav::render
