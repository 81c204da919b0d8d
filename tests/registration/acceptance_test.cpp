// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/acceptance.hpp"

#include <cmath>
#include <functional>
#include <gtest/gtest.h>

#include "registration/error_probability.hpp"
#include "tests/support/matchers.hpp"

namespace nav::registration {
namespace {

const Point<frames::Ct> kTarget{{10, 20, 30}};

/// A result that is within every default limit.
ImageRegistrationResult good() {
  ImageRegistrationResult result{.ct_from_reference = {Eigen::Quaterniond::Identity(), {0, 0, 0}},
                                 .termination = Termination::kConverged,
                                 .message = "done",
                                 .iterations = 20,
                                 .initial_cost = 0.7,
                                 .final_cost = 0.2,
                                 .overlap = 0.95,
                                 .patches = 1000,
                                 .uncertainty = {{{0, 0, 0}}, Eigen::Matrix<double, 6, 6>::Zero()},
                                 .covariance_valid = true,
                                 .z_score = 20,
                                 .split_disagreement_mm = 0.3,
                                 .halves_disagreement_mm = 0.4,
                                 .total_s = 1.0};
  result.uncertainty.covariance.diagonal() << 1e-5, 1e-5, 1e-5, 0.04, 0.04, 0.04;
  return result;
}

TEST(AcceptanceTest, AcceptsAGoodResult) {
  const Decision decision = decide(good(), {}, kTarget);
  EXPECT_TRUE(decision.accepted);
  EXPECT_TRUE(decision.reasons.empty());
}

TEST(AcceptanceTest, EachExceededLimitIsOneReasonThatNamesIt) {
  const double nan = std::nan("");
  const double inf = std::numeric_limits<double>::infinity();
  using Spoil = std::function<void(ImageRegistrationResult&)>;
  const std::vector<std::pair<std::string, Spoil>> cases{
      {"overlap", [](auto& r) { r.overlap = 0.59; }},
      {"overlap", [&](auto& r) { r.overlap = nan; }},
      {"random poses", [](auto& r) { r.z_score = -1; }},
      {"random poses", [&](auto& r) { r.z_score = nan; }},
      {"cost", [](auto& r) { r.final_cost = 0.5; }},
      {"cost", [&](auto& r) { r.final_cost = nan; }},
      {"margin", [](auto& r) { r.margin = 0.05; }},
      {"margin", [&](auto& r) { r.margin = nan; }},
      {"predicted error", [](auto& r) { r.uncertainty.covariance *= 1000; }},
      {"predicted error", [&](auto& r) { r.uncertainty.covariance(0, 0) = nan; }},
      {"along Ct z",
       [](auto& r) {
         r.covariance_valid = false;
         r.covariance_fault = "unknown along Ct z";
       }},
      {"odd and even", [&](auto& r) { r.split_disagreement_mm = inf; }},
      {"second half", [](auto& r) { r.halves_disagreement_mm = 30; }},
      {"solver", [](auto& r) { r.termination = Termination::kFailed; }},
      {"time limit", [](auto& r) { r.termination = Termination::kTimeLimit; }},
      {"lower cost", [](auto& r) { r.basin.shift_mm = 2; }},
      {"lower cost", [&](auto& r) { r.basin.shift_mm = nan; }},
      {"scale", [](auto& r) { r.stretch.strain(1, 2) = 0.02; }},
      {"scale", [&](auto& r) { r.stretch.strain(1, 2) = nan; }},
      {"scale", [&](auto& r) { r.stretch.depth_scale = nan; }},
      {"motion of the patient",
       [](auto& r) {
         r.misfits = {{MisfitCause::kMotion, 1.3, 0.1, 0.01}};
       }},
      {"deformed relative to the CT",
       [&](auto& r) {
         r.misfits = {{MisfitCause::kBend, nan, 0, 0.01}};
       }},
  };
  for (const auto& [name, spoil] : cases) {
    ImageRegistrationResult result = good();
    spoil(result);
    const Decision decision = decide(result, {}, kTarget);
    EXPECT_FALSE(decision.accepted) << name;
    ASSERT_EQ(decision.reasons.size(), 1u) << name;
    EXPECT_NE(decision.reasons[0].find(name), std::string::npos) << decision.reasons[0];
  }
}

TEST(AcceptanceTest, HalvesThatCannotBeComparedGiveOneReason) {
  ImageRegistrationResult result = good();
  result.split_disagreement_mm = result.halves_disagreement_mm = INFINITY;
  result.split_fault = result.halves_fault = "expected two positions, found one";
  EXPECT_EQ(decide(result, {}, kTarget).reasons,
            std::vector<std::string>{
                "disagreement of the two halves of the images: expected two positions, found one"});
  result.halves_fault = "expected many, found few";
  EXPECT_EQ(decide(result, {}, kTarget).reasons.size(), 2U);
  // A reason that is already reported is not repeated.
  result.covariance_valid = false;
  result.covariance_fault = result.split_fault = result.halves_fault = "the pose is no minimum";
  EXPECT_EQ(decide(result, {}, kTarget).reasons,
            std::vector<std::string>{"uncertainty: the pose is no minimum"});
}

TEST(AcceptanceTest, NoReasonShowsANonFiniteNumber) {
  ImageRegistrationResult result = good();
  result.overlap = result.z_score = result.final_cost = std::nan("");
  result.margin = std::nan("");
  result.split_disagreement_mm = result.halves_disagreement_mm = INFINITY;
  result.basin.shift_mm = INFINITY;
  result.uncertainty.covariance(0, 0) = std::nan("");
  const Decision decision = decide(result, {}, kTarget);
  EXPECT_EQ(decision.reasons.size(), 8U);
  for (const std::string& reason : decision.reasons) {
    EXPECT_TRUE(reason.ends_with(", found no finite value")) << reason;
  }
}

TEST(AcceptanceTest, ImagesAtTooFewPositionsAreRejectedOnce) {
  ImageRegistrationResult result = good();
  result.bootstrap.places = kLeastPlaces - 1;
  result.bootstrap.fault = "expected at least 3 positions, found 2";
  const Decision decision = decide(result, {}, kTarget);
  EXPECT_FALSE(decision.accepted);
  ASSERT_EQ(decision.reasons.size(), 1U);
  EXPECT_EQ(decision.reasons[0],
            "positions at which images were acquired: expected at least 3, found 2");
  result.bootstrap = {};  // Without a bootstrap the number of positions is unknown.
  EXPECT_EQ(decide(result, {}, kTarget).verdict(), Verdict::kAccept);
}

TEST(AcceptanceTest, EachValueNearItsLimitIsOneWarningAndNoRejection) {
  EXPECT_EQ(decide(good(), {}, kTarget).verdict(), Verdict::kAccept);
  using Spoil = std::function<void(ImageRegistrationResult&)>;
  const std::vector<std::pair<std::string, Spoil>> cases{
      {"overlap of the sweep with the CT: 0.7; warning below 0.8, refused below 0.6",
       [](auto& r) { r.overlap = 0.7; }},
      {"cost of the match: 0.42; warning above 0.4, refused above 0.45",
       [](auto& r) { r.final_cost = 0.42; }},
      {"margin", [](auto& r) { r.margin = 0.2; }},
      {"predicted error", [](auto& r) { r.uncertainty.covariance *= 25; }},
      {"odd and even images: 0.8 mm", [](auto& r) { r.split_disagreement_mm = 0.8; }},
      {"second half", [](auto& r) { r.halves_disagreement_mm = 2; }},
      {"iteration limit", [](auto& r) { r.termination = Termination::kIterationLimit; }},
      {"scale", [](auto& r) { r.stretch.depth_scale = 1.009; }},
      {"lower cost", [](auto& r) { r.basin.shift_mm = 0.9; }},
      {"not from images: expected at least 6 images",
       [](auto& r) {
         r.bootstrap.places = kLeastPlaces;
         r.bootstrap.fault = "expected at least 6 images, found 2";
       }},
      {"(images 68 ms later than their poses: lower --temporal-offset-ms): 0.5 mm",
       [](auto& r) {
         r.misfits = {
             {.cause = MisfitCause::kDelay, .found_mm = 0.5, .gain = 0.01, .values = {0.068}}};
       }},
  };
  for (const auto& [name, spoil] : cases) {
    ImageRegistrationResult result = good();
    spoil(result);
    const Decision decision = decide(result, {}, kTarget);
    EXPECT_EQ(decision.verdict(), Verdict::kWarn) << name;
    EXPECT_TRUE(decision.accepted && decision.reasons.empty()) << name;
    ASSERT_EQ(decision.warnings.size(), 1U) << name;
    EXPECT_NE(decision.warnings[0].find(name), std::string::npos) << decision.warnings[0];
    result.overlap = 0.1;
    EXPECT_EQ(decide(result, {}, kTarget).verdict(), Verdict::kReject) << name;
    EXPECT_TRUE(decide(result, {}, kTarget).warnings.empty()) << name;
  }
}

TEST(AcceptanceTest, AnErrorThatWasEstimatedWithThePoseHasItsOwnLimit) {
  ImageRegistrationResult result = good();
  result.misfits = {{.cause = MisfitCause::kDelay,
                     .found_mm = 2,
                     .gain = 0.1,
                     .values = {0.04},
                     .deviations = {0.003}}};
  Decision decision = decide(result, {}, kTarget);
  EXPECT_EQ(decision.verdict(), Verdict::kWarn);
  EXPECT_NE(decision.warnings.at(0).find("images 40 +- 6 ms later than their poses"),
            std::string::npos)
      << decision.warnings.at(0);
  result.misfits[0].found_mm = 5;
  EXPECT_EQ(decide(result, {}, kTarget).verdict(), Verdict::kReject);
  // An interval that includes 0 names no cause.
  result.misfits[0].deviations = {0.03};
  EXPECT_EQ(decide(result, {}, kTarget).verdict(), Verdict::kAccept);
}

TEST(AcceptanceTest, EvidenceThatIsWeakTogetherIsRejectedByItsProbability) {
  ImageRegistrationResult result = good();
  result.final_cost = 0.35;
  result.z_score = 1;
  result.margin = 0.32;
  result.split_disagreement_mm = 0.7;
  result.halves_disagreement_mm = 1.2;
  EXPECT_GT(error_probability(result, kTarget), 0.05);
  const Decision decision = decide(result, {}, kTarget);
  EXPECT_EQ(decision.verdict(), Verdict::kReject);
  EXPECT_NE(decision.reasons.at(0).find("probability"), std::string::npos);
  EXPECT_LT(error_probability(good(), kTarget), 0.01);
  // More evidence against a result never lowers the probability.
  ImageRegistrationResult worse = result;
  worse.margin = 0.2;
  EXPECT_GT(error_probability(worse, kTarget), error_probability(result, kTarget));
  worse.covariance_valid = false;
  EXPECT_EQ(error_probability(worse, kTarget), 1);
  worse = result;
  worse.halves_disagreement_mm = std::numeric_limits<double>::infinity();
  EXPECT_GT(error_probability(worse, kTarget), 0.5);
}

TEST(AcceptanceTest, TheSimplestMisfitThatExplainsMuchIsNamed) {
  ImageRegistrationResult result = good();
  // A delay also resembles a motion.
  result.misfits = {{.cause = MisfitCause::kDelay,
                     .found_mm = 1.0,
                     .noise_mm = 0.1,
                     .gain = 0.02,
                     .values = {-0.1}},
                    {MisfitCause::kMotion, 2.0, 0.1, 0.03},
                    {MisfitCause::kBend, 1.0, 0.1, 0.2}};  // This misfit only causes a warning.
  Decision decision = decide(result, {}, kTarget);
  ASSERT_EQ(decision.reasons.size(), 1U);
  EXPECT_NE(decision.reasons[0].find("100 ms earlier"), std::string::npos) << decision.reasons[0];
  EXPECT_EQ(likeliest_misfit(result, {}), &result.misfits[0]);
  // A simpler misfit is not named if it explains little of the cost.
  result.misfits[1].gain = 0.05;
  decision = decide(result, {}, kTarget);
  ASSERT_EQ(decision.reasons.size(), 1U);
  EXPECT_NE(decision.reasons[0].find("motion of the patient"), std::string::npos)
      << decision.reasons[0];
  EXPECT_EQ(likeliest_misfit(result, {}), &result.misfits[1]);
  result.misfits.erase(result.misfits.begin(), result.misfits.begin() + 2);
  decision = decide(result, {}, kTarget);
  EXPECT_EQ(decision.verdict(), Verdict::kWarn);
  EXPECT_NE(decision.warnings.at(0).find("--deformable"), std::string::npos);
  EXPECT_EQ(likeliest_misfit(result, {}), nullptr);
  EXPECT_EQ(likeliest_misfit(result, kWarningLimits), &result.misfits[0]);
}

TEST(AcceptanceTest, AWarningLimitBeyondTheRejectionLimitHasNoEffect) {
  AcceptanceLimits strict;
  strict.max_cost = 0.25;  // The default warning limit is 0.4.
  ImageRegistrationResult result = good();
  result.final_cost = 0.26;
  EXPECT_EQ(decide(result, strict, kTarget).verdict(), Verdict::kReject);
  result.final_cost = 0.24;
  EXPECT_EQ(decide(result, strict, kTarget).verdict(), Verdict::kAccept);
}

TEST(AcceptanceTest, ARejectionRemovesTheWarnings) {
  ImageRegistrationResult result = good();
  result.final_cost = 0.42;
  Decision decision = decide(result, {}, kTarget);
  ASSERT_EQ(decision.verdict(), Verdict::kWarn);
  EXPECT_STREQ(in_words(decision.verdict()), "accepted with warnings");
  decision.reject("landmarks say otherwise");
  EXPECT_EQ(decision.verdict(), Verdict::kReject);
  EXPECT_EQ(decision.reasons, std::vector<std::string>{"landmarks say otherwise"});
  EXPECT_TRUE(decision.warnings.empty());
}

TEST(AcceptanceTest, NanCausesNoWarningButARejection) {
  Judge judge;
  judge.at_most("size", std::nan(""), 2, 1, " mm");
  judge.at_least("score", std::nan(""), 1, 2);
  const Decision decision = std::move(judge).decision();
  EXPECT_EQ(decision.reasons.size(), 2U);
  EXPECT_TRUE(decision.warnings.empty());
}

TEST(AcceptanceTest, ThePredictedErrorDependsOnTheTarget) {
  // 0.0032 rad per axis about the origin: small near the origin, but too large 2 m away.
  EXPECT_TRUE(decide(good(), {}, {{0, 0, 0}}).accepted);
  const Decision far = decide(good(), {}, {{2000, 0, 0}});
  EXPECT_FALSE(far.accepted);
  // Two axes of 0.0032 rad times 2 m, and three translations of 0.2 mm.
  EXPECT_NEAR(good().tre_rms_mm({{2000, 0, 0}}), std::sqrt(2 * 1e-5 * 4e6 + 3 * 0.04), 1e-9);
}

TEST(AcceptanceTest, AnInvalidCovarianceHasAnInfiniteError) {
  ImageRegistrationResult result = good();
  result.covariance_valid = false;
  EXPECT_TRUE(std::isinf(result.tre_rms_mm(kTarget)));
}

TEST(AcceptanceTest, RejectsInvalidLimits) {
  AcceptanceLimits limits;
  limits.min_overlap = 1.5;
  EXPECT_TRUE(test::rejects(validate(limits), ErrorCode::kUsage, {"min_overlap", "1.5"}));
  EXPECT_THROW((void)decide(good(), limits, kTarget), Bug);
  limits = {};
  limits.max_tre_rms_mm = std::nan("");
  EXPECT_TRUE(test::rejects(validate(limits), ErrorCode::kUsage, {"max_tre_rms_mm"}));
}

/// Landmarks at four corners. Each CT point is shifted by a vector of the given length.
LandmarkRegistration corners(double off_mm) {
  std::vector<LandmarkPair> pairs;
  const double signs[4] = {1, -1, 1, -1};
  const Eigen::Vector3d at[4] = {{0, 0, 0}, {60, 0, 0}, {60, 60, 0}, {0, 60, 0}};
  pairs.reserve(4);
  for (int i = 0; i < 4; ++i) {
    pairs.push_back({std::string(1, static_cast<char>('A' + i)),
                     {at[i]},
                     {at[i] + Eigen::Vector3d(0, 0, off_mm * signs[i])},
                     1});
  }
  return *register_landmarks(pairs);
}

TEST(AcceptanceTest, LandmarksAreJudgedByResidualAndPredictedError) {
  const Point<frames::Ct> centre{{30, 30, 0}};
  EXPECT_EQ(decide(corners(0.5), LandmarkLimits{}, centre).verdict(), Verdict::kAccept);
  LandmarkLimits near;
  near.max_fre_rms_mm = 0.1;
  const Decision warned = decide(corners(0.5), LandmarkLimits{}, centre, near);
  EXPECT_EQ(warned.verdict(), Verdict::kWarn);
  ASSERT_EQ(warned.warnings.size(), 1U);
  EXPECT_NE(warned.warnings[0].find("residual of the landmarks"), std::string::npos);
  const Decision apart = decide(corners(20), LandmarkLimits{}, centre);
  ASSERT_EQ(apart.reasons.size(), 2U);
  EXPECT_NE(apart.reasons[0].find("residual"), std::string::npos);
  const Decision far = decide(corners(0.5), LandmarkLimits{}, {{30, 30, 500}});
  ASSERT_EQ(far.reasons.size(), 1U);
  EXPECT_NE(far.reasons[0].find("predicted error"), std::string::npos);
  // Residuals of 3 mm show that sigmas of 1 mm were too small. The factor is sqrt(4 * 9 / 6).
  const LandmarkRegistration rough = corners(3);
  constexpr double kRounding = 1e-6;
  EXPECT_NEAR(predicted_tre_rms_mm(rough, centre), std::sqrt(6.0) * rough.tre_rms_mm(centre),
              kRounding);
}

}  // namespace
}  // namespace nav::registration
