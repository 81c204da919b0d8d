// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/similarity/sound_shift.hpp"

#include <gtest/gtest.h>

namespace nav::registration {
namespace {

using Vec = Eigen::Vector3d;

constexpr double kAssumed = 1540;

/// Channels of 2 mm texels, unsmoothed: HU by the depth along +y, from y = 0 on.
CtChannels layers(double (*hu_at_mm)(double)) {
  CtChannels ct;
  ct.size = {10, 80, 10};
  ct.spacing_mm = Vec::Constant(2);
  ct.origin_ct_mm = Vec(-9, 1, -9);  // Texels are centred between the layers' borders.
  ct.directions = Eigen::Matrix3d::Identity();
  ct.texels.resize(std::size_t{10} * 80 * 10);
  for (std::size_t i = 0; i < ct.texels.size(); ++i) {
    const double y = 1 + 2 * static_cast<double>(i / 10 % 80);
    ct.texels[i] = {static_cast<float>(hu_at_mm(y)) / kHuPerUnit, 0, 0, 0};
  }
  return ct;
}

const Transform<frames::Ct, frames::Reference> kHere(Eigen::Quaterniond::Identity(), Vec::Zero());

/// Patches straight below (0, 0, 0), shown at these depths.
PatchSet patches_at(std::initializer_list<double> depths_mm) {
  PatchSet set;
  for (const double depth : depths_mm) {
    Patch patch{};
    patch.centre_mm = Vec(0, depth, 0);
    patch.beam = Vec::UnitY();
    patch.depth_mm = depth;
    patch.index = set.patches.size();
    set.patches.push_back(patch);
  }
  return set;
}

TEST(SoundShiftTest, SpeedsAreThoseOfTheLiterature) {
  // Duck 1990: fat 1450, water at body temperature 1524, liver and muscle 1570 to 1590 m/s.
  EXPECT_NEAR(sound_speed_at(-100), 1440, 15);
  EXPECT_NEAR(sound_speed_at(0), 1527, 10);
  EXPECT_NEAR(sound_speed_at(50), 1580, 10);
  // Contrast agent changes HU alone.
  EXPECT_EQ(sound_speed_at(55), sound_speed_at(160));
}

TEST(SoundShiftTest, EchoesAreShownByTheTimeOfTheirTravel) {
  // 20 mm of fat over liver.
  const CtChannels ct = layers([](double y) { return y < 20 ? -100.0 : 55.0; });
  const double fat = kAssumed / sound_speed_at(-100), liver = kAssumed / sound_speed_at(55);
  const double bottom = 20 * fat;  // Depth at which the lower side of the fat is shown.
  const auto shifts = sound_shifts_mm(ct, patches_at({10, bottom, 100}), kHere);
  ASSERT_EQ(shifts.size(), 3U);
  EXPECT_NEAR(shifts[0], 10 - 10 / fat, 1e-4);
  EXPECT_NEAR(shifts[1], bottom - 20, 1e-4);
  EXPECT_NEAR(shifts[2], 100 - (20 + (100 - bottom) / liver), 1e-4);
  EXPECT_GT(shifts[1], 1);     // Fat shows what lies below it too deep,
  EXPECT_LT(shifts[2], -0.5);  // and 80 mm of liver more than make up for it.
}

TEST(SoundShiftTest, AirBoneAndWhatIsOutsideTheCtCountAsAssumed) {
  for (const auto hu : {+[](double) { return -1000.0; }, +[](double) { return 250.0; }}) {
    for (const float shift : sound_shifts_mm(layers(hu), patches_at({30, 100}), kHere)) {
      EXPECT_NEAR(shift, 0, 1e-5);
    }
  }
  // Another pose: the CT is 500 mm away.
  const Transform<frames::Ct, frames::Reference> far(Eigen::Quaterniond::Identity(), {500, 0, 0});
  const auto shifts =
      sound_shifts_mm(layers([](double) { return 50.0; }), patches_at({30, 100}), far);
  for (const float shift : shifts) EXPECT_NEAR(shift, 0, 1e-5);
}

}  // namespace
}  // namespace nav::registration
