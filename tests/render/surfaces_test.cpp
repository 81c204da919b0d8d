// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Tests the live plane, the needle and targets: depth, orientation, masks and states.
#include "render/spec/ray_spec.hpp"
#include "tests/render/scene_support.hpp"

namespace nav::render {
namespace {

/// Ambient and diffuse light apply to solid objects, not to the volume.
Shading unshaded(double ambient, double diffuse) {
  Shading shading;
  shading.enabled = false;
  shading.ambient = ambient;
  shading.diffuse = diffuse;
  shading.specular = 0;
  shading.shininess = 1;
  return shading;
}

class SurfacesTest : public test::EngineTest {};
INSTANTIATE_TEST_SUITE_P(Engines, SurfacesTest, ::testing::ValuesIn(test::engine_cases()),
                         [](const auto& c) { return c.param.name; });

constexpr float kColour = 1e-5F;

/// A red block of 12 mm at the origin, in air of 40 mm. Parallel view of 60 mm, blue background.
Scene block_scene() {
  const auto ct =
      test::make_volume(test::centred_grid({41, 41, 41}, {1, 1, 1}), [](int i, int j, int k) {
        const auto in = [](int a) { return a >= 14 && a <= 26; };
        return in(i) && in(j) && in(k) ? 1000 : -1000;
      });
  Scene scene = test::plain_scene(ct, test::solid({1, 0, 0}), test::frontal(100, 60, true));
  scene.width = scene.height = 61;
  scene.background_rgb = {0, 0, 1};
  return scene;
}

/// Air only, so that only surfaces are visible. One pixel per mm, pixel (30, 30) at the origin.
Scene empty_scene() {
  Scene scene = block_scene();
  scene.transfer = test::fog(0);
  scene.camera.orthographic_height_mm = 61;
  return scene;
}

bool is(const RgbaF& p, double r, double g, double b) {
  return test::difference(
             p, {static_cast<float>(r), static_cast<float>(g), static_cast<float>(b), 1}) < kColour;
}

TEST_P(SurfacesTest, PlaneIsInFrontInsideOrBehindTheBlock) {
  Scene scene = block_scene();
  const double grey = 102.0 / 255;
  const auto seen_with_plane_at = [&](double y) {
    scene.plane = test::upright_plane(test::grey_image(40, 40, 102), 1, {0, y, 20});
    return test::draw(*engine_, scene);
  };
  EXPECT_TRUE(is(test::middle(seen_with_plane_at(-30)), grey, grey, grey)) << "before the volume";
  EXPECT_TRUE(is(test::middle(seen_with_plane_at(-10)), grey, grey, grey)) << "before the block";
  EXPECT_TRUE(is(test::middle(seen_with_plane_at(0)), 1, 0, 0)) << "inside";
  const RenderedImage behind = seen_with_plane_at(12);
  EXPECT_TRUE(is(test::middle(behind), 1, 0, 0)) << "behind";
  EXPECT_TRUE(is(behind.pixels.at(44, 30), grey, grey, grey)) << "beside the block";
  EXPECT_TRUE(is(behind.pixels.at(2, 2), 0, 0, 1)) << "background around";
}

TEST_P(SurfacesTest, ImageHasTheCorrectColumnsRowsAndGreys) {
  // 21 × 15 pixels of 2 mm. Each pixel has its own grey, so the test reads the position from the
  // grey.
  std::vector<std::uint8_t> pixels;
  for (int row = 0; row < 15; ++row) {
    for (int column = 0; column < 21; ++column) {
      pixels.push_back(static_cast<std::uint8_t>(10 + 11 * column + row));
    }
  }
  Scene scene = empty_scene();
  scene.plane = test::upright_plane({21, 15, pixels}, 2, {0, 0, 14});
  const RenderedImage image = test::draw(*engine_, scene);
  for (int row = 1; row < 14; ++row) {
    for (int column = 1; column < 20; ++column) {
      const Eigen::Vector3d p(2.0 * (column - 10), 0, 14 - 2.0 * row);
      const Eigen::Vector2d at = test::project(scene, p);
      const RgbaF& found = image.pixels.at(static_cast<int>(std::lround(at.x())),
                                           static_cast<int>(std::lround(at.y())));
      const double grey = (10 + 11 * column + row) / 255.0;
      EXPECT_TRUE(is(found, grey, grey, grey)) << column << ' ' << row << ": " << found.r * 255;
    }
  }
  // Between two columns there is exactly the mean, without an 8-bit filter.
  EXPECT_NEAR(image.pixels.at(31, 30).r * 255, 10 + 11 * 10.5 + 7, 1e-3);
}

TEST_P(SurfacesTest, AShearedCalibrationGivesAParallelogram) {
  Scene scene = empty_scene();
  scene.plane = test::upright_plane(test::grey_image(11, 11, 200), 2, {0, 0, 10});
  PixelGrid& grid = scene.plane->frame.grid;
  grid.mm_per_pixel << 2, 0.5, 0, 2;  // Rows move to the right with depth.
  grid.origin_mm << -10, 0;
  ASSERT_TRUE(test::has_value(validate(grid)));
  const RenderedImage image = test::draw(*engine_, scene);
  // Pixel centres of row 10 run from x = -5 to 15 mm at z = -10. Edges are half a pixel further.
  EXPECT_TRUE(is(image.pixels.at(30 - 8, 40), 0, 0, 1));
  EXPECT_TRUE(is(image.pixels.at(30 - 3, 39), 200 / 255.0, 200 / 255.0, 200 / 255.0));
  EXPECT_TRUE(is(image.pixels.at(30 + 13, 39), 200 / 255.0, 200 / 255.0, 200 / 255.0));
  EXPECT_TRUE(is(image.pixels.at(30 + 13, 21), 0, 0, 1));
}

TEST_P(SurfacesTest, SectorShowsOnlyTheAreaOfTheProbe) {
  Scene scene = empty_scene();
  scene.plane = test::upright_plane(test::grey_image(50, 40, 128), 1, {0, 0, 20});
  const SectorOutline sector{{0, -10}, 12, 45, 0.5};
  scene.plane->frame.outline = sector;
  const RenderedImage image = test::draw(*engine_, scene);
  int shown = 0;
  for (int y = 0; y < 61; ++y) {
    for (int x = 0; x < 61; ++x) {
      const Eigen::Vector2d p(x - 30, 20 + y - 30);  // Image mm. The first row is at z = 20.
      const bool in_image = std::abs(p.x()) <= 25 && p.y() >= -0.5 && p.y() <= 39.5;
      const bool inside = in_image && sector.contains(p);
      EXPECT_EQ(inside, !is(image.pixels.at(x, y), 0, 0, 1)) << x << ' ' << y;
      shown += inside ? 1 : 0;
    }
  }
  EXPECT_GT(shown, 500);
  EXPECT_TRUE(is(image.pixels.at(30, 30), 128 / 255.0, 128 / 255.0, 128 / 255.0));
}

TEST_P(SurfacesTest, BorderShowsTheState) {
  Scene scene = empty_scene();
  scene.plane = test::upright_plane(test::grey_image(41, 31, 128), 1, {0, 0, 15});
  scene.plane->opacity = 0.5;
  const auto seen = [&](SafetyState state) {
    scene.plane->safety = {state, state == SafetyState::kValid ? "" : "test"};
    return test::draw(*engine_, scene);
  };
  // The rectangle ends at z = 15.5, at row 14.5. The first row of pixels inside is 15.
  const auto border = [](const RenderedImage& i) { return i.pixels.at(30, 15); };
  const auto is_colour = [](const RgbaF& p, const Eigen::Vector3d& c) {
    return is(p, c.x(), c.y(), c.z());
  };
  const double grey = 0.5 * 128 / 255.0;
  const RenderedImage valid = seen(SafetyState::kValid);
  EXPECT_TRUE(is_colour(border(valid), spec::kValidRgb)) << "opaque whatever the opacity";
  EXPECT_TRUE(is(valid.pixels.at(30, 17), grey, grey, 0.5 + grey)) << "two pixels wide";
  EXPECT_TRUE(is(valid.pixels.at(30, 14), 0, 0, 1)) << "inside the edge only";
  const RenderedImage degraded = seen(SafetyState::kDegraded);
  EXPECT_TRUE(is_colour(border(degraded), spec::kDegradedRgb));
  EXPECT_TRUE(is(test::middle(degraded), grey, grey, 0.5 + grey));
  const RenderedImage stale = seen(SafetyState::kStale);
  EXPECT_TRUE(is_colour(border(stale), spec::kStaleRgb));
  EXPECT_TRUE(is(test::middle(stale), 0, 0, 1)) << "no old image";
  const RenderedImage lost = seen(SafetyState::kLost);
  EXPECT_TRUE(is(border(lost), 0, 0, 1));
  EXPECT_TRUE(is(test::middle(lost), 0, 0, 1));
}

NeedleShape needle_across(double y) {
  return {.tip_ct = {{-5, y, 0}},
          .hub_ct = {{25, y, 0}},
          .radius_mm = 2.0,
          .rgb = {0, 1, 0},
          .safety = {SafetyState::kValid, ""}};
}

TEST_P(SurfacesTest, NeedleHidesAndIsHidden) {
  Scene scene = block_scene();
  scene.shading = unshaded(1.0, 0);  // Solid objects have their plain colour.
  scene.needle = needle_across(-15);
  EXPECT_TRUE(is(test::middle(test::draw(*engine_, scene)), 0, 1, 0)) << "before the block";
  scene.needle = needle_across(15);
  const RenderedImage behind = test::draw(*engine_, scene);
  EXPECT_TRUE(is(test::middle(behind), 1, 0, 0)) << "behind the block";
  EXPECT_TRUE(is(behind.pixels.at(45, 30), 0, 1, 0)) << "beside it";
  // A plane between needle and eye hides the needle. A plane behind it does not.
  scene.transfer = test::fog(0);
  scene.plane = test::upright_plane(test::grey_image(40, 40, 255), 1, {0, 5, 20});
  EXPECT_TRUE(is(test::middle(test::draw(*engine_, scene)), 1, 1, 1));
  scene.needle = needle_across(-5);
  EXPECT_TRUE(is(test::middle(test::draw(*engine_, scene)), 0, 1, 0));
}

TEST_P(SurfacesTest, NeedleIsTranslucentIfStaleAndAbsentIfLost) {
  Scene scene = empty_scene();
  scene.shading = unshaded(1.0, 0);
  scene.needle = needle_across(0);
  scene.needle->safety = {SafetyState::kStale, "test"};
  EXPECT_TRUE(is(test::middle(test::draw(*engine_, scene)), 0, 0.4, 0.6));
  scene.needle->safety = {SafetyState::kLost, "test"};
  EXPECT_TRUE(is(test::middle(test::draw(*engine_, scene)), 0, 0, 1));
}

TEST_P(SurfacesTest, DrawnNeedleEndsAtItsTip) {
  Scene scene = empty_scene();
  scene.camera.orthographic_height_mm = 6.1;  // Ten pixels per mm.
  scene.needle = test::needle({0.02, 0, 0}, {25, 0, 0});
  const RenderedImage image = test::draw(*engine_, scene);
  EXPECT_TRUE(is(image.pixels.at(30, 30), 0, 0, 1)) << "0.02 mm before the tip";
  EXPECT_FALSE(is(image.pixels.at(31, 30), 0, 0, 1)) << "0.08 mm behind the tip";
}

TEST_P(SurfacesTest, SphereShowsItsShadedFrontOnce) {
  Scene scene = empty_scene();
  scene.shading = unshaded(0.25, 0.75);
  scene.camera.orthographic_height_mm = 30.5;  // Two pixels per mm.
  scene.spheres.push_back({{{0, 0, 0}}, 10, {1, 1, 0}, 0.5});
  const RenderedImage image = test::draw(*engine_, scene);
  EXPECT_TRUE(is(test::middle(image), 0.5, 0.5, 0.5)) << "one layer of opacity 0.5";
  // At 6 mm from the axis the cosine of the normal is 0.8.
  const double lit = 0.5 * (0.25 + 0.75 * 0.8);
  EXPECT_TRUE(is(image.pixels.at(42, 30), lit, lit, 0.5));
  // An eye inside does not see the sphere.
  scene.camera.look_at_ct.mm = {0, 1, 0};
  scene.camera.eye_ct.mm = {0, 0, 0};
  EXPECT_TRUE(is(test::middle(test::draw(*engine_, scene)), 0, 0, 1));
}

TEST_P(SurfacesTest, TranslucentLayersAreSortedByDepth) {
  Scene scene = empty_scene();
  scene.shading = unshaded(1, 0);
  scene.spheres.push_back({{{0, 10, 0}}, 3, {0, 1, 0}, 0.5});   // Behind, but first in the list.
  scene.spheres.push_back({{{0, -10, 0}}, 3, {1, 0, 0}, 0.5});  // In front.
  EXPECT_TRUE(is(test::middle(test::draw(*engine_, scene)), 0.5, 0.25, 0.25));
}

TEST_P(SurfacesTest, SpheresAtOneDepthKeepTheirOrder) {
  Scene scene = empty_scene();
  scene.shading = unshaded(1, 0);
  scene.spheres.push_back({{{0, 0, 0}}, 3, {1, 0, 0}, 0.5});
  scene.spheres.push_back({{{0, 0, 0}}, 3, {0, 1, 0}, 0.5});
  EXPECT_TRUE(is(test::middle(test::draw(*engine_, scene)), 0.5, 0.25, 0.25));
}

TEST_P(SurfacesTest, EdgeOnPlaneIsNotDrawn) {
  Scene scene = empty_scene();
  scene.plane = test::upright_plane(test::grey_image(40, 40, 255), 1, {0, 0, 20});
  scene.camera.eye_ct.mm = {100, 0, 0};
  EXPECT_TRUE(is(test::middle(test::draw(*engine_, scene)), 0, 0, 1));
}

}  // namespace
}  // namespace nav::render
