// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/placement.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>

#include "session/registration_file.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::session {
namespace {

TEST(PlacementTest, SaysWhetherTheUserDeclaredItOrNobodyDid) {
  const auto ct = Volume::create(VoxelGrid{{1, 1, 1}}, {0}, "one voxel");
  SweepSurvey sweep;
  sweep.paired = 1;
  PlacementOptions options;
  auto found = place_ct(options, *ct, sweep, std::nullopt, "Reference");
  ASSERT_TRUE(test::has_value(found));
  EXPECT_EQ(found->kind, "centred");
  EXPECT_EQ(found->placement.safety.state, SafetyState::kDegraded);
  EXPECT_NE(found->placement.safety.cause.find("centred on the sweep"), std::string::npos);
  EXPECT_EQ(found->placement.safety.cause.find("declaration"), std::string::npos);
  options.ct_from_reference = Eigen::Matrix4d::Identity();
  found = place_ct(options, *ct, sweep, std::nullopt, "Reference");
  ASSERT_TRUE(test::has_value(found));
  EXPECT_EQ(found->kind, "declared");
  EXPECT_EQ(found->placement.safety.state, SafetyState::kDegraded);
  EXPECT_NE(found->placement.safety.cause.find("by declaration"), std::string::npos);
}

TEST(PlacementTest, AGivenRegistrationIsReadOnceAndComparedWithTheRecordingLater) {
  const auto ct = Volume::create(VoxelGrid{{1, 1, 1}}, {0}, "one voxel");
  const test::TemporaryFolder folder;
  RecordingRead recording{.name = "sweep.igs.mha", .frames = 3, .first_s = 1, .last_s = 2};
  io::Json json;
  json["ct_sha256"] = ct_digest(*ct);
  json["recording"] = json_of(recording);
  json["registration"]["accepted"] = true;
  json["registration"][kAcceptedPose] = {1, 0, 0, 5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  PlacementOptions options;
  options.registration = folder / "registration.json";
  std::ofstream(options.registration) << json.dump();
  const auto given = given_placement(options, *ct, "Reference");
  ASSERT_TRUE(test::has_value(given));
  ASSERT_TRUE(given->has_value());
  std::filesystem::remove(options.registration);
  SweepSurvey sweep;
  sweep.paired = 1;
  const auto placed = place_sweep(options, *given, *ct, sweep, recording);
  ASSERT_TRUE(test::has_value(placed));
  EXPECT_EQ(placed->kind, "registered");
  EXPECT_EQ(placed->placement.ct_from_reference.translation_mm().x(), 5);
  recording.temporal_offset_ms = 25;
  EXPECT_TRUE(test::rejects(place_sweep(options, *given, *ct, sweep, recording),
                            ErrorCode::kMalformedData,
                            {"registration.json", "temporal offset", "25 ms"}));
}

TEST(PlacementTest, SaysHowFarASweepLiesFromACtThatItNeverMeets) {
  // Voxels from -0.5 to 9.5 mm along each axis; two images of 4 mm, 2 mm apart.
  VoxelGrid grid{{10, 10, 10}};
  SweepSurvey sweep;
  sweep.paired = 2;
  for (const double z : {0.0, 2.0}) {
    for (const double x : {0.0, 4.0}) {
      for (const double y : {0.0, 4.0}) sweep.corners.push_back({{x, y, z}});
    }
  }
  PlacementOptions options;
  const auto outside = [&](double x_mm) {
    const auto ct =
        Volume::create(grid, std::vector<std::int16_t>(grid.voxel_count(), 0), "thousand voxels");
    options.ct_from_reference = Eigen::Matrix4d::Identity();
    (*options.ct_from_reference)(0, 3) = x_mm;
    const auto found = place_ct(options, *ct, sweep, std::nullopt, "Reference");
    return found ? found->outside : found.error().message;
  };
  EXPECT_EQ(outside(9), "");
  EXPECT_EQ(outside(-4), "");
  EXPECT_EQ(outside(5000), "the sweep lies outside the CT; its nearest image is 4991 mm away");
  // Along the CT's own axes, which are not those of its frame.
  grid.directions = Eigen::AngleAxisd(M_PI / 4, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  EXPECT_NE(outside(7.1), "") << "in the box about the CT, beside the CT";
}

}  // namespace
}  // namespace nav::session
