// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/similarity/shadow_mask.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <functional>
#include <gtest/gtest.h>

#include "registration/counter_random.hpp"
#include "registration/similarity/image_outline.hpp"
#include "tests/support/matchers.hpp"

namespace nav::registration {
namespace {

constexpr int kWidth = 120;
constexpr int kHeight = 100;
constexpr int kFrames = 4;

/// Images of 1 mm pixels whose values are grey(frame, position in mm).
Sweep painted(const std::function<int(int, Eigen::Vector2d)>& grey,
              const std::optional<SectorOutline>& outline = {}, int count = kFrames) {
  std::vector<TrackedImage> frames;
  for (int f = 0; f < count; ++f) {
    UltrasoundImage frame;
    frame.acquired = Timestamp(std::chrono::milliseconds(100 * f));
    frame.grid = PixelGrid::centred(kWidth, 1.0, 1.0);
    frame.outline = outline;
    std::vector<std::uint8_t> pixels;
    for (int row = 0; row < kHeight; ++row) {
      for (int column = 0; column < kWidth; ++column) {
        pixels.push_back(
            static_cast<std::uint8_t>(grey(f, frame.grid.at(column, row).mm.head<2>())));
      }
    }
    frame.pixels = Image2d<std::uint8_t>(kWidth, kHeight, std::move(pixels));
    const Transform<frames::Reference, frames::Image> pose(Eigen::Quaterniond::Identity(),
                                                           {0, 0, 5.0 * f});
    frames.push_back({std::move(frame), pose, Duration{0}});
  }
  return *Sweep::create(std::move(frames), "painted");
}

/// Value of the mask at a position in mm, for 1 mm pixels.
int at(const Image2d<std::uint8_t>& mask, double x, double y) {
  return mask.at(static_cast<int>(std::lround(x + 0.5 * (kWidth - 1))),
                 static_cast<int>(std::lround(y)));
}

TEST(ShadowMaskTest, KeepsAUniformImageBelowTheNearField) {
  const auto masks = shadow_masks(painted([](int, const Eigen::Vector2d&) { return 100; }), {});
  ASSERT_TRUE(test::has_value(masks));
  ASSERT_EQ(masks->size(), static_cast<std::size_t>(kFrames));
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      EXPECT_EQ((*masks)[0].at(column, row), row >= 10 ? 1 : 0) << column << ' ' << row;
    }
  }
}

TEST(ShadowMaskTest, LeavesOutPixelsThatAreBlackInEveryImage) {
  // A sector without an outline in the recording, and with a vessel inside.
  const auto sector = [](const Eigen::Vector2d& p) { return std::abs(p.x()) < 20 + 0.5 * p.y(); };
  const auto vessel = [](const Eigen::Vector2d& p) {
    return (p - Eigen::Vector2d(5, 40)).norm() < 4;
  };
  const auto masks = shadow_masks(
      painted([&](int, const Eigen::Vector2d& p) { return sector(p) && !vessel(p) ? 100 : 0; }),
      {});
  ASSERT_TRUE(test::has_value(masks));
  const auto& mask = masks->front();
  int outside = 0;
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      const Eigen::Vector2d p(column - 0.5 * (kWidth - 1), row);
      if (sector(p)) continue;
      ++outside;
      EXPECT_EQ(mask.at(column, row), 0) << column << ' ' << row;
    }
  }
  EXPECT_GT(outside, 1000);
  EXPECT_EQ(at(mask, 5, 40), 1) << "a vessel is no border";
  EXPECT_EQ(at(mask, -10, 60), 1);
}

