// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <fstream>
#include <gtest/gtest.h>
#include <sstream>

#include "app/verbs/replay.hpp"
#include "app/verbs/simulate/simulate.hpp"
#include "io/ct.hpp"
#include "io/image_output.hpp"
#include "session/registration_file.hpp"
#include "tests/integration/truth_file.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

/// Tests 'sonde replay --follow' for patients who breathe. The start is the true pose at rest.
namespace nav::app {
namespace {

using Pose = Transform<frames::Ct, frames::Reference>;

constexpr int kViewPixels = 96;

/// Recording of an abdomen that breathes with an amplitude of 10 mm, with CT and truth.
struct Patient {
  SimulateOptions options;
  io::Json truth;
  Patient(const test::TemporaryFolder& folder, std::uint64_t seed) {
    const std::string name = std::to_string(seed);
    options.out = folder / (name + ".igs.mha");
    options.ct = folder / (name + ".ct.mha");
    options.seed = seed;
    options.duration_s = 5;
    options.ct_spacing_mm = 2;
    options.breathing = "rigid";
    options.breathing_mm = 10;
    Console console(false);
    const auto written = run_simulate(options, console);
    EXPECT_TRUE(written) << written.error().message;
    truth = read_json(std::filesystem::path(options.out).replace_extension(".truth.json"));
  }
};

/// Writes a file like 'sonde register': an accepted registration of a CT at a pose, and whether the
/// breathing model was accepted.
std::filesystem::path registration_of(const std::filesystem::path& ct, const io::Json& pose,
                                      const test::TemporaryFolder& folder, bool breath = true) {
  CollectingDiagnostics unheard;
  io::Json json;
  json["ct_sha256"] = session::ct_digest(*io::read_ct(ct, unheard, {}));
  json["registration"] = {{"accepted", true}, {"ct_from_reference_mm", pose}};
  json["breath"] = {{"accepted", breath}};
  const auto path = folder / "registration.json";
  std::ofstream(path) << json.dump();
  return path;
}

SessionConfig following(const Patient& patient, const std::filesystem::path& ct,
                        const test::TemporaryFolder& folder) {
  SessionConfig config;
  config.source.recording = patient.options.out;
  config.ct.path = ct;
  config.placement.registration =
      registration_of(ct, patient.truth.at("ct_from_reference_mm"), folder);
  config.placement.follow = true;
  config.output.folder = folder / "out";
  config.output.width = config.output.height = kViewPixels;
  config.output.frames = 2;
  return config;
}

/// Returns the 3D view of the last image of a replay, without the overlay text beside and below it.
std::vector<int> last_view(const std::filesystem::path& out) {
  const auto image = io::read_png(out / "replay_00001.png");
  EXPECT_TRUE(test::has_value(image));
  std::vector<int> view;
  for (int row = 0; row < kViewPixels; ++row) {
    for (int column = 0; column < kViewPixels; ++column) {
      const Rgba8 p = image->at(column, row);
      view.insert(view.end(), {p.r, p.g, p.b});
    }
  }
  return view;
}

struct Line {
  std::size_t sequence;
  std::string state;
  Pose pose;
};

std::vector<Line> lines_of(const std::filesystem::path& path) {
  std::ifstream in(path);
  std::string text;
  std::getline(in, text);
  EXPECT_EQ(text,
            "sequence,acquired_ns,state,cost,displacement_mm,mean_displacement_mm,"
            "predicted_rms_mm,distinctness,tx_mm,ty_mm,tz_mm,qx,qy,qz,qw");
  std::vector<Line> lines;
  while (std::getline(in, text)) {
    std::vector<std::string> fields;
    std::istringstream row(text);
    for (std::string field; std::getline(row, field, ',');) fields.push_back(field);
    EXPECT_EQ(fields.size(), 15U);
    const auto at = [&](std::size_t i) { return std::stod(fields[i]); };
    lines.push_back({std::stoul(fields[0]),
                     fields[2],
                     {Eigen::Quaterniond(at(14), at(11), at(12), at(13)).normalized(),
                      {at(8), at(9), at(10)}}});
  }
  return lines;
}

/// RMS error in mm over positions of an image: the distance between the tissue at the pose and the
/// tissue in the CT.
double error_mm(const Patient& patient, const io::Json& frame, const Pose& pose) {
  const Eigen::Matrix4d now = matrix_of(frame.at("ct_from_image_mm"));
  const Eigen::Matrix4d rest = matrix_of(frame.at("rest_ct_from_image_mm"));
  const Eigen::Matrix4d image_from_pixels = matrix_of(patient.truth.at("image_from_pixels_mm"));
  const Eigen::Matrix4d reference_from_ct =
      matrix_of(patient.truth.at("ct_from_reference_mm")).inverse();
  double sum = 0;
  int count = 0;
  for (double column = 50; column < 400; column += 100) {
    for (double row = 20; row < 300; row += 80) {
      const Eigen::Vector4d image = image_from_pixels * Eigen::Vector4d(column, row, 0, 1);
      const Eigen::Vector4d found = pose.matrix() * reference_from_ct * now * image;
      sum += (found - rest * image).squaredNorm();
      ++count;
    }
  }
  return std::sqrt(sum / count);
}

TEST(FollowTest, TheCtFollowsBreathingTissue) {
  const test::TemporaryFolder folder;
  const Patient patient(folder, 502);
  Console console(false);
  const auto json = folder / "report.json";
  const auto played =
      run_replay(following(patient, patient.options.ct, folder), json.string(), console);
  ASSERT_TRUE(test::has_value(played));
  const auto lines = lines_of(folder / "out" / "following.csv");
  ASSERT_EQ(lines.size(), patient.truth.at("frames").size());
  const Pose accepted = *rigid_from_matrix<frames::Ct, frames::Reference>(
      matrix_of(patient.truth.at("ct_from_reference_mm")));
  double followed = 0, still = 0;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    ASSERT_EQ(lines[i].sequence, i);
    EXPECT_EQ(lines[i].state, "following");
    const io::Json& frame = patient.truth.at("frames")[i];
    followed += std::pow(error_mm(patient, frame, lines[i].pose), 2);
    still += std::pow(error_mm(patient, frame, accepted), 2);
  }
  const auto count = static_cast<double>(lines.size());
  EXPECT_LT(std::sqrt(followed / count), 0.4 * std::sqrt(still / count));
  EXPECT_LT(std::sqrt(followed / count), 2.5);
  const io::Json summary = read_json(json).at("following");
  EXPECT_EQ(summary.at("pictures"), lines.size());
  EXPECT_EQ(summary.at("states").at("following"), lines.size());
  EXPECT_TRUE(summary.at("alarms").empty());
  EXPECT_GT(summary.at("largest_displacement_mm"), 5);

