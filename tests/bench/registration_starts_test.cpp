// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <vector>

#include "bench/registration/slice_curve.hpp"
#include "bench/registration/start_curve.hpp"

namespace nav::bench {
namespace {

/// Returns a result at a distance along x from the truth.
StartTrial result(double along_mm, double cost, bool accepted, double predicted_mm) {
  return {.pose = CtPose(Eigen::Quaterniond::Identity(), {along_mm, 0, 0}),
          .cost = cost,
          .accepted = accepted,
          .predicted_mm = predicted_mm,
          .hidden_mm = 40.0};
}

StartSweep planted(std::vector<StartTrial> trials) {
  return {"fan", true, std::move(trials), {Point<frames::Reference>{{0, 0, 50}}}};
}

TEST(StartCurveTest, CountsTheResultsNearTheCheapestPose) {
  const StartSweep sweep = planted({result(0, 0.2, true, 0.2), result(0.3, 0.21, true, 0.4),
                                    result(0.1, 0.22, false, 0.3), result(9, 0.3, false, 7)});
  const auto points = count_starts({sweep});
  ASSERT_EQ(points.size(), 1U);
  EXPECT_EQ(points[0].sweeps, 1);
  EXPECT_EQ(points[0].registrations, 4);
  EXPECT_EQ(points[0].same, 3);  // The fourth result is elsewhere.
  EXPECT_EQ(points[0].accepted, 2);
  EXPECT_EQ(points[0].elsewhere, 0);
  EXPECT_EQ(points[0].split, 1);
  EXPECT_NEAR(points[0].apart_max_mm, 0.3, 1e-12);
  EXPECT_NEAR(points[0].predicted_ratio_max, 2, 1e-12);
  EXPECT_EQ(points[0].hidden_least_mm, 40);
}

TEST(StartCurveTest, EqualVerdictsAreNotCountedAsSplit) {
  const auto accepted = planted({result(0, 0.2, true, 0.2), result(0, 0.2, true, 0.2)});
  const auto refused = planted({result(0, 0.2, false, 0.2), result(9, 0.3, true, 0.2)});
  const auto points = count_starts({accepted, refused});
  EXPECT_EQ(points[0].split, 0);
  EXPECT_EQ(points[0].elsewhere, 1);  // The other pose of the second sweep.
}

TEST(StartCurveTest, GroupsByPathAndCt) {
  StartSweep other = planted({result(0, 0.5, false, 3)});
  other.own_ct = false;
  StartSweep slide = planted({result(0, 0.2, true, 0.2)});
  slide.path = "slide";
  const auto points = count_starts({planted({result(0, 0.2, true, 0.2)}), other, slide, slide});
  ASSERT_EQ(points.size(), 3U);
  EXPECT_FALSE(points[1].own_ct);
  EXPECT_EQ(points[2].path, "slide");
  EXPECT_EQ(points[2].sweeps, 2);
  const std::string text = to_text(points);
  EXPECT_NE(text.find("other CT: 1 sweeps"), std::string::npos) << text;
}

TEST(StartCurveTest, AMissingPredictionGivesAnInfiniteRatio) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  const auto some = planted({result(0, 0.2, true, 0.2), result(0, 0.2, false, kInf)});
  EXPECT_TRUE(std::isinf(count_starts({some})[0].predicted_ratio_max));
  const auto none = planted({result(0, 0.2, false, kInf), result(0, 0.2, false, kInf)});
  EXPECT_EQ(count_starts({none})[0].predicted_ratio_max, 1);
}

TEST(StartCurveTest, SweepsWithoutAPoseAreCounted) {
  const auto points = count_starts({planted({})});
  ASSERT_EQ(points.size(), 1U);
  EXPECT_EQ(points[0].sweeps, 1);
  EXPECT_EQ(points[0].registrations, 0);
  EXPECT_TRUE(std::isnan(points[0].apart_max_mm));
}

TEST(StartCurveTest, AllStartsGiveOneVerdictAndAFanHidesAShift) {
  StartCurveOptions options;
  options.sweeps.first_seed = 21;
  options.sweeps.patients = 1;
  options.sweeps.paths = {SweepPath::kFan};
  options.sweeps.hands = {};
  options.starts_mm = {3, 6, 9};
  CaseStore store;
  const auto sweeps = run_starts(options, store);
  ASSERT_TRUE(sweeps.has_value());
  const auto points = count_starts(*sweeps);
  ASSERT_EQ(points.size(), 2U);
  EXPECT_TRUE(points[0].own_ct);
  EXPECT_EQ(points[0].same, 3);
  EXPECT_EQ(points[0].accepted, 3);
  EXPECT_LT(points[0].apart_max_mm, 0.2);
  EXPECT_LT(points[0].predicted_ratio_max, 1.5);
  EXPECT_GT(points[0].hidden_least_mm, 5);
  EXPECT_EQ(points[1].accepted, 0);  // The CT of another patient.
}

TEST(SliceCurveTest, ThickSlicesAreMeansOfThinSlices) {
  VoxelGrid grid;
  grid.size = {2, 1, 5};
  grid.spacing_mm = {1, 1, 2};
  grid.origin_mm = {0, 0, 10};
  const auto thin = Volume::create(grid, {0, 100, 10, 110, 20, 121, 30, 130, 900, 900}, "thin");
  ASSERT_TRUE(thin.has_value());
  const Volume thick = with_thick_slices(*thin, 2);
  EXPECT_EQ(thick.grid().size, (std::array{2, 1, 2}));
  EXPECT_EQ(thick.grid().spacing_mm.z(), 4);
  EXPECT_EQ(thick.grid().origin_mm.z(), 11);  // Between the two slices.
  const std::vector<std::int16_t> found(thick.hu().begin(), thick.hu().end());
  EXPECT_EQ(found, (std::vector<std::int16_t>{5, 105, 25, 126}));  // The last slice has no partner
                                                                   // and is left out.
  const Volume same = with_thick_slices(*thin, 1);
  EXPECT_TRUE(std::ranges::equal(same.hu(), thin->hu()));
}

TEST(SliceCurveTest, ThickSlicesStillRegister) {
  SliceOptions options;
  options.first_seed = 21;
  options.patients = 1;
  options.thickness_mm = {2, 5};
  options.local = default_cohort().local;
  CaseStore store;
  const auto points = measure_slices(options, store);
  ASSERT_EQ(points.size(), 2U);
  for (const EffortPoint& point : points) {
    EXPECT_EQ(point.axis, "slices");
    EXPECT_EQ(point.trials, 1);
    EXPECT_EQ(point.right, 1);
    EXPECT_LT(point.error_median_mm, 0.6) << point.x;
  }
}

}  // namespace
}  // namespace nav::bench
