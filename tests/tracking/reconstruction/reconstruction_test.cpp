// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <gtest/gtest.h>
#include <random>

#include "tests/support/matchers.hpp"
#include "tests/tracking/reconstruction/planted_sweep.hpp"

namespace nav::tracking {
namespace {

using test::oblique;
using test::ReferenceFromImage;
using Method = ReconstructionMethod;

constexpr std::array<Method, 4> kMethods{Method::kNearest, Method::kTrilinear, Method::kGaussian,
                                         Method::kBackward};
constexpr std::array<Compounding, 4> kCompoundings{Compounding::kMean, Compounding::kMedian,
                                                   Compounding::kMaximum, Compounding::kLatest};
constexpr double kVoxelMm = 0.5;

ReconstructionOptions options_of(Method method, Compounding compounding = Compounding::kMean) {
  ReconstructionOptions options;
  options.method = method;
  options.compounding = compounding;
  options.reach_mm = kVoxelMm;
  options.threads = 2;
  return options;
}

double plane_field(const Eigen::Vector3d& mm) {
  return 120 + Eigen::Vector3d(2.5, -3, 1.5).dot(mm - Eigen::Vector3d(9, -2, 16));
}

class EveryMethod : public ::testing::TestWithParam<Method> {};

TEST_P(EveryMethod, KeepsAPlaneField) {
  const auto sweep = test::sweep_of(plane_field, 24);
  const auto grid = test::grid_around(sweep, kVoxelMm);
  auto volume = test::reconstruct(sweep, grid, options_of(GetParam()));
  const auto values = volume.values();
  ASSERT_TRUE(test::has_value(values));
  // Values come from at most a voxel and a half away (Gaussian: its end and half a voxel).
  const double furthest_mm = kVoxelMm * std::sqrt(3.0) * 1.5;
  const double gradient = Eigen::Vector3d(2.5, -3, 1.5).norm();
  double square = 0;
  double sum = 0;
  double count = 0;
  test::for_each_voxel(grid.size, [&](const Eigen::Vector3d& index, std::size_t offset) {
    const std::int16_t value = (*values)[offset];
    if (value == kUnseenVoxel) return;
    const double error = value - plane_field(grid.at(index).mm);
    EXPECT_LE(std::abs(error), gradient * furthest_mm + 1) << index.transpose();
    square += error * error;
    sum += error;
    ++count;
  });
  // The sweep is 16 x 14 x 9.2 mm: the voxels in it, and those at its faces.
  EXPECT_GT(count, 0.9 * 16 * 14 * 9.2 / std::pow(kVoxelMm, 3));
  EXPECT_LT(count, 1.6 * 16 * 14 * 9.2 / std::pow(kVoxelMm, 3));
  constexpr double kGreyLevels =
      0.9;  // Half of a voxel's difference in grey levels, 4.2 / 2 · 0.5.
  EXPECT_LT(std::sqrt(square / count), kGreyLevels);
  EXPECT_LT(std::abs(sum / count), 0.1);
}

TEST_P(EveryMethod, KeepsTheVolumeOfASphere) {
  const Eigen::Vector3d centre =
      Eigen::Vector3d(3, -8, 11) + oblique() * Eigen::Vector3d(8, 7, 4.6);
  constexpr double kRadiusMm = 3.5;
  const auto sweep = test::sweep_of(
      [&](const Eigen::Vector3d& mm) { return (mm - centre).norm() < kRadiusMm ? 200.0 : 0.0; },
      24);
  const auto grid = test::grid_around(sweep, kVoxelMm);
  auto volume = test::reconstruct(sweep, grid, options_of(GetParam()));
  const auto values = volume.values();
  ASSERT_TRUE(test::has_value(values));
  double sum = 0;
  test::for_each_voxel(grid.size, [&](const Eigen::Vector3d& index, std::size_t offset) {
    if ((*values)[offset] == kUnseenVoxel) return;
    sum += (*values)[offset];
    const double distance = (grid.at(index).mm - centre).norm();
    // A voxel and a half around the surface has both values.
    if (std::abs(distance - kRadiusMm) < 1.4) return;
    EXPECT_EQ((*values)[offset], distance < kRadiusMm ? 200 : 0) << distance;
  });
  const double found = sum / 200 * std::pow(kVoxelMm, 3);
  const double truth = 4.0 / 3 * M_PI * std::pow(kRadiusMm, 3);
  // A few of the voxels that the images barely miss are empty.
  EXPECT_NEAR(found, truth, 0.04 * truth);
}

TEST_P(EveryMethod, CompoundsImagesOfOnePlace) {
  std::vector<TrackedImage> sweep;
  for (const double value : {10.0, 40.0, 20.0, 34.0, 31.0}) {
    sweep.push_back(test::image_of([=](const Eigen::Vector3d&) { return value; },
                                   ReferenceFromImage(oblique(), Eigen::Vector3d(3, -8, 11)), 40,
                                   40, 0.2));
  }
  const auto grid = test::grid_around(sweep, kVoxelMm);
  for (const auto& [compounding, expected] :
       {std::pair(Compounding::kMean, 27), std::pair(Compounding::kMedian, 31),
        std::pair(Compounding::kMaximum, 40), std::pair(Compounding::kLatest, 31)}) {
    auto volume = test::reconstruct(sweep, grid, options_of(GetParam(), compounding));
    const auto values = volume.values();
    ASSERT_TRUE(test::has_value(values));
    std::size_t seen = 0;
    for (const std::int16_t value : *values) {
      if (value == kUnseenVoxel) continue;
      EXPECT_EQ(value, expected);
      ++seen;
    }
    EXPECT_GT(seen, 200U);
  }
}

TEST_P(EveryMethod, GivesTheSameBytesWithAnyNumberOfThreads) {
  std::mt19937 random(7);
  const auto sweep = test::sweep_of(
      [&](const Eigen::Vector3d&) { return static_cast<double>(random() % 256); }, 10);
  const auto grid = test::grid_around(sweep, 0.3);
  for (const Compounding compounding : kCompoundings) {
    ReconstructionOptions options = options_of(GetParam(), compounding);
    options.threads = 1;
    auto alone = test::reconstruct(sweep, grid, options);
    const auto expected = alone.values();
    ASSERT_TRUE(test::has_value(expected));
    for (const int threads : {2, 5, 0}) {
      options.threads = threads;
      auto shared = test::reconstruct(sweep, grid, options);
      const auto found = shared.values();
      ASSERT_TRUE(test::has_value(found));
      EXPECT_EQ(*found, *expected) << threads;
      EXPECT_TRUE(std::ranges::equal(shared.scan_lines(), alone.scan_lines()));
    }
  }
}

TEST_P(EveryMethod, PixelsCountByTheirConfidence) {
  // Two images in one place: 100 with the weight 1, and 200 with 64 / 256.
  std::vector<TrackedImage> sweep;
  for (const double value : {100.0, 200.0}) {
    sweep.push_back(test::sweep_of([&](const Eigen::Vector3d&) { return value; }, 1).front());
  }
  const auto grid = test::grid_around(sweep, kVoxelMm);
  ReconstructionOptions options = options_of(GetParam());
  options.by_confidence = true;
  auto volume = *Reconstruction::create(grid, options);
  const auto of_image = [&](std::uint8_t confidence) {
    const auto& pixels = sweep[0].frame.pixels;
    return Image2d<std::uint8_t>(pixels.width(), pixels.height(),
                                 std::vector<std::uint8_t>(pixels.pixels().size(), confidence));
  };
  volume.add(sweep[0], test::whole_area(sweep[0]), of_image(255));
  volume.add(sweep[1], test::whole_area(sweep[1]), of_image(63));
  const auto values = volume.values();
  ASSERT_TRUE(test::has_value(values));
  std::size_t seen = 0;
  for (const std::int16_t value : *values) {
    if (value == kUnseenVoxel) continue;
    EXPECT_EQ(value, 120) << "(100 + 200 / 4) / (1 + 1 / 4)";
    ++seen;
  }
  EXPECT_GT(seen, 200U);
}

TEST_P(EveryMethod, FullConfidenceChangesNoMean) {
  const auto sweep = test::sweep_of(plane_field, 5);
  const auto grid = test::grid_around(sweep, kVoxelMm);
  auto plain = test::reconstruct(sweep, grid, options_of(GetParam()));
  ReconstructionOptions options = options_of(GetParam());
  options.by_confidence = true;
  auto weighted = *Reconstruction::create(grid, options);
  for (const TrackedImage& image : sweep) {
    const auto& pixels = image.frame.pixels;
    weighted.add(image, test::whole_area(image),
                 Image2d<std::uint8_t>(pixels.width(), pixels.height(),
                                       std::vector<std::uint8_t>(pixels.pixels().size(), 255)));
  }
  const auto a = *plain.values();
  const auto b = *weighted.values();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_LE(std::abs(a[i] - b[i]), 1) << i;
}

TEST(ReconstructionOptionsTest, WeightsNeedACompoundingInWhichTheyCount) {
  for (const Method method : kMethods) {
    for (const Compounding compounding : kCompoundings) {
      ReconstructionOptions options = options_of(method, compounding);
      options.by_confidence = true;
      const bool counts = compounding == Compounding::kMean ||
                          (method == Method::kBackward && compounding == Compounding::kMedian);
      EXPECT_EQ(validate(options).has_value(), counts);
      if (!counts) {
        EXPECT_TRUE(test::rejects(validate(options), ErrorCode::kUsage, {"confidence", "mean"}));
      }
    }
  }
}

TEST_P(EveryMethod, CanBeReadAfterEveryImage) {
  const auto sweep = test::sweep_of(plane_field, 6);
  const auto grid = test::grid_around(sweep, kVoxelMm);
  auto read_often = *Reconstruction::create(grid, options_of(GetParam()));
  std::vector<TrackedImage> so_far;
  for (const TrackedImage& image : sweep) {
    read_often.add(image, test::whole_area(image));
    so_far.push_back(image);
    auto fresh = test::reconstruct(so_far, grid, options_of(GetParam()));
    EXPECT_EQ(*read_often.values(), *fresh.values()) << so_far.size();
  }
}

TEST_P(EveryMethod, LeavesOutPixelsOutsideTheGrid) {
  const auto sweep = test::sweep_of(plane_field, 12);
  const auto whole = test::grid_around(sweep, kVoxelMm);
  VoxelGridIn<frames::Reference> part = whole;
  for (std::size_t a = 0; a < 3; ++a) part.size[a] = whole.size[a] / 3;
  part.origin_mm = whole.at(Eigen::Vector3d(whole.size[0], whole.size[1], whole.size[2]) / 3).mm;
  auto volume = test::reconstruct(sweep, part, options_of(GetParam()));
  const auto values = volume.values();
  ASSERT_TRUE(test::has_value(values));
  EXPECT_LT(std::ranges::count(*values, kUnseenVoxel), std::ssize(*values) / 2);
  part.origin_mm += Eigen::Vector3d(1e9, 0, 0);
  auto far = test::reconstruct(sweep, part, options_of(GetParam()));
  EXPECT_EQ(std::ranges::count(*far.values(), kUnseenVoxel), std::ssize(*values));
}

TEST_P(EveryMethod, StopsWhenAsked) {
  const auto sweep = test::sweep_of(plane_field, 2);
  auto volume =
      test::reconstruct(sweep, test::grid_around(sweep, kVoxelMm), options_of(GetParam()));
  std::stop_source stop;
  stop.request_stop();
  EXPECT_TRUE(test::rejects(volume.values({stop.get_token()}), ErrorCode::kCancelled, {}));
  EXPECT_TRUE(test::has_value(volume.values()));
}

INSTANTIATE_TEST_SUITE_P(Methods, EveryMethod, ::testing::ValuesIn(kMethods));

TEST(ReconstructionTest, BackwardKeepsTheScanLineOfALinearProbe) {
  const auto sweep = test::sweep_of(plane_field, 3);
  const auto grid = test::grid_around(sweep, kVoxelMm);
  auto volume = test::reconstruct(sweep, grid, options_of(Method::kBackward));
  const auto values = volume.values();
  ASSERT_TRUE(test::has_value(values));
  const Eigen::Vector3d down = oblique() * Eigen::Vector3d::UnitY();
  test::for_each_voxel(grid.size, [&](const Eigen::Vector3d& index, std::size_t offset) {
    const ScanLineAtVoxel line = volume.scan_lines()[offset];
    EXPECT_EQ(line.defined(), (*values)[offset] != kUnseenVoxel);
    if (!line.defined()) return;
    constexpr double kTurnRad = 0.01;  // The images turn by 0.008.
    EXPECT_GT(line.away().dot(down), std::cos(kTurnRad));
    const Eigen::Vector3d in_image =
        oblique().inverse() * (grid.at(index).mm - Eigen::Vector3d(3, -8, 11));
    EXPECT_NEAR(line.depth_mm(), in_image.y(), 0.03);
  });
}

TEST(ReconstructionTest, BackwardKeepsTheScanLineOfASector) {
  auto sweep = test::sweep_of(plane_field, 1);
  const SectorOutline sector{{8, -10}, 12, 22, 0.5};
  sweep.front().frame.outline = sector;
  const auto grid = test::grid_around(sweep, kVoxelMm);
  auto volume = test::reconstruct(sweep, grid, options_of(Method::kBackward));
  ASSERT_TRUE(test::has_value(volume.values()));
  int seen = 0;
  test::for_each_voxel(grid.size, [&](const Eigen::Vector3d& index, std::size_t offset) {
    const ScanLineAtVoxel line = volume.scan_lines()[offset];
    const Eigen::Vector3d in_image =
        (sweep.front().reference_from_image.inverse() * grid.at(index)).mm;
    if (!line.defined()) return;
    ++seen;
    const Eigen::Vector2d from = in_image.head<2>() - sector.apex_mm;
    EXPECT_TRUE(sector.contains(in_image.head<2>())) << in_image.transpose();
    const Eigen::Vector3d away = oblique() * Eigen::Vector3d(from.x(), from.y(), 0).normalized();
    EXPECT_GT(line.away().dot(away), 1 - 1e-6);
    EXPECT_NEAR(line.depth_mm(), from.norm() - 12, 0.02);
  });
  EXPECT_GT(seen, 500);
}

/// Images through one point, which look at it from different sides.
TEST(ReconstructionTest, BackwardWeighsImagesByTheirOrientation) {
  const auto looking = [](double angle, double value) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
    // The image's middle lies at the origin of the Reference frame.
    return test::image_of([=](const Eigen::Vector3d&) { return value; },
                          ReferenceFromImage(turn, turn * Eigen::Vector3d(-4, -4, 0)), 33, 33,
                          0.25);
  };
  const std::vector<TrackedImage> sweep{looking(0, 100), looking(0, 100), looking(M_PI / 3, 220)};
  VoxelGridIn<frames::Reference> grid;
  grid.size = {1, 1, 1};
  auto volume = test::reconstruct(sweep, grid, options_of(Method::kBackward));
  const auto values = volume.values();
  ASSERT_TRUE(test::has_value(values));
  // The mean direction of 2 · (0, 1) and (-sin 60°, cos 60°) is tilted by atan(sin 60° / 2.5).
  const double tilt = std::atan(std::sin(M_PI / 3) / 2.5);
  const double straight = 2 * std::pow(std::cos(tilt), 2);
  const double turned = std::pow(std::cos(M_PI / 3 - tilt), 2);
  const double expected = (straight * 100 + turned * 220) / (straight + turned);
  EXPECT_EQ(values->front(), std::lround(expected));
  EXPECT_LT(expected, (100 + 100 + 220) / 3.0 - 10);
  const Eigen::Vector3d mean(-turned * std::sin(M_PI / 3), straight + turned * std::cos(M_PI / 3),
                             0);
  EXPECT_GT(volume.scan_lines().front().away().dot(mean.normalized()), 1 - 1e-6);
}

TEST(ReconstructionTest, BackwardLeavesOutImagesFromTheOtherSide) {
  const auto image = [](double angle, double value) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
    return test::image_of([=](const Eigen::Vector3d&) { return value; },
                          ReferenceFromImage(turn, turn * Eigen::Vector3d(-4, -4, 0)), 33, 33,
                          0.25);
  };
  VoxelGridIn<frames::Reference> grid;
  grid.size = {1, 1, 1};
  auto most = test::reconstruct({image(0, 100), image(0, 100), image(M_PI, 220)}, grid,
                                options_of(Method::kBackward));
  EXPECT_EQ(most.values()->front(), 100);
  // Directions that cancel give a value, and no scan line.
  auto none =
      test::reconstruct({image(0, 100), image(M_PI, 220)}, grid, options_of(Method::kBackward));
  EXPECT_EQ(none.values()->front(), 160);
  EXPECT_FALSE(none.scan_lines().front().defined());
}

