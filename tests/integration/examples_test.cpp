// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/verb_table.hpp"
#include "tests/app/options/command_line_support.hpp"
#include "tests/integration/truth_file.hpp"

/// The examples of the help run as they stand, on a small simulated sweep.
namespace nav::app {
namespace {

constexpr int kLandmarks = 6;

/// Works in its folder, because the examples name files without one.
class ExamplesTest : public CommandLineTest {
 protected:
  void SetUp() override {
    before_ = std::filesystem::current_path();
    std::filesystem::current_path(folder_.path());
    const Outcome simulated = sonde(
        "simulate --out sweep.igs.mha --ct ct.mha --ct-spacing-mm 4 --duration-s 0.5 "
        "--frame-rate-hz 8 --tracker ideal --columns 64 --rows 48");
    ASSERT_EQ(simulated.code, 0) << simulated.errors;
    write_landmarks();
  }
  void TearDown() override { std::filesystem::current_path(before_); }

  /// Points of the patient, in the CT and where the truth has them in the reference frame.
  void write_landmarks() {
    const io::Json truth = read_json("sweep.igs.truth.json");
    const Eigen::Matrix4d reference_from_ct = matrix_of(truth.at("ct_from_reference_mm")).inverse();
    std::ofstream file("points.csv");
    file << "name,reference_x_mm,reference_y_mm,reference_z_mm,ct_x_mm,ct_y_mm,ct_z_mm\n";
    int number = 0;
    for (const io::Json& point : truth.at("landmarks_ct_mm")) {
      const Eigen::Vector3d ct(point.at(0), point.at(1), point.at(2));
      const Eigen::Vector3d reference = (reference_from_ct * ct.homogeneous()).head<3>();
      file << "point " << ++number;
      for (const Eigen::Vector3d& p : {reference, ct}) {
        for (const double coordinate : p) file << "," << coordinate;
      }
      file << "\n";
      if (number == kLandmarks) break;
    }
    ASSERT_GE(number, 4);
  }

  /// Runs an example of a verb and expects that it writes a file; empty: to standard output.
  void run(const char* verb, std::size_t number, const std::string& written) {
    const std::string& example = find_verb(verb)->examples.at(number);
    ASSERT_TRUE(example.starts_with("sonde ")) << example;
    const Outcome outcome = sonde(example.substr(6));
    EXPECT_EQ(outcome.code, 0) << example << "\n" << outcome.errors;
    if (written.empty()) {
      EXPECT_FALSE(outcome.output.empty()) << example;
    } else {
      EXPECT_TRUE(std::filesystem::exists(written)) << example << ": " << written;
    }
    ++run_count_;
  }

  std::filesystem::path before_;
  int run_count_ = 0;
};

TEST_F(ExamplesTest, TheExamplesOfTheHelpRun) {
  run("info", 0, "");
  run("info", 1, "");
  run("register", 1, "registration.json");
  // The replay takes a registration of its CT.
  ASSERT_EQ(sonde("register --ct ct.mha --landmarks points.csv --json registration.json").code, 0);
  run("replay", 0, "replay/replay_00000.png");
  run("slices", 0, "slices/axial.png");
  run("slices", 1, "slices/ultrasound.png");
  run("reconstruct", 0, "us.mha");
  write_ultrasound("us.mha");  // A smaller one, whose features take less time.
  run("derive", 0, "features");
  run("devices", 0, "");
  run("help", 0, "");
  run("help", 1, "");
  run("completion", 0, "");
  EXPECT_EQ(run_count_, 12);
}

}  // namespace
}  // namespace nav::app
