// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/vtk/vtk_text.hpp"

#include <array>
#include <vector>
#include <vtkFreeTypeTools.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPath.h>
#include <vtkStdString.h>
#include <vtkTextProperty.h>
#include <vtkTextRenderer.h>

namespace nav::render {

bool is_drawn(const Letter& letter) {
  if (!letter.code) return false;
  const char32_t code = *letter.code;
  constexpr char32_t kNoBreakSpace = 0xa0;
  if ((code >= 0x20 && code < 0x7f) || code == kNoBreakSpace) return true;
  if (code < 0x20) return false;
  vtkNew<vtkTextProperty> property;
  property->SetFontFamilyToArial();
  const auto outline = vtkFreeTypeTools::GetInstance()->GetUnscaledGlyphOutline(property, code);
  return outline.Path != nullptr && outline.Path->GetNumberOfPoints() > 0;
}

std::string drawable_text(const std::string& words) {
  std::string drawable;
  for (const Letter& letter : letters_of(words)) drawable += is_drawn(letter) ? letter.bytes : "?";
  return drawable;
}

TextMask rasterise_text(const std::string& words, int size_px) {
  NAV_CHECK(size_px >= 4 && size_px <= 512, size_px);
  vtkNew<vtkTextProperty> property;
  property->SetFontFamilyToArial();
  property->SetFontSize(size_px);
  property->SetColor(1, 1, 1);
  property->SetJustificationToLeft();
  property->SetVerticalJustificationToBottom();
  vtkNew<vtkImageData> image;
  std::array<int, 2> dimensions{};
  // vtkFreeTypeTools itself would read each byte as a letter. At 72 dpi font sizes are pixels.
  vtkTextRenderer* renderer = vtkTextRenderer::GetInstance();
  NAV_CHECK(renderer != nullptr);
  renderer->SetScaleToPowerOfTwo(false);
  const bool drawn =
      !words.empty() && renderer->RenderString(property, drawable_text(words), image,
                                               dimensions.data(), 72, vtkTextRenderer::FreeType);
  if (!drawn) return {Image2d<std::uint8_t>(1, 1, {0}), 0};

  std::array<int, 6> extent{};
  image->GetExtent(extent.data());
  const int width = extent[1] - extent[0] + 1;
  const int height = extent[3] - extent[2] + 1;
  const int channels = image->GetNumberOfScalarComponents();
  std::vector<std::uint8_t> coverage;
  coverage.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int y = extent[3]; y >= extent[2]; --y) {  // VTK counts rows from the bottom.
    for (int x = extent[0]; x <= extent[1]; ++x) {
      const auto* pixel = static_cast<const unsigned char*>(image->GetScalarPointer(x, y, 0));
      coverage.push_back(pixel[channels - 1]);
    }
  }
  // Rows at and above 0 stand on the base line.
  return {Image2d<std::uint8_t>(width, height, std::move(coverage)), extent[3] + 1};
}

}  // namespace nav::render
