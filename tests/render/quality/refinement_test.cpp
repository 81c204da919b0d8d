// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/quality/refinement.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <limits>

#include "render/predicates/model.hpp"
#include "tests/render/scene_support.hpp"

namespace nav::render {
namespace {

using Expression = PredicateExpression;

Timestamp time_at(double seconds) { return Timestamp(from_seconds(seconds)); }

PredicateModel asking(std::vector<Expression> expressions) {
  PredicateModel model;
  std::vector<PredicateHistogram::Bar> bars;
  for (Expression& one : expressions) {
    model.entries.push_back({"entry " + std::to_string(bars.size()), std::move(one)});
    bars.push_back({1.0 / static_cast<double>(expressions.size()), 100, 0.5});
  }
  model.histogram = *PredicateHistogram::create(std::move(bars));
  return model;
}

Scene plane_scene() {
  const auto ct = test::make_volume(test::centred_grid({4, 4, 4}, {1, 1, 1}),
                                    [](int, int, int) { return 0.0; });
  Scene scene = test::plain_scene(ct, test::fog(0.1), test::frontal(100, 10, false));
  scene.plane = test::upright_plane(test::grey_image(4, 4, 100), 1, {0, 0, 0});
  return scene;
}

/// Scenes whose images take the given time.
class RefinementTest : public ::testing::Test {
 protected:
  struct Drawn {
    int factor;
    bool sparse;
    bool refined;
  };
  Drawn draw(double seconds, double took_s) {
    const auto plan = refinement_.plan(scene_, time_at(seconds));
    refinement_.drawn(took_s, plan.factor);
    return {plan.factor, plan.scene.quality.pixel_error > scene_.quality.pixel_error, plan.refined};
  }
  void expect_whole(double seconds, double took_s) {
    const Drawn drawn = draw(seconds, took_s);
    EXPECT_TRUE(drawn.refined && drawn.factor == 1 && !drawn.sparse) << drawn.factor;
  }
  void turn() { scene_.camera.eye_ct.mm.x() += 1; }
  void move_plane() { scene_.plane->frame.grid.origin_mm.x() += 1; }
  void show(PredicateModel model) {
    scene_.predicates.emplace();
    scene_.predicates->model = std::move(model);
  }