TEST(ShadowMaskTest, CutsAShadowAndItsNeighboursInOneImageOnly) {
  // In image 1 a rib at a depth of 40 mm darkens |x| < 8 mm from there on.
  const auto masks = shadow_masks(painted([](int f, const Eigen::Vector2d& p) {
                                    const bool shadow =
                                        f == 1 && std::abs(p.x()) < 8 && p.y() >= 40;
                                    return shadow ? 5 : 100;
                                  }),
                                  {});
  ASSERT_TRUE(test::has_value(masks));
  const auto& mask = (*masks)[1];
  EXPECT_EQ(at(mask, 0, 30), 1);   // In front of the rib.
  EXPECT_EQ(at(mask, 0, 41), 0);   // Behind the rib.
  EXPECT_EQ(at(mask, 0, 90), 0);   // Far behind the rib.
  EXPECT_EQ(at(mask, 11, 60), 0);  // A neighbour within 4 lines.
  EXPECT_EQ(at(mask, 15, 60), 1);  // Beyond the neighbours.
  EXPECT_EQ(at((*masks)[0], 0, 60), 1);
}

TEST(ShadowMaskTest, BrightNoiseBelowTheUsualGreyIsStillShadow) {
  // The depth gain amplifies the noise floor: it is well above black and well below tissue.
  const auto masks = shadow_masks(painted([](int f, const Eigen::Vector2d& p) {
                                    const bool shadow = f == 2 && p.x() > 20 && p.y() >= 50;
                                    return shadow ? 60 : 120;
                                  }),
                                  {});
  ASSERT_TRUE(test::has_value(masks));
  EXPECT_EQ(at((*masks)[2], 40, 70), 0);
  EXPECT_EQ(at((*masks)[2], 0, 70), 1);
}

/// Grey noise of \p spread about 0 that is different at each pixel and in each image.
int noise_at(int f, const Eigen::Vector2d& p, double spread) {
  const auto column = static_cast<std::uint64_t>(std::lround(p.x() + 200));
  const auto row = static_cast<std::uint64_t>(std::lround(p.y()));
  double sum = 0;  // Four uniform numbers: nearly Gaussian, standard deviation 0.577.
  for (std::uint64_t k = 0; k < 4; ++k) {
    sum += fraction(4 * ((static_cast<std::uint64_t>(f) * 500 + column) * 500 + row) + k) - 0.5;
  }
  return static_cast<int>(std::lround(spread / 0.577 * sum));
}

/// Tissue whose grey varies over centimetres and from image to image, with speckle.
int tissue_at(int f, const Eigen::Vector2d& p) {
  return 125 + noise_at(f, p, 20) +
         static_cast<int>(
             std::lround(20 * std::sin(0.15 * p.x() + 1.3 * f) * std::cos(0.2 * p.y())));
}

/// The fraction of the mask that is usable in a rectangle in mm, limits included.
double usable_share(const Image2d<std::uint8_t>& mask, const Eigen::AlignedBox2d& box) {
  double usable = 0;
  double all = 0;
  for (double y = box.min().y(); y <= box.max().y(); ++y) {
    for (double x = box.min().x(); x <= box.max().x(); ++x) {
      usable += at(mask, x, y);
      ++all;
    }
  }
  return usable / all;
}

TEST(ShadowMaskTest, NoiseThatTheDepthGainLiftsIsNoEcho) {
  // Noise grows with depth: at the bottom it is as bright as tissue. In image 1 a rib at a depth of
  // 30 mm darkens the right side; below 80 mm all images show noise alone.
  const auto grey = [](int f, const Eigen::Vector2d& p) {
    const bool shadow = f == 1 && p.x() > 15 && p.y() >= 30;
    if (!shadow && p.y() < 80) return tissue_at(f, p);
    return static_cast<int>(15 + 1.15 * p.y()) + noise_at(f, p, 20);
  };
  const auto masks = shadow_masks(painted(grey, {}, 24), {});
  ASSERT_TRUE(test::has_value(masks));
  using Box = Eigen::AlignedBox2d;
  using Vec = Eigen::Vector2d;
  EXPECT_GT(usable_share((*masks)[1], Box(Vec(-50, 12), Vec(8, 70))), 0.95);
  EXPECT_LT(usable_share((*masks)[1], Box(Vec(20, 40), Vec(55, 99))), 0.02);
  EXPECT_GT(usable_share((*masks)[2], Box(Vec(-50, 12), Vec(50, 70))), 0.95);
  for (const auto& mask : *masks) {
    EXPECT_LT(usable_share(mask, Box(Vec(-50, 86), Vec(50, 99))), 0.02);
  }
}