  // The rendered CT is at the pose that follows, not at the pose of the registration.
  const auto drawn = last_view(folder / "out");
  SessionConfig held = following(patient, patient.options.ct, folder);
  held.placement.follow = false;
  held.placement.registration =
      registration_of(patient.options.ct, patient.truth.at("ct_from_reference_mm"), folder, false);
  ASSERT_TRUE(test::has_value(run_replay(held, json.string(), console)));
  EXPECT_NE(last_view(folder / "out"), drawn);
}

TEST(FollowTest, TheCtOfAnotherPatientIsHiddenWithAWarning) {
  const test::TemporaryFolder folder;
  const Patient patient(folder, 502);
  const Patient other(folder, 501);
  Console console(false);
  const auto json = folder / "report.json";
  ASSERT_TRUE(test::has_value(
      run_replay(following(patient, other.options.ct, folder), json.string(), console)));
  const auto lines = lines_of(folder / "out" / "following.csv");
  ASSERT_EQ(lines.back().state, "lost");
  const io::Json alarms = read_json(json).at("following").at("alarms");
  ASSERT_FALSE(alarms.empty());
  EXPECT_EQ(alarms.back().at("state"), "lost");
  const auto& entries = console.entries();
  EXPECT_TRUE(std::any_of(entries.begin(), entries.end(), [](const DiagnosticEntry& entry) {
    return entry.source == "follow" && entry.severity == Severity::kWarning &&
           entry.message.find("register again") != std::string::npos;
  }));
}

TEST(FollowTest, OnlyARegisteredCtWithARecordingCanFollow) {
  SessionConfig config;
  config.placement.follow = true;
  EXPECT_TRUE(test::rejects(validate(config), ErrorCode::kUsage,
                            {"placement.follow", "registered", "none"}));
  config.placement.ct_from_reference = Eigen::Matrix4d::Identity();
  EXPECT_TRUE(test::rejects(validate(config), ErrorCode::kUsage, {"only declared"}));
  config.placement.ct_from_reference.reset();
  config.placement.registration = "registration.json";
  EXPECT_TRUE(test::has_value(validate(config)));
  config.source.kind = SessionConfig::SourceKind::kSimulated;
  EXPECT_TRUE(test::rejects(validate(config), ErrorCode::kUsage, {"a recording"}));
}

}  // namespace
}  // namespace nav::app
