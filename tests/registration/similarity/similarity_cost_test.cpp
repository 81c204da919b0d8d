// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/similarity/similarity_cost.hpp"

#include <ceres/sized_cost_function.h>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "nav/matrices.hpp"
#include "registration/cost_solver.hpp"
#include "registration/pose_solver.hpp"
#include "registration/search/starts.hpp"
#include "registration/uncertainty/sandwich.hpp"
#include "tests/registration/synthetic.hpp"

namespace nav::registration {
namespace {

constexpr double kRidge = 0.02;

struct CostScene {
  test::BlobPatient patient{11};
  Volume ct = test::blob_ct(patient, test::oblique_grid());
  CtChannels channels =
      *make_ct_channels(ct, {Eigen::Vector3d::Constant(-80), Eigen::Vector3d::Constant(80)}, 2.25);
  Sweep sweep = test::blob_sweep(patient, spec());
  PatchSet patches = make_patches(sweep, *shadow_masks(sweep, {}), {3.0, 9, 200, 6.0}, 2.25);

  static test::SweepSpec spec() {
    test::SweepSpec spec;
    spec.frames = 10;
    spec.step_mm = 8;
    return spec;
  }
};
const CostScene& cost_scene() {
  static const CostScene instance;
  return instance;
}
/// A pose away from the optimum, where the gradient is large.
Pose off_pose() { return test::off_by(test::true_pose(), 3, 0.05, 2); }

class SimilarityCostLossTest : public testing::TestWithParam<PatchLoss> {};

TEST_P(SimilarityCostLossTest, GradientMatchesCentralDifferences) {
  const SimilarityCost cost = SimilarityCost(cost_scene().channels, cost_scene().patches, kRidge, 1)
                                  .robust({GetParam(), 0.3});
  const Eigen::Vector3d centre(5, -8, 3);
  const Vector6d gradient = cost.terms(off_pose(), centre).gradient;
  // Float sums need a step that changes the cost enough. Kinks of the interpolant limit the step
  // from above.
  constexpr double kStepMm = 0.02;
  constexpr double kRelative = 0.01;
  for (int i = 0; i < 6; ++i) {
    Vector6d step = Vector6d::Zero();
    const double scale = i < 3 ? 1 / kRotationScaleMm : 1.0;
    step[i] = kStepMm * scale;
    const double difference = (cost.cost(moved(off_pose(), centre, step)).cost -
                               cost.cost(moved(off_pose(), centre, -step)).cost) /
                              (2 * kStepMm);
    EXPECT_NEAR(gradient[i] * scale, 0.5 * difference, kRelative * gradient.tail<3>().norm()) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Losses, SimilarityCostLossTest,
                         testing::Values(PatchLoss::kNone, PatchLoss::kCauchy,
                                         PatchLoss::kGemanMcClure),
                         [](const auto& tested) {
                           return tested.param == PatchLoss::kGemanMcClure
                                      ? std::string("geman_mcclure")
                                      : std::string(to_string(tested.param));
                         });

TEST(SimilarityCostTest, ALossAppliesToEveryPatchAndToSubsets) {
  const SimilarityCost plain(cost_scene().channels, cost_scene().patches, kRidge, 1);
  const RobustLoss loss{PatchLoss::kCauchy, 0.2};
  const GridPose pose = grid_pose(cost_scene().channels, off_pose());
  double expected = 0;
  for (std::size_t i = 0; i < cost_scene().patches.patches.size(); ++i) {
    expected +=
        cost_scene().patches.patches[i].weight *
        loss.value(patch_cost(cost_scene().channels, place(cost_scene().patches, i, pose), kRidge));
  }
  const SimilarityCost robust = plain.robust(loss);
  EXPECT_NEAR(robust.cost(off_pose()).cost, expected, 1e-12);
  EXPECT_NEAR(robust.terms(off_pose(), {0, 0, 0}).cost, expected, 1e-12);
  EXPECT_NEAR(robust.on(cost_scene().patches).cost(off_pose()).cost, expected, 1e-12);
  EXPECT_GT(eigenpairs<6>(robust.terms(off_pose(), {0, 0, 0}).hessian).values[0], 0);
}

/// A third of LC².
class ThirdOfLc2 final : public PatchMeasure {
 public:
  [[nodiscard]] const char* name() const override { return "third"; }
  [[nodiscard]] double cost(const CtChannels& ct, const PlacedPatch& patch,
                            double ridge) const override {
    return patch_cost(ct, patch, ridge) / 3;
  }
  [[nodiscard]] PatchTerms terms(const CtChannels& ct, const PlacedPatch& patch, double ridge,
                                 bool with_hessian) const override {
    PatchTerms terms =
        with_hessian ? patch_terms(ct, patch, ridge) : patch_gradient(ct, patch, ridge);
    terms.s /= 3;
    terms.gradient /= 3;
    terms.hessian /= 3;
    return terms;
  }
};

TEST(SimilarityCostTest, TakesAnyMeasureOfPatches) {
  const ThirdOfLc2 third;
  const SimilarityCost cost(cost_scene().channels, cost_scene().patches, kRidge, 1, third);
  const SimilarityCost lc2(cost_scene().channels, cost_scene().patches, kRidge, 1);
  EXPECT_TRUE(cost.has_patch_terms());
  EXPECT_NEAR(cost.cost(off_pose()).cost, lc2.cost(off_pose()).cost / 3, 1e-9);
  const CostTerms terms = cost.on(cost_scene().patches).terms(off_pose(), {0, 0, 0});
  const CostTerms expected = lc2.terms(off_pose(), {0, 0, 0});
  EXPECT_LT((terms.gradient - expected.gradient / 3).norm(), 1e-6 * expected.gradient.norm());
  EXPECT_LT((terms.hessian - expected.hessian / 3).norm(), 1e-6 * expected.hessian.norm());
  for (const Similarity measure :
       {Similarity::kLc2, Similarity::kNcc, Similarity::kMutualInformation}) {
    const SimilarityMeasure& one = measure_of(measure);
    EXPECT_NE(one.by_patch() == nullptr, one.by_samples() == nullptr) << one.name();
  }
}

TEST(SimilarityCostTest, HessianIsPositiveAndPatchGradientsAddUp) {
  const SimilarityCost cost(cost_scene().channels, cost_scene().patches, kRidge, 1);
  const CostTerms terms = cost.terms(off_pose(), {0, 0, 0}, true);
  EXPECT_GT(eigenpairs<6>(terms.hessian).values[0], 0);
  Vector6d sum = Vector6d::Zero();
  for (const Vector6d& g : terms.patch_gradients) sum += g;
  EXPECT_LT((sum - terms.gradient).norm(), 1e-12 * terms.gradient.norm() + 1e-15);
}

TEST(SimilarityCostTest, HessianIsTheSumOfPatchHessiansAboutTheCommonCentre) {
  const SimilarityCost cost(cost_scene().channels, cost_scene().patches, kRidge, 1);
  const Eigen::Vector3d centre(5, -8, 3);
  const GridPose pose = grid_pose(cost_scene().channels, off_pose());
  const Matrix6d to_grid = grid_from_ct(cost_scene().channels);
  Matrix6d expected = Matrix6d::Zero();
  for (std::size_t i = 0; i < cost_scene().patches.patches.size(); ++i) {
    const PlacedPatch placed = place(cost_scene().patches, i, pose);
    const Matrix6d m =
        patch_from_common(placed.centre - cost_scene().channels.grid_of(centre)) * to_grid;
    const PatchTerms terms = patch_terms(cost_scene().channels, placed, kRidge);
    expected += cost_scene().patches.patches[i].weight * m.transpose() * terms.hessian * m;
  }
  EXPECT_LT((cost.terms(off_pose(), centre).hessian - expected).norm(), 1e-12 * expected.norm());
}

TEST(SimilarityCostTest, GradientWithoutHessianIsEqual) {
  const SimilarityCost cost(cost_scene().channels, cost_scene().patches, kRidge, 1);
  const CostTerms terms = cost.terms(off_pose(), {1, 2, 3}, true);
  const CostTerms alone = cost.gradient(off_pose(), {1, 2, 3}, true);
  EXPECT_EQ(alone.cost, terms.cost);
  EXPECT_EQ(alone.gradient, terms.gradient);
  EXPECT_EQ(alone.patch_gradients, terms.patch_gradients);
  EXPECT_EQ(alone.hessian, Matrix6d::Zero());
}

TEST(SimilarityCostTest, ResultDoesNotDependOnTheNumberOfThreads) {
  const SimilarityCost one(cost_scene().channels, cost_scene().patches, kRidge, 1);
  const SimilarityCost two(cost_scene().channels, cost_scene().patches, kRidge, 2);
  const CostTerms a = one.terms(off_pose(), {1, 2, 3});
  const CostTerms b = two.terms(off_pose(), {1, 2, 3});
  EXPECT_EQ(a.cost, b.cost);
  EXPECT_EQ(a.gradient, b.gradient);
  EXPECT_EQ(a.hessian, b.hessian);
  EXPECT_EQ(one.cost(off_pose()).cost, a.cost);
}

TEST(SimilarityCostTest, NonFiniteChannelsCountAsNoMatch) {
  CtChannels poisoned = cost_scene().channels;
  for (std::size_t i = 0; i < poisoned.texels.size(); i += 2) {
    poisoned.texels[i][0] = std::numeric_limits<float>::quiet_NaN();
  }
  const SimilarityCost cost(poisoned, cost_scene().patches, kRidge, 1);
  const CostTerms terms = cost.terms(test::true_pose(), {0, 0, 0});
  EXPECT_EQ(terms.non_finite, static_cast<int>(cost_scene().patches.patches.size()));
  EXPECT_NEAR(terms.cost, 1.0, 1e-12);
  EXPECT_TRUE(terms.gradient.allFinite() && terms.hessian.allFinite());
}

TEST(SimilarityCostTest, TheSolverDescendsToTheTruth) {
  const SimilarityCost cost(cost_scene().channels, cost_scene().patches, 0.005, 1);
  const Point<frames::Reference> centroid = cost_scene().sweep.centroid();
  const PoseSolution solution = solve_pose(cost, off_pose(), centroid, {30}, {});
  EXPECT_EQ(solution.termination, Termination::kConverged) << solution.message;
  EXPECT_LT(solution.final_cost, 0.5 * solution.initial_cost);
  constexpr double kDescentMm = 0.6;  // Samples of 3 mm, 200 patches of 10 images.
  EXPECT_LT(test::cube_error_mm(solution.pose, test::true_pose()), kDescentMm);
  // Ceres squares the residuals and adds the squares.
  EXPECT_NEAR(solution.final_cost, cost.cost(solution.pose).cost, 1e-9);
}

TEST(SimilarityCostTest, TheSolverStopsWhenCancelled) {
  const SimilarityCost cost(cost_scene().channels, cost_scene().patches, kRidge, 1);
  const auto solution =
      solve_pose(cost, off_pose(), cost_scene().sweep.centroid(), {30}, [] { return false; });
  EXPECT_TRUE(solution.cancelled);
}

/// The cost 10 + (x − 1)² with a curvature that is reported too small. The first step goes to x =
/// 2, where the cost is almost equal but not lower.
class Mirror final : public ceres::SizedCostFunction<2, 1> {
 public:
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const double off = x[0][0] - 1;
    const double cost = 10 + off * off;
    residuals[0] = 0;
    residuals[1] = std::sqrt(cost);
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    constexpr double kTrustRegion = 3;  // The first trust region of the solver. It shortens steps
                                        // by a factor of 1 + 1/3.
    const double root = std::sqrt(0.4999999 / (1 + 1 / kTrustRegion));
    residuals[0] = off / root;
    residuals[1] = std::sqrt(cost - residuals[0] * residuals[0]);
    jacobians[0][0] = root;
    jacobians[0][1] = 0;
    return true;
  }
};

TEST(CostSolverTest, ARejectedStepWithoutChangeDoesNotEndTheSolve) {
  Eigen::VectorXd x(1);
  const CostSolution found = minimise(new Mirror, x, {50, 1e-6}, {});
  EXPECT_EQ(found.termination, Termination::kConverged) << found.message;
  EXPECT_NEAR(x[0], 1, 1e-2);
  EXPECT_NEAR(found.final_cost, 10, 1e-4);
  EXPECT_GT(found.iterations, 1);
}

TEST(SandwichTest, NamesADirectionThatTheCtDoesNotShow) {
  // The CT does not change along z, so a shift along z costs nothing.
  CtChannels prism = cost_scene().channels;
  const auto slice = static_cast<std::size_t>(prism.size[0] * prism.size[1]);
  for (std::size_t i = 0; i < prism.texels.size(); ++i) {
    prism.texels[i] = cost_scene().channels.texels[40 * slice + i % slice];
    prism.texels[i][3] = 0;
  }
  const SimilarityCost cost(prism, cost_scene().patches, kRidge, 1);
  const auto shape = local_shape(cost, test::true_pose(), {{0, 0, 0}}, 0.5);
  const auto result = sandwich_covariance(shape, cost_scene().patches, test::true_pose(), 0.15);
  EXPECT_FALSE(result.valid);
  EXPECT_NE(result.fault.find("does not determine"), std::string::npos) << result.fault;
}

TEST(SandwichTest, DistinguishesADirectionThatFallsFromAFlatOne) {
  Matrix6d hessian = Matrix6d::Identity();
  EXPECT_EQ(curvature_fault(hessian), "");
  hessian(5, 5) = 0;
  EXPECT_EQ(curvature_fault(hessian),
            "the sweep does not determine the translation along Ct (0.00, 0.00, 1.00): expected a "
            "curvature ratio above 0.001, found 0");
  hessian(5, 5) = -0.01;
  EXPECT_EQ(curvature_fault(hessian),
            "the sweep does not determine the translation along Ct (0.00, 0.00, 1.00): the pose is "
            "not a minimum of the cost along it");
}

/// Patches of several images, whose gradients pull alternately in opposite directions along x.
struct Pulls {
  LocalShape shape{{{0, 0, 0}}, Matrix6d::Identity(), {}, {}};
  PatchSet patches;
  SweepPoints sweep{{}, {{0, 0, 0}}};
  Pulls(int images, int each) {
    for (int i = 0; i < images * each; ++i) {
      Patch patch{};
      patch.frame = i / each;
      patch.weight = 1.0 / (images * each);
      patches.patches.push_back(patch);
      Vector6d pull = Vector6d::Zero();
      pull[3] = (patch.frame % 2 == 0 ? 3 : -3) * patch.weight;
      shape.patch_gradients.push_back(pull);
    }
  }
  [[nodiscard]] Disagreement of(Halves halves) const {
    const Pose pose(Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero());
    return disagreement(shape, patches, sweep, pose, halves);
  }
};

TEST(DisagreementTest, IsTheDistanceBetweenThePosesOfTheHalves) {
  const Pulls pulls(4, 10);
  EXPECT_EQ(pulls.of(Halves::kOddEven).fault, "");
  EXPECT_NEAR(pulls.of(Halves::kOddEven).rms_mm, 6, 1e-9);
  EXPECT_NEAR(pulls.of(Halves::kFirstSecond).rms_mm, 0, 1e-9);
}

TEST(DisagreementTest, ReportsWhyTheHalvesCannotBeCompared) {
  EXPECT_TRUE(std::isinf(Pulls(1, 100).of(Halves::kOddEven).rms_mm));
  EXPECT_EQ(Pulls(1, 100).of(Halves::kOddEven).fault,
            "expected images with patches at two or more positions, found one position");
  EXPECT_EQ(Pulls(3, 12).of(Halves::kFirstSecond).fault,
            "expected at least 20 patches in each half, found 12");
  Pulls falling(4, 10);
  falling.shape.hessian(3, 3) = -1;
  EXPECT_EQ(falling.of(Halves::kOddEven).fault, curvature_fault(falling.shape.hessian));
  Pulls unknown(4, 10);
  unknown.shape.patch_gradients[0][3] = std::nan("");
  EXPECT_NE(unknown.of(Halves::kOddEven).fault.find("finite gradients"), std::string::npos);
}

TEST(SandwichTest, AddsTheBiasFloor) {
  const SimilarityCost cost(cost_scene().channels, cost_scene().patches, 0.005, 1);
  const auto solution = solve_pose(cost, off_pose(), cost_scene().sweep.centroid(), {30}, {});
  const Point<frames::Ct> centre = solution.pose * cost_scene().sweep.centroid();
  const auto shape = local_shape(cost, solution.pose, centre, 0.5);
  const auto small = sandwich_covariance(shape, cost_scene().patches, solution.pose, 0.0);
  const auto large = sandwich_covariance(shape, cost_scene().patches, solution.pose, 2.0);
  ASSERT_TRUE(small.valid) << small.fault;
  ASSERT_TRUE(large.valid) << large.fault;
  EXPECT_GT(small.uncertainty.tre_rms_mm(centre), 0.0);
  // Three translations of 2 mm each, added in quadrature.
  EXPECT_NEAR(std::pow(large.uncertainty.tre_rms_mm(centre), 2) -
                  std::pow(small.uncertainty.tre_rms_mm(centre), 2),
              3 * 4.0, 1e-9);
}

TEST(StartsTest, FillTheBoxEvenlyAndAreReproducible) {
  const auto twists = spread_twists(600, 0.2, 15, 7);
  ASSERT_EQ(twists.size(), 600u);
  Vector6d mean = Vector6d::Zero();
  for (const Vector6d& twist : twists) {
    EXPECT_LE(twist.head<3>().cwiseAbs().maxCoeff(), 0.2);
    EXPECT_LE(twist.tail<3>().cwiseAbs().maxCoeff(), 15);
    mean += twist / 600;
  }
  // A random set would have 15/√3/√600 = 0.35 mm. Halton points are more even.
  EXPECT_LT(mean.tail<3>().cwiseAbs().maxCoeff(), 0.35);
  EXPECT_LT(mean.head<3>().cwiseAbs().maxCoeff(), 0.2 / 15 * 0.35);
  EXPECT_EQ(twists, spread_twists(600, 0.2, 15, 7));
  EXPECT_NE(twists, spread_twists(600, 0.2, 15, 8));
}

TEST(TwistTest, LeftJacobianIsTheDerivativeOfExp) {
  const Eigen::Vector3d omega(0.4, -0.7, 0.2);
  constexpr double kStep = 1e-6;
  for (const double scale : {1.0, 1e-5}) {
    const Eigen::Vector3d w = scale * omega;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(i);
      const Eigen::Quaterniond change = exp_rotation(w + step) * exp_rotation(w).conjugate();
      const Eigen::Vector3d found = 2 * change.vec() / kStep;
      EXPECT_LT((found - left_jacobian(w).col(i)).norm(), 1e-5);
    }
  }
}

}  // namespace
}  // namespace nav::registration