TEST(ShadowMaskTest, TissueWithoutShadowsStaysUsable) {
  const auto masks =
      shadow_masks(painted([](int f, const Eigen::Vector2d& p) { return tissue_at(f, p); }), {});
  ASSERT_TRUE(test::has_value(masks));
  for (const auto& mask : *masks) {
    EXPECT_GT(usable_share(mask, {Eigen::Vector2d(-50, 12), Eigen::Vector2d(50, 96)}), 0.95);
  }
}

TEST(ShadowMaskTest, AVesselEndsNoLine) {
  const auto masks = shadow_masks(painted([](int f, const Eigen::Vector2d& p) {
                                    const bool blood = (p - Eigen::Vector2d(0, 40)).norm() < 10;
                                    return blood ? 3 : tissue_at(f, p);
                                  }),
                                  {});
  ASSERT_TRUE(test::has_value(masks));
  EXPECT_EQ(at((*masks)[0], 0, 40), 1);
  EXPECT_GT(usable_share((*masks)[0], {Eigen::Vector2d(-8, 55), Eigen::Vector2d(8, 95)}), 0.95);
}

TEST(ShadowMaskTest, FollowsTheScanLinesOfASector) {
  const SectorOutline outline{{0, -60}, 60, 150, 0.5};
  // A shadow in the direction of 0.3 rad, from a radius of 100 mm on.
  const auto masks = shadow_masks(painted(
                                      [&](int f, const Eigen::Vector2d& p) {
                                        if (!outline.contains(p)) return 0;
                                        const Eigen::Vector2d d = p - outline.apex_mm;
                                        const double angle = std::atan2(d.x(), d.y());
                                        const bool shadow = f == 0 && d.norm() >= 100 &&
                                                            std::abs(angle - 0.3) < 0.06;
                                        return shadow ? 10 : 110;
                                      },
                                      outline),
                                  {});
  ASSERT_TRUE(test::has_value(masks));
  const auto on_line = [&](double angle, double radius) {
    return at((*masks)[0], radius * std::sin(angle), radius * std::cos(angle) - 60);
  };
  EXPECT_EQ(on_line(0.3, 90), 1);
  EXPECT_EQ(on_line(0.3, 104), 0);
  EXPECT_EQ(on_line(0.3, 135), 0);
  EXPECT_EQ(on_line(-0.3, 135), 1);
  EXPECT_EQ(on_line(0.0, 66), 0);  // In the near field: within 10 mm of the face at a radius of 60
                                   // mm.
  EXPECT_EQ(at((*masks)[0], -59, 5), 0);  // Outside the sector.
}

TEST(ShadowMaskTest, BlackImagesHaveNoUsablePixels) {
  const auto masks = shadow_masks(painted([](int, const Eigen::Vector2d&) { return 0; }), {});
  ASSERT_TRUE(test::has_value(masks));
  for (const std::uint8_t value : (*masks)[0].pixels()) EXPECT_EQ(value, 0);
}

