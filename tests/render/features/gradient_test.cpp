// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/gradient.hpp"

#include <limits>
#include <numbers>

#include "render/features/definition.hpp"
#include "tests/render/features/derived_support.hpp"

namespace nav::render::features {
namespace {

Eigen::Matrix3d oblique() {
  Eigen::Matrix3d m =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  m.col(2) = -m.col(2);  // Left-handed.
  return m;
}

ScanLines along(const Eigen::Vector3d& d) { return *ScanLines::parallel({d}, {{0, 0, 0}}); }

TEST(GradientTest, IsExactForALinearRampOnObliqueAnisotropicGrids) {
  const Eigen::Vector3d slope(3, -2, 5);
  const Eigen::Vector3d line = Eigen::Vector3d(1, 1, 0.5).normalized();
  for (const std::array<int, 3> size : {std::array{9, 8, 7}, {2, 2, 2}, {5, 1, 6}}) {
    const auto grid = test::centred_grid(size, {0.2, 0.2, 1}, oblique());
    const auto volume =
        test::make_scalar_at(grid, [&](const Eigen::Vector3d& p) { return slope.dot(p); });
    Eigen::Vector3d seen = slope;  // There is no gradient along an axis of one voxel.
    if (size[1] == 1) seen -= slope.dot(oblique().col(1)) * oblique().col(1);
    const auto lines = along(line);
    const double across = seen.cross(line).norm();
    const double angle = std::atan2(across, seen.dot(line));
    struct Expected {
      GradientPart part;
      double value, tolerance;
    };
    for (const Expected& e : {Expected{GradientPart::kMagnitude, seen.norm(), 2e-4},
                              {GradientPart::kAngle, angle, 2e-5},
                              {GradientPart::kAlong, seen.dot(line), 2e-4},
                              {GradientPart::kAcross, across, 2e-4}}) {
      const auto found = gradient_part(volume, e.part, &lines);
      ASSERT_TRUE(test::has_value(found));
      for (const float value : *found->values) EXPECT_NEAR(value, e.value, e.tolerance);
    }
    EXPECT_LT((gradient_at(volume, 1, 0, 1) - seen).norm(), 2e-4);
  }
}

TEST(GradientTest, IsOneSidedBesideUnknownVoxels) {
  const auto grid = test::centred_grid({7, 3, 3}, {0.5, 1, 1});
  const auto volume = test::make_scalar(
      grid, [](int i, int, int) { return i == 3 || i == 5 ? std::nan("") : 2.0 * i; });
  const auto found = gradient_part(volume, GradientPart::kMagnitude, nullptr);
  ASSERT_TRUE(test::has_value(found));
  EXPECT_FLOAT_EQ(found->at(0, 1, 1), 4);
  EXPECT_FLOAT_EQ(found->at(2, 1, 1), 4);
  EXPECT_TRUE(std::isnan(found->at(3, 1, 1)));
  EXPECT_TRUE(std::isnan(found->at(4, 1, 1)));  // There is no neighbour along i.
}

TEST(GradientTest, PartsFollowTheScanLineOfEveryVoxel) {
  const auto grid = test::centred_grid({9, 9, 9}, {1, 1, 1});
  const auto fan = ScanLines::fan({{0, 0, 0}}, 0);
  ASSERT_TRUE(test::has_value(fan));
  // Values grow with the distance from the apex. The apex is a voxel and has no line.
  const auto volume =
      test::make_scalar_at(grid, [](const Eigen::Vector3d& p) { return 2 * p.squaredNorm(); });
  const auto along = gradient_part(volume, GradientPart::kAlong, &*fan);
  const auto across = gradient_part(volume, GradientPart::kAcross, &*fan);
  ASSERT_TRUE(test::has_value(along));
  ASSERT_TRUE(test::has_value(across));
  EXPECT_TRUE(std::isnan(along->at(4, 4, 4)));
  EXPECT_TRUE(std::isnan(across->at(4, 4, 4)));
  for (int k = 1; k < 8; ++k) {
    for (int j = 1; j < 8; ++j) {
      for (int i = 1; i < 8; ++i) {
        const double distance = Eigen::Vector3d(i - 4, j - 4, k - 4).norm();
        if (distance == 0) continue;
        EXPECT_NEAR(along->at(i, j, k), 4 * distance, 1e-4);
        EXPECT_NEAR(across->at(i, j, k), 0, 1e-4);
      }
    }
  }
}

TEST(GradientTest, RejectsAPartAlongALineWithoutScanLines) {
  const auto volume = test::speckled(test::centred_grid({4, 4, 4}, {1, 1, 1}), 1);
  for (const auto part : {GradientPart::kAngle, GradientPart::kAlong, GradientPart::kAcross}) {
    const auto refused = gradient_part(volume, part, nullptr);
    ASSERT_FALSE(refused.has_value());
    EXPECT_NE(refused.error().message.find("expected scan-line directions"), std::string::npos);
  }
}

TEST(GradientTest, AngleIsExactNearZeroAndPiAndNanWithoutADirection) {
  const Eigen::Vector3d z(0, 0, 1);
  EXPECT_EQ(gradient_angle({0, 0, 2}, z, 1e-3), 0);
  EXPECT_DOUBLE_EQ(gradient_angle({0, 0, -2}, z, 1e-3), std::numbers::pi);
  EXPECT_NEAR(gradient_angle({1e-9, 0, 1}, z, 1e-3), 1e-9, 1e-18);  // acos would give 0.
  EXPECT_NEAR(gradient_angle({1, 0, 0}, z * (1 + 1e-15), 1e-3), std::numbers::pi / 2, 1e-15);
  EXPECT_TRUE(std::isnan(gradient_angle({1e-4, 0, 0}, z, 1e-3)));
  EXPECT_TRUE(std::isnan(gradient_angle({0, 0, 0}, z, 1e-3)));
  const Eigen::Vector3d nowhere = Eigen::Vector3d::Constant(std::nan(""));
  EXPECT_TRUE(std::isnan(gradient_angle({1, 0, 0}, nowhere, 1e-3)));
  EXPECT_TRUE(std::isnan(gradient_angle(nowhere, z, 1e-3)));
}

TEST(GradientTest, SmoothingKeepsARampAndDampsASine) {
  const auto grid = test::centred_grid({40, 21, 21}, {0.5, 0.5, 1});
  GradientOptions options;
  options.smoothing_mm = 0.8;
  const auto ramp = test::make_scalar_at(
      grid, [](const Eigen::Vector3d& p) { return 1e5 + 3 * p.x() - 4 * p.z(); });
  const auto magnitude = [&options](const ScalarVolume& volume) {
    const auto found = gradient_part(volume, GradientPart::kMagnitude, nullptr, options);
    EXPECT_TRUE(test::has_value(found));
    return found->at(20, 10, 10);
  };
  EXPECT_NEAR(magnitude(ramp), 5, 0.01);  // Floats near 1e5 resolve 0.008.
  const double q = 0.9;
  const auto sine = test::make_scalar_at(
      grid, [&](const Eigen::Vector3d& p) { return 100 * std::sin(q * p.x()); });
  const double damped = 100 * q * std::exp(-0.5 * q * q * 0.64);
  const Eigen::Vector3d p = grid.at(Eigen::Vector3d(20, 10, 10)).mm;
  EXPECT_NEAR(magnitude(sine), std::abs(damped * std::cos(q * p.x())), 0.01 * damped);
}

TEST(GradientTest, SmoothedGradientIsUnknownOnlyAtUnknownVoxels) {
  const auto grid = test::centred_grid({11, 10, 9}, {0.5, 0.5, 0.5});
  const auto volume = test::make_scalar(
      grid, [](int i, int j, int k) { return i == 5 && j == 4 && k == 3 ? std::nan("") : i + j; });
  GradientOptions options;
  options.smoothing_mm = 0.4;
  const auto found = gradient_part(volume, GradientPart::kMagnitude, nullptr, options);
  ASSERT_TRUE(test::has_value(found));
  for (int i = 0; i < 11; ++i) EXPECT_EQ(std::isnan(found->at(i, 4, 3)), i == 5) << i;
}

TEST(GradientTest, SmoothedGradientEqualsItsDefinition) {
  for (const std::array<int, 3> size : {std::array{19, 13, 9}, {8, 1, 6}}) {
    const auto grid = test::centred_grid(size, {0.2, 0.3, 1}, oblique());
    const auto volume = test::speckled(grid, 7);
    const Eigen::Vector3d line = Eigen::Vector3d(1, -2, 0.5).normalized();
    const auto lines = along(line);
    const auto truth = definition::gradients(volume, 0.4);
    GradientOptions options;
    options.smoothing_mm = 0.4;
    double rms_before = std::numeric_limits<double>::infinity();
    for (const double truncate : {2.0, 3.0, 4.0, 6.0}) {
      options.truncate = truncate;
      const auto found = gradient_part(volume, GradientPart::kAlong, &lines, options);
      const auto across = gradient_part(volume, GradientPart::kAcross, &lines, options);
      ASSERT_TRUE(test::has_value(found));
      ASSERT_TRUE(test::has_value(across));
      double sum = 0;
      for (std::size_t n = 0; n < truth.size(); ++n) {
        const double along_error = (*found->values)[n] - truth[n].dot(line);
        const double across_error = (*across->values)[n] - truth[n].cross(line).norm();
        sum += along_error * along_error + across_error * across_error;
      }
      const double rms = std::sqrt(sum / static_cast<double>(truth.size()));
      EXPECT_LT(rms, rms_before) << truncate;
      rms_before = rms;
    }
    EXPECT_LT(rms_before, 2e-4);  // For slopes of some hundreds per mm.
  }
}

TEST(GradientTest, RejectsFiltersOfHundredsOfVoxels) {
  // The spacing is in metres. A smoothing of 0.4 mm would need filters of 4000 voxels in each
  // direction.
  const auto volume = test::speckled(test::centred_grid({4, 4, 4}, {4e-4, 4e-4, 4e-4}), 1);
  GradientOptions options;
  options.smoothing_mm = kUsualSmoothingMm;
  const auto refused = gradient_part(volume, GradientPart::kMagnitude, nullptr, options);
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code, ErrorCode::kUsage);
  EXPECT_NE(refused.error().message.find("smoothing_mm"), std::string::npos);
  EXPECT_NE(refused.error().message.find("256 voxels"), std::string::npos);
  options.smoothing_mm = 0;
  EXPECT_TRUE(test::has_value(gradient_part(volume, GradientPart::kMagnitude, nullptr, options)));
}

TEST(ScanLinesTest, AFanPointsAwayFromItsApexWithDepthFromItsFace) {
  const auto grid = test::centred_grid({5, 5, 5}, {1, 1, 1});
  const auto fan = ScanLines::fan({{0, 0, -10}}, 8);
  ASSERT_TRUE(test::has_value(fan));
  EXPECT_LT((fan->away(grid, 2, 2, 2) - Eigen::Vector3d(0, 0, 1)).norm(), 1e-12);
  EXPECT_DOUBLE_EQ(fan->depth_mm(grid, 2, 2, 2), 2);
  EXPECT_DOUBLE_EQ(fan->depth_mm(grid, 4, 2, 4), std::hypot(2, 12) - 8);
  const auto at_apex = ScanLines::fan({{0, 0, 0}}, 0);
  EXPECT_TRUE(at_apex->away(grid, 2, 2, 2).hasNaN());
}

TEST(ScanLinesTest, PackedDirectionsAreNearlyExact) {
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  for (int n = 0; n < 20000; ++n) {
    const Eigen::Vector3d d =
        Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
    const Eigen::Vector3d back = PackedDirection::pack(d).unpack();
    EXPECT_LT(std::atan2(d.cross(back).norm(), d.dot(back)), 1e-4);
  }
  for (int a = 0; a < 6; ++a) {
    const Eigen::Vector3d d = (a < 3 ? 1 : -1) * Eigen::Vector3d::Unit(a % 3);
    EXPECT_EQ(PackedDirection::pack(d).unpack(), d);
  }
  EXPECT_TRUE(PackedDirection{}.unpack().hasNaN());
}

/// Images side by side along z. Each is rotated about x by an angle that grows.
std::vector<SweepPlane> linear_sweep(int count, double turn_rad) {
  std::vector<SweepPlane> planes;
  for (int n = 0; n < count; ++n) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(turn_rad * n, Eigen::Vector3d::UnitX()));
    planes.push_back({{turn, {0, -10, n - 0.5 * count}}, {-8, 0}, {8, 20}, {}});
  }
  return planes;
}