TEST(ReconstructionTest, RejectsOptionsAndGrids) {
  VoxelGridIn<frames::Reference> grid;
  grid.size = {4, 4, 4};
  ReconstructionOptions options;
  options.reach_mm = 0;
  EXPECT_TRUE(test::rejects(Reconstruction::create(grid, options), ErrorCode::kUsage,
                            {"reach", "(0, 100] mm", "found 0"}));
  options = {};
  options.gaussian_voxels = NAN;
  EXPECT_TRUE(test::rejects(Reconstruction::create(grid, options), ErrorCode::kUsage,
                            {"Gaussian", "0.3 to 2", "nan"}));
  grid.spacing_mm.x() = 0;
  EXPECT_FALSE(Reconstruction::create(grid, {}));
}

TEST(ReconstructionTest, TellsItsMemoryBefore) {
  VoxelGridIn<frames::Reference> grid;
  grid.size = {100, 100, 100};
  EXPECT_EQ(reconstruction_bytes(grid, options_of(Method::kNearest), 1e7), 1e7);
  EXPECT_EQ(reconstruction_bytes(grid, options_of(Method::kBackward), 1e7), 2.2e7);
  EXPECT_GT(reconstruction_bytes(grid, options_of(Method::kNearest, Compounding::kMedian), 1e8),
            4e8);
}

}  // namespace
}  // namespace nav::tracking
