// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/bone/bone_registration.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <gtest/gtest.h>

#include "registration/bone/ct_bone.hpp"
#include "registration/twist.hpp"
#include "tests/support/matchers.hpp"

namespace nav::registration {
namespace {

using Pose = Transform<frames::Ct, frames::Reference>;
using Spot = Eigen::Vector3d;

constexpr double kVoxelMm = 1;

/// Distance to a made bone along z, mm, negative inside: a shaft that is not round, and, with a
/// joint, two condyles of unlike size and a knob.
struct MadeBone {
  bool joint = true;
  bool mirrored = false;
  [[nodiscard]] double operator()(Spot p) const {
    if (mirrored) p.x() = -p.x();
    const double angle = std::atan2(p.y(), p.x()) - 0.01 * p.z();
    double d = p.head<2>().norm() - 9 - 1.2 * std::cos(3 * angle);
    if (!joint) return d;
    d = std::max(d, p.z() - 40);
    d = std::min(d, (p - Spot(-9, -2, 36)).norm() - 14);
    d = std::min(d, (p - Spot(9, 3, 38)).norm() - 10);
    return std::min(d, (p - Spot(10, -5, 8)).norm() - 6);
  }
};

/// A CT of it: cortex about marrow in soft tissue, over a millimetre of partial volume.
Volume ct_of(const MadeBone& bone) {
  VoxelGrid grid;
  grid.size = {71, 71, 121};
  grid.origin_mm = {-35, -35, -60};
  grid.spacing_mm.setConstant(kVoxelMm);
  std::vector<std::int16_t> hu;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const double d = bone(grid.at({1.0 * i, 1.0 * j, 1.0 * k}).mm);
        const double cortex = std::clamp(0.5 - d, 0.0, 1.0);
        const double marrow = std::clamp(0.5 - d - 3, 0.0, 1.0);
        hu.push_back(static_cast<std::int16_t>(50 + 1150 * cortex - 1120 * marrow));
      }
    }
  }
  return *Volume::create(grid, std::move(hu), "made bone");
}

Shape surface_of(const MadeBone& bone) {
  const Volume ct = ct_of(bone);
  const auto shape =
      bone_surface(ct, *bone_threshold_hu(ct), {Spot::Constant(-1e3), Spot::Constant(1e3)});
  EXPECT_TRUE(test::has_value(shape));
  return *shape;
}

const Pose kTruth(Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Spot(1, 2, -1).normalized())),
                  {20, -30, 10});

/// Images across the bone from z0 to z1 mm, and where their lines meet it: exact, and on the side
/// that faces the probe, which comes from -y.
struct Scanned {
  Sweep sweep;
  BoneOfSweep bone;
};
Scanned scan(const MadeBone& bone, double z0, double z1) {
  std::vector<TrackedImage> frames;
  BoneOfSweep found{{}, 77};
  for (int f = 0; f < 30; ++f) {
    const double s = f / 29.0;
    const double angle = 0.6 * std::sin(6 * s);
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, Spot::UnitZ()));
    const Transform<frames::Ct, frames::Image> view(
        turn, turn * Spot(0, -35, 0) + Spot(0, 0, z0 + (z1 - z0) * s));
    UltrasoundImage frame;
    frame.acquired = Timestamp(std::chrono::milliseconds(50 * f));
    frame.grid = PixelGrid::centred(4, 10, 10);
    frame.pixels = Image2d<std::uint8_t>(4, 4, std::vector<std::uint8_t>(16, 0));
    frames.push_back({frame, kTruth.inverse() * view, Duration{0}});
    BoneSurface surface;
    for (int line = 0; line < 77; ++line) {
      const double x = 0.5 * (line - 38);
      for (double y = 0; y < 60; y += 0.05) {
        if (bone((view * Point<frames::Image>{{x, y, 0}}).mm) > 0) continue;
        surface.push_back({line, {x, y}, {0, 1}, 0.9});
        break;
      }
    }
    found.images.push_back(std::move(surface));
  }
  return {*Sweep::create(std::move(frames), "made"), std::move(found)};
}

Pose displaced(double mm, double rad) {
  Vector6d twist;
  twist << rad * Spot(1, -1, 2).normalized(), mm * Spot(2, 1, -2).normalized();
  return moved(kTruth, {0, 0, 10}, twist);
}

/// RMS distance of the echoes from where they belong, mm.
double error_mm(const Scanned& scanned, const Pose& found) {
  double squares = 0;
  const auto points = bone_points(scanned.bone, scanned.sweep, 0);
  for (const BonePoint& one : points) {
    squares += ((found * one.at).mm - (kTruth * one.at).mm).squaredNorm();
  }
  return std::sqrt(squares / static_cast<double>(points.size()));
}

