// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/transfer/vessel_fit.hpp"

#include <cmath>
#include <gtest/gtest.h>

#include "render/transfer/transfer_presets.hpp"
#include "tests/render/scene_support.hpp"
#include "tests/support/matchers.hpp"

namespace nav::render {
namespace {

constexpr int kPlantedSide = 64;  // Voxels of 1.5 mm.
constexpr int kPlantedBloodHu = 300;
constexpr int kPlantedTissueHu = 60;
constexpr int kPlantedMarrowHu = 280;
constexpr int kPlantedCortexHu = 900;

/// Noise of +-15 HU that does not repeat.
int planted_noise(int i, int j, int k) { return (i * 7919 + j * 104729 + k * 1299709) % 31 - 15; }

/// Distance from the axis of a tube along k, voxels.
double from_axis(int i, int j, double x, double y) { return std::hypot(i - x, j - y); }
bool in_vessel(int i, int j, int) { return from_axis(i, j, 18, 32) < 7; }
bool in_bone(int i, int j, int) { return from_axis(i, j, 44, 32) < 10; }
bool in_cortex(int i, int j, int k) { return in_bone(i, j, k) && from_axis(i, j, 44, 32) >= 7.5; }
bool in_fragment(int i, int j, int k) {
  return std::abs(i - 30) < 2 && std::abs(j - 10) < 2 && std::abs(k - 30) < 2;
}

/// Tissue with a vessel, a long bone whose marrow has the values of blood, and a fragment; air
/// around it.
std::shared_ptr<const Volume> planted_ct(int blood_hu) {
  return std::make_shared<const Volume>(*test::make_volume(
      test::centred_grid({kPlantedSide, kPlantedSide, kPlantedSide}, {1.5, 1.5, 1.5}),
      [&](int i, int j, int k) {
        if (std::min(i, j) < 4 || std::max(i, j) > kPlantedSide - 5) return -1000;
        if (in_cortex(i, j, k)) return kPlantedCortexHu;
        if (in_bone(i, j, k)) return kPlantedMarrowHu + planted_noise(i, j, k);
        if (in_vessel(i, j, k) || in_fragment(i, j, k)) return blood_hu + planted_noise(i, j, k);
        return kPlantedTissueHu + planted_noise(i, j, k);
      }));
}

TEST(BloodPoolTest, IsFoundInAPlantedHistogram) {
  for (const int blood : {180, 300, 450}) {
    const auto pool = find_blood_pool(*planted_ct(blood));
    ASSERT_TRUE(test::has_value(pool)) << blood;
    EXPECT_NEAR(pool->mean_hu, blood, 5) << "not the marrow, which bone encloses";
    EXPECT_NEAR(pool->tissue_hu, kPlantedTissueHu, 5);
    EXPECT_LT(pool->sigma_hu, 25);
    const VesselWindow window = vessel_window(*pool);
    EXPECT_GT(window.zero_below, kPlantedTissueHu + 15) << "noise of tissue is no vessel";
    EXPECT_LT(window.full_from, blood - 15);
    EXPECT_GT(window.full_to, blood + 15);
  }
}

TEST(BloodPoolTest, IsNotFoundWithoutContrastAgent) {
  EXPECT_TRUE(test::rejects(find_blood_pool(*planted_ct(kPlantedTissueHu)), ErrorCode::kNotFound,
                            {"contrast-filled blood", "found none"}));
}

TEST(BloodPoolTest, IsTakenAtAGivenPoint) {
  const auto ct = planted_ct(kPlantedBloodHu);
  const auto pool = blood_pool_at(*ct, ct->grid().at({18, 32, 30}));
  ASSERT_TRUE(test::has_value(pool));
  EXPECT_NEAR(pool->mean_hu, kPlantedBloodHu, 6);
  EXPECT_TRUE(test::rejects(blood_pool_at(*ct, ct->grid().at({30, 50, 30})), ErrorCode::kUsage,
                            {"blood at", "130 to 1500 HU"}));
  EXPECT_TRUE(
      test::rejects(blood_pool_at(*ct, {{1e4, 0, 0}}), ErrorCode::kUsage, {"inside the CT"}));
  EXPECT_TRUE(test::rejects(blood_pool_at(*ct, {{std::nan(""), 0, 0}}), ErrorCode::kUsage, {}));
}

TEST(VesselClassesTest, TellVesselsFromBoneMarrowAndFragments) {
  const auto ct = planted_ct(kPlantedBloodHu);
  const VesselWindow window = vessel_window(*find_blood_pool(*ct));
  const VesselClasses classes = classify_vessels(*ct, window);
  int wrong = 0;
  std::size_t at = 0;
  for (int k = 0; k < kPlantedSide; ++k) {
    for (int j = 0; j < kPlantedSide; ++j) {
      for (int i = 0; i < kPlantedSide; ++i, ++at) {
        VesselClass expected = VesselClass::kRest;
        if (in_vessel(i, j, k)) expected = VesselClass::kVessel;
        if (in_bone(i, j, k)) expected = VesselClass::kBone;
        if (in_fragment(i, j, k)) expected = VesselClass::kFragment;
        if (classes.voxels[at] != expected) ++wrong;
      }
    }
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_NEAR(classes.fragment_ml, 27 * 1.5 * 1.5 * 1.5 / 1000, 1e-9);
  EXPECT_EQ(classify_vessels(*ct, window, 0).fragment_ml, 0) << "every part is large enough";
}

TEST(SeparatedVesselsTest, ChangeOnlyBoneItsRimAndFragments) {
  const auto ct = planted_ct(kPlantedBloodHu);
  const VesselWindow window = vessel_window(*find_blood_pool(*ct));
  const auto classes = classify_vessels(*ct, window);
  const auto preset = *preset_transfer_function("cta-vessels");
  const auto fitted = *with_vessel_window(preset, window, "vessels", "organs");
  const auto separated = separate_vessels(*ct, classes, window, fitted, "vessels");
  ASSERT_TRUE(test::has_value(separated));
  const auto& drawn = separated->transfer;
  for (std::size_t i = 0; i < classes.voxels.size(); ++i) {
    const int before = ct->values()[i];
    const int after = separated->ct->values()[i];
    if (classes.voxels[i] == VesselClass::kVessel) {
      EXPECT_EQ(after, before);
    } else if (classes.voxels[i] == VesselClass::kBone) {
      EXPECT_EQ(after, before + kSeparationHu);
    } else if (classes.voxels[i] == VesselClass::kRest) {
      EXPECT_TRUE(after == before || after == before + kSeparationHu);
    }
  }
  // Bone looks as before in its own values; marrow with the values of blood is no vessel there.
  const auto bone_alone = [&](double hu) {
    double tau = 0;
    for (const auto& component : fitted.components()) {
      if (component.name == "vessels") continue;
      tau = std::max(tau, TransferFunction::blend("one", {component})->at(hu).tau_per_mm);
    }
    return tau;
  };
  for (const double hu : {-500.0, 60.0, 280.0, 600.0, 900.0, 1500.0}) {
    EXPECT_NEAR(drawn.at(hu + kSeparationHu).tau_per_mm, bone_alone(hu), 1e-12) << hu;
  }
  EXPECT_GT(drawn.at(kPlantedBloodHu).tau_per_mm, 0.2);
  EXPECT_EQ(drawn.at(kPlantedBloodHu).importance, 1);
  EXPECT_EQ(drawn.at(5000).tau_per_mm, 0) << "nothing lies between the two ranges";
}

}  // namespace
}  // namespace nav::render
