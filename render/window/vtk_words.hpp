// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>
#include <vtkSmartPointer.h>

#include "render/window/window.hpp"

class vtkRenderWindow;
class vtkRenderer;
class vtkTextActor;

namespace nav::render {

/// Overlay text in a layer of its own over everything else in a window, which it does not disturb.
/// The window must outlive it. One thread, that of the window.
class WordsLayer {
 public:
  explicit WordsLayer(vtkRenderWindow& window);
  ~WordsLayer();
  WordsLayer(const WordsLayer&) = delete;
  WordsLayer& operator=(const WordsLayer&) = delete;

  /// Sets the text that the next image of the window shows; it replaces the last text.
  void set(const std::vector<WindowWords>& words);

 private:
  vtkRenderWindow& window_;
  vtkSmartPointer<vtkRenderer> renderer_;
  std::vector<vtkSmartPointer<vtkTextActor>> lines_;
};

}  // namespace nav::render
