// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Runs the program sonde-bench as a user does.
#include "bench/verbs/bench_command_line.hpp"

#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "tests/app/options/command_line_support.hpp"

namespace nav::bench {
namespace {

using app::Outcome;

class BenchCommandLineTest : public app::CommandLineTest {
 protected:
  BenchCommandLineTest() {
    program_ = "sonde-bench";
    run_ = &run_command_line;
  }
};

/// `sonde bench …` prints the output of sonde-bench, and names the command as the user typed it.
TEST_F(BenchCommandLineTest, SondeRunsTheProgramBesideIt) {
  for (const char* arguments : {"--help", "render --help", "gallery --help", "--version"}) {
    const Outcome here = sonde(arguments);
    const Outcome there = built_sonde(std::string("bench ") + arguments);
    EXPECT_EQ(here.code, 0) << here.errors;
    EXPECT_EQ(there.code, 0) << there.errors;
    std::string expected = here.output;
    const std::string usage = "Usage: sonde-bench";
    const auto at = expected.find(usage);
    if (at != std::string::npos) expected.replace(at, usage.size(), "Usage: sonde bench");
    EXPECT_EQ(there.output, expected);
  }
  const Outcome help = built_sonde("-v gallery --help");
  EXPECT_EQ(help.code, 0);
  EXPECT_NE(help.output.find("sonde gallery"), std::string::npos) << help.output;
  for (const auto& [arguments, sentence] : std::vector<std::pair<std::string, std::string>>{
           {"bench render foo",
            "sonde bench render: expected no further argument than 'sonde bench render --help' "
            "lists, found foo"},
           {"bench foo",
            "sonde bench: expected one of render, predicates, scaling, registration, derived, "
            "vessels, reconstruct, devices or "
            "gallery, found 'foo'"},
           {"gallery", "--out: expected a value (folder to write to), found none"}}) {
    expect_rejection(built_sonde(arguments), arguments, 2, {"sonde-bench: error: " + sentence});
  }
}

TEST_F(BenchCommandLineTest, WhatCannotBeParsedIsToldAsEverythingElse) {
  for (const auto& [arguments, sentence] : std::vector<std::pair<std::string, std::string>>{
           {"render --width five", "--width: expected 16 to 8192 pixels, found five"},
           {"scaling --largest 9999", "--largest: expected 64 to 768 voxels, found 9999"},
           {"registration --patients 0", "--patients: expected 1 to 100 patients, found 0"},
           {"render --part x", "--part: expected compare, live, skipping or costs, found x"},
           {"registration --model x", "--model: expected rays or scatterers, found x"},
           {"registration --effort x", "--effort: expected quick or usual, found x"},
           {"derived --threads 100000", "--threads: expected 0 to 1024 threads, found 100000"},
           {"render foo",
            "sonde-bench render: expected no further argument than 'sonde-bench render --help' "
            "lists, found foo"},
           {"foo",
            "verb: expected one of render, predicates, scaling, registration, derived, vessels, "
            "reconstruct, devices "
            "or gallery, "
            "found 'foo'"}}) {
    expect_rejection(arguments, 2, {"sonde-bench: error: " + sentence});
  }
}

TEST_F(BenchCommandLineTest, OptionsThatWouldDoNothingAreRejected) {
  for (const auto& [arguments, rejection] : std::vector<std::pair<std::string, std::string>>{
           {"render --part live --scene x",
            "--scene requires --part compare, skipping or costs, found live"},
           {"render --part live --ct x", "--ct requires --part compare, skipping or costs"},
           {"render --part skipping --costs", "--costs requires --part live"},
           {"render --part skipping --width 64", "--width requires --part compare, live or costs"},
           {"render --quick --height 64", "--height requires no --quick"},
           {"predicates --quick --side 64", "--side requires no --quick"},
           {"predicates --volume prostate --side 64",
            "--side requires a simulated --volume, found prostate"},
           {"predicates --engine gl --threads 1", "--threads requires --engine cpu or both"},
           {"predicates --volume two --threads 1", "--threads requires a --volume"},
           {"predicates --volume features --width 300", "--width requires a --volume that"},
           {"predicates --volume features --look vessel", "--look requires a --volume that"},
           {"predicates --look vessel", "--look requires a --volume that has some"},
           {"predicates --volume features --engine gl", "--engine requires --volume of"},
           {"registration --part skin --trials t.csv", "--trials requires --part cohort"},
           {"registration --part skin --effort quick", "--effort requires --part cohort, faults"},
           {"registration --part skin --no-evaluation", "--no-evaluation requires --part"},
           {"registration --part curve --patients 2", "--patients requires a --part other"},
           {"derived --quick --side 64",
            "--side requires no --quick, which has a side of its own, found both"}}) {
    expect_rejection(arguments, 2, {rejection});
  }
}

TEST_F(BenchCommandLineTest, OutputsAreCheckedBeforeAnythingIsMeasured) {
  const std::string nowhere = (folder_ / "none" / "x").string();
  for (const char* arguments : {"render --quick --json ", "predicates --quick --json ",
                                "derived --json ", "registration --json "}) {
    expect_rejection(arguments + nowhere, 3, {"--json: ", "none/x"});
  }
  const std::string ct = write_ct();
  expect_rejection("render --ct " + ct + " --json " + ct, 2, {"--json", "that of --ct"});
  expect_rejection("registration --trials x --json x", 2, {"--trials", "that of --json"});
}

TEST_F(BenchCommandLineTest, AGallerySaysWhichImagesThereAre) {
  expect_rejection("gallery --only nope --out " + (folder_ / "gallery").string(), 2,
                   {"--only", "fig2a", "registration-sweep", "simulator-spine", "predicates-inside",
                    "found nope"});
}

TEST_F(BenchCommandLineTest, AGalleryOfNothingFails) {
  const std::string out = " --out " + (folder_ / "gallery").string();
  expect_rejection("gallery --engine foo --only simulator-vessel" + out, 2,
                   {"cpu, gl or reference", "foo"});
  const char* data = std::getenv("SONDE_DATA_DIR");
  const std::string before = data == nullptr ? "" : data;
  ::setenv("SONDE_DATA_DIR", (folder_ / "no-data").c_str(), 1);
  expect_rejection(
      "gallery --only fig2a" + out, 3,
      {"no-data", "expected the data of fig2a", "SONDE_DATA_DIR", "nothing was drawn"});
  if (data == nullptr) {
    ::unsetenv("SONDE_DATA_DIR");
  } else {
    ::setenv("SONDE_DATA_DIR", before.c_str(), 1);
  }
}

TEST_F(BenchCommandLineTest, SkippingIsMeasuredAboutACubicPatientAlone) {
  const auto json = folder_ / "bench.json";
  const Outcome outcome = sonde(
      "render --quick --part skipping --scene patient-64/vessels-only --json " + json.string());
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const io::Json report = read_json("bench.json");
  ASSERT_EQ(report["skip_bounds"].size(), 1U);
  EXPECT_EQ(report["skip_bounds"][0]["scene"], "patient-64/vessels-only/perspective/shaded");
  EXPECT_EQ(report["skip_bounds"][0]["bit_identical"], true);
  EXPECT_TRUE(report["ratios"]["samples_skip_off_over_on"]["bit_identical"].is_null());
  expect_rejection("render --part skipping --scene patient-257", 2, {"--scene", "patient-257"});
}

}  // namespace
}  // namespace nav::bench
