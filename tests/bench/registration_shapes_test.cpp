// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "bench/registration/shape_cohort.hpp"
#include "tests/support/matchers.hpp"

namespace nav::bench {
namespace {

TEST(RegistrationShapesTest, AcceptsNoWrongBoneOfASeededFew) {
  int right = 0;
  for (const BoneKind kind :
       {BoneKind::kLongBone, BoneKind::kVertebra, BoneKind::kPelvis, BoneKind::kHemipelvis}) {
    for (const BoneCase bone_case :
         {BoneCase::kRight, BoneCase::kOtherSide, BoneCase::kTurned, BoneCase::kScaled}) {
      if (bone_case == BoneCase::kOtherSide && !BoneModel(kind, 7).has_sides()) continue;
      const auto trial = run_bone(kind, bone_case, 7, 3);
      ASSERT_TRUE(test::has_value(trial));
      EXPECT_FALSE(trial->false_accept) << to_string(kind) << ", " << to_string(bone_case);
      EXPECT_EQ(trial->accepted, trial->reasons.empty());
      if (bone_case == BoneCase::kRight && trial->accepted) {
        EXPECT_LT(trial->error_mm, 2) << to_string(kind);
        ++right;
      }
    }
  }
  EXPECT_GE(right, 2);
}

TEST(RegistrationShapesTest, TheTableCountsWhatHappened) {
  auto trial = run_bone(BoneKind::kPelvis, BoneCase::kTurned, 7, 3);
  ASSERT_TRUE(test::has_value(trial));
  trial->accepted = true;
  trial->false_accept = true;
  const auto counts = count_bones({*trial, *trial});
  ASSERT_EQ(counts.size(), 1u);
  EXPECT_EQ(counts[0].runs, 2);
  EXPECT_EQ(counts[0].false_accepts, 2);
  EXPECT_NE(to_text({*trial}).find("1 runs, 1 accepted, 1 of them wrong"), std::string::npos);
}

TEST(RegistrationShapesTest, BonesOfTheMidlineAreSymmetricAndOthersAreNot) {
  for (int k = 0; k < kBoneKinds; ++k) {
    const BoneModel bone(static_cast<BoneKind>(k), 5);
    const BoneModel other = bone.mirrored();
    EXPECT_EQ(other.at(0.2, 0.7).x(), -bone.at(0.2, 0.7).x());
    if (bone.has_sides()) continue;
    // Longitudes that are mirror images of each other.
    const Eigen::Vector3d here = bone.at(0.1, 0.6);
    const Eigen::Vector3d there = bone.at(0.4, 0.6);
    EXPECT_NEAR(here.x(), -there.x(), 1.2) << to_string(bone.kind());
    EXPECT_NEAR(here.y(), there.y(), 1.2);
  }
}

}  // namespace
}  // namespace nav::bench
