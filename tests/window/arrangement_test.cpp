// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/arrangement.hpp"

#include <array>
#include <gtest/gtest.h>
#include <optional>
#include <vector>

namespace nav::app {
namespace {

constexpr QRect kArea(190, 6, 1400, 800);

std::vector<QRect> rects_of(const Arrangement& made) {
  std::vector<QRect> all{made.numerals};
  if (made.panel) all.push_back(*made.panel);
  for (const auto& view : made.views.all) {
    if (view) all.push_back(*view);
  }
  return all;
}

TEST(ArrangementTest, NothingOverlapsAndNothingIsCut) {
  for (const WindowLayout layout : {WindowLayout::kGuidance, WindowLayout::kSlices,
                                    WindowLayout::kNeedle, WindowLayout::kSingle}) {
    for (const auto tool_width : {std::optional<int>(), std::optional(kToolWidth)}) {
      const auto all = rects_of(arrange_views(layout, ViewId::kSagittal, kArea, tool_width));
      for (std::size_t i = 0; i < all.size(); ++i) {
        EXPECT_TRUE(kArea.contains(all[i]));
        for (std::size_t j = 0; j < i; ++j) {
          EXPECT_FALSE(all[i].intersects(all[j])) << i << ", " << j;
        }
      }
    }
  }
}

TEST(ArrangementTest, EachLayoutHasItsViews) {
  const auto has = [](WindowLayout layout, std::vector<ViewId> wanted) {
    const Arrangement made = arrange_views(layout, ViewId::kCt, kArea);
    std::size_t shown = 0;
    for (const auto& view : made.views.all) shown += view ? 1 : 0;
    bool all = shown == wanted.size();
    for (const ViewId id : wanted) all = all && made.views[id].has_value();
    return all;
  };
  EXPECT_TRUE(has(WindowLayout::kGuidance, {ViewId::kScene, ViewId::kUltrasound, ViewId::kCt}));
  EXPECT_TRUE(has(WindowLayout::kSlices,
                  {ViewId::kAxial, ViewId::kCoronal, ViewId::kSagittal, ViewId::kScene}));
  EXPECT_TRUE(has(WindowLayout::kNeedle, {ViewId::kBullsEye, ViewId::kNeedleFirst,
                                          ViewId::kNeedleSecond, ViewId::kUltrasound}));
  EXPECT_TRUE(has(WindowLayout::kSingle, {ViewId::kCt}));
}

TEST(ArrangementTest, AToolHasItsSpaceInTheSmallestWindow) {
  constexpr QRect kLeast(190, 6, 1084, 700);  // 1280 x 800 without rail and states.
  for (const WindowLayout layout : {WindowLayout::kGuidance, WindowLayout::kSlices,
                                    WindowLayout::kNeedle, WindowLayout::kSingle}) {
    const Arrangement made = arrange_views(layout, ViewId::kCt, kLeast, kToolWidth);
    ASSERT_TRUE(made.panel);
    EXPECT_GE(made.panel->width(), kToolWidth);
    EXPECT_GE(made.panel->height(), kToolHeight);
    const Arrangement without = arrange_views(layout, ViewId::kCt, kLeast);
    for (std::size_t i = 0; i < kViewCount; ++i) {
      EXPECT_EQ(made.views.all[i].has_value(), without.views.all[i].has_value());
      if (!made.views.all[i]) continue;
      EXPECT_GE(made.views.all[i]->height(), 130);
    }
  }
}

TEST(ArrangementTest, ASecondScreenHasAnyChoiceOfViews) {
  constexpr std::array kChosen{ViewId::kScene, ViewId::kUltrasound, ViewId::kCt,
                               ViewId::kAxial, ViewId::kCoronal,    ViewId::kSagittal};
  for (unsigned choice = 1; choice < 1U << kChosen.size(); ++choice) {
    PerView<bool> views;
    for (std::size_t i = 0; i < kChosen.size(); ++i) views[kChosen[i]] = (choice >> i & 1U) != 0;
    for (const QRect& area : {kArea, QRect(0, 0, 1, 1)}) {
      const Arrangement made = arrange_second(views, area);
      for (std::size_t i = 0; i < kViewCount; ++i) {
        EXPECT_EQ(made.views.all[i].has_value(), views.all[i]) << choice;
      }
      const auto all = rects_of(made);
      for (std::size_t i = 0; i < all.size(); ++i) {
        EXPECT_FALSE(all[i].isEmpty());
        if (area != kArea) continue;
        EXPECT_TRUE(kArea.contains(all[i])) << choice;
        EXPECT_GE(all[i].width(), 250) << choice;
        for (std::size_t j = 0; j < i; ++j) EXPECT_FALSE(all[i].intersects(all[j])) << choice;
      }
    }
  }
}

TEST(ArrangementTest, ATinyWindowHasNoEmptyRectangle) {
  for (const WindowLayout layout : {WindowLayout::kGuidance, WindowLayout::kSlices,
                                    WindowLayout::kNeedle, WindowLayout::kSingle}) {
    for (const QRect& rect : rects_of(arrange_views(layout, ViewId::kAxial, QRect(0, 0, 1, 1)))) {
      EXPECT_FALSE(rect.isEmpty());
    }
    for (const QRect& rect :
         rects_of(arrange_views(layout, ViewId::kAxial, QRect(0, 0, 1, 1), kToolWidth))) {
      EXPECT_FALSE(rect.isEmpty());
    }
  }
}

}  // namespace
}  // namespace nav::app
