// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Tests the positions of rendered voxels for every kind of grid and camera.
#include <random>

#include "tests/render/verification_engines.hpp"

namespace nav::render {
namespace {

using GeometryTest = test::VerificationTest;
INSTANTIATE_TEST_SUITE_P(Engines, GeometryTest, ::testing::ValuesIn(test::verified_engines()),
                         [](const auto& c) { return c.param.name; });

Eigen::Matrix3d oblique() {
  return Eigen::AngleAxisd(0.6, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
}
Eigen::Matrix3d left_handed() { return oblique() * Eigen::Vector3d(1, 1, -1).asDiagonal(); }

/// One bright voxel in an asymmetric position. Everything else is air.
std::shared_ptr<const StoredVolume> marker(const VoxelGrid& grid, const std::array<int, 3>& at) {
  return test::make_volume(grid, [&](int i, int j, int k) {
    return i == at[0] && j == at[1] && k == at[2] ? 2000 : -1000;
  });
}

TEST_P(GeometryTest, FacingThePatientTheirLeftIsOnTheRight) {
  // +x is the left of the patient, +z the head.
  VoxelGrid grid = test::centred_grid({9, 9, 9}, {2, 2, 2});
  const auto ct = marker(grid, {7, 4, 6});
  Scene scene = test::plain_scene(ct, test::solid({1, 1, 1}), test::frontal(200, 20, true));
  const Eigen::Vector2d c = test::centroid(test::draw(*engine_, scene));
  EXPECT_GT(c.x(), 16 + 3);
  EXPECT_LT(c.y(), 12 - 2);
}

TEST_P(GeometryTest, AMarkerAppearsAtItsProjection) {
  constexpr double kTolerancePixels = 0.35;  // The blob is a few pixels wide and not quite round.
  const std::array<int, 3> at{9, 3, 2};
  for (const Eigen::Matrix3d& directions :
       {Eigen::Matrix3d(Eigen::Matrix3d::Identity()), oblique(), left_handed()}) {
    for (const bool orthographic : {false, true}) {
      VoxelGrid grid = test::centred_grid({12, 10, 5}, {1.5, 2.0, 3.5}, directions);
      grid.origin_mm += Eigen::Vector3d(3, -2, 1);
      Scene scene = test::plain_scene(marker(grid, at), test::solid({1, 1, 1}),
                                      test::frontal(90, 40, orthographic));
      scene.camera.eye_ct.mm += Eigen::Vector3d(25, 4, -18);
      scene.camera.up_ct.v = {0.3, 0.1, 1};
      scene.width = 97;
      scene.height = 81;
      const Eigen::Vector3d p = grid.at({9, 3, 2}).mm;
      const Eigen::Vector2d found = test::centroid(test::draw(*engine_, scene));
      EXPECT_LT((found - test::project(scene, p)).norm(), kTolerancePixels)
          << found.transpose() << " instead of " << test::project(scene, p).transpose();
    }
  }
}

TEST_P(GeometryTest, EveryKindOfGridHasItsOwnThickness) {
  constexpr double kTolerance = 1e-5;
  constexpr double kTau = 0.05;
  struct Case {
    std::array<int, 3> size;
    Eigen::Vector3d spacing_mm;
    double length_mm;  ///< Length along j through the middle.
  };
  for (const Case& c : std::vector<Case>{{{7, 17, 9}, {1, 1, 1}, 16},
                                         {{9, 6, 5}, {1, 20, 1}, 100},
                                         {{30, 26, 3}, {0.5, 0.5, 10}, 12.5},
                                         {{2, 2, 2}, {5, 5, 5}, 5},
                                         {{16, 1, 16}, {1, 3, 1}, 3},
                                         {{1, 8, 1}, {10, 2, 10}, 14},
                                         {{1, 1, 1}, {4, 4, 4}, 4}}) {
    const auto ct = test::make_volume(test::centred_grid(c.size, c.spacing_mm),
                                      [](int, int, int) { return 9; });
    Scene scene = test::plain_scene(ct, test::fog(kTau), test::frontal(150, 2, true));
    const float found = test::middle(test::draw(*engine_, scene)).g;
    EXPECT_NEAR(found, -std::expm1(-kTau * c.length_mm), kTolerance)
        << c.size[0] << " x " << c.size[1] << " x " << c.size[2];
  }
}

TEST_P(GeometryTest, ADistantOriginChangesNothing) {
  constexpr float kTolerance = 1e-4F;
  const auto scene_at = [](const Eigen::Vector3d& offset) {
    VoxelGrid grid = test::centred_grid({20, 20, 20}, {1, 1, 1}, oblique());
    grid.origin_mm += offset;
    Scene scene = test::plain_scene(
        test::make_volume(grid, [](int i, int j, int k) { return (i * 7 + j * 5 + k * 3) % 800; }),
        test::solid({1, 0.5, 0.2}), test::frontal(90, 30, false));
    scene.shading.enabled = true;
    scene.camera.eye_ct.mm += offset;
    scene.camera.look_at_ct.mm += offset;
    scene.plane = test::upright_plane(test::grey_image(20, 12, 99), 1, offset);
    scene.needle = test::needle(offset, offset + Eigen::Vector3d(20, -30, 20), SafetyState::kValid);
    return scene;
  };
  const RenderedImage near = test::draw(*engine_, scene_at({0, 0, 0}));
  const RenderedImage far = test::draw(*engine_, scene_at({1e5, -1e5, 1e5}));
  EXPECT_LT(test::max_difference(near, far), kTolerance);
}

TEST_P(GeometryTest, ADistantEyeKeepsItsPrecision) {
  constexpr double kTolerance = 1e-5;
  const auto ct =
      test::make_volume(test::centred_grid({9, 41, 9}, {4, 1, 4}), [](int, int, int) { return 0; });
  const Scene scene = test::plain_scene(ct, test::fog(0.05), test::frontal(1e6, 10, false));
  EXPECT_NEAR(test::middle(test::draw(*engine_, scene)).g, -std::expm1(-0.05 * 40), kTolerance);
}

TEST_P(GeometryTest, FromInsideOnlyTheVolumeAheadCounts) {
  constexpr double kTolerance = 1e-5;
  const auto ct = test::make_volume(test::centred_grid({21, 21, 21}, {1, 1, 1}),
                                    [](int, int, int) { return 0; });
  for (const double y : {-10.0, -3.3, 0.0, 4.0}) {
    Scene scene = test::plain_scene(ct, test::fog(0.1), test::frontal(50, 2, true));
    scene.camera.eye_ct.mm = {0, y, 0};
    scene.camera.look_at_ct.mm = {0, y + 1, 0};
    const float found = test::middle(test::draw(*engine_, scene)).g;
    EXPECT_NEAR(found, -std::expm1(-0.1 * (10 - y)), kTolerance) << "eye at y = " << y;
  }
  Scene behind = test::plain_scene(ct, test::fog(0.1), test::frontal(50, 2, true));
  behind.camera.eye_ct.mm = {0, 10, 0};
  behind.camera.look_at_ct.mm = {0, 11, 0};
  EXPECT_EQ(test::middle(test::draw(*engine_, behind)).g, 0);
}

TEST_P(GeometryTest, RaysAlongAxesFacesAndEdgesAreFinite) {
  // Rays exactly in faces and through corners of voxels and bricks. draw() checks every pixel.
  const auto ct = test::make_volume(
      test::centred_grid({17, 17, 17}, {1, 1, 1}),
      [](int i, int j, int k) { return (i == 8 || j == 8 || k == 8) ? 700 : -500; });
  for (const Eigen::Vector3d& from :
       {Eigen::Vector3d(0, -40, 0), Eigen::Vector3d(40, 0, 0), Eigen::Vector3d(0, 0, 40),
        Eigen::Vector3d(40, 40, 40), Eigen::Vector3d(8, -40, 8), Eigen::Vector3d(8, 8, 40)}) {
    Scene scene = test::plain_scene(ct, test::solid({1, 1, 1}), test::frontal(40, 17, true));
    scene.width = scene.height = 17;  // One pixel per voxel, so that rays pass through voxel
                                      // centres.
    scene.shading.enabled = true;
    scene.camera.eye_ct.mm = from;
    scene.camera.look_at_ct.mm = {0, 0, 0};
    scene.camera.up_ct.v = {0.31, 0.17, 1};
    if (from.x() == 0 && from.y() == 0) scene.camera.up_ct.v = {0, 1, 0};
    EXPECT_GT(test::middle(test::draw(*engine_, scene)).g, 0.05F);
  }
}

}  // namespace
}  // namespace nav::render
