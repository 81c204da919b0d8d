// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/default_window.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <vector>

#include "tests/render/scene_support.hpp"

namespace nav::render {
namespace {

/// Number of values of each kind.
struct Shown {
  int air = 0;
  int lung = 0;
  int soft = 0;
  int contrast = 0;
};

HuWindow window_for(const StoredVolume& volume, const Shown& shown) {
  std::vector<float> values;
  const auto add = [&](int count, float hu) {
    values.insert(values.end(), static_cast<std::size_t>(count), hu);
  };
  add(shown.air, -1000);
  add(shown.lung, -850);
  add(shown.soft, 50);
  add(shown.contrast, 400);
  return default_window(volume, values);
}

bool is_window(const HuWindow& window, double level, double width) {
  return window.level == level && window.width == width;
}

class DefaultWindowTest : public ::testing::Test {
 protected:
  /// Mostly soft tissue, with a layer of air.
  std::shared_ptr<const StoredVolume> ct_ =
      test::make_volume(test::centred_grid({10, 10, 20}, {1, 1, 1}),
                        [](int, int, int k) { return k == 0 ? -1000 : 50; });
};

TEST_F(DefaultWindowTest, ACtGetsTheUsualWindowForTheVisibleTissue) {
  EXPECT_TRUE(is_window(window_for(*ct_, {.soft = 100}), 60, 400));
  EXPECT_TRUE(is_window(window_for(*ct_, {.soft = 90, .contrast = 10}), 60, 400)) << "a rib";
  EXPECT_TRUE(is_window(window_for(*ct_, {.soft = 80, .contrast = 20}), 200, 700));
  EXPECT_TRUE(is_window(window_for(*ct_, {.contrast = 100}), 200, 700));
  EXPECT_TRUE(is_window(window_for(*ct_, {.lung = 60, .soft = 40}), -500, 1500));
  EXPECT_TRUE(is_window(window_for(*ct_, {.lung = 30, .soft = 70}), 60, 400));
  EXPECT_TRUE(is_window(window_for(*ct_, {.lung = 40, .soft = 30, .contrast = 30}), 200, 700));
}

TEST_F(DefaultWindowTest, AirAroundABodyIsNotLung) {
  EXPECT_TRUE(is_window(window_for(*ct_, {.air = 90, .soft = 10}), 60, 400));
  EXPECT_TRUE(is_window(window_for(*ct_, {.air = 100}), 60, 400));
  EXPECT_TRUE(is_window(window_for(*ct_, {}), 60, 400));
}

TEST_F(DefaultWindowTest, OtherVolumesGetTheirRangeWithoutOutliers) {
  // 1000 voxels of background, then values from 1 to 1000, and one value far above.
  const auto mr =
      test::make_volume(test::centred_grid({10, 10, 20}, {1, 1, 1}), [](int i, int j, int k) {
        const int n = (k * 10 + j) * 10 + i;
        return n == 1999 ? 3000 : std::max(0, n - 999);
      });
  const HuWindow window = window_for(*mr, {.soft = 100});
  constexpr double kRounding = 0.5;
  EXPECT_NEAR(window.level - window.width / 2, 0, kRounding) << "black: the background";
  EXPECT_GT(window.level + window.width / 2, 900);
  EXPECT_LT(window.level + window.width / 2, 1001);
  const auto flat =
      test::make_volume(test::centred_grid({4, 4, 4}, {1, 1, 1}), [](int, int, int) { return 7; });
  EXPECT_GE(window_for(*flat, {}).width, 1);
}

TEST_F(DefaultWindowTest, AMaskGetsTheRangeOfItsTwoValues) {
  const auto mask = test::make_volume(test::centred_grid({10, 10, 10}, {1, 1, 1}),
                                      [](int i, int, int) { return i < 5 ? 1 : 0; });
  EXPECT_TRUE(is_window(window_for(*mask, {}), 0.5, 1));
}

}  // namespace
}  // namespace nav::render
