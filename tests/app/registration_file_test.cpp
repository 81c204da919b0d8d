// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/registration_file.hpp"

#include <fstream>
#include <gtest/gtest.h>

#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::app {
namespace {

using Code = ErrorCode;

Volume volume(std::int16_t value) {
  VoxelGrid grid;
  grid.size = {2, 2, 2};
  return *Volume::create(grid, std::vector<std::int16_t>(8, value), "ct");
}

class RegistrationFileTest : public ::testing::Test {
 protected:
  auto read(const Json& json, bool follows = false) {
    const auto path = folder_ / "registration.json";
    std::ofstream(path) << json.dump();
    return read_registration(path, ct_, "Reference", follows);
  }
  Json good() const {
    Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
    matrix(1, 3) = -7.25;
    Json json;
    json["ct_sha256"] = ct_digest(ct_);
    json["registration"]["accepted"] = true;
    json["registration"]["ct_from_reference_mm"] = json_of(matrix);
    return json;
  }
  test::TemporaryFolder folder_;
  Volume ct_ = volume(40);
};

TEST_F(RegistrationFileTest, ReadsWhatRegisterWrites) {
  const auto found = read(good());
  ASSERT_TRUE(test::has_value(found));
  EXPECT_EQ(found->ct_from_reference.translation_mm().y(), -7.25);
}

TEST_F(RegistrationFileTest, APoseThatWasRefusedIsNeverTaken) {
  Json json = good();
  json["registration"][kRefusedPose] = json["registration"][kAcceptedPose];
  json["registration"].erase(kAcceptedPose);
  EXPECT_TRUE(test::refuses(read(json), Code::kMalformedData,
                            {"16 numbers in registration.ct_from_reference_mm"}));
  json["registration"]["accepted"] = false;
  EXPECT_TRUE(test::refuses(read(json), Code::kRefused, {"not accepted"}));
}

TEST_F(RegistrationFileTest, CarriesVerdictAndWarnings) {
  EXPECT_TRUE(read(good())->warnings.empty());  // A file from before there were verdicts.
  Json json = good();
  json["registration"]["verdict"] = "warn";
  json["registration"]["warnings"] = {"cost of the match: 0.3"};
  const auto found = read(json);
  ASSERT_TRUE(test::has_value(found));
  EXPECT_EQ(found->warnings, std::vector<std::string>{"cost of the match: 0.3"});
  json["registration"]["verdict"] = "accept";
  EXPECT_TRUE(test::refuses(read(json), Code::kMalformedData, {"registration.warnings", "cost"}));
  json["registration"]["verdict"] = "perhaps";
  EXPECT_TRUE(test::refuses(read(json), Code::kMalformedData, {"accept or warn", "perhaps"}));
}

TEST_F(RegistrationFileTest, BelongsToItsCt) {
  Json json = good();
  json["ct_sha256"] = ct_digest(volume(41));
  EXPECT_TRUE(test::refuses(read(json), Code::kMalformedData, {"another CT"}));
  EXPECT_NE(ct_digest(volume(40)), ct_digest(volume(41)));
}

TEST_F(RegistrationFileTest, RefusesWhatWasNotAccepted) {
  Json json = good();
  json["registration"]["accepted"] = false;
  EXPECT_TRUE(test::refuses(read(json), Code::kRefused, {"not accepted"}));
}

TEST_F(RegistrationFileTest, RefusesPosesThatAloneSayNothing) {
  Json json = good();
  json["breath"] = {{"accepted", true}};
  EXPECT_TRUE(test::refuses(read(json), Code::kRefused, {"with the breath", "--follow"}));
  EXPECT_TRUE(test::has_value(read(json, true)));  // From the pose of rest on.
  json["breath"]["accepted"] = false;
  json["deformable"] = {{"accepted", true}};
  EXPECT_TRUE(test::refuses(read(json), Code::kRefused, {"bent by a deformation"}));
  EXPECT_TRUE(test::refuses(read(json, true), Code::kRefused, {"bent by a deformation"}));
  json["deformable"]["accepted"] = false;
  EXPECT_TRUE(test::has_value(read(json)));
}

TEST_F(RegistrationFileTest, RefusesDamage) {
  Json json = good();
  json["registration"]["ct_from_reference_mm"][0] = 2;
  EXPECT_TRUE(test::refuses(read(json), Code::kMalformedData, {"scaled"}));
  json = good();
  json["registration"]["ct_from_reference_mm"].erase(3);
  EXPECT_TRUE(test::refuses(read(json), Code::kMalformedData, {"16 numbers"}));
  json = good();
  json["registration"]["ct_from_reference_mm"][3] = nullptr;
  EXPECT_TRUE(test::refuses(read(json), Code::kMalformedData, {"16 numbers", "null"}));
  json = good();
  json["registration"].erase("accepted");
  EXPECT_FALSE(read(json));
  EXPECT_TRUE(test::refuses(read(Json(3)), Code::kMalformedData, {"not JSON"}));
}

TEST_F(RegistrationFileTest, BelongsToItsReferenceFrame) {
  Json json = good();
  json["reference_frame"] = "Reference";
  EXPECT_TRUE(test::has_value(read(json)));
  json["reference_frame"] = nullptr;  // Landmarks alone.
  EXPECT_TRUE(test::has_value(read(json)));
  json["reference_frame"] = "Tracker";
  EXPECT_TRUE(test::refuses(read(json), ErrorCode::kMalformedData, {"Reference", "Tracker"}));
}

}  // namespace
}  // namespace nav::app