TEST(ScanLinesTest, LinesOfASweepAreThoseOfItsImages) {
  const auto grid = test::centred_grid({9, 21, 11}, {1, 1, 1});
  const auto lines = compound_scan_lines(grid, linear_sweep(12, 0), 1.0);
  ASSERT_TRUE(test::has_value(lines));
  for (int j = 0; j < 21; ++j) {
    EXPECT_LT((lines->away(grid, 4, j, 5) - Eigen::Vector3d::UnitY()).norm(), 1e-12);
    EXPECT_NEAR(lines->depth_mm(grid, 4, j, 5), j, 1e-5);
  }
  const auto few = compound_scan_lines(grid, linear_sweep(2, 0), 0.5);
  EXPECT_TRUE(few->away(grid, 4, 4, 10).hasNaN());
  EXPECT_TRUE(std::isnan(few->depth_mm(grid, 4, 4, 10)));
}

TEST(ScanLinesTest, LinesOfRotatedConvexImagesStartAtTheirApex) {
  const auto grid = test::centred_grid({15, 21, 3}, {1, 1, 1});
  const SectorOutline outline{{0, -5}, 5, 40, 1.0};
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitZ()));
  const SweepPlane plane{{turn, {0, -12, 0}}, {-40, 0}, {40, 60}, outline};
  const auto lines = compound_scan_lines(grid, std::vector{plane}, 0.6);
  ASSERT_TRUE(test::has_value(lines));
  const Eigen::Vector3d apex = (plane.ct_from_image * Point<frames::Image>{{0, -5, 0}}).mm;
  const Eigen::Vector3d p = grid.at(Eigen::Vector3d(9, 15, 1)).mm;
  EXPECT_LT((lines->away(grid, 9, 15, 1) - (p - apex).normalized()).norm(), 1e-4);
  EXPECT_NEAR(lines->depth_mm(grid, 9, 15, 1), (p - apex).norm() - 5, 1e-5);
  EXPECT_TRUE(lines->away(grid, 9, 15, 0).hasNaN());  // 1 mm beside the image.
}

