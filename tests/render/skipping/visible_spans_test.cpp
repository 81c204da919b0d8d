// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/skipping/visible_spans.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "tests/render/scene_support.hpp"

namespace nav::render {
namespace {

constexpr int kOutsideHu = -1000;
constexpr int kBoneHu = 900;

TransferFunction bone() {
  return *TransferFunction::create(
      "bone", {{-1000, {1, 1, 1}, 0, 0}, {400, {1, 1, 1}, 0, 0}, {600, {1, 1, 1}, 0.5, 0}});
}

/// A ball of bone with the given radius in voxels, in the middle of 65^3 voxels of 1 mm.
std::shared_ptr<const StoredVolume> ball(double radius) {
  return test::make_volume(test::centred_grid({65, 65, 65}, {1, 1, 1}), [&](int i, int j, int k) {
    return Eigen::Vector3d(i - 32, j - 32, k - 32).norm() <= radius ? kBoneHu : kOutsideHu;
  });
}

BrickShell shell_of(const StoredVolume& volume) {
  const BrickGrid bricks = make_brick_grid(volume, 1);
  return brick_shell(bricks, hidden_bricks(bricks, TransferTable(bone()), 1));
}

Scene scene_of(std::shared_ptr<const StoredVolume> ct, double distance_mm, bool orthographic) {
  Scene scene =
      test::plain_scene(std::move(ct), bone(), test::frontal(distance_mm, 120, orthographic));
  scene.width = 90;
  scene.height = 70;
  return scene;
}

TEST(VisibleSpansTest, TheShellHasTheBricksWithAFreeFace) {
  EXPECT_TRUE(shell_of(*ball(-1)).bricks.empty());
  // 65 voxels are 9 bricks per axis. All are occupied, and the ones at the border are the shell.
  const auto full = test::make_volume(test::centred_grid({65, 65, 65}, {1, 1, 1}),
                                      [](int, int, int) { return kBoneHu; });
  EXPECT_EQ(shell_of(*full).bricks.size(), 9U * 9 * 9 - 7U * 7 * 7);
  // Voxels 20 to 44 lie in bricks 2 to 5.
  const auto box =
      test::make_volume(test::centred_grid({65, 65, 65}, {1, 1, 1}), [](int i, int j, int k) {
        return std::min({i, j, k}) >= 20 && std::max({i, j, k}) <= 44 ? kBoneHu : kOutsideHu;
      });
  EXPECT_EQ(shell_of(*box).bricks.size(), 4U * 4 * 4 - 2U * 2 * 2);
}

TEST(VisibleSpansTest, EnclosesADistantBallAndLeavesOutTheCorners) {
  constexpr double kRadius = 12;
  for (const bool orthographic : {false, true}) {
    const Scene scene = scene_of(ball(kRadius), 200, orthographic);
    const VisibleSpans spans(scene, shell_of(*scene.ct), 2);
    const VisibleSpan middle = spans.at(scene.width / 2, scene.height / 2);
    // frontal() measures from the middle of the volume.
    EXPECT_LE(middle.near, 200 - kRadius);
    EXPECT_GE(middle.far, 200 + kRadius);
    EXPECT_GT(middle.near, 200 - kRadius - 30);
    EXPECT_LT(middle.far, 200 + kRadius + 30);
    for (const int x : {0, scene.width - 1}) {
      for (const int y : {0, scene.height - 1}) EXPECT_TRUE(spans.at(x, y).empty());
    }
  }
}

TEST(VisibleSpansTest, AnEmptyVolumeHasNoSpanAndAnEyeInsideHasAFullSpan) {
  for (const bool orthographic : {false, true}) {
    const Scene nothing = scene_of(ball(-1), 200, orthographic);
    EXPECT_TRUE(VisibleSpans(nothing, shell_of(*nothing.ct), 1).at(40, 30).empty());
    const Scene inside = scene_of(ball(20), 3, orthographic);
    const VisibleSpan span = VisibleSpans(inside, shell_of(*inside.ct), 1).at(0, 0);
    EXPECT_EQ(span.near, 0);
    EXPECT_TRUE(std::isinf(span.far));
  }
}

TEST(VisibleSpansTest, ObjectsBehindTheEyeHaveNoSpan) {
  Scene scene = scene_of(ball(12), 200, false);
  scene.camera.look_at_ct.mm = 2 * scene.camera.eye_ct.mm - scene.camera.look_at_ct.mm;
  const VisibleSpans spans(scene, shell_of(*scene.ct), 1);
  EXPECT_TRUE(spans.at(scene.width / 2, scene.height / 2).empty());
}

}  // namespace
}  // namespace nav::render
