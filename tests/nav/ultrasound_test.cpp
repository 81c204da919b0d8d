// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <limits>

#include "nav/sweep.hpp"
#include "tests/support/matchers.hpp"

namespace nav {
namespace {

constexpr double kGridRounding = 1e-12;

TEST(PixelGridTest, OriginIsTheMiddleOfTheTransducerFace) {
  const PixelGrid grid = PixelGrid::centred(101, 0.5, 0.25);
  EXPECT_NEAR(grid.at(50, 0).mm.norm(), 0, kGridRounding);
  EXPECT_NEAR(grid.at(0, 0).mm.x(), -25, kGridRounding);
  EXPECT_NEAR(grid.at(100, 40).mm.x(), 25, kGridRounding);
  EXPECT_NEAR(grid.at(100, 40).mm.y(), 10, kGridRounding);
  EXPECT_EQ(grid.at(3, 7).mm.z(), 0);
}

TEST(PixelGridTest, KeepsTheShearOfARealCalibration) {
  PixelGrid grid = PixelGrid::centred(820, 0.0854, 0.079);
  grid.mm_per_pixel(0, 1) = 0.079 * std::sin(0.048);
  EXPECT_NEAR(grid.shear_rad(), 0.048, 1e-3);
  const Eigen::Vector2d pixel(123.25, 456.5);
  EXPECT_LT((grid.pixel_of(grid.at(pixel.x(), pixel.y())) - pixel).norm(), 1e-9);
}

TEST(UltrasoundColoursTest, AGreyImageHasNone) {
  UltrasoundImage frame;
  EXPECT_EQ(frame.colours.pixels().data(), nullptr);
  set_colours(frame, {2, 2, {{0, 0, 0}, {255, 255, 255}, {7, 7, 7}, {8, 8, 8}}});
  EXPECT_EQ(frame.colours.pixels().data(), nullptr) << "nothing is allocated";
  EXPECT_EQ(frame.pixels.at(1, 0), 255);
  EXPECT_EQ(frame.pixels.at(0, 1), 7);
}

TEST(UltrasoundColoursTest, PixelsAreTheLuma) {
  UltrasoundImage frame;
  set_colours(frame, {3, 1, {{255, 0, 0}, {0, 255, 0}, {0, 0, 255}}});
  EXPECT_EQ(frame.colours.at(2, 0), (Rgb8{0, 0, 255}));
  // ITU-R BT.601: 0.299, 0.587 and 0.114 of 255.
  EXPECT_EQ(frame.pixels.at(0, 0), 76);
  EXPECT_EQ(frame.pixels.at(1, 0), 150);
  EXPECT_EQ(frame.pixels.at(2, 0), 29);
  for (int grey = 0; grey < 256; ++grey) {
    const auto value = static_cast<std::uint8_t>(grey);
    EXPECT_EQ(luma(Rgb8{value, value, value}), value);
  }
}

TEST(UltrasoundColoursTest, ASweepKeepsOnlyTheBrightness) {
  UltrasoundImage frame;
  set_colours(frame, {2, 1, {{255, 0, 0}, {0, 255, 0}}});
  const Transform<frames::Reference, frames::Image> still(Eigen::Quaterniond::Identity(),
                                                          Eigen::Vector3d::Zero());
  const auto sweep = Sweep::create({{frame, still, Duration(0)}}, "none");
  ASSERT_TRUE(test::has_value(sweep));
  EXPECT_TRUE(sweep->frames()[0].frame.colours.empty());
  EXPECT_EQ(sweep->frames()[0].frame.pixels.at(1, 0), 150);
}

TEST(PixelGridTest, RejectsGridsThatNoProbeHas) {
  PixelGrid grid = PixelGrid::centred(10, 0.1, 0.1);
  EXPECT_TRUE(test::has_value(validate(grid)));
  grid.mm_per_pixel(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(test::rejects(validate(grid), ErrorCode::kMalformedData, {"finite"}));
  EXPECT_TRUE(test::rejects(validate(PixelGrid::centred(10, 0, 0.1)), ErrorCode::kMalformedData,
                            {"axis 0", "found 0"}));
  grid = PixelGrid::centred(10, 0.1, 0.1);
  grid.mm_per_pixel(0, 1) = 0.1;
  EXPECT_TRUE(test::rejects(validate(grid), ErrorCode::kMalformedData, {"orthogonal", "45"}));
}

TEST(SectorOutlineTest, ContainsOnlyTheRingSegment) {
  const SectorOutline sector{{0, -60}, 60, 200, 0.5};
  EXPECT_TRUE(sector.contains({0, 10}));
  EXPECT_FALSE(sector.contains({0, -1}));
  EXPECT_FALSE(sector.contains({0, 141}));
  EXPECT_TRUE(sector.contains({60 * std::sin(0.49) * 2, -60 + 120 * std::cos(0.49)}));
  EXPECT_FALSE(sector.contains({120 * std::sin(0.51), -60 + 120 * std::cos(0.51)}));
  EXPECT_FALSE(sector.contains({0, -130})) << "behind the apex";
}

TrackedImage tracked(int ms, int width = 2) {
  UltrasoundImage frame{.acquired = Timestamp(std::chrono::milliseconds(ms)),
                        .received = Timestamp(std::chrono::milliseconds(ms)),
                        .pixels = Image2d<std::uint8_t>(width, 1, std::vector<std::uint8_t>(width)),
                        .grid = PixelGrid::centred(width, 1, 1)};
  return {
      std::move(frame),
      Transform<frames::Reference, frames::Image>(Eigen::Quaterniond::Identity(), {0, 0, 1.0 * ms}),
      Duration::zero()};
}

TEST(SweepTest, KeepsTheImagesInOrderAndComputesTheirCentroid) {
  const auto sweep = Sweep::create({tracked(10), tracked(20)}, "calibration");
  ASSERT_TRUE(test::has_value(sweep));
  EXPECT_NEAR(sweep->centroid().mm.z(), 15, kGridRounding);
}

TEST(SweepTest, RejectsInvalidImagesAndNamesTheirIndex) {
  using Code = ErrorCode;
  EXPECT_TRUE(test::rejects(Sweep::create({}, ""), Code::kMalformedData, {"at least one"}));
  EXPECT_TRUE(test::rejects(Sweep::create({tracked(1), tracked(2), tracked(2)}, ""),
                            Code::kMalformedData, {"image 2", "0.002"}));
  EXPECT_TRUE(test::rejects(Sweep::create({tracked(1), tracked(2, 3)}, ""), Code::kMalformedData,
                            {"image 1", "2 x 1", "3 x 1"}));
}

}  // namespace
}  // namespace nav
