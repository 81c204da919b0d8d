// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/labels.hpp"

#include "render/features/scribbles.hpp"
#include "tests/render/features/derived_support.hpp"

namespace nav::render::features {
namespace {

/// Control points on a plane, which a B-spline reproduces. Control point c lies at knot c - 1.
LayerSurface tilted(int axis, const std::array<int, 3>& size, double base, double du, double dv) {
  const std::array<int, 2> control{7, 6};
  const auto across = axis == 0   ? std::array{size[1], size[2]}
                      : axis == 1 ? std::array{size[0], size[2]}
                                  : std::array{size[0], size[1]};
  std::vector<double> heights;
  for (int v = 0; v < control[1]; ++v) {
    for (int u = 0; u < control[0]; ++u) {
      heights.push_back(base + du * (u - 1) * (across[0] - 1) / (control[0] - 3.0) +
                        dv * (v - 1) * (across[1] - 1) / (control[1] - 3.0));
    }
  }
  return *LayerSurface::create(axis, size, control, heights);
}

LayerSurface wavy(const std::array<int, 3>& size, double base, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> height(base - 3, base + 3);
  std::vector<double> heights;
  for (int n = 0; n < 9 * 8; ++n) heights.push_back(height(random));
  return *LayerSurface::create(2, size, {9, 8}, heights);
}

TEST(LayerSurfaceTest, ReproducesPlanesOverEveryAxis) {
  const std::array<int, 3> size{20, 14, 17};
  for (int axis = 0; axis < 3; ++axis) {
    const auto surface = tilted(axis, size, 4, 0.25, -0.125);
    for (const double u : {0.0, 3.7, 9.0, 12.99}) {
      for (const double v : {0.0, 5.5, 13.0}) {
        EXPECT_NEAR(surface.height(u, v), 4 + 0.25 * u - 0.125 * v, 1e-12);
      }
    }
    EXPECT_NEAR(surface.steepest().x(), 0.25, 1e-12);
    EXPECT_NEAR(surface.steepest().y(), 0.125, 1e-12);
  }
}

TEST(LayerSurfaceTest, IsNeverSteeperThanItsBound) {
  const auto surface = wavy({30, 25, 20}, 10, 3);
  const Eigen::Vector2d most = surface.steepest();
  constexpr double kStep = 1e-5;
  for (double u = 0; u < 28.9; u += 0.37) {
    for (double v = 0; v < 23.9; v += 0.41) {
      const double h = surface.height(u, v);
      EXPECT_LE(std::abs(surface.height(u + kStep, v) - h) / kStep, most.x() + 1e-6);
      EXPECT_LE(std::abs(surface.height(u, v + kStep) - h) / kStep, most.y() + 1e-6);
    }
  }
}

TEST(LayerModelTest, RasterIsExactAtVoxelCentresAndWithinItsErrorElsewhere) {
  const auto grid = test::centred_grid({30, 25, 20}, {0.3, 0.3, 0.5});
  const auto low = wavy(grid.size, 6, 1), high = wavy(grid.size, 13, 2);
  const auto model = LayerModel::create({low, high});
  ASSERT_TRUE(test::has_value(model));
  const auto labels = model->rasterise(grid);
  ASSERT_TRUE(test::has_value(labels));
  for (int k = 0; k < 20; ++k) {
    for (int j = 0; j < 25; ++j) {
      for (int i = 0; i < 30; ++i) {
        EXPECT_EQ(labels->at(i, j, k), 1U << model->layer_at(Eigen::Vector3d(i, j, k)));
      }
    }
  }
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(0, 1);
  int wrong = 0;
  for (int n = 0; n < 50000; ++n) {
    const Eigen::Vector3d p(29 * unit(random), 24 * unit(random), 19 * unit(random));
    if (labels->nearest(p) == 1U << model->layer_at(p)) continue;
    ++wrong;
    const double away = std::min(std::abs(low.height(p.x(), p.y()) - p.z()),
                                 std::abs(high.height(p.x(), p.y()) - p.z()));
    EXPECT_LE(away, model->raster_error_voxels());
  }
  EXPECT_GT(wrong, 0);  // The error of the raster is not zero.
  EXPECT_EQ(labels->nearest({-0.6, 0, 0}), 0U);
  EXPECT_EQ(labels->nearest({std::nan(""), 0, 0}), 0U);
}

TEST(LayerModelTest, AVoxelOnAFlatSurfaceIsBehindIt) {
  const std::array<int, 3> size{6, 5, 4};
  const auto flat = LayerSurface::create(2, size, {4, 4}, std::vector<double>(16, 0.0));
  const auto model = LayerModel::create({*flat});
  ASSERT_TRUE(test::has_value(model));
  EXPECT_EQ(model->raster_error_voxels(), 0.5);
  const auto labels = model->rasterise(test::centred_grid(size, {1, 1, 1}));
  ASSERT_TRUE(test::has_value(labels));
  EXPECT_EQ(model->layer_at({3, 2, 0}), 1);
  EXPECT_EQ(labels->at(3, 2, 0), 2U);
}

TEST(LayerModelTest, AFlatSurfaceThroughVoxelsHasThemAllOnOneSide) {
  const std::array<int, 3> size{40, 30, 36};
  for (const double height : {13.0, 7.0, 26.0}) {  // In voxels. The sums of splines are rounded.
    const auto flat =
        LayerSurface::create(1, size, {9, 7}, std::vector<double>(63, 0.5 * height / 0.5));
    const auto model = LayerModel::create({*flat});
    ASSERT_TRUE(test::has_value(model));
    const auto labels = model->rasterise(test::centred_grid(size, {0.5, 0.5, 0.5}));
    ASSERT_TRUE(test::has_value(labels));
    int on = 0;
    for (int k = 0; k < size[2]; ++k) {
      for (int i = 0; i < size[0]; ++i) {
        on += labels->at(i, static_cast<int>(height), k) == 2U ? 1 : 0;
      }
    }
    EXPECT_EQ(on, size[0] * size[2]) << height;
  }
}

TEST(LayerModelTest, RejectsInvalidInputByName) {
  const std::array<int, 3> size{8, 8, 8};
  EXPECT_FALSE(LayerSurface::create(3, size, {4, 4}, std::vector<double>(16)));
  EXPECT_FALSE(LayerSurface::create(2, size, {3, 4}, std::vector<double>(12)));
  EXPECT_FALSE(LayerSurface::create(2, size, {4, 4}, std::vector<double>(15)));
  EXPECT_FALSE(LayerSurface::create(2, size, {4, 4}, std::vector<double>(16, std::nan(""))));
  EXPECT_FALSE(LayerModel::create({}));
  const auto z = tilted(2, size, 1, 0, 0);
  EXPECT_FALSE(LayerModel::create({z, tilted(1, size, 1, 0, 0)}));
  EXPECT_FALSE(LayerModel::create({z})->rasterise(test::centred_grid({8, 8, 9}, {1, 1, 1})));
  EXPECT_FALSE(LabelVolume::create(test::centred_grid(size, {1, 1, 1}), {1, 2}, "labels"));
}

Stroke line(const Eigen::Vector3d& from, const Eigen::Vector3d& to, const Eigen::Vector3d& normal,
            double radius) {
  Stroke stroke;
  stroke.points = {{from}, {to}};
  stroke.plane_normal = {normal};
  stroke.radius_mm = radius;
  return stroke;
}

TEST(ScribbleTest, MarksTheVoxelsWithinReachOnObliquePlanes) {
  const auto grid = test::centred_grid({24, 20, 18}, {0.5, 0.7, 0.9});
  const Eigen::Vector3d normal = Eigen::Vector3d(1, 2, 2) / 3;
  const Eigen::Vector3d along = normal.cross(Eigen::Vector3d::UnitX()).normalized();
  auto stroke = line(-3 * along, 4 * along, normal, 1.3);
  stroke.points.push_back({4 * along + 2 * normal.cross(along)});
  ScribbleMask mask(grid);
  const auto marked = mask.add(stroke);
  ASSERT_TRUE(test::has_value(marked));
  std::size_t expected = 0;
  const double half = 0.5 * normal.cwiseAbs().dot(grid.spacing_mm);
  for (std::size_t n = 0; n < mask.bits().size(); ++n) {
    const auto i = static_cast<int>(n % 24), j = static_cast<int>(n / 24 % 20);
    const Eigen::Vector3d p = grid.at(Eigen::Vector3d(i, j, static_cast<double>(n / 480))).mm;
    double nearest = 1e9;
    for (int s = 0; s <= 4000; ++s) {  // Dense points instead of a closed form.
      const double t = s / 2000.0;
      const Eigen::Vector3d q =
          t <= 1 ? Eigen::Vector3d((-3 + 7 * t) * along)
                 : Eigen::Vector3d(4 * along + 2 * (t - 1) * normal.cross(along));
      nearest = std::min(nearest, (p - q).norm());
    }
    if (std::abs(nearest - 1.3) < 1e-3) continue;
    const bool inside = nearest < 1.3 && std::abs(p.dot(normal)) <= half;
    EXPECT_EQ(mask.bits()[n], inside ? ScribbleMask::kShowBit : 0) << n;
    expected += inside ? 1 : 0;
  }
  EXPECT_GT(expected, 40U);
  EXPECT_NEAR(static_cast<double>(marked->changed), static_cast<double>(expected), 2);
}

TEST(ScribbleTest, LaterStrokesReplaceAndErasersClear) {
  const auto grid = test::centred_grid({9, 9, 9}, {1, 1, 1});
  ScribbleMask mask(grid);
  auto stroke = line({-2, 0, 0}, {2, 0, 0}, {0, 0, 1}, 0.4);
  EXPECT_EQ(mask.add(stroke)->changed, 5U);
  const auto again = mask.add(stroke);
  ASSERT_TRUE(test::has_value(again));
  EXPECT_EQ(again->changed, 0U);
  EXPECT_TRUE(again->covers_any);
  stroke.paint = Paint::kHide;
  stroke.points[1].mm.x() = 0;
  EXPECT_EQ(mask.add(stroke)->changed, 3U);
  EXPECT_EQ(std::count(mask.bits().begin(), mask.bits().end(), ScribbleMask::kShowBit), 2);
  stroke.paint = Paint::kErase;
  stroke.points = {{{-2, 0, 0}}};
  EXPECT_EQ(mask.add(stroke)->changed, 1U);
  EXPECT_EQ(std::count(mask.bits().begin(), mask.bits().end(), ScribbleMask::kHideBit), 2);
  const auto outside = mask.add(line({1e6, 0, 0}, {1e6, 5, 0}, {0, 0, 1}, 1));
  ASSERT_TRUE(test::has_value(outside));
  EXPECT_EQ(outside->changed, 0U);
  EXPECT_FALSE(outside->covers_any);
  EXPECT_EQ(mask.add(line({-2, 0, 0}, {2, 0, 0}, {0, 0, 1e300}, 0.4))->changed, 3U) << "any length";
  EXPECT_FALSE(mask.add(line({1e300, 0, 0}, {0, 5, 0}, {0, 0, 1}, 1)));
  stroke.points.clear();
  EXPECT_FALSE(mask.add(stroke));
  EXPECT_FALSE(mask.add(line({0, 0, 0}, {1, 0, 0}, {0, 0, 0}, 1)));
  EXPECT_FALSE(mask.add(line({0, 0, std::nan("")}, {1, 0, 0}, {0, 0, 1}, 1)));
}

TEST(ScribbleTest, RejectsPointsThatLeaveTheirSlice) {
  const auto grid = test::centred_grid({9, 9, 9}, {1, 1, 0.5});
  ScribbleMask mask(grid);
  auto stroke = line({-2, 0, 0}, {2, 0, 0.24}, {0, 0, 1}, 0.4);
  EXPECT_TRUE(test::has_value(mask.add(stroke))) << "within half a voxel";
  stroke.points.push_back({{3, 0, -0.75}});
  const auto refused = [&](const Stroke& one, std::initializer_list<std::string> pieces) {
    return test::rejects(mask.add(one), ErrorCode::kUsage, pieces) &&
           test::rejects(check(one, grid), ErrorCode::kUsage, pieces);
  };
  EXPECT_TRUE(
      refused(stroke, {"within 0.25 mm", "point 3", "(    3     0 -0.75)", "0.75 mm away"}));
  stroke.half_thickness_mm = 0.7;
  EXPECT_TRUE(refused(stroke, {"within 0.7 mm", "0.75 mm away"}));
  stroke.half_thickness_mm = 0.75;
  EXPECT_TRUE(test::has_value(mask.add(stroke)));
}

TEST(ScribbleTest, CountsPredicatesOnlyAtMarkedVoxels) {
  const auto grid = test::centred_grid({9, 9, 9}, {1, 1, 1});
  ScribbleMask mask(grid);
  ASSERT_TRUE(mask.add(line({-2, 0, 0}, {2, 0, 0}, {0, 0, 1}, 0.4)));
  auto hide = line({0, 3, 0}, {1, 3, 0}, {0, 0, 1}, 0.4);
  hide.paint = Paint::kHide;
  ASSERT_TRUE(mask.add(hide));
  std::size_t asked = 0;
  const auto counts = count_scribbles(mask, 32, [&](std::size_t voxel) {
    ++asked;
    return 1U | (voxel % 9 >= 4 ? 2U : 0U) | 1U << 31;
  });
  EXPECT_EQ(asked, 7U);
  EXPECT_EQ(counts.shown[0], 5U);
  EXPECT_EQ(counts.shown[1], 3U);
  EXPECT_EQ(counts.shown[2], 0U);
  EXPECT_EQ(counts.shown[31], 5U);
  EXPECT_EQ(counts.hidden[0], 2U);
  EXPECT_EQ(counts.hidden[31], 2U);
}

}  // namespace
}  // namespace nav::render::features
