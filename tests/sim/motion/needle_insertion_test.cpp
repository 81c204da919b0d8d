// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/motion/needle_insertion.hpp"

#include <gmock/gmock.h>

namespace nav::sim {
namespace {

using ::testing::HasSubstr;
using Vec = Eigen::Vector3d;

constexpr Timestamp kBegin{std::chrono::seconds(1)};
constexpr Timestamp kEnd{std::chrono::seconds(5)};

/// A path of 60 mm that is parallel to no axis.
NeedlePlan plan() { return {{{10, -120, 30}}, {{30, -80, 70}}, 0, 0}; }

NeedleInsertionOptions with(BendingKind kind) {
  NeedleInsertionOptions options;
  options.bending.kind = kind;
  options.bending.bevel_rad = 0.4;
  return options;
}

NeedleInsertion make(const NeedleInsertionOptions& options) {
  auto insertion = NeedleInsertion::create(plan(), options, kBegin, kEnd);
  EXPECT_TRUE(insertion) << insertion.error().message;
  return *insertion;
}

TEST(NeedleInsertionTest, MovesFromTheSkinToTheTargetAtConstantSpeed) {
  const auto needle = make(with(BendingKind::kStraight));
  EXPECT_DOUBLE_EQ(needle.speed_mm_s(), 15);
  EXPECT_EQ(needle.inserted_mm(Timestamp{}), 0);
  EXPECT_NEAR(needle.inserted_mm(kBegin + std::chrono::seconds(3)), 45, 1e-9);
  EXPECT_EQ(needle.inserted_mm(kEnd + std::chrono::seconds(9)), 60);
  EXPECT_LE((needle.truth(kBegin).tip_ct.mm - plan().entry_ct.mm).norm(), 1e-12);
  const auto middle = needle.truth(kBegin + std::chrono::seconds(1));
  EXPECT_LE((middle.tip_ct.mm - (plan().entry_ct.mm + Vec(5, 10, 10))).norm(), 1e-9);
  EXPECT_LE((needle.truth(kEnd).tip_ct.mm - plan().target_ct.mm).norm(), 1e-9);
  NeedleInsertionOptions fast = with(BendingKind::kStraight);
  fast.speed_mm_s = 40;
  EXPECT_NEAR(make(fast).inserted_mm(kBegin + std::chrono::seconds(1)), 40, 1e-9);
  EXPECT_EQ(make(fast).inserted_mm(kBegin + std::chrono::seconds(2)), 60) << "stops at the target";
}

TEST(NeedleInsertionTest, TheTipIsThatOfTheBentNeedleOnTheHub) {
  for (const auto kind : {BendingKind::kStraight, BendingKind::kBevelArc, BendingKind::kTipLoad}) {
    const auto needle = make(with(kind));
    for (const double s : {1.0, 2.3, 4.0, 5.0, 6.0}) {
      const Timestamp time(from_seconds(s));
      const NeedleTruth truth = needle.truth(time);
      const BentNeedle bent(needle.options().bending, truth.inserted_mm);
      const auto from_hub = needle.ct_from_hub(time) * needle.hub_from_needle();
      EXPECT_LE(((from_hub * bent.tip()).mm - truth.tip_ct.mm).norm(), 1e-9);
      EXPECT_LE((from_hub.translation_mm() - truth.straight_tip_ct.mm).norm(), 1e-9);
      EXPECT_NEAR((truth.tip_ct.mm - truth.straight_tip_ct.mm).norm(), truth.tip_error_mm, 1e-9);
      if (kind == BendingKind::kStraight) {
        EXPECT_EQ(truth.tip_error_mm, 0);
      }
    }
    EXPECT_EQ(needle.truth(kEnd).tip_error_mm > 0.1, kind != BendingKind::kStraight);
  }
}

TEST(NeedleInsertionTest, StartsOutsideThePatientOnThePlannedLine) {
  NeedleInsertionOptions options = with(BendingKind::kStraight);
  options.outside_mm = 20;
  const auto needle = make(options);
  const Vec axis = (plan().target_ct.mm - plan().entry_ct.mm).normalized();
  const auto tip = [&](Timestamp time) { return needle.ct_from_needle(time).translation_mm(); };
  EXPECT_LE((tip(kBegin) - (plan().entry_ct.mm - 20 * axis)).norm(), 1e-9);
  EXPECT_EQ(needle.inserted_mm(kBegin), 0);
  EXPECT_LE((tip(kBegin + std::chrono::milliseconds(10)) - tip(kBegin)).norm(), 0.01)
      << "a gentle start";
  EXPECT_LE((tip(kBegin + std::chrono::seconds(2)) - (plan().entry_ct.mm + 20 * axis)).norm(), 1e-9)
      << "half way at half time";
  EXPECT_LE((tip(kEnd) - plan().target_ct.mm).norm(), 1e-9);
}

TEST(NeedleInsertionTest, TheShaftRunsFromTheTipThroughTheSkinToTheHub) {
  NeedleInsertionOptions options = with(BendingKind::kBevelArc);
  options.aside_at_target_mm = 6;
  options.length_mm = 90;
  const auto needle = make(options);
  const auto shaft = needle.shaft_ct(kEnd);
  EXPECT_LE((shaft.front().mm - needle.truth(kEnd).tip_ct.mm).norm(), 1e-12);
  EXPECT_LE((shaft.back().mm - needle.ct_from_hub(kEnd).translation_mm()).norm(), 1e-9);
  EXPECT_LE((shaft[shaft.size() - 2].mm - plan().entry_ct.mm).norm(), 1e-9);
  double length = 0;
  for (std::size_t i = 1; i < shaft.size(); ++i) length += (shaft[i].mm - shaft[i - 1].mm).norm();
  EXPECT_NEAR(length, 90, 0.01) << "bending changes no length, but for the chords of its pieces";
  const Vec axis = needle.ct_from_needle(kEnd).matrix().block<3, 1>(0, 2);
  const Vec off = shaft.front().mm - plan().target_ct.mm;
  EXPECT_NEAR((off - off.dot(axis) * axis).norm(), 6, 1e-9);
}

TEST(NeedleInsertionTest, RejectsInvalidOptionsByName) {
  const auto rejection = [](const NeedleInsertionOptions& o) {
    const auto made = NeedleInsertion::create(plan(), o, kBegin, kEnd);
    EXPECT_FALSE(made);
    return made ? std::string() : made.error().message;
  };
  NeedleInsertionOptions o = with(BendingKind::kBevelArc);
  o.speed_mm_s = -3;
  EXPECT_THAT(rejection(o), HasSubstr("speed"));
  EXPECT_THAT(rejection(o), HasSubstr("found -3.00 mm/s"));
  o.speed_mm_s = std::nan("");
  EXPECT_THAT(rejection(o), HasSubstr("found nan mm/s"));
  o = with(BendingKind::kStraight);
  o.length_mm = 59;
  EXPECT_THAT(rejection(o),
              HasSubstr("at least the path from the skin to the target, 60.00 mm, found 59.00 mm"));
  o.length_mm = 1e5;
  EXPECT_THAT(rejection(o), HasSubstr("a length of 0 to 1000 mm"));
  o = with(BendingKind::kStraight);
  o.aside_at_target_mm = 2;
  EXPECT_THAT(rejection(o), HasSubstr("straight"));
  o = with(BendingKind::kTipLoad);
  o.aside_at_target_mm = -2;
  EXPECT_THAT(rejection(o), HasSubstr("-2.00 mm"));
  o.aside_at_target_mm = 20;
  EXPECT_THAT(rejection(o), HasSubstr("0 to 12 mm (a fifth of the path), found 20 mm"));
  o.aside_at_target_mm.reset();
  o.outside_mm = -1;
  EXPECT_THAT(rejection(o), HasSubstr("outside the skin"));
  o.outside_mm = 0;
  o.bending.tip_force_n = 5;
  EXPECT_THAT(rejection(o), HasSubstr("a fifth of the path"));
  o = with(BendingKind::kStraight);
  EXPECT_FALSE(NeedleInsertion::create(plan(), o, kEnd, kBegin));
  EXPECT_FALSE(NeedleInsertion::create({{{0, 0, 0}}, {{0, 0, 0}}, 0, 0}, o, kBegin, kEnd));
}

}  // namespace
}  // namespace nav::sim
