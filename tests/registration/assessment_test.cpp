// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Eigenvalues>
#include <cmath>
#include <gtest/gtest.h>
#include <numeric>

#include "registration/acceptance.hpp"
#include "registration/pose_solver.hpp"
#include "registration/prepared.hpp"
#include "registration/regions.hpp"
#include "registration/search/basin.hpp"
#include "registration/uncertainty/sandwich.hpp"
#include "tests/registration/synthetic.hpp"
#include "tests/support/matchers.hpp"

/// Tests what a result reports about itself: the basin, the regions and the time limit.
namespace nav::registration {
namespace {

struct AssessedScene {
  Volume ct = test::blob_ct(test::BlobPatient(11), test::cubic_grid());
  Sweep sweep = test::blob_sweep(test::BlobPatient(11), {});
  PreparedCt prepared_ct = *PreparedCt::create(ct, test::small_options());
  PreparedSweep prepared_sweep = prepared(sweep);
  static PreparedSweep prepared(const Sweep& sweep) {
    CollectingDiagnostics diagnostics;
    return *PreparedSweep::create(sweep, test::small_options(), diagnostics);
  }
  [[nodiscard]] SimilarityCost finest() const {
    return {*prepared_ct.levels().back(), prepared_sweep.levels().back().patches, 0.005, 1};
  }
};
const AssessedScene& assessed_scene() {
  static const AssessedScene instance;
  return instance;
}

Result<ImageRegistrationResult> registered(const Sweep& sweep) {
  CollectingDiagnostics diagnostics;
  return register_sweep(assessed_scene().ct, sweep, test::off_by(test::true_pose(), 5, 0.05, 1),
                        test::small_options(), diagnostics);
}

BasinCheck basin_at(const Pose& pose) {
  const auto& points = assessed_scene().prepared_sweep.points();
  const SimilarityCost cost = assessed_scene().finest();
  return check_basin(costs_around(cost, points, pose), cost, points);
}

TEST(BasinTest, CostsRiseAllAroundTheMinimum) {
  const BasinCheck check = basin_at(test::true_pose());
  EXPECT_GT(check.rise, 0);
  EXPECT_EQ(check.shift_mm, 0);
}

TEST(BasinTest, ReportsTheDistanceFromAFalseStopToTheMinimum) {
  // A false stop: 2.5 mm beside the minimum, where no solver should stop.
  const Pose truth = test::true_pose();
  const Pose beside(truth.rotation(), truth.translation_mm() + Eigen::Vector3d(2.5, 0, 0));
  const BasinCheck check = basin_at(beside);
  EXPECT_LT(check.rise, 0);
  EXPECT_NEAR(check.shift_mm, 2.5, 1.0);  // The check moves in steps of 1 mm.
}

TEST(BasinTest, TheResultContainsTheBasinCheck) {
  const auto result = registered(assessed_scene().sweep);
  ASSERT_TRUE(test::has_value(result));
  EXPECT_GT(result->basin.rise, 0);
  EXPECT_EQ(result->basin.shift_mm, 0);
  EXPECT_TRUE(decide(*result, {}, {{0, 0, 0}}).accepted);
}

TEST(CostsAroundTest, PartsAddUpAndGradientsDoNotChangeTheCost) {
  const auto& points = assessed_scene().prepared_sweep.points();
  const SimilarityCost cost = assessed_scene().finest().robust({PatchLoss::kCauchy, 0.3});
  const Pose pose = test::true_pose();
  const CostsAround plain = costs_around(cost, points, pose);
  const CostsAround both = costs_around(cost, points, pose, true);
  ASSERT_EQ(plain.beside.size(), 12u);
  ASSERT_EQ(plain.patches.patches.size(), plain.here.patch_costs.size());
  for (std::size_t i = 0; i < plain.beside.size(); ++i) {
    const CostTerms& terms = both.beside[i].terms;
    const double sum = std::accumulate(terms.patch_costs.begin(), terms.patch_costs.end(), 0.0);
    EXPECT_NEAR(sum, terms.cost, 1e-12);
    EXPECT_NEAR(terms.cost, plain.beside[i].terms.cost, 1e-5);
    EXPECT_GT(terms.cost, both.here.cost);
    // Each gradient points back to the centre.
    const Vector6d& gradient = terms.gradient;
    EXPECT_GT((i % 2 == 0 ? -1 : 1) * gradient[static_cast<Eigen::Index>(i / 2)], 0) << i;
  }
}

TEST(CostsAroundTest, CostsAroundThePoseGiveTheCurvature) {
  const auto& points = assessed_scene().prepared_sweep.points();
  const SimilarityCost cost = assessed_scene().finest();
  const Pose pose = test::true_pose();
  const Point<frames::Ct> centre = pose * points.centroid;
  const LocalShape fine = local_shape(cost, pose, centre, 0.25);
  const LocalShape shared = local_shape(cost, centre, costs_around(cost, points, pose, true));
  ASSERT_EQ(shared.patch_gradients.size(), fine.patch_gradients.size());
  const Eigen::LLT<Matrix6d> llt(fine.hessian);
  ASSERT_EQ(llt.info(), Eigen::Success);
  const Eigen::Matrix<double, 6, 1> ratios =
      (llt.solve(shared.hessian)).eigenvalues().real().eval();
  // The steps are 1 mm instead of 0.25 mm, and the samples are 2 mm apart.
  EXPECT_GT(ratios.minCoeff(), 0.75);
  EXPECT_LT(ratios.maxCoeff(), 1.25);
}

TEST(LocalShapeTest, HardlyDependsOnThePatchesThatAreDifferentiated) {
  // Only every n-th patch is differentiated. Without the first patch, these are quite different
  // patches.
  ImageRegistrationOptions dense = test::small_options();
  dense.levels.back() = {2, 7, 1800, 2};
  CollectingDiagnostics diagnostics;
  const auto sweep = PreparedSweep::create(assessed_scene().sweep, dense, diagnostics);
  ASSERT_TRUE(test::has_value(sweep));
  const SimilarityCost cost(*assessed_scene().prepared_ct.levels().back(),
                            sweep->levels().back().patches, 0.005, 1);
  const Pose pose = test::true_pose();
  const Point<frames::Ct> centre = pose * sweep->points().centroid;
  ASSERT_GT(cost.patches().patches.size(), 1200U);
  const Matrix6d one = local_shape(cost, pose, centre, 0.5).hessian;
  std::size_t index = 0;
  const PatchSet rest = subset(cost.patches(), [&](const Patch&) { return index++ > 0; });
  const SimilarityCost others = cost.on(rest);
  const Matrix6d other = local_shape(others, pose, centre, 0.5).hessian;
  const Eigen::LLT<Matrix6d> llt(one);
  ASSERT_EQ(llt.info(), Eigen::Success);
  const Eigen::Matrix<double, 6, 1> ratios = llt.solve(other).eigenvalues().real().eval();
  EXPECT_GT(ratios.minCoeff(), 0.85);
  EXPECT_LT(ratios.maxCoeff(), 1.2);  // The curvature of the differentiated patches alone would
                                      // give 1.23.
}

// Limit for a region whose images lie at their true positions. A region that is displaced by 4 mm
// pulls more. Regions of a few dozen noisy patches are ignored.
constexpr double kAgreeMm = 1.0;
constexpr int kManyPatches = 40;

TEST(RegionTest, RegionsCoverTheSweepAndAgreeIfAllImagesAreRight) {
  const auto result = registered(assessed_scene().sweep);
  ASSERT_TRUE(test::has_value(result));
  ASSERT_EQ(result->regions.size(), 9u);
  int patches = 0;
  for (const RegionAgreement& region : result->regions) {
    patches += region.patches;
    if (region.patches >= kManyPatches) {
      EXPECT_LT(region.pull_mm, kAgreeMm) << region.along << region.deep;
    }
    EXPECT_LT(region.cost, 0.33);
  }
  EXPECT_EQ(patches, result->used_patches);
  // The thirds are ordered along the sweep (z of the CT) and in depth (y of the CT).
  const auto& regions = result->regions;
  EXPECT_GT(regions[6].centre.mm.z(), regions[0].centre.mm.z() + 30);
  EXPECT_GT(regions[2].centre.mm.y(), regions[0].centre.mm.y() + 30);
}

TEST(RegionTest, ADisplacedThirdOfTheSweepPullsAndIsNamed) {
  // The last third of the images is displaced by 4 mm.
  std::vector<TrackedImage> frames = assessed_scene().sweep.frames();
  for (std::size_t i = 2 * frames.size() / 3; i < frames.size(); ++i) {
    const auto& pose = frames[i].reference_from_image;
    frames[i].reference_from_image = Transform<frames::Reference, frames::Image>(
        pose.rotation(), pose.translation_mm() + Eigen::Vector3d(4, 0, 0));
  }
  const auto torn = Sweep::create(std::move(frames), "torn");
  ASSERT_TRUE(test::has_value(torn));
  const auto result = registered(*torn);
  ASSERT_TRUE(test::has_value(result));
  double others_mm = 0;
  double torn_mm = 0;
  for (const RegionAgreement& region : result->regions) {
    if (region.patches < kManyPatches) continue;
    double& worst_mm = region.along == 2 ? torn_mm : others_mm;
    worst_mm = std::max(worst_mm, region.pull_mm);
  }
  EXPECT_GT(torn_mm, kAgreeMm);
  EXPECT_GT(torn_mm, others_mm);
}

TEST(TimeLimitTest, ReportsAndRejectsTheBestPoseAtTheTimeLimit) {
  const auto start = test::off_by(test::true_pose(), 5, 0.05, 1);
  CollectingDiagnostics diagnostics;
  auto options = test::small_options();
  options.time_limit_s = 1e-9;
  for (const int starts : {0, 60}) {
    options.starts = starts;
    const auto result =
        register_sweep(assessed_scene().ct, assessed_scene().sweep, start, options, diagnostics);
    ASSERT_TRUE(test::has_value(result));
    EXPECT_EQ(result->termination, Termination::kTimeLimit);
    EXPECT_STREQ(to_string(result->termination), "time_limit");
    // There is no time for a step, so the result is the start pose.
    EXPECT_LT(test::cube_error_mm(result->ct_from_reference, start), 1e-9);
    const Decision decision = decide(*result, {}, {{0, 0, 0}});
    EXPECT_FALSE(decision.accepted);
    EXPECT_NE(decision.reasons.at(0).find("time limit"), std::string::npos);
  }
  options.time_limit_s = 1e9;
  const auto whole =
      register_sweep(assessed_scene().ct, assessed_scene().sweep, start, options, diagnostics);
  ASSERT_TRUE(test::has_value(whole));
  EXPECT_EQ(whole->termination, Termination::kConverged);
  options.time_limit_s = std::nan("");
  EXPECT_TRUE(test::rejects(validate(options), ErrorCode::kUsage, {"time_limit_s"}));
}

TEST(IterationLimitTest, ReportsTheIterationLimit) {
  const auto start = test::off_by(test::true_pose(), 5, 0.05, 1);
  CollectingDiagnostics diagnostics;
  auto options = test::small_options();
  options.max_iterations = 1;
  const auto result =
      register_sweep(assessed_scene().ct, assessed_scene().sweep, start, options, diagnostics);
  ASSERT_TRUE(test::has_value(result));
  EXPECT_EQ(result->termination, Termination::kIterationLimit);
  EXPECT_STREQ(to_string(result->termination), "iteration_limit");
  // These limits accept every value, so that only the termination matters.
  constexpr double kAny = 1e9;
  const AcceptanceLimits any{.min_overlap = 0,
                             .min_z_score = -kAny,
                             .min_places = 0,
                             .max_cost = 1,
                             .min_margin = -kAny,
                             .max_tre_rms_mm = kAny,
                             .max_split_disagreement_mm = kAny,
                             .max_halves_disagreement_mm = kAny,
                             .max_basin_shift_mm = kAny,
                             .max_scale = kAny,
                             .max_misfit_mm = {kAny, kAny, kAny, kAny, kAny}};
  const Decision decision = decide(*result, any, {{0, 0, 0}}, any);
  EXPECT_EQ(decision.verdict(), Verdict::kWarn);
  ASSERT_EQ(decision.warnings.size(), 1U);
  EXPECT_NE(decision.warnings[0].find("iteration limit"), std::string::npos);
}

TEST(TimeLimitTest, AnInterruptedSolveKeepsItsSteps) {
  int asked = 0;
  const SolveLimits limits{30, 3e-6, [&] { return ++asked > 2; }};
  const Pose start = test::off_by(test::true_pose(), 3, 0.03, 2);
  const SimilarityCost cost = assessed_scene().finest();
  const PoseSolution cut =
      solve_pose(cost, start, assessed_scene().prepared_sweep.points().centroid, limits, {});
  EXPECT_EQ(cut.termination, Termination::kTimeLimit);
  EXPECT_FALSE(cut.cancelled);
  EXPECT_LT(cut.final_cost, cut.initial_cost);
  EXPECT_NEAR(cost.cost(cut.pose).cost, cut.final_cost, 1e-6);
}

}  // namespace
}  // namespace nav::registration
