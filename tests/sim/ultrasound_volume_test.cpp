// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/ultrasound_volume.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <tbb/global_control.h>

#include "sim/anatomy/patient.hpp"
#include "tests/support/matchers.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;

const Patient& neck() {
  static const Patient patient = *make_patient("neck", {2, Contrast::kPortal});
  return patient;
}

UltrasoundVolumeOptions small(double apex_mm = 0) {
  UltrasoundVolumeOptions options;
  options.size = {48, 64, 48};
  options.apex_mm = apex_mm;
  return options;
}

Result<UltrasoundVolume> scan(const UltrasoundVolumeOptions& options) {
  return scan_ultrasound_volume(*neck().anatomy, neck().views[0].ct_from_image, options);
}

TEST(UltrasoundVolumeTest, BloodIsDarkerThanThyroid) {
  UltrasoundVolumeOptions options = small();
  options.size = {80, 80, 80};
  const auto scanned = scan(options);
  ASSERT_TRUE(test::has_value(scanned));
  const VoxelGrid& grid = scanned->volume.grid();
  const auto labels =
      label_bits(*neck().anatomy, grid, {{Tissue::kArtery, Tissue::kVein}, {Tissue::kThyroid}});
  double blood = 0, solid = 0;
  int bloods = 0, solids = 0;
  for (std::size_t v = 0; v < labels.size(); ++v) {
    if (labels[v] == 1) blood += scanned->volume.values()[v], ++bloods;
    if (labels[v] == 2) solid += scanned->volume.values()[v], ++solids;
  }
  ASSERT_GT(bloods, 1000);
  ASSERT_GT(solids, 1000);
  EXPECT_LT(blood / bloods, solid / solids - 40);
}

TEST(UltrasoundVolumeTest, VoxelsLieInFrontOfTheProbeFace) {
  const auto scanned = scan(small());
  ASSERT_TRUE(test::has_value(scanned));
  const auto& pose = neck().views[0].ct_from_image;
  const VoxelGrid& grid = scanned->volume.grid();
  const Vec middle(0.5 * (grid.size[0] - 1), 0, 0.5 * (grid.size[2] - 1));
  EXPECT_LT((grid.at(middle).mm - pose.translation_mm()).norm(), 1e-9);
  const Vec deep = grid.at(middle + Vec(0, grid.size[1] - 1, 0)).mm;
  EXPECT_LT((deep - (pose * Point<frames::Image>{Vec(0, 40, 0)}).mm).norm(), 1e-9);
  EXPECT_LT((scanned->face_ct.mm - pose.translation_mm()).norm(), 1e-12);
  EXPECT_NEAR(scanned->into_ct.v.norm(), 1, 1e-12);
}

TEST(UltrasoundVolumeTest, AFanLeavesTheCornersAtTheFaceBlack) {
  const auto scanned = scan(small(20));
  ASSERT_TRUE(test::has_value(scanned));
  const StoredVolume& v = scanned->volume;
  EXPECT_EQ(v.at(0, 2, 0), 0);
  EXPECT_EQ(v.at(47, 2, 24), 0);
  double middle = 0;
  for (int j = 10; j < 50; ++j) middle += v.at(24, j, 24) / 40.0;
  EXPECT_GT(middle, 20);
}

TEST(UltrasoundVolumeTest, OneAndTwoThreadsGiveEqualBytes) {
  const auto with = [](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return scan(small(30));
  };
  const auto one = with(1);
  const auto two = with(2);
  EXPECT_TRUE(std::ranges::equal(one->volume.values(), two->volume.values()));
}

TEST(UltrasoundVolumeTest, RejectsInvalidOptions) {
  UltrasoundVolumeOptions options = small();
  options.size[1] = 100000;
  EXPECT_TRUE(test::rejects(scan(options), ErrorCode::kUsage, {"size deep", "100000"}));
  options = small();
  options.depth_mm = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(test::rejects(scan(options), ErrorCode::kUsage, {"depth_mm", "nan"}));
  options = small();
  options.probe.lines = 0;
  EXPECT_TRUE(test::rejects(scan(options), ErrorCode::kUsage, {"lines", "0"}));
}

}  // namespace
}  // namespace nav::sim
