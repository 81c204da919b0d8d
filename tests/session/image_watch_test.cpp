// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/image_watch.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

namespace nav::session {
namespace {

/// Screen of a scanner with a convex probe: a sector of speckle with its apex at the top, and a
/// depth display in the corner.
struct Screen {
  int width = 320, height = 240;
  double radius_px = 40, depth_px = 220, half_angle = 0.6;
  int digits = 1;       ///< The number that the depth display shows.
  bool in_air = false;  ///< Only the first centimetre is bright.

  Image2d<std::uint8_t> draw(unsigned seed) const {
    std::mt19937 random(seed);
    std::vector<std::uint8_t> pixels(static_cast<std::size_t>(width) *
                                     static_cast<std::size_t>(height));
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const double across = x - 0.5 * width, down = y + radius_px - 5;
        const double r = std::hypot(across, down), angle = std::atan2(across, down);
        const bool echo = r >= radius_px && r <= radius_px - 5 + depth_px &&
                          std::abs(angle) <= half_angle && (!in_air || r < radius_px + 25);
        std::uint8_t grey = static_cast<std::uint8_t>(random() % 9);
        if (echo) grey = static_cast<std::uint8_t>(60 + random() % 150);
        if (x >= 290 && x < 310 && y >= 10 && y < 30) {
          grey = ((x * digits) / 5 + y / 4) % 2 == 0 ? 230 : 10;
        }
        pixels[static_cast<std::size_t>(y * width + x)] = grey;
      }
    }
    return {width, height, std::move(pixels)};
  }
};

constexpr ScreenArea kDisplay{.left = 285, .top = 5, .width = 30, .height = 30};

struct WatchBench {
  explicit WatchBench(bool with_display = true)
      : watch({.depth_display = with_display ? std::optional(kDisplay) : std::nullopt}) {
    show(Screen{}, 40);
  }
  /// Change after so many images.
  std::string show(const Screen& screen, int images) {
    for (int i = 0; i < images; ++i) (void)watch.look(screen.draw(seed++));
    return watch.change();
  }
  ImageWatch watch;
  unsigned seed = 1;
};

TEST(ImageWatchTest, TheSameScreenNeverChanges) {
  WatchBench bench;
  EXPECT_EQ(bench.show(Screen{}, 60), "");
  // The probe is lifted, and put back.
  EXPECT_EQ(bench.show(Screen{.in_air = true}, 30), "");
  EXPECT_EQ(bench.show(Screen{}, 30), "");
}

TEST(ImageWatchTest, ADepthDisplayThatChangesIsSaidAfterThreeImagesAndTakenBack) {
  WatchBench bench;
  const Screen deeper{.digits = 2};
  EXPECT_EQ(bench.show(deeper, 2), "");
  EXPECT_NE(bench.show(deeper, 1).find("depth display"), std::string::npos);
  EXPECT_NE(bench.show(Screen{}, 2), "");
  EXPECT_EQ(bench.show(Screen{}, 1), "");
}

TEST(ImageWatchTest, ASectorThatGrowsShrinksOrMovesIsSaid) {
  WatchBench bench(false);
  EXPECT_NE(bench.show({.half_angle = 0.8}, 5).find("grown"), std::string::npos);
  EXPECT_EQ(bench.show({}, 5), "");
  // Deeper: everything is drawn smaller.
  EXPECT_NE(bench.show({.radius_px = 25, .depth_px = 205, .half_angle = 0.6}, 5), "");
  EXPECT_EQ(bench.show({}, 5), "");
  EXPECT_NE(bench.show({.half_angle = 0.35}, 5).find("shrunk"), std::string::npos);
}

TEST(ImageWatchTest, AnotherSizeIsNamedWithBoth) {
  WatchBench bench;
  EXPECT_EQ(bench.show({.width = 640, .height = 480}, 4),
            "the screen of the scanner has 640 x 480 pixels, at first 320 x 240");
  EXPECT_EQ(bench.show({}, 4), "");
}

TEST(ImageWatchTest, OneBadImageIsNoChange) {
  WatchBench bench;
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(bench.show({.half_angle = 0.9}, 1), "");
    EXPECT_EQ(bench.show({}, 1), "");
  }
}

TEST(ImageWatchTest, AChangeWhileItLearnsIsNotLearned) {
  ImageWatch watch({.depth_display = kDisplay});
  unsigned seed = 1;
  for (int i = 0; i < 10; ++i) (void)watch.look(Screen{}.draw(seed++));
  for (int i = 0; i < 10; ++i) (void)watch.look(Screen{.digits = 2}.draw(seed++));
  EXPECT_NE(watch.change(), "");
  for (int i = 0; i < 30; ++i) (void)watch.look(Screen{}.draw(seed++));
  EXPECT_EQ(watch.change(), "");
}

TEST(ImageWatchTest, BlackAndTinyScreensAreTaken) {
  ImageWatch watch({});
  for (int i = 0; i < 60; ++i) {
    EXPECT_EQ(watch.look({1, 1, {0}}), "");
  }
  ImageWatch black({.depth_display = ScreenArea{1000, 1000, 10, 10}});
  for (int i = 0; i < 60; ++i) {
    EXPECT_EQ(black.look({64, 48, std::vector<std::uint8_t>(64 * 48)}), "");
  }
}

TEST(ScreenAreaTest, TakesFourWholeNumbers) {
  ASSERT_TRUE(screen_area({1, 2, 3, 4}));
  EXPECT_EQ(screen_area({1, 2, 3, 4})->height, 4);
  for (const std::vector<double>& wrong : std::vector<std::vector<double>>{
           {}, {1, 2, 3}, {1, 2, 0, 4}, {-1, 2, 3, 4}, {1.5, 2, 3, 4}, {1, 2, 3, 1e9}}) {
    EXPECT_FALSE(screen_area(wrong));
  }
}

}  // namespace
}  // namespace nav::session