TEST(ShadowMaskTest, RejectsInvalidOptionsAndGeometry) {
  const Sweep sweep = painted([](int, const Eigen::Vector2d&) { return 100; });
  ShadowMaskOptions options;
  options.near_field_mm = std::nan("");
  EXPECT_TRUE(test::rejects(shadow_masks(sweep, options), ErrorCode::kUsage, {"near_field_mm"}));
  options = {};
  options.drop_grey = 0;
  EXPECT_TRUE(test::rejects(shadow_masks(sweep, options), ErrorCode::kUsage, {"drop_grey"}));
  const SectorOutline inverted{{0, -60}, 150, 60, 0.5};
  EXPECT_TRUE(test::rejects(
      shadow_masks(painted([](int, const Eigen::Vector2d&) { return 100; }, inverted), {}),
      ErrorCode::kMalformedData, {"image 0", "radius"}));
  // Depth bins and lines are one millimetre apart. These outlines would need 10^10 of them.
  for (const SectorOutline& far :
       {SectorOutline{{0, -60}, 60, 1e10, 0.5}, SectorOutline{{0, -1e10}, 1e10, 1e10 + 100, 1.0}}) {
    EXPECT_TRUE(test::rejects(
        shadow_masks(painted([](int, const Eigen::Vector2d&) { return 100; }, far), {}),
        ErrorCode::kMalformedData, {"image 0", "1000 mm deep", "radii in mm"}));
  }
  std::vector<TrackedImage> frames = sweep.frames();
  for (TrackedImage& tracked : frames) tracked.frame.grid.mm_per_pixel *= 100;
  EXPECT_TRUE(test::rejects(shadow_masks(*Sweep::create(std::move(frames), "metres"), {}),
                            ErrorCode::kMalformedData, {"image 0", "at most 1000 mm", "pixels"}));
}

TEST(ImageOutlineTest, FindsTheSectorOfARecordingWithoutOutline) {
  const SectorOutline truth{{2, -30}, 42, 118, 0.45};
  // With shadows, a vessel, and a lack of contact at one side of the face.
  const auto grey = [&](int f, const Eigen::Vector2d& p) {
    if (!truth.contains(p)) return 0;
    const Eigen::Vector2d d = p - truth.apex_mm;
    if (std::atan2(d.x(), d.y()) < -0.38 && d.norm() < 50) return 0;
    if ((p - Eigen::Vector2d(5, 40)).norm() < 6) return 0;
    return f == 1 && p.x() > 10 ? 0 : 90;
  };
  const auto found = sector_of(painted(grey));
  ASSERT_TRUE(found.has_value());
  // Half a pixel at the edge rotates a side of 60 mm by half a degree.
  EXPECT_LE((found->apex_mm - truth.apex_mm).norm(), 1.5);
  EXPECT_NEAR(found->half_angle_rad, truth.half_angle_rad, 0.015);
  EXPECT_NEAR(found->apex_mm.y() + found->radius_min_mm, truth.apex_mm.y() + 42, 1);
  EXPECT_NEAR(found->apex_mm.y() + found->radius_max_mm, truth.apex_mm.y() + 118, 1);
  EXPECT_EQ(with_outline(painted(grey)).frames().back().frame.outline->half_angle_rad,
            found->half_angle_rad);
}

TEST(ImageOutlineTest, ALinearProbeOrABlackSweepHasNoSector) {
  const auto none = [](const std::function<int(int, Eigen::Vector2d)>& grey) {
    return !sector_of(painted(grey)).has_value();
  };
  EXPECT_TRUE(none([](int, const Eigen::Vector2d&) { return 80; }));
  EXPECT_TRUE(none([](int, const Eigen::Vector2d& p) { return std::abs(p.x()) < 30 ? 80 : 0; }));
  EXPECT_TRUE(none([](int, const Eigen::Vector2d&) { return 0; }));
  // A shadow over one side of a rectangle is no sector either.
  EXPECT_TRUE(
      none([](int, const Eigen::Vector2d& p) { return p.x() > 0.6 * p.y() - 50 ? 80 : 0; }));
}

TEST(ImageOutlineTest, KeepsAnOutlineFromTheRecording) {
  const SectorOutline own{{0, -20}, 25, 100, 0.3};
  const auto sweep = with_outline(painted([](int, const Eigen::Vector2d&) { return 80; }, own));
  EXPECT_EQ(sweep.frames().front().frame.outline->radius_max_mm, 100);
}

}  // namespace
}  // namespace nav::registration