  Scene scene_ = plane_scene();
  Refinement refinement_;
};

TEST_F(RefinementTest, IsCoarseOnlyWhileMovingAndSlow) {
  EXPECT_FALSE(refinement_.wants_refinement());
  expect_whole(0, 0.2);  // The first image.
  expect_whole(0.5, 0);  // There is no motion.
  turn();
  EXPECT_TRUE(draw(1, 0.03).sparse);
  EXPECT_FALSE(refinement_.wants_refinement(time_at(1.05)));
  turn();
  EXPECT_FALSE(draw(1.06, 0.03).refined);
  EXPECT_FALSE(refinement_.wants_refinement(time_at(1.15)));
  EXPECT_TRUE(refinement_.wants_refinement(time_at(1.17)));
  EXPECT_TRUE(refinement_.wants_refinement());
  expect_whole(1.17, 0.2);
  EXPECT_FALSE(refinement_.wants_refinement(time_at(2)));
  // With an update each 33 ms, 160 ms are left to draw within 300 ms.
  EXPECT_LE(ProgressiveOptions{}.refine_after_s + 0.04, 0.15);
}

TEST_F(RefinementTest, IsNeverCoarseIfFastOrUnlimited) {
  expect_whole(0, 0.02);
  turn();
  expect_whole(0.01, 0.02);
  ProgressiveOptions never;
  never.budget_s = std::numeric_limits<double>::infinity();
  refinement_ = Refinement(never);
  for (int i = 0; i < 3; ++i) {
    expect_whole(0.01 * i, 2);
    turn();
  }
}

TEST_F(RefinementTest, TheTimeOfTheFullImageSetsTheSizeOfTheFirstSmallOne) {
  scene_.quality.pixel_error = 0.5;  // No rays can be saved.
  expect_whole(0, 1.0);
  turn();
  EXPECT_EQ(draw(0.01, 0.1).factor, 6);  // 1 / 36 s.
  turn();
  EXPECT_EQ(draw(0.02, 0.1).factor, 8);  // 0.1 s with a 36th of the pixels.
}

TEST_F(RefinementTest, AMovingPlaneIsMeasuredSeparatelyFromTheView) {
  expect_whole(0, 0.2);
  for (int i = 1; i < 5; ++i) {
    move_plane();
    expect_whole(0.02 * i, 0.01);
  }
  turn();
  EXPECT_FALSE(draw(0.2, 0.02).refined);
}

TEST_F(RefinementTest, OneSlowImageDoesNotCountForever) {
  expect_whole(0, 0.02);
  move_plane();
  expect_whole(0.02, 0.06);  // The reason does not matter.
  int coarse = 0;
  for (double now = 1; now < 20; now += 1) {
    move_plane();
    if (draw(now, 0.01).refined) break;
    ++coarse;
    expect_whole(now + 0.2, 0.02);
  }
  EXPECT_GT(coarse, 0);
  EXPECT_LT(coarse, 5);
  move_plane();
  expect_whole(30, 0.01);
}

TEST_F(RefinementTest, AnImageDrawnInFullDoesNotCountForSmallImages) {
  scene_.quality.pixel_error = 0.5;
  expect_whole(0, 0.2);
  turn();
  const auto plan = refinement_.plan(scene_, time_at(0.01));
  EXPECT_EQ(plan.factor, 3);
  refinement_.drawn(0.2, 1);  // Other geometry needs all pixels.
  turn();
  EXPECT_EQ(draw(0.02, 0.2).factor, 3);
}

TEST_F(RefinementTest, AnotherPredicateSetIsExpectedToBeSlower) {
  const auto intensity = Expression::kind("intensity", {0.1, 0.5});
  const auto gradient = Expression::kind("gradient_magnitude");
  show(asking({intensity, gradient}));
  expect_whole(0, 0.02);
  turn();
  expect_whole(0.1, 0.02);
  // This is the same set, because tables hold parameters, names and importances.
  show(asking({Expression::kind("intensity", {0.2, 0.9}), gradient}));
  scene_.predicates->model.histogram.drag(0, 0.3);
  scene_.predicates->model.entries[0].name = "bright";
  expect_whole(0.2, 0.02);
  show(asking({intensity, Expression::negation(gradient)}));
  const Drawn first = draw(0.3, 0.015);
  EXPECT_EQ(first.factor, 2);  // 0.12 s are expected.
  EXPECT_FALSE(first.refined);
  turn();
  EXPECT_EQ(draw(0.31, 0.015).factor, 2);  // Nothing else is known yet.
  expect_whole(0.5, 0.06);
  turn();
  EXPECT_FALSE(draw(0.6, 0.015).refined);
  expect_whole(0.8, 0.02);  // The set has its own program now.
  turn();
  expect_whole(1, 0.02);
  scene_.predicates.reset();
  expect_whole(1.1, 0.02);  // Without predicates no image is slower.
  show(asking({intensity}));
  EXPECT_FALSE(draw(1.2, 0.01).refined);
}

TEST_F(RefinementTest, ProvisionalImagesAreAllowedInMotionAndFullOnesFollow) {
  expect_whole(0, 0.01);
  const auto draw_provisional = [&](double seconds) {
    const auto plan = refinement_.plan(scene_, time_at(seconds));
    const bool allowed = plan.scene.quality.provisional;
    refinement_.drawn(0.001, plan.factor, allowed);
    EXPECT_EQ(refinement_.is_refined(), !allowed) << seconds;
    return allowed;
  };
  EXPECT_FALSE(draw_provisional(1)) << "nothing moves";
  turn();
  EXPECT_TRUE(draw_provisional(1.01)) << "however fast";
  EXPECT_TRUE(refinement_.wants_refinement());
  EXPECT_TRUE(draw_provisional(1.02));
  turn();
  EXPECT_TRUE(draw_provisional(1.03));
  EXPECT_TRUE(refinement_.wants_refinement(time_at(1.2)));
  EXPECT_FALSE(draw_provisional(1.2));
  EXPECT_FALSE(refinement_.wants_refinement());
  // The time of provisional images does not count for full images.
  turn();
  expect_whole(2, 0.01);
  scene_.quality.provisional = true;  // Callers do not decide this.
  EXPECT_FALSE(refinement_.plan(scene_, time_at(3)).scene.quality.provisional);
}

TEST_F(RefinementTest, NoImageIsProvisionalIfNoneMayBeCoarse) {
  ProgressiveOptions never;
  never.budget_s = std::numeric_limits<double>::infinity();
  refinement_ = Refinement(never);
  expect_whole(0, 0.1);
  turn();
  EXPECT_FALSE(refinement_.plan(scene_, time_at(0.01)).scene.quality.provisional);
}

TEST_F(RefinementTest, AfterAnInterruptedImageTheNextIsCoarse) {
  scene_.quality.pixel_error = 0.5;
  auto plan = refinement_.plan(scene_, time_at(0));
  EXPECT_TRUE(plan.refined);  // Nothing is known yet.
  EXPECT_EQ(plan.yields_to, SceneChange::kGeometry);
  refinement_.interrupted(0.05);
  turn();
  plan = refinement_.plan(scene_, time_at(0.05));
  EXPECT_FALSE(plan.refined);
  EXPECT_EQ(plan.factor, 2);
  EXPECT_FALSE(plan.yields_to) << "coarse images are always shown";
  refinement_.drawn(0.1, plan.factor);
  turn();
  EXPECT_EQ(draw(0.1, 0.03).factor, 4);
  EXPECT_TRUE(refinement_.wants_refinement(time_at(0.3)));
  EXPECT_TRUE(refinement_.plan(scene_, time_at(0.3)).refined);
  refinement_.interrupted(0.2);
  move_plane();
  EXPECT_FALSE(draw(0.5, 0.03).refined);
  expect_whole(0.7, 0.4);
}

TEST_F(RefinementTest, AnInterruptedImageCountsAsSlowHoweverSoonItWasGivenUp) {
  scene_.quality.pixel_error = 0.5;
  expect_whole(0, 0.01);
  for (int i = 0; i < 5; ++i) {
    turn();
    EXPECT_TRUE(refinement_.plan(scene_, time_at(1 + i)).refined);
    refinement_.interrupted(0.001);
    turn();
    EXPECT_FALSE(draw(1.01 + i, 0.005).refined) << "an image is shown between two interruptions";
    expect_whole(1.5 + i, 0.01);
  }
}

TEST_F(RefinementTest, AFirstAttemptWithFewerRaysMayBeGivenUp) {
  scene_.width = 400;  // Rays lie closely, so that some can be spared.
  scene_.height = 300;
  expect_whole(0, 1);
  turn();
  auto plan = refinement_.plan(scene_, time_at(1));
  ASSERT_EQ(plan.factor, 1);
  ASSERT_FALSE(plan.refined);
  EXPECT_EQ(plan.yields_to, SceneChange::kGeometry);
  refinement_.interrupted(0.1);
  for (int i = 0; i < 3; ++i) {
    turn();
    plan = refinement_.plan(scene_, time_at(1.1 + 0.1 * i));
    EXPECT_GE(plan.factor, 2);
    EXPECT_FALSE(plan.yields_to);
    refinement_.drawn(0.02, plan.factor);
  }
  expect_whole(2, 1);
  turn();
  EXPECT_GE(draw(2.1, 0.02).factor, 2) << "it took too long before";
}

/// Each image takes 0.6 s for all pixels, 0.06 s if the view rests.
class RestingViewTest : public RefinementTest {
 protected:
  RestingViewTest() {
    scene_.quality.pixel_error = 0.5;
    refinement_ = Refinement({.budget_s = 0.02, .refine_after_s = 1e9});
    expect_whole(0, 0.6);
  }
  int draw_one(double seconds, double kept_share) {
    const auto plan = refinement_.plan(scene_, time_at(seconds));
    const bool kept = plan.factor == last_factor_ && !turned_;
    turned_ = false;
    yields_to_ = plan.yields_to;
    last_factor_ = plan.factor;
    refinement_.drawn((kept ? kept_share : 1) * 0.6 / (plan.factor * plan.factor), plan.factor);
    return plan.factor;
  }
  int after_turn(double seconds) {
    turn();
    turned_ = true;
    return draw_one(seconds, 0.1);
  }
  int after_plane(double seconds, double kept_share = 0.1) {
    move_plane();
    return draw_one(seconds, kept_share);
  }
  std::optional<SceneChange> yields_to_;
  int last_factor_ = 0;
  bool turned_ = false;
};

TEST_F(RestingViewTest, GetsMorePixelsOnceItsRaysAreKept) {
  EXPECT_EQ(after_turn(1), 6);  // 0.6 s / 36 is within 0.02 s.
  EXPECT_EQ(after_plane(1.03), 6);
  EXPECT_EQ(after_plane(1.2), 6) << "the view may turn again";
  EXPECT_FALSE(yields_to_);
  EXPECT_EQ(after_plane(1.3), 2) << "0.015 s for 0.06 s of rays in all pixels";
  EXPECT_EQ(yields_to_, SceneChange::kView) << "all rays once, 0.15 s";
  for (int i = 1; i < 20; ++i) EXPECT_EQ(after_plane(1.3 + 0.03 * i), 2);
  EXPECT_FALSE(yields_to_);
  EXPECT_EQ(after_turn(3), 6);
}

TEST_F(RestingViewTest, LosesThemIfMoreRaysAreAffected) {
  after_turn(1);
  after_plane(1.1);
  ASSERT_EQ(after_plane(1.3), 2);
  int most = 2;
  for (int i = 1; i < 20; ++i) most = std::max(most, after_plane(1.3 + 0.03 * i, 0.5));
  EXPECT_EQ(most, 4) << "0.3 s of rays in all pixels";
}

TEST_F(RestingViewTest, NeverTakesAStepThatLastsTooLong) {
  refinement_ = Refinement({.budget_s = 0.02, .refine_after_s = 1e9, .finer_step_s = 0.05});
  expect_whole(0.5, 0.6);
  EXPECT_EQ(after_turn(1), 6);
  after_plane(1.1);
  EXPECT_EQ(after_plane(1.3), 4) << "0.6 s / 16 is within 0.05 s";
}

TEST_F(RestingViewTest, AChangedBudgetChangesTheImages) {
  EXPECT_EQ(after_turn(1), 6);
  refinement_.set_budget(0.04);
  EXPECT_EQ(after_turn(1.1), 4);
}

TEST(SameSetTest, DistinguishesCombinations) {
  const auto a = Expression::kind("intensity"), b = Expression::kind("snr");
  EXPECT_TRUE(same_set(asking({a, b}), asking({a, b})));
  EXPECT_FALSE(same_set(asking({a, b}), asking({b, a})));
  EXPECT_FALSE(same_set(asking({a, b}), asking({a})));
  EXPECT_FALSE(same_set(asking({Expression::all({a, b})}), asking({Expression::any({a, b})})));
  EXPECT_FALSE(same_set(asking({Expression::all({a, b})}), asking({Expression::all({a, a})})));
}

}  // namespace
}  // namespace nav::render