TEST(CtBoneTest, TheSurfaceLiesWithinAFractionOfAVoxelAndLeavesOutMarrow) {
  const MadeBone bone;
  const Volume ct = ct_of(bone);
  const auto threshold = bone_threshold_hu(ct);
  ASSERT_TRUE(threshold.has_value());
  EXPECT_NEAR(*threshold, 600, 100);  // Half way from 50 to 1200 HU.
  double squares = 0;
  const Shape shape = surface_of(bone);
  ASSERT_GT(shape.elements.size(), 3000U);
  for (const ShapeElement& one : shape.elements) {
    const double d = bone(one.point_mm);
    EXPECT_LT(std::abs(d), 1.2);  // The inner wall lies 3 mm deep.
    squares += d * d;
    EXPECT_GT(bone(one.point_mm + 1.5 * one.axis), d);
  }
  EXPECT_LT(std::sqrt(squares / static_cast<double>(shape.elements.size())), 0.2 * kVoxelMm);
}

TEST(CtBoneTest, SoftTissueHasNoBone) {
  VoxelGrid grid;
  grid.size = {20, 20, 20};
  const auto ct = Volume::create(grid, std::vector<std::int16_t>(8000, 60), "soft");
  ASSERT_TRUE(test::has_value(ct));
  EXPECT_FALSE(bone_threshold_hu(*ct).has_value());
}

TEST(BoneRegistrationTest, AJointDeterminesThePose) {
  const MadeBone bone;
  const Scanned scanned = scan(bone, -35, 50);
  const auto result =
      register_bone(scanned.bone, scanned.sweep, surface_of(bone), displaced(15, 0.17));
  ASSERT_TRUE(test::has_value(result));
  EXPECT_LT(error_mm(scanned, result->shape.ct_from_reference), 0.5);
  EXPECT_TRUE(result->shape.sliding.empty());
  // Bone alone does not tell level and patient.
  const auto said = [](const Decision& decision) {
    return std::ranges::any_of(decision.warnings, [](const std::string& one) {
      return one.find("level and patient") != std::string::npos;
    });
  };
  const Point<frames::Ct> target = result->shape.uncertainty.centre_ct;
  const Decision alone = decide(*result, {}, target);
  EXPECT_TRUE(alone.accepted);
  EXPECT_TRUE(said(alone));
  const KnownPose known{kTruth, 5, true};
  const Decision confirmed = decide(*result, {}, target, known);
  EXPECT_TRUE(confirmed.accepted);
  EXPECT_FALSE(said(confirmed));
}

TEST(BoneRegistrationTest, TheShaftAloneSlidesAndSaysWhatToShow) {
  const MadeBone bone{.joint = false};
  const Scanned scanned = scan(bone, -30, 20);
  const auto result =
      register_bone(scanned.bone, scanned.sweep, surface_of(bone), displaced(8, 0.1));
  ASSERT_TRUE(test::has_value(result));
  const auto decision = decide(*result, {}, result->shape.uncertainty.centre_ct);
  EXPECT_FALSE(decision.accepted);
  ASSERT_FALSE(result->shape.sliding.empty());
  bool told = false;
  for (const std::string& one : decision.reasons) {
    told = told || one.find("show an end or a joint") != std::string::npos;
  }
  EXPECT_TRUE(told);
}

TEST(BoneRegistrationTest, TheOtherSideIsRejected) {
  const Scanned scanned = scan({}, -35, 50);
  const auto result =
      register_bone(scanned.bone, scanned.sweep, surface_of({.joint = true, .mirrored = true}),
                    displaced(5, 0.05));
  ASSERT_TRUE(test::has_value(result));
  EXPECT_FALSE(decide(*result, {}, result->shape.uncertainty.centre_ct).accepted);
}

TEST(BoneRegistrationTest, TooFewEchoesSaySo) {
  Scanned scanned = scan({}, -35, 50);
  for (BoneSurface& image : scanned.bone.images) image.clear();
  const auto result = register_bone(scanned.bone, scanned.sweep, surface_of({}), kTruth);
  ASSERT_FALSE(result.has_value());
  EXPECT_EQ(result.error().code, ErrorCode::kRefused);
  EXPECT_EQ(result.error().message,
            "bone: expected at least 20 scan lines that meet bone, found 0: show more of the bone");
}

}  // namespace
}  // namespace nav::registration
