// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/registration_file.hpp"

#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <vector>

#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::session {
namespace {

using Code = ErrorCode;

Volume volume(std::int16_t value) {
  VoxelGrid grid;
  grid.size = {2, 2, 2};
  return *Volume::create(grid, std::vector<std::int16_t>(8, value), "ct");
}

class RegistrationFileTest : public ::testing::Test {
 protected:
  auto read(const io::Json& json, bool follows = false,
            const std::optional<RecordingRead>& recording = {}) {
    const auto path = folder_ / "registration.json";
    std::ofstream(path) << json.dump();
    auto found = read_registration(path, ct_, {"Reference", follows});
    if (found && found->recording && recording) {
      const auto fits = check_recording(*found->recording, *recording, path);
      if (!fits) found = fits.error();
    }
    return found;
  }
  io::Json good() const {
    io::Json json;
    json["ct_sha256"] = ct_digest(ct_);
    json["registration"]["accepted"] = true;
    json["registration"]["ct_from_reference_mm"] = {1, 0, 0, 0, 0, 1, 0, -7.25,
                                                    0, 0, 1, 0, 0, 0, 0, 1};
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
  io::Json json = good();
  json["registration"][kRefusedPose] = json["registration"][kAcceptedPose];
  EXPECT_TRUE(test::rejects(read(json), Code::kMalformedData,
                            {"without registration.refused_ct_from_reference_mm"}));
  json["registration"].erase(kAcceptedPose);
  EXPECT_FALSE(read(json));
  json["registration"].erase(kRefusedPose);
  EXPECT_TRUE(test::rejects(read(json), Code::kMalformedData,
                            {"16 numbers in registration.ct_from_reference_mm"}));
  json = good();
  json["registration"][kRefusedPose] = json["registration"][kAcceptedPose];
  json["registration"]["accepted"] = false;
  EXPECT_TRUE(test::rejects(read(json), Code::kRefused, {"not accepted"}));
}

TEST_F(RegistrationFileTest, ReadsTheCovarianceOfThePoseAndRejectsADamagedOne) {
  EXPECT_FALSE(read(good())->uncertainty) << "of landmarks";
  io::Json json = good();
  io::Json& registration = json["registration"];
  registration["covariance_valid"] = true;
  registration["covariance_centre_ct_mm"] = {1, 2, 3};
  registration["covariance"] = std::vector<double>(36, 0.0);
  for (std::size_t i = 0; i < 6; ++i) registration["covariance"][7 * i] = 0.25;
  const auto found = read(json);
  ASSERT_TRUE(test::has_value(found));
  ASSERT_TRUE(found->uncertainty);
  EXPECT_EQ(found->uncertainty->centre_ct.mm, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(found->uncertainty->covariance(5, 5), 0.25);
  registration["covariance"][1] = 0.1;
  EXPECT_TRUE(test::rejects(read(json), Code::kMalformedData, {"symmetric"}));
  registration["covariance"][1] = 0;
  registration["covariance"][0] = -0.25;
  EXPECT_TRUE(test::rejects(read(json), Code::kMalformedData, {"negative variance"}));
  registration["covariance"] = {1, 2};
  EXPECT_TRUE(test::rejects(read(json), Code::kMalformedData, {"36 numbers"}));
  registration["covariance_valid"] = false;
  EXPECT_FALSE(read(json)->uncertainty) << "the sweep does not determine a direction";
}

TEST_F(RegistrationFileTest, CarriesVerdictAndWarnings) {
  EXPECT_TRUE(read(good())->warnings.empty());  // A file from before there were verdicts.
  io::Json json = good();
  json["registration"]["verdict"] = "warn";
  json["registration"]["warnings"] = {"cost of the match: 0.3"};
  const auto found = read(json);
  ASSERT_TRUE(test::has_value(found));
  EXPECT_EQ(found->warnings, std::vector<std::string>{"cost of the match: 0.3"});
  json["registration"]["verdict"] = "accept";
  EXPECT_TRUE(test::rejects(read(json), Code::kMalformedData, {"registration.warnings", "cost"}));
  json["registration"]["verdict"] = "perhaps";
  EXPECT_TRUE(test::rejects(read(json), Code::kMalformedData, {"accept or warn", "perhaps"}));
}

TEST_F(RegistrationFileTest, BelongsToItsCt) {
  io::Json json = good();
  json["ct_sha256"] = ct_digest(volume(41));
  EXPECT_TRUE(test::rejects(read(json), Code::kMalformedData, {"another CT"}));
  EXPECT_NE(ct_digest(volume(40)), ct_digest(volume(41)));
}

TEST_F(RegistrationFileTest, RejectsWhatWasNotAccepted) {
  io::Json json = good();
  json["registration"]["accepted"] = false;
  EXPECT_TRUE(test::rejects(read(json), Code::kRefused, {"not accepted"}));
}

TEST_F(RegistrationFileTest, RejectsPosesThatAloneSayNothing) {
  io::Json json = good();
  json["breath"] = {{"accepted", true}};
  EXPECT_TRUE(test::rejects(read(json), Code::kRefused, {"with the breath", "--follow"}));
  EXPECT_TRUE(test::has_value(read(json, true)));  // From the pose of rest on.
  json["breath"]["accepted"] = false;
  json["deformable"] = {{"accepted", true}};
  EXPECT_TRUE(test::rejects(read(json), Code::kRefused, {"bent by a deformation"}));
  EXPECT_TRUE(test::rejects(read(json, true), Code::kRefused, {"bent by a deformation"}));
  json["deformable"]["accepted"] = false;
  EXPECT_TRUE(test::has_value(read(json)));
}

TEST_F(RegistrationFileTest, RejectsDamage) {
  io::Json json = good();
  json["registration"]["ct_from_reference_mm"][0] = 2;
  EXPECT_TRUE(test::rejects(read(json), Code::kMalformedData, {"scaled"}));
  json = good();
  json["registration"]["ct_from_reference_mm"].erase(3);
  EXPECT_TRUE(test::rejects(read(json), Code::kMalformedData, {"16 numbers"}));
  json = good();
  json["registration"]["ct_from_reference_mm"][3] = nullptr;
  EXPECT_TRUE(test::rejects(read(json), Code::kMalformedData, {"16 numbers", "null"}));
  json = good();
  json["registration"].erase("accepted");
  EXPECT_FALSE(read(json));
  EXPECT_TRUE(test::rejects(read(io::Json(3)), Code::kMalformedData,
                            {"the JSON object of 'sonde register', found 3"}));
}

TEST_F(RegistrationFileTest, TakesNoTextThatCanBeReadInTwoWays) {
  const auto path = folder_ / "registration.json";
  const auto read_text = [&](const std::string& text) {
    std::ofstream(path) << text;
    return read_registration(path, ct_, {"Reference", false});
  };
  std::string twice = good().dump();
  const std::string accepted = "\"accepted\":true";
  ASSERT_NE(twice.find(accepted), std::string::npos);
  twice.replace(twice.find(accepted), accepted.size(), "\"accepted\":false," + accepted);
  EXPECT_TRUE(test::rejects(read_text(twice), Code::kMalformedData, {"\"accepted\" twice"}));
  EXPECT_TRUE(test::rejects(read_text("{\"registration\""), Code::kMalformedData,
                            {"registration.json", "expected JSON"}));
  // Deeper than the stack is high.
  constexpr std::size_t kDeep = 2'000'000;
  EXPECT_TRUE(test::rejects(
      read_text("{\"verb\":" + std::string(kDeep, '[') + std::string(kDeep, ']') + "}"),
      Code::kMalformedData, {"at most 64 levels"}));
}

TEST_F(RegistrationFileTest, BelongsToOneReadingOfItsRecording) {
  RecordingRead recording{.name = "sweep.igs.mha",
                          .frames = 46,
                          .first_s = 10.25,
                          .last_s = 13.5,
                          .temporal_offset_ms = -40};
  recording.corners[0].mm = {-18.5, 2, 0.1};
  recording.corners[1].mm = {18.5, 2, 0.3};
  recording.corners[2].mm = {-18.5, 62, 0.2};
  io::Json json = good();
  EXPECT_TRUE(test::has_value(read(json, false, recording)));  // Older, or by landmarks.
  json["recording"] = json_of(recording);
  EXPECT_TRUE(test::has_value(read(json, false, recording)));
  EXPECT_TRUE(test::has_value(read(json)));

  RecordingRead other = recording;
  other.temporal_offset_ms = 25;
  EXPECT_TRUE(test::rejects(read(json, false, other), Code::kMalformedData,
                            {"expected the temporal offset that sweep.igs.mha was registered with, "
                             "-40 ms, found 25 ms"}));
  other = recording;
  other.corners[2].mm.y() += 1.5;  // Other pixels do this.
  EXPECT_TRUE(test::rejects(read(json, false, other), Code::kMalformedData,
                            {"expected the calibration of the probe that sweep.igs.mha was",
                             "found one that puts a corner of its images 1.5 mm elsewhere"}));
  // Another recording may be of another probe.
  for (const auto& change : std::vector<std::function<void(RecordingRead&)>>{
           [](RecordingRead& r) { r.name = "fan.igs.mha"; },
           [](RecordingRead& r) { r.frames = 47; }, [](RecordingRead& r) { r.first_s += 0.01; },
           [](RecordingRead& r) { *r.last_s += 0.01; }}) {
    RecordingRead another = other;
    change(another);
    EXPECT_TRUE(test::has_value(read(json, false, another)));
  }
  for (const char* key : {"name", "frames", "first_s", "last_s", "temporal_offset_ms"}) {
    io::Json damaged = json;
    damaged["recording"][key] = io::Json::array();
    EXPECT_TRUE(test::rejects(read(damaged, false, recording), Code::kMalformedData,
                              {"9 corners_probe_mm in recording"}));
  }
  json["recording"]["corners_probe_mm"][8] = "deep";
  EXPECT_TRUE(test::rejects(read(json, false, recording), Code::kMalformedData, {"\"deep\""}));
}

TEST_F(RegistrationFileTest, RejectsWhatContradictsItself) {
  io::Json json = good();
  json["registration"]["reasons"] = io::Json::array();
  json["verb"] = "register";
  EXPECT_TRUE(test::has_value(read(json)));
  json["verb"] = "demo";
  EXPECT_TRUE(test::rejects(read(json), Code::kMalformedData,
                            {"the JSON of 'sonde register' in verb, found \"demo\""}));
  json = good();
  json["registration"]["reasons"] = {"cost of the match: 0.6"};
  EXPECT_TRUE(test::rejects(read(json), Code::kMalformedData,
                            {"with empty registration.reasons", "cost of the match"}));
}

TEST_F(RegistrationFileTest, RejectsAnotherVerdictBesideTheRegistration) {
  io::Json json = good();
  json["accepted"] = true;
  json["verdict"] = "accept";
  EXPECT_TRUE(test::has_value(read(json)));
  json["accepted"] = false;
  EXPECT_TRUE(test::rejects(
      read(json), Code::kMalformedData,
      {"expected accepted and registration.accepted to agree, found false and true"}));
  json = good();
  json["registration"]["verdict"] = "accept";
  for (const char* other : {"refuse", "rejected", "warn"}) {
    json["verdict"] = other;
    EXPECT_TRUE(test::rejects(read(json), Code::kMalformedData,
                              {"expected verdict and registration.verdict to agree", other}));
  }
}

TEST_F(RegistrationFileTest, RejectsErrorsBeyondTheLimitsOfAcceptance) {
  const std::vector<std::pair<const char*, double>> limits{{"predicted_target_error_rms_mm", 2},
                                                           {"target_error_rms_mm", 2},
                                                           {"fre_rms_mm", 5},
                                                           {"error_probability", 0.03}};
  for (const auto& [key, limit] : limits) {
    io::Json json = good();
    json["effort"] = "usual";
    json["registration"][key] = limit;
    EXPECT_TRUE(test::has_value(read(json))) << key;
    for (const io::Json& beyond : {io::Json(1.01 * limit), io::Json(), io::Json("small")}) {
      json["registration"][key] = beyond;
      EXPECT_TRUE(test::rejects(read(json), Code::kMalformedData, {key, "of at most"})) << key;
    }
  }
  io::Json json = good();
  json["registration"]["landmarks"] = {{"apart_mm", 3.5}, {"limit_mm", 4}};
  EXPECT_TRUE(test::has_value(read(json)));
  json["registration"]["landmarks"]["apart_mm"] = 12;
  EXPECT_TRUE(test::rejects(read(json), Code::kMalformedData,
                            {"registration.landmarks.apart_mm of at most 4, found 12"}));
}

TEST_F(RegistrationFileTest, OneMadeWithoutACtIsOfNone) {
  io::Json json = good();
  json["ct_sha256"] = nullptr;
  EXPECT_TRUE(test::rejects(read(json), Code::kMalformedData,
                            {"expected a registration of ct, found one that was made without a CT "
                             "(register with --ct)"}));
}

TEST_F(RegistrationFileTest, BelongsToItsReferenceFrame) {
  io::Json json = good();
  json["reference_frame"] = "Reference";
  const auto named = read(json);
  ASSERT_TRUE(test::has_value(named));
  EXPECT_TRUE(named->names_frame);
  json["reference_frame"] = nullptr;  // Landmarks alone.
  const auto unnamed = read(json);
  ASSERT_TRUE(test::has_value(unnamed));
  EXPECT_FALSE(unnamed->names_frame);
  json["reference_frame"] = "Tracker";
  EXPECT_TRUE(test::rejects(read(json), ErrorCode::kMalformedData, {"Reference", "Tracker"}));
}

}  // namespace
}  // namespace nav::session
