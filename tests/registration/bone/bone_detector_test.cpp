// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/bone/bone_detector.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <gtest/gtest.h>

#include "registration/counter_random.hpp"
#include "tests/support/matchers.hpp"

namespace nav::registration {
namespace {

constexpr int kBoneWidth = 200;
constexpr int kBoneHeight = 240;
constexpr double kBonePixelMm = 0.2;
constexpr double kEchoMm = 0.4;  // Standard deviation of the painted echo.

/// Speckle: 0 to 1, the same for the same pixel and image.
double speckle(int image, const Eigen::Vector2d& p) {
  const auto x = static_cast<std::uint64_t>(std::lround(10 * p.x() + 5000));
  const auto y = static_cast<std::uint64_t>(std::lround(10 * p.y()));
  return fraction((static_cast<std::uint64_t>(image) * 20000 + x) * 20000 + y);
}

using Painter = std::function<double(int image, const Eigen::Vector2d& p)>;

Sweep bone_images(const Painter& grey, const std::optional<SectorOutline>& outline = {}) {
  std::vector<TrackedImage> frames;
  for (int f = 0; f < 6; ++f) {
    UltrasoundImage frame;
    frame.acquired = Timestamp(std::chrono::milliseconds(100 * f));
    frame.grid = PixelGrid::centred(kBoneWidth, kBonePixelMm, kBonePixelMm);
    frame.outline = outline;
    std::vector<std::uint8_t> pixels;
    for (int row = 0; row < kBoneHeight; ++row) {
      for (int column = 0; column < kBoneWidth; ++column) {
        const Eigen::Vector2d p = frame.grid.at(column, row).mm.head<2>();
        const bool inside = !outline || outline->contains(p);
        pixels.push_back(
            static_cast<std::uint8_t>(inside ? std::clamp(grey(f, p), 0.0, 255.0) : 0.0));
      }
    }
    frame.pixels = Image2d<std::uint8_t>(kBoneWidth, kBoneHeight, std::move(pixels));
    frames.push_back({std::move(frame),
                      Transform<frames::Reference, frames::Image>(Eigen::Quaterniond::Identity(),
                                                                  {0, 0, 3.0 * f}),
                      Duration{0}});
  }
  return *Sweep::create(std::move(frames), "painted bone");
}

double tissue(int image, const Eigen::Vector2d& p) { return 70 + 50 * speckle(image, p); }
double echo(double from_surface_mm) {
  return 220 * std::exp(-0.5 * std::pow(from_surface_mm / kEchoMm, 2));
}
double round_bone_mm(double x) { return 18 + 0.02 * x * x; }

/// Tissue over a round bone between -10 and 10 mm; the shadow holds what shadow() says.
Painter bone_with_shadow(const Painter& shadow) {
  return [=](int image, const Eigen::Vector2d& p) {
    if (std::abs(p.x()) > 10) return tissue(image, p);
    const double below = p.y() - round_bone_mm(p.x());
    // Grey is logarithmic: the stronger echo shows.
    return std::max(below > 0 ? shadow(image, p) : tissue(image, p), echo(below));
  };
}

TEST(BoneDetectorTest, FindsASurfaceFinerThanAPixel) {
  const auto bone = bone_of_sweep(bone_images(
      bone_with_shadow([](int image, const Eigen::Vector2d& p) { return 6 * speckle(image, p); })));
  ASSERT_TRUE(test::has_value(bone));
  ASSERT_EQ(bone->images.size(), 6U);
  for (const BoneSurface& image : bone->images) {
    EXPECT_GE(image.size(), 36U);  // 41 lines of 0.5 mm meet it.
    double squares = 0;
    for (const BoneEcho& one : image) {
      EXPECT_LE(std::abs(one.at_mm.x()), 11);
      EXPECT_GE(one.confidence, 0.5);
      EXPECT_EQ(one.along, Eigen::Vector2d(0, 1));
      squares += std::pow(one.at_mm.y() - round_bone_mm(one.at_mm.x()), 2);
    }
    // Half a pixel.
    EXPECT_LT(std::sqrt(squares / static_cast<double>(image.size())), 0.1);
  }
}

TEST(BoneDetectorTest, FindsNoBoneWhereNothingCastsAShadow) {
  const auto bone = bone_of_sweep(bone_images(bone_with_shadow(tissue)));
  ASSERT_TRUE(test::has_value(bone));
  EXPECT_EQ(bone->share(), 0);
}

TEST(BoneDetectorTest, FindsNoBoneInAShadowWithoutARidge) {
  const auto bone = bone_of_sweep(bone_images([](int image, const Eigen::Vector2d& p) {
    const double dark = std::clamp((p.y() - 15) / 12, 0.0, 1.0);
    return tissue(image, p) * (std::abs(p.x()) < 10 ? 1 - 0.95 * dark : 1);
  }));
  ASSERT_TRUE(test::has_value(bone));
  EXPECT_EQ(bone->share(), 0);
}

TEST(BoneDetectorTest, FindsNoBoneAtTheWallOfAVessel) {
  const auto bone = bone_of_sweep(bone_images([](int image, const Eigen::Vector2d& p) {
    const double from_wall = (p - Eigen::Vector2d(0, 20)).norm() - 5;
    return std::max(from_wall < 0 ? 2 : tissue(image, p), echo(from_wall));
  }));
  ASSERT_TRUE(test::has_value(bone));
  EXPECT_EQ(bone->share(), 0);
}

TEST(BoneDetectorTest, NoiseThatTheDepthGainLiftsDoesNotHideAShadow) {
  const auto noise = [](int image, const Eigen::Vector2d& p) {
    return speckle(image + 50, p) * std::max(2 * (p.y() - 10), 5.0);
  };
  const auto bone = bone_of_sweep(bone_images(bone_with_shadow(noise)));
  ASSERT_TRUE(test::has_value(bone));
  for (const BoneSurface& image : bone->images) {
    EXPECT_GE(image.size(), 30U);
    for (const BoneEcho& one : image) {
      EXPECT_NEAR(one.at_mm.y(), round_bone_mm(one.at_mm.x()), 0.5);
    }
  }
}

TEST(BoneDetectorTest, TheSecondEchoOfABoneIsNoBone) {
  const auto ghost = [](int image, const Eigen::Vector2d& p) {
    return std::max(25 * speckle(image, p), 0.6 * echo(p.y() - 2 * round_bone_mm(p.x())));
  };
  const auto bone = bone_of_sweep(bone_images(bone_with_shadow(ghost)));
  ASSERT_TRUE(test::has_value(bone));
  for (const BoneSurface& image : bone->images) {
    for (const BoneEcho& one : image) EXPECT_LT(one.at_mm.y(), 25);
  }
}

TEST(BoneDetectorTest, FollowsTheLinesOfASector) {
  const SectorOutline outline{{0, -20}, 20, 66, 0.35};
  // A ring about the apex: every line meets it at a right angle.
  const auto bone = bone_of_sweep(bone_images(
      [&](int image, const Eigen::Vector2d& p) {
        const double below = (p - outline.apex_mm).norm() - 42;
        return std::max(below > 0 ? 5 * speckle(image, p) : tissue(image, p), echo(below));
      },
      outline));
  ASSERT_TRUE(test::has_value(bone));
  EXPECT_GT(bone->share(), 0.8);
  for (const BoneSurface& image : bone->images) {
    for (const BoneEcho& one : image) {
      const Eigen::Vector2d from_apex = one.at_mm - outline.apex_mm;
      EXPECT_NEAR(from_apex.norm(), 42, 0.3);
      EXPECT_NEAR(one.along.dot(from_apex.normalized()), 1, 1e-9);
    }
  }
}

TEST(BoneDetectorTest, TheResultDoesNotDependOnTheThreads) {
  const Sweep sweep = bone_images(
      bone_with_shadow([](int image, const Eigen::Vector2d& p) { return 20 * speckle(image, p); }));
  const auto one = bone_of_sweep(sweep, {}, 1);
  const auto two = bone_of_sweep(sweep, {}, 2);
  ASSERT_TRUE(test::has_value(one));
  ASSERT_TRUE(test::has_value(two));
  for (std::size_t i = 0; i < one->images.size(); ++i) {
    ASSERT_EQ(one->images[i].size(), two->images[i].size());
    for (std::size_t k = 0; k < one->images[i].size(); ++k) {
      EXPECT_EQ(one->images[i][k].at_mm, two->images[i][k].at_mm);
      EXPECT_EQ(one->images[i][k].confidence, two->images[i][k].confidence);
    }
  }
}

TEST(BoneDetectorTest, BlackAndNoisyImagesHaveNoBone) {
  const auto black = bone_of_sweep(bone_images([](int, const Eigen::Vector2d&) { return 0.0; }));
  ASSERT_TRUE(test::has_value(black));
  EXPECT_EQ(black->share(), 0);
  const auto noise = bone_of_sweep(
      bone_images([](int image, const Eigen::Vector2d& p) { return 255 * speckle(image, p); }));
  ASSERT_TRUE(test::has_value(noise));
  EXPECT_LT(noise->share(), 0.01);
}

TEST(BoneDetectorTest, RejectsOptionsOutOfRangeByTheirNames) {
  const Sweep sweep = bone_images([](int, const Eigen::Vector2d&) { return 0.0; });
  BoneDetectorOptions options;
  options.least_shadow_mm = 9;
  const auto bone = BoneDetector::create(sweep, options);
  ASSERT_FALSE(bone.has_value());
  EXPECT_EQ(bone.error().code, ErrorCode::kUsage);
  EXPECT_EQ(bone.error().message, "least_shadow_mm: expected 1 to shadow_mm, found 9");
}

}  // namespace
}  // namespace nav::registration