TEST(ScanLinesTest, OverlappingImagesAreWeightedByTheirDistance) {
  const auto grid = test::centred_grid({5, 21, 5}, {1, 1, 1});
  const auto image = [](const Eigen::Quaterniond& turn, double y, double z) {
    return SweepPlane{{turn, {0, y, z}}, {-8, 0}, {8, 40}, {}};
  };
  const auto straight = Eigen::Quaterniond::Identity();
  // The distances to the voxels in the middle are 0.2 and 0.6 mm, so the weights are 0.8 and 0.4.
  // The second image starts 3 mm earlier.
  const auto both = compound_scan_lines(
      grid, std::vector{image(straight, -10, -0.2), image(straight, -13, 0.6)}, 1.0);
  ASSERT_TRUE(test::has_value(both));
  EXPECT_NEAR(both->depth_mm(grid, 2, 6, 2), 6 + 3 * 0.4 / 1.2, 1e-5);
  // Rotated by 0.5 rad with a share of 0.4 of 1.2: the weighted mean of the two directions.
  const Eigen::Quaterniond aside(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()));
  const auto turned = compound_scan_lines(
      grid, std::vector{image(straight, -10, -0.2), image(aside, -13, 0.6)}, 1.0);
  const Eigen::Vector3d mean =
      0.8 * Eigen::Vector3d::UnitY() + 0.4 * (aside * Eigen::Vector3d::UnitY());
  EXPECT_LT((turned->away(grid, 2, 10, 2) - mean.normalized()).norm(), 1e-4);
  const Eigen::Quaterniond back(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ()));
  const auto opposite =
      compound_scan_lines(grid, std::vector{image(straight, -10, -0.5), image(back, 10, 0.5)}, 1.0);
  EXPECT_TRUE(opposite->away(grid, 2, 10, 2).hasNaN());
  EXPECT_TRUE(std::isnan(opposite->depth_mm(grid, 2, 10, 2)));
}

