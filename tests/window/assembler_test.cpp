// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/assembler.hpp"

#include <gtest/gtest.h>

#include "tests/window/moments.hpp"

namespace nav::app {
namespace {

using test::flat_of;
using test::kMs;
using test::kStart;
using test::valid_moment;
using test::view_image_of;

TEST(RefreshAssemblerTest, ShowsTheViewsOfOneMomentTogether) {
  RefreshAssembler assembler;
  const auto moment = valid_moment(1, kStart);
  assembler.add(flat_of(moment), kStart);
  EXPECT_FALSE(assembler.next(kStart + 10 * kMs).flat) << "the 3D view is being drawn";
  assembler.add(view_image_of(moment), kStart + 20 * kMs);
  const Assembled shown = assembler.next(kStart + 20 * kMs);
  ASSERT_TRUE(shown.flat && shown.scene);
  EXPECT_EQ(shown.flat->views[ViewId::kCt]->moment->number, 1U);
  EXPECT_EQ(shown.scene->moment->number, 1U);
  EXPECT_FALSE(assembler.scene_is_late());
}

TEST(RefreshAssemblerTest, TheThreeDViewWaitsForTheFlatViewsOfItsMoment) {
  RefreshAssembler assembler;
  const auto moment = valid_moment(1, kStart);
  assembler.add(view_image_of(moment), kStart);
  EXPECT_FALSE(assembler.next(kStart + 5 * kMs).scene);
  assembler.add(flat_of(moment), kStart + 6 * kMs);
  const Assembled shown = assembler.next(kStart + 6 * kMs);
  EXPECT_TRUE(shown.flat && shown.scene);
}

TEST(RefreshAssemblerTest, FlatViewsGoOnWithoutALateThreeDView) {
  RefreshAssembler assembler;
  assembler.add(flat_of(valid_moment(1, kStart)), kStart);
  assembler.add(view_image_of(valid_moment(1, kStart)), kStart);
  ASSERT_TRUE(assembler.next(kStart).scene);
  assembler.add(flat_of(valid_moment(2, kStart)), kStart);
  assembler.add(flat_of(valid_moment(3, kStart)), kStart + 30 * kMs);
  EXPECT_FALSE(assembler.next(kStart + RefreshAssembler::kMostWait - 1 * kMs).flat);
  const Assembled shown = assembler.next(kStart + RefreshAssembler::kMostWait);
  ASSERT_TRUE(shown.flat);
  EXPECT_EQ(shown.flat->moment->number, 3U) << "the newest";
  EXPECT_TRUE(assembler.scene_is_late());
  EXPECT_EQ(assembler.superseded(), 1U);
}

TEST(RefreshAssemblerTest, AnImageOfTheShownMomentIsShownAtOnce) {
  RefreshAssembler assembler;
  const auto moment = valid_moment(1, kStart);
  assembler.add(flat_of(moment), kStart);
  assembler.add(view_image_of(moment), kStart);
  ASSERT_TRUE(assembler.next(kStart).scene);
  // The camera moved, or the image is drawn in full.
  assembler.add(view_image_of(moment), kStart + 5 * kMs);
  EXPECT_TRUE(assembler.next(kStart + 5 * kMs).scene);
  EXPECT_FALSE(assembler.scene_is_late());
}

TEST(RefreshAssemblerTest, TheNewestFlatViewsOfAMomentAreShown) {
  RefreshAssembler assembler;
  const auto moment = valid_moment(1, kStart);
  FlatImages moved = flat_of(moment);
  moved.views[ViewId::kCt]->asked = 7;
  assembler.add(flat_of(moment), kStart);
  assembler.add(std::move(moved), kStart + 1 * kMs);
  assembler.add(view_image_of(moment), kStart + 2 * kMs);
  const Assembled shown = assembler.next(kStart + 2 * kMs);
  ASSERT_TRUE(shown.flat && shown.scene);
  EXPECT_EQ(shown.flat->views[ViewId::kCt]->asked, 7U);
}

TEST(RefreshAssemblerTest, FlatViewsDoNotWaitForAHiddenThreeDView) {
  RefreshAssembler assembler;
  assembler.expect_scene(false);
  assembler.add(view_image_of(valid_moment(1, kStart)), kStart);
  assembler.add(flat_of(valid_moment(1, kStart)), kStart);
  const Assembled shown = assembler.next(kStart);
  EXPECT_TRUE(shown.flat);
  EXPECT_FALSE(shown.scene);
  EXPECT_FALSE(assembler.scene_is_late());
}

}  // namespace
}  // namespace nav::app
