// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/window/window_layout.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "render/vtk/vtk_text.hpp"

namespace nav::render {
namespace {

using Align = WindowWords::Align;
using Stack = WindowWords::Stack;
constexpr Rgba8 kInk = {255, 255, 255, 255};

/// The texts of a replay in the worst case.
std::vector<WindowWords> much() {
  std::vector<WindowWords> words{{"R", kInk, 0.01, 0.5, Align::kLeft, 17},
                                 {"L", kInk, 0.99, 0.5, Align::kRight, 17},
                                 {"S", kInk, 0.5, 0.025, Align::kCentre, 17},
                                 {"I", kInk, 0.5, 0.975, Align::kCentre, 17}};
  for (const char* line : {"CT NOT REGISTERED", "the recording has ended: last image, not live",
                           "warning 1 of 2: predicted error at the target: 4.8 mm"}) {
    words.push_back({line, kInk, 0.01, 0.07, Align::kLeft, 14, Stack::kDown});
  }
  for (const char* line : {"needle lost: the patient reference is not tracked",
                           "CT degraded: the CT is placed by declaration, not registered",
                           "ultrasound stale: the ultrasound picture is 1234 ms old"}) {
    words.push_back({line, kInk, 0.01, 0.93, Align::kLeft, 14, Stack::kUp});
  }
  return words;
}

std::string said(const std::vector<PlacedWords>& lines) {
  std::string all;
  for (const PlacedWords& line : lines) all += line.words + " ";
  return all;
}

/// Tests that lines lie in the window and do not overlap.
void expect_apart(const std::vector<PlacedWords>& lines, int width, int height) {
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const PlacedWords& a = lines[i];
    const double half = 0.5 * line_height_px(a.size_px);
    EXPECT_GE(a.y_px, half) << a.words;
    EXPECT_LE(a.y_px, height - half) << a.words;
    const int ink = rasterise_text(a.words, a.size_px).coverage.width();
    EXPECT_LE(a.align == Align::kLeft ? a.x_px + ink : a.x_px, width) << a.words;
    for (std::size_t j = 0; j < i; ++j) {
      const PlacedWords& b = lines[j];
      if (a.size_px == 17 && b.size_px == 17) continue;  // Letters of different edges.
      EXPECT_GE(std::abs(a.y_px - b.y_px), half + 0.5 * line_height_px(b.size_px) - 1e-9)
          << a.words << " and " << b.words;
    }
  }
}

TEST(WindowLayoutTest, TextsDoNotOverlapAndStayWholeInSmallWindows) {
  for (const auto& [width, height] : {std::pair(300, 225), {400, 300}, {900, 700}, {1920, 1080}}) {
    SCOPED_TRACE(std::to_string(width) + " x " + std::to_string(height));
    const auto lines = placed_words(much(), width, height);
    expect_apart(lines, width, height);
    std::size_t words = 0;
    for (const WindowWords& w : much()) words += 1 + std::ranges::count(w.words, ' ');
    EXPECT_EQ(static_cast<std::size_t>(std::ranges::count(said(lines), ' ')), words);
  }
}

TEST(WindowLayoutTest, AWrappedLineReadsDownwardsInBothStacks) {
  for (const Stack stack : {Stack::kDown, Stack::kUp}) {
    const auto lines = placed_words(
        {{"one two three four five six seven", kInk, 0.01, 0.5, Align::kLeft, 14, stack}}, 90, 300);
    ASSERT_GT(lines.size(), 2U);
    const auto first =
        std::ranges::min_element(lines, {}, [](const PlacedWords& line) { return line.y_px; });
    EXPECT_TRUE(first->words.starts_with("one")) << first->words;
  }
}

TEST(WindowLayoutTest, OnlyStatesRemainInATinyWindow) {
  const auto lines = placed_words(much(), 200, 110);
  expect_apart(lines, 200, 110);
  EXPECT_NE(said(lines).find("needle lost"), std::string::npos) << said(lines);
  EXPECT_EQ(said(lines).find("predicted error"), std::string::npos) << said(lines);
}

}  // namespace
}  // namespace nav::render
