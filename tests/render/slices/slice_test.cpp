// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/slices/slice.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "tests/render/scene_support.hpp"

namespace nav::render {
namespace {

using V = Eigen::Vector3d;
constexpr double kSingle = 2e-3;  // The error of some thousand HU in single precision.

/// HU = 3 x - 2 y + 5 z + 10, CT mm. Trilinear interpolation of this is exact.
double planted(const V& p) { return 3 * p.x() - 2 * p.y() + 5 * p.z() + 10; }

std::shared_ptr<const StoredVolume> ramp_volume(const Eigen::Matrix3d& directions) {
  const VoxelGrid grid = test::centred_grid({41, 31, 21}, {1, 2, 3}, directions);
  std::vector<std::int16_t> voxels;
  for (int k = 0; k < 21; ++k) {
    for (int j = 0; j < 31; ++j) {
      for (int i = 0; i < 41; ++i) {
        voxels.push_back(static_cast<std::int16_t>(
            std::lround(planted(grid.at({1.0 * i, 1.0 * j, 1.0 * k}).mm))));
      }
    }
  }
  return std::make_shared<const StoredVolume>(
      *StoredVolume::create(grid, std::move(voxels), "ramp"));
}

V place(const SlicePlane& plane, const SliceOptions& o, int column, int row) {
  return plane.centre_ct.mm + (column - 0.5 * (o.width - 1)) * o.mm_per_pixel * plane.right.v +
         (row - 0.5 * (o.height - 1)) * o.mm_per_pixel * plane.down.v;
}

SlicePlane oblique() {
  const Eigen::Matrix3d turn =
      Eigen::Quaterniond(0.8, 0.3, -0.4, 0.2).normalized().toRotationMatrix();
  return {{{2, -3, 1}}, {turn.col(0)}, {turn.col(1)}};
}

void expect_planted(const StoredVolume& ct, const SlicePlane& plane, double tolerance) {
  const SliceOptions o{
      .width = 91, .height = 77, .mm_per_pixel = 0.7, .slab = SlabMode::kMaximum, .threads = 2};
  const auto values = slice_values(ct, plane, o);
  ASSERT_TRUE(test::has_value(values));
  int inside = 0;
  for (int row = 0; row < o.height; ++row) {
    for (int column = 0; column < o.width; ++column) {
      const V p = place(plane, o, column, row);
      const V index = ct.grid().index_of({p});
      double edge = 1e9;  // Distance to the box in voxels, negative outside.
      for (int a = 0; a < 3; ++a) {
        edge =
            std::min({edge, index[a], ct.grid().size[static_cast<std::size_t>(a)] - 1 - index[a]});
      }
      if (std::abs(edge) < 1e-6) continue;
      const float found = values->at(column, row);
      ASSERT_EQ(std::isnan(found), edge < 0) << column << ' ' << row;
      if (edge < 0) continue;
      ++inside;
      EXPECT_NEAR(found, planted(p), tolerance);
    }
  }
  EXPECT_GT(inside, 500);
}

TEST(SliceTest, ShowsTheValueOfEachPositionInEachDirection) {
  const auto ct = ramp_volume(Eigen::Matrix3d::Identity());
  const Point<frames::Ct> centre{{1.25, 0.5, -0.75}};
  for (const auto& plane :
       {axial_slice(centre), coronal_slice(centre), sagittal_slice(centre), oblique()}) {
    expect_planted(*ct, plane, kSingle);
  }
}

TEST(SliceTest, RotatedAndLeftHandedVolumesGiveTheSameValues) {
  Eigen::Matrix3d turn = Eigen::Quaterniond(0.9, 0.1, 0.3, -0.2).normalized().toRotationMatrix();
  constexpr double kRounded = 1.01;  // The values of rotated voxels are rounded to whole HU.
  expect_planted(*ramp_volume(turn), oblique(), kRounded);
  turn.col(1) *= -1;
  expect_planted(*ramp_volume(turn), oblique(), kRounded);
}

TEST(SliceTest, ASingleLayerReachesHalfAVoxelToEachSide) {
  const auto ct = test::make_volume(test::centred_grid({9, 9, 1}, {1, 1, 4}),
                                    [](int i, int, int) { return 100 * i; });
  const SliceOptions o{5, 5, 1};
  EXPECT_EQ(slice_values(*ct, axial_slice({{0, 0, 1.9}}), o)->at(2, 2), 400);
  EXPECT_TRUE(std::isnan(slice_values(*ct, axial_slice({{0, 0, 2.1}}), o)->at(2, 2)));
}

TEST(SliceTest, SlabsCombineTheValuesAcrossTheSlice) {
  const auto ct = ramp_volume(Eigen::Matrix3d::Identity());
  const SlicePlane plane = axial_slice({{0, 0, 0}});
  SliceOptions o{21, 21, 1, 12};
  const double reach = 5 * 6;  // Across z: 5 HU per mm.
  const auto middle = [&](SlabMode mode) {
    o.slab = mode;
    return slice_values(*ct, plane, o)->at(10, 10);
  };
  EXPECT_NEAR(middle(SlabMode::kMaximum), 10 + reach, kSingle);
  EXPECT_NEAR(middle(SlabMode::kMinimum), 10 - reach, kSingle);
  EXPECT_NEAR(middle(SlabMode::kMean), 10, kSingle);
  // Half of the slab is outside. Only the rest counts. Box: |z| <= 30.
  const SlicePlane edge = axial_slice({{0, 0, 30}});
  o.slab = SlabMode::kMean;
  EXPECT_NEAR(slice_values(*ct, edge, o)->at(10, 10), 10 + 5 * (30 - 3), kSingle);
  EXPECT_TRUE(std::isnan(slice_values(*ct, axial_slice({{0, 0, 37}}), o)->at(10, 10)));
}

TEST(SliceTest, AMaximumSlabShowsAThinVesselAndAMeanSlabDoesNot) {
  const auto ct = test::make_volume(test::centred_grid({32, 32, 32}, {1, 1, 1}),
                                    [](int i, int, int k) { return i == 16 && k == 20 ? 300 : 0; });
  SliceOptions o{32, 32, 1, 20};
  const SlicePlane plane = axial_slice({{0, 0, 0}});
  const auto peak = [&](SlabMode mode) {
    o.slab = mode;
    const auto values = slice_values(*ct, plane, o);
    return *std::max_element(values->pixels().begin(), values->pixels().end());
  };
  EXPECT_EQ(peak(SlabMode::kMaximum), 300);
  EXPECT_NEAR(peak(SlabMode::kMean), 300.0 / 20, kSingle);  // The area of the vessel over the
                                                            // thickness.
  EXPECT_EQ(peak(SlabMode::kMinimum), 0);
}

TEST(SliceTest, ASlabAlongVoxelPlanesHasTheirExtremes) {
  std::mt19937 random(7);
  std::uniform_int_distribution<int> noise(-1000, 1000);
  const auto ct = test::make_volume(test::centred_grid({21, 19, 17}, {1, 1.5, 2.5}),
                                    [&](int, int, int) { return noise(random); });
  const VoxelGrid& grid = ct->grid();
  const auto slice = [&](int axis, const Point<frames::Ct>& at) {
    return axis == 0 ? sagittal_slice(at) : axis == 1 ? coronal_slice(at) : axial_slice(at);
  };
  for (const int axis : {0, 1, 2}) {
    // Slabs centred on planes and between planes. One of them leaves the CT.
    for (const auto& [first, last] : {std::pair{4, 10}, {5, 10}, {-2, 4}}) {
      V index(8, 9, 8);
      index[axis] = 0.5 * (first + last);
      const double spacing = grid.spacing_mm[axis];
      SliceOptions o{1, 1, 1, (last - first) * spacing};
      double most = -1e9;
      double least = 1e9;
      for (int k = std::max(first, 0); k <= last; ++k) {
        V voxel = index;
        voxel[axis] = k;
        const double value = *ct->sample(grid.at(voxel));
        most = std::max(most, value);
        least = std::min(least, value);
      }
      const SlicePlane plane = slice(axis, grid.at(index));
      EXPECT_NEAR(slice_values(*ct, plane, o)->at(0, 0), most, kSingle) << axis << ' ' << first;
      o.slab = SlabMode::kMinimum;
      EXPECT_NEAR(slice_values(*ct, plane, o)->at(0, 0), least, kSingle) << axis << ' ' << first;
    }
  }
}

TEST(SliceTest, TheMeanOfASlabIsTheMeanOfTheCtInIt) {
  const auto ct = ramp_volume(Eigen::Matrix3d::Identity());
  const auto at = [&](const SlicePlane& plane, double slab_mm) {
    const SliceOptions o{
        .width = 1, .height = 1, .mm_per_pixel = 1, .slab_mm = slab_mm, .slab = SlabMode::kMean};
    return slice_values(*ct, plane, o)->at(0, 0);
  };
  const Point<frames::Ct> centre{{1.3, -2.2, 4.1}};
  for (const double slab_mm : {0.0, 1e-7, 0.1, 1.0, 7.3, 20.0}) {
    for (const auto& plane : {axial_slice(centre), coronal_slice(centre), sagittal_slice(centre)}) {
      EXPECT_NEAR(at(plane, slab_mm), planted(centre.mm), kSingle) << slab_mm;
    }
    EXPECT_NEAR(at(oblique(), slab_mm), planted(oblique().centre_ct.mm), kSingle) << slab_mm;
  }
  // From 24.75 mm to the end of the CT at 30 mm.
  EXPECT_NEAR(at(axial_slice({{0, 0, 29}}), 8.5), planted({0, 0, 0.5 * (24.75 + 30)}), kSingle);
}

TEST(SliceTest, TheMeanOfAnObliqueSlabIsAnIntegral) {
  constexpr double kPeriodMm = 16;
  const VoxelGrid grid = test::centred_grid({41, 41, 41}, {1, 1, 1});
  const auto ct = test::make_volume(grid, [&](int, int, int k) {
    return std::lround(1000 * std::cos(2 * M_PI * (k - 20) / kPeriodMm));
  });
  SlicePlane plane = axial_slice({{0, 0, 0}});
  plane.down.v = V(0, std::cos(0.4), std::sin(0.4));
  // Half a period, from one zero to the next.
  const double slab_mm = 0.5 * kPeriodMm / std::cos(0.4);
  const SliceOptions o{
      .width = 1, .height = 1, .mm_per_pixel = 1, .slab_mm = slab_mm, .slab = SlabMode::kMean};
  constexpr double kLinear = 0.02;  // The error between voxels: (2 pi / 16)^2 / 12.
  EXPECT_NEAR(slice_values(*ct, plane, o)->at(0, 0), 2000 / M_PI, kLinear * 2000 / M_PI);
}

TEST(SliceTest, IsOrientedByRadiologicalConvention) {
  const auto labels = [](const SlicePlane& plane) {
    const SliceLabels l = labels_of(plane);
    return l.left + "|" + l.right + "|" + l.top + "|" + l.bottom;
  };
  EXPECT_EQ(labels(axial_slice({{0, 0, 0}})), "R|L|A|P");
  EXPECT_EQ(labels(coronal_slice({{0, 0, 0}})), "R|L|S|I");
  EXPECT_EQ(labels(sagittal_slice({{0, 0, 0}})), "A|P|S|I");
  SlicePlane turned = axial_slice({{0, 0, 0}});
  turned.right.v = V(1, 0.5, 0).normalized();
  turned.down.v = V(-0.5, 1, 0).normalized();
  EXPECT_EQ(labels(turned), "RA|LP|AL|PR");
}

TEST(SliceTest, SlicesAlongTheNeedleHaveAVerticalShaftInTheMiddle) {
  for (const V& hub :
       {V(30, -80, 40), V(1, -90, 3), V(1, 90, 3), V(0, 0, 100), V(1, 2, -90), V(-50, 1, 2)}) {
    const V tip(1, 2, 3);
    const auto planes = needle_slices({hub}, {tip});
    for (const SlicePlane& plane : planes) {
      EXPECT_TRUE(test::has_value(validate(plane, {})));
      EXPECT_NEAR((plane.down.v - (tip - hub).normalized()).norm(), 0, 1e-12);
      EXPECT_EQ(plane.centre_ct.mm, tip);
    }
    EXPECT_NEAR(planes[0].right.v.dot(planes[1].right.v), 0, 1e-12);
  }
  // A needle from the head of the patient. The first slice has the orientation of a coronal one.
  EXPECT_NEAR((needle_slices({{0, 0, 90}}, {{0, 0, 0}})[0].right.v - V::UnitX()).norm(), 0, 1e-12);
}

TEST(SliceTest, AnObliqueSliceIsOrientedLikeTheNearestStandardSlice) {
  const Point<frames::Ct> at{{1, 2, 3}};
  for (const double sign : {1.0, -1.0}) {
    for (const auto& [normal, like] : {std::pair(V(0, 0, 1), axial_slice(at)),
                                       {V(0, 2, 0), coronal_slice(at)},
                                       {V(3, 0, 0), sagittal_slice(at)}}) {
      const SlicePlane plane = oblique_slice(at, {sign * normal});
      EXPECT_NEAR((plane.right.v - like.right.v).norm(), 0, 1e-12);
      EXPECT_NEAR((plane.down.v - like.down.v).norm(), 0, 1e-12);
    }
    const V normal = V(0.3, -0.5, 0.6).normalized();
    const SlicePlane plane = oblique_slice(at, {sign * normal});
    EXPECT_TRUE(test::has_value(validate(plane, {})));
    EXPECT_NEAR((plane.right.v.cross(plane.down.v) - normal).norm(), 0, 1e-12)
        << "seen from the feet";
    EXPECT_EQ(plane.centre_ct.mm, at.mm);
  }
  // A slice tilted by 45° from axial to coronal, seen from the feet and the front.
  const SliceLabels labels = labels_of(oblique_slice(at, {{0, 0.7, 0.71}}));
  EXPECT_EQ(labels.left + "|" + labels.right + "|" + labels.top, "R|L|AS");
}

TEST(SliceTest, RejectsInvalidPlanesAndOptions) {
  const auto ct = ramp_volume(Eigen::Matrix3d::Identity());
  const SlicePlane good = axial_slice({{0, 0, 0}});
  const auto refused = [&](auto change, const std::string& field) {
    SlicePlane plane = good;
    SliceOptions o{10, 10, 1};
    change(plane, o);
    return test::rejects(slice_values(*ct, plane, o), ErrorCode::kUsage, {"slice", field});
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(refused([](auto&, auto& o) { o.width = 0; }, "width"));
  EXPECT_TRUE(refused([](auto&, auto& o) { o.height = 16385; }, "height"));
  EXPECT_TRUE(refused([&](auto&, auto& o) { o.mm_per_pixel = nan; }, "mm_per_pixel"));
  EXPECT_TRUE(refused([](auto&, auto& o) { o.slab_mm = -1; }, "slab_mm"));
  EXPECT_TRUE(refused([&](auto& p, auto&) { p.centre_ct.mm.x() = nan; }, "centre_ct"));
  EXPECT_TRUE(refused([](auto& p, auto&) { p.right.v *= 2; }, "unit"));
  EXPECT_TRUE(refused([](auto& p, auto&) { p.right.v = p.down.v; }, "right angle"));
  EXPECT_TRUE(refused([](auto& p, auto&) { p.right.v = -p.down.v; }, "right angle"));
}

TEST(ToGreyTest, AppliesTheWindowAndMarksPixelsOutside) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto grey = to_grey(Image2d<float>(5, 1, {-1000, -140, 60, 260, nan}), {60, 400});
  EXPECT_EQ(grey.at(0, 0).r, 0);
  EXPECT_EQ(grey.at(1, 0).r, 0);
  EXPECT_EQ(grey.at(2, 0).r, 128);
  EXPECT_EQ(grey.at(3, 0).r, 255);
  EXPECT_EQ(grey.at(4, 0), kOutsideCt);
  EXPECT_NE(kOutsideCt.r, kOutsideCt.b) << "no grey";
}

/// The border colour of a live plane.
bool is_green(const Rgba8& p) { return p.g > p.r + 50; }

class FusionTest : public ::testing::Test {
 protected:
  FusionTest() : us_(test::upright_plane(test::grey_image(40, 30, 200), 1, {0, 0, 15})) {
    plane_ = ultrasound_slice(us_.ct_from_image, {0, 15});
    options_ = {101, 81, 0.5};
    ct_ = Image2d<Rgba8>(101, 81, std::vector<Rgba8>(101 * 81, Rgba8{40, 40, 40, 255}));
  }
  Rgba8 at(int column, int row, const Fusion& fusion) {
    const auto fused = fuse(ct_, plane_, options_, us_, fusion);
    EXPECT_TRUE(test::has_value(fused));
    return fused->at(column, row);
  }
  UltrasoundPlane us_;
  SlicePlane plane_;
  SliceOptions options_;
  Image2d<Rgba8> ct_;
};

TEST_F(FusionTest, BlendsInsideTheImageOnly) {
  EXPECT_EQ(at(50, 40, {}), (Rgba8{120, 120, 120, 255}));
  EXPECT_EQ(at(50, 40, {FusionMode::kBlend, 0.25}), (Rgba8{80, 80, 80, 255}));
  EXPECT_EQ(at(50, 40, {FusionMode::kBlend, 0}), (Rgba8{40, 40, 40, 255}));
  // The image covers 40 mm × 30 mm. Its rows have their middle 14.5 mm below the first row.
  EXPECT_EQ(at(50 - 41, 40, {}), (Rgba8{40, 40, 40, 255})) << "left of it";
  const Rgba8 border = at(50 - 39, 40, {});
  EXPECT_GT(border.g, border.r + 50) << "green: live";
}

TEST_F(FusionTest, PixelsShowTheImageAtTheirPosition) {
  std::vector<std::uint8_t> ramp;
  for (int row = 0; row < 30; ++row) {
    for (int column = 0; column < 40; ++column) {
      ramp.push_back(static_cast<std::uint8_t>(4 * row + 2 * column));
    }
  }
  us_ = test::upright_plane({40, 30, std::move(ramp)}, 1, {0, 0, 15});
  const auto& grid = us_.frame.grid;
  for (const auto& [column, row] : {std::pair(50, 40), {31, 22}, {64, 55}}) {
    const Eigen::Vector2d p = Eigen::Vector2d(0, 15) + 0.5 * Eigen::Vector2d(column - 50, row - 40);
    const Eigen::Vector2d pixel = grid.mm_per_pixel.inverse() * (p - grid.origin_mm);
    EXPECT_NEAR(at(column, row, {FusionMode::kBlend, 1}).r, 4 * pixel.y() + 2 * pixel.x(), 0.51);
  }
}

TEST_F(FusionTest, CheckerboardAndWipeShowOneOfTheTwoImages) {
  const Fusion squares{FusionMode::kCheckerboard, 0.5, 5};
  EXPECT_EQ(at(52, 42, squares).r, 200);
  EXPECT_EQ(at(48, 42, squares).r, 40);
  EXPECT_EQ(at(48, 38, squares).r, 200);
  EXPECT_EQ(at(62, 42, squares).r, 40);
  const Fusion wipe{FusionMode::kWipe, 0.5, 10, 0.5};
  EXPECT_EQ(at(45, 40, wipe).r, 200);
  EXPECT_EQ(at(55, 40, wipe).r, 40);
}

TEST_F(FusionTest, TheBorderOfACoarseSliceHasNoGap) {
  options_ = {41, 31, 2.1};
  ct_ = Image2d<Rgba8>(41, 31, std::vector<Rgba8>(41 * 31, Rgba8{40, 40, 40, 255}));
  const auto fused = fuse(ct_, plane_, options_, us_, {});
  ASSERT_TRUE(test::has_value(fused));
  int borders = 0;
  int inside = 0;
  for (int row = 1; row < 30; ++row) {
    for (int column = 1; column < 40; ++column) {
      const auto drawn = [&](int right, int down) {
        return fused->at(column + right, row + down).g != 40;
      };
      if (!drawn(0, 0)) continue;
      const bool at_edge = !(drawn(1, 0) && drawn(-1, 0) && drawn(0, 1) && drawn(0, -1));
      const Rgba8& p = fused->at(column, row);
      const bool green = p.g > p.r + 50;
      EXPECT_TRUE(green || !at_edge) << column << ' ' << row;
      ++(green ? borders : inside);
    }
  }
  EXPECT_GT(borders, 40);
  EXPECT_GT(inside, 100) << "and is at most two pixels wide";
}

TEST_F(FusionTest, AStaleImageIsNeverDrawnAsLive) {
  us_.safety.state = SafetyState::kStale;
  EXPECT_EQ(at(50, 40, {}), (Rgba8{40, 40, 40, 255}));
  const Rgba8 border = at(50 - 39, 40, {});
  EXPECT_EQ(border.r, border.g) << "grey";
  EXPECT_NE(border.r, 40);
  us_.safety.state = SafetyState::kLost;
  EXPECT_EQ(at(50 - 39, 40, {}), (Rgba8{40, 40, 40, 255}));
  us_.safety.state = SafetyState::kDegraded;
  EXPECT_EQ(at(50, 40, {}).r, 120);
  EXPECT_GT(at(50 - 39, 40, {}).r, at(50 - 39, 40, {}).b) << "amber";
}

TEST_F(FusionTest, RespectsTheTrueOutline) {
  us_.frame.outline = SectorOutline{{0, -5}, 8, 30, 0.4};
  EXPECT_EQ(at(50, 40, {}).r, 120);
  EXPECT_EQ(at(50 - 36, 20, {}).r, 40) << "beside the sector, inside the rectangle";
}

TEST_F(FusionTest, ACrossingPlaneShowsTheUltrasoundOnTheLineOfBoth) {
  plane_ = axial_slice(plane_.centre_ct);
  EXPECT_TRUE(is_green(at(50, 40, {}))) << "on the line of both";
  EXPECT_EQ(at(50, 43, {}).r, 40) << "1.5 mm off the ultrasound plane";
  options_.mm_per_pixel = 0.1;
  EXPECT_EQ(at(50, 43, {}).r, 120) << "0.3 mm off it";
}

/// Rotates a plane about a line of the ultrasound plane through the middle of its image.
SlicePlane turned(const SlicePlane& plane, double about_rad, double by_rad) {
  const Eigen::Vector3d line =
      std::cos(about_rad) * plane.right.v + std::sin(about_rad) * plane.down.v;
  const Eigen::AngleAxisd turn(by_rad, line);
  return {plane.centre_ct, {turn * plane.right.v}, {turn * plane.down.v}};
}

TEST_F(FusionTest, ACrossingPlaneIsALineInTheColourOfItsStateWithoutGaps) {
  constexpr double kDeg = M_PI / 180;
  constexpr double kHalfImageMm = 12;  // Image of 40 mm × 30 mm, without border.
  for (const double mm_per_pixel : {0.1, 0.5, 1.2, 3.0}) {
    for (const double by_deg : {90.0, 60.0, -30.0, 16.0}) {
      for (const double about_deg : {0.0, 35.0, 90.0, 120.0}) {
        options_.mm_per_pixel = mm_per_pixel;
        const SlicePlane crossing = turned(plane_, about_deg * kDeg, by_deg * kDeg);
        const auto fused = fuse(ct_, crossing, options_, us_, {});
        ASSERT_TRUE(test::has_value(fused));
        const Eigen::Vector2d along(std::cos(about_deg * kDeg), std::sin(about_deg * kDeg));
        const double half_px = std::min(kHalfImageMm / mm_per_pixel, 38.0);
        int gaps = 0;
        for (double t = -half_px; t <= half_px; t += 0.1) {
          const Eigen::Vector2d p = Eigen::Vector2d(50, 40) + t * along;
          gaps += is_green(fused->at(static_cast<int>(std::lround(p.x())),
                                     static_cast<int>(std::lround(p.y()))))
                      ? 0
                      : 1;
        }
        EXPECT_EQ(gaps, 0) << mm_per_pixel << " mm, turned by " << by_deg << " about " << about_deg;
      }
    }
  }
}

TEST_F(FusionTest, PlanesThatNearlyAgreeDrawNoLineOverTheImage) {
  plane_ = turned(plane_, 0, 0.02);
  EXPECT_EQ(at(50, 40, {}), (Rgba8{120, 120, 120, 255}));
}

TEST_F(FusionTest, TheLineOfAStalePlaneIsGreyAndALostPlaneHasNone) {
  plane_ = axial_slice(plane_.centre_ct);
  us_.safety.state = SafetyState::kStale;
  const Rgba8 line = at(50, 40, {});
  EXPECT_EQ(line.r, line.g);
  EXPECT_NE(line.r, 40);
  EXPECT_NE(line.r, 120) << "nor its image";
  us_.safety.state = SafetyState::kLost;
  EXPECT_EQ(at(50, 40, {}).r, 40);
}

TEST_F(FusionTest, ASecondVolumeIsFusedLikeAnImage) {
  std::vector<Rgba8> pixels(101 * 81, Rgba8{200, 200, 200, 255});
  pixels[0] = kOutsideCt;
  const Image2d<Rgba8> second(101, 81, std::move(pixels));
  const auto at_of = [&](int column, int row, const Fusion& fusion) {
    const auto fused = fuse(ct_, second, options_, fusion);
    EXPECT_TRUE(test::has_value(fused));
    return static_cast<int>(fused->at(column, row).r);
  };
  EXPECT_EQ(at_of(50, 40, {FusionMode::kBlend, 0.25}), 80);
  EXPECT_EQ(at_of(0, 0, {FusionMode::kBlend, 0.25}), 40) << "the CT alone reaches";
  const Fusion squares{FusionMode::kCheckerboard, 0.5, 5};
  EXPECT_EQ(at_of(52, 42, squares), 200);
  EXPECT_EQ(at_of(48, 42, squares), 40);
  EXPECT_EQ(at_of(45, 40, {FusionMode::kWipe}), 200);
  EXPECT_EQ(at_of(55, 40, {FusionMode::kWipe}), 40);
  ct_ = Image2d<Rgba8>(101, 81, std::vector<Rgba8>(101 * 81, kOutsideCt));
  EXPECT_EQ(at_of(50, 40, {FusionMode::kBlend, 0.25}), 200) << "the second alone reaches";
  EXPECT_TRUE(test::rejects(fuse(ct_, second, options_, {FusionMode::kBlend, 2}), ErrorCode::kUsage,
                            {"share"}));
}

TEST_F(FusionTest, RejectsInvalidFusionOptions) {
  const auto refused = [&](const Fusion& fusion, const std::string& field) {
    return test::rejects(fuse(ct_, plane_, options_, us_, fusion), ErrorCode::kUsage, {field});
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(refused({FusionMode::kBlend, 1.5}, "share"));
  EXPECT_TRUE(refused({FusionMode::kBlend, nan}, "share"));
  EXPECT_TRUE(refused({FusionMode::kCheckerboard, 0.5, 0}, "square_mm"));
  EXPECT_TRUE(refused({FusionMode::kWipe, 0.5, 10, -1}, "wipe"));
  EXPECT_TRUE(refused(
      {.mode = FusionMode::kBlend, .share = 0.5, .square_mm = 10, .wipe = 0.5, .reach_mm = -1},
      "reach_mm"));
}

TEST(SliceTest, ASliceAlongAnImageHasThePixelPositionsOfTheImage) {
  const auto ct = ramp_volume(Eigen::Matrix3d::Identity());
  const Transform<frames::Ct, frames::Image> ct_from_image{
      Eigen::Quaterniond(0.8, 0.3, -0.4, 0.2).normalized(), V(1, -2, 3)};
  const Eigen::Vector2d origin_mm(-6, -4);
  const HuWindow window{10, 255};
  const auto image = slice_along_image(*ct, ct_from_image, origin_mm, 0.5, 25, 17, window);
  int inside = 0;
  for (int row = 0; row < 17; ++row) {
    for (int column = 0; column < 25; ++column) {
      const Eigen::Vector2d p = origin_mm + 0.5 * Eigen::Vector2d(column, row);
      const auto place = ct_from_image * Point<frames::Image>{{p.x(), p.y(), 0}};
      const auto hu = ct->sample(place);
      const Rgba8& found = image.at(column, row);
      if (!hu) {
        EXPECT_EQ(found.b, kOutsideCt.b);
        continue;
      }
      const double grey = 255 * std::clamp((*hu - window.level) / window.width + 0.5, 0.0, 1.0);
      EXPECT_NEAR(found.r, grey, 0.51) << column << ", " << row;
      ++inside;
    }
  }
  EXPECT_GT(inside, 200);
}

}  // namespace
}  // namespace nav::render
