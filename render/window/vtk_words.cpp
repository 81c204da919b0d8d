// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/window/vtk_words.hpp"

#include <algorithm>
#include <vtkCoordinate.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>

#include "render/vtk/vtk_text.hpp"
#include "render/window/window_layout.hpp"

namespace nav::render {
namespace {

void place(const PlacedWords& line, int width, int height, vtkTextActor& actor) {
  actor.SetInput(drawable_text(line.words).c_str());
  actor.GetPositionCoordinate()->SetCoordinateSystemToNormalizedViewport();
  actor.SetPosition(line.x_px / width, 1 - line.y_px / height);
  vtkTextProperty& style = *actor.GetTextProperty();
  style.SetFontSize(line.size_px);
  style.SetColor(line.colour.r / 255.0, line.colour.g / 255.0, line.colour.b / 255.0);
  // The text has its own background, because the image below may be as bright as the text.
  style.SetBackgroundColor(0.06, 0.08, 0.1);
  style.SetBackgroundOpacity(0.75);
  style.SetVerticalJustificationToCentered();
  switch (line.align) {
    case WindowWords::Align::kLeft:
      return style.SetJustificationToLeft();
    case WindowWords::Align::kCentre:
      return style.SetJustificationToCentered();
    case WindowWords::Align::kRight:
      return style.SetJustificationToRight();
  }
}

}  // namespace

WordsLayer::WordsLayer(vtkRenderWindow& window)
    : window_(window), renderer_(vtkSmartPointer<vtkRenderer>::New()) {
  window_.SetNumberOfLayers(2);
  renderer_->SetLayer(1);
  renderer_->InteractiveOff();
  window_.AddRenderer(renderer_);
}

WordsLayer::~WordsLayer() {
  window_.MakeCurrent();
  for (const auto& line : lines_) line->ReleaseGraphicsResources(&window_);
  window_.RemoveRenderer(renderer_);
}

void WordsLayer::set(const std::vector<WindowWords>& unplaced) {
  const int* size = window_.GetSize();
  const int width = std::max(size[0], 1);
  const int height = std::max(size[1], 1);
  const std::vector<PlacedWords> words = placed_words(unplaced, width, height);
  while (lines_.size() < words.size()) {
    lines_.push_back(vtkSmartPointer<vtkTextActor>::New());
    renderer_->AddViewProp(lines_.back());
  }
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    const bool shown = i < words.size();
    lines_[i]->SetVisibility(shown ? 1 : 0);
    if (shown) place(words[i], width, height, *lines_[i]);
  }
}

}  // namespace nav::render