TEST(ScanLinesTest, AConvexImageCoversOnlyItsSector) {
  const auto grid = test::centred_grid({21, 21, 1}, {1, 1, 1});
  const SectorOutline outline{{0, -5}, 8, 20, 0.4};
  const SweepPlane plane{
      {Eigen::Quaterniond::Identity(), {0, -10, 0}}, {-40, 0}, {40, 60}, outline};
  const auto lines = compound_scan_lines(grid, std::vector{plane}, 0.6);
  ASSERT_TRUE(test::has_value(lines));
  for (int j = 0; j < 21; ++j) {
    for (int i = 0; i < 21; ++i) {
      const double x = i - 10;
      const double y = j + 5;  // Depth from the apex.
      const double radius = std::hypot(x, y);
      const double angle = std::atan2(std::abs(x), y);
      if (std::abs(radius - 8) < 1e-6 || std::abs(radius - 20) < 1e-6) continue;
      EXPECT_EQ(!std::isnan(lines->depth_mm(grid, i, j, 0)),
                radius > 8 && radius < 20 && angle < 0.4)
          << i << ", " << j;
    }
  }
}

TEST(ScanLinesTest, RejectsInvalidInputByName) {
  EXPECT_FALSE(ScanLines::parallel({{0, 0, 0}}, {{0, 0, 0}}));
  EXPECT_FALSE(ScanLines::fan({{0, 0, 0}}, -1));
  const auto grid = test::centred_grid({4, 4, 4}, {1, 1, 1});
  EXPECT_FALSE(ScanLines::per_voxel(grid, {}, {}));
  EXPECT_FALSE(compound_scan_lines(grid, {}, 1));
  EXPECT_FALSE(compound_scan_lines(grid, linear_sweep(1, 0), 0));
  const auto other = compound_scan_lines(grid, linear_sweep(4, 0), 1);
  const auto volume = test::speckled(test::centred_grid({4, 4, 5}, {1, 1, 1}), 1);
  EXPECT_NE(gradient_part(volume, GradientPart::kAlong, &*other).error().message.find("scan-line"),
            std::string::npos);
}

}  // namespace
}  // namespace nav::render::features
