// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Options that have no effect, contradict each other or are out of range.
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "app/report.hpp"
#include "tests/app/options/command_line_support.hpp"
#include "tests/support/test_data.hpp"

namespace nav::app {
namespace {

struct Idle {
  std::string arguments;
  std::string rejection;
};

TEST_F(CommandLineTest, EmptyValuesAreRejected) {
  for (const char* option : {"--appearance", "--session", "--json", "--save-appearance",
                             "--us-volume", "--config", "--registration", "--series"}) {
    expect_rejection("replay x.mha --print-session " + std::string(option) + " ''", 2,
                     {std::string(option) + ": expected a value, found ''"});
  }
  expect_rejection("predicates ''", 2, {"volume: expected a value, found ''"});
  EXPECT_EQ(sonde("replay x.mha --print-session --needle-frame ''").code, 0);
}

TEST_F(CommandLineTest, AnOptionReplacesItsAlternativeInTheSession) {
  const auto session = folder_ / "session.toml";
  const auto printed = [&](const std::string& file, const std::string& options) {
    std::ofstream(session) << file;
    const Outcome outcome = sonde(options + " --print-session --session " + session.string());
    EXPECT_EQ(outcome.code, 0) << options << ": " << outcome.errors;
    return outcome.output;
  };
  const std::string draw = "predicates --predicates tendon-fibres --phantom-side 32";
  std::string text = printed("[predicates]\ninto = [0, 1, 0]\n", draw + " --scan-lines s.json");
  EXPECT_NE(text.find("scan_lines"), std::string::npos) << text;
  EXPECT_EQ(text.find("into"), std::string::npos) << text;
  text = printed("[predicates]\nscan_lines = \"s.json\"\n", draw + " --apex 0 0 0");
  EXPECT_EQ(text.find("scan_lines"), std::string::npos) << text;
  text = printed("[predicates]\nlayers = \"l.json\"\n", draw + " --labels l.mha");
  EXPECT_EQ(text.find("l.json"), std::string::npos) << text;
  text = printed("[predicates]\nlabels = [\"l.mha\"]\n", draw + " --layers l.json");
  EXPECT_EQ(text.find("l.mha"), std::string::npos) << text;
  text = printed("[look]\nfile = \"l.json\"\n", "replay x.mha --transfer-function ct-liver");
  EXPECT_EQ(text.find("l.json"), std::string::npos) << text;
  EXPECT_NE(text.find("ct-liver"), std::string::npos) << text;
  text = printed("[output]\nstep_voxels = 0.5\n", "replay x.mha --rms-error 0.01");
  EXPECT_EQ(text.find("step_voxels"), std::string::npos) << text;
}

TEST_F(CommandLineTest, SimulationOptionsWithoutEffectAreRejected) {
  const std::string out = (folder_ / "sweep.mha").string();
  for (const auto& [arguments, rejection] : std::vector<Idle>{
           {"--ct-spacing-mm 2", "--ct-spacing-mm requires --ct"},
           {"--contrast native", "--contrast requires --ct"},
           {"--look-at 1 2 3", "--look-at requires --patient-ct"},
           {"--patient-ct x --family neck", "--family has no effect with --patient-ct"},
           {"--patient-ct x --ct y.mha --contrast native",
            "--contrast has no effect with --patient-ct"},
           {"--needle-speed-mm-s 4",
            "--needle-speed-mm-s requires --needle straight, bevel or tip-load (found none)"},
           {"--needle none --needle-bending-mm 4", "--needle-bending-mm requires --needle"},
           {"--needle none --needle-length-mm 90", "--needle-length-mm requires --needle"},
           {"--needle-bevel-deg 9", "--needle-bevel-deg requires --needle"},
           {"--needle straight --needle-bevel-deg 9",
            "--needle-bevel-deg requires --needle bevel or tip-load (found straight)"},
           {"--path rock --length-mm 30", "--length-mm requires --path sweep or tilt (found rock)"},
           {"--path fan --length-mm 30", "--length-mm requires --path sweep or tilt"},
           {"--angle-deg 30", "--angle-deg requires --path fan, rock or tilt (found sweep)"}}) {
    expect_rejection("simulate --columns 16 --rows 16 --out " + out + " " + arguments, 2,
                     {rejection});
    EXPECT_FALSE(std::filesystem::exists(out)) << arguments;
  }
  const Outcome all = sonde(
      "simulate --columns 16 --rows 16 --duration-s 0.2 --out " + out + " --ct " +
      (folder_ / "small.mha").string() +
      " --ct-spacing-mm 20 --contrast native --path tilt --length-mm 30 --angle-deg 20 --needle "
      "bevel --needle-bevel-deg 9 --needle-length-mm 200");
  EXPECT_EQ(all.code, 0) << all.errors;
}

TEST_F(CommandLineTest, AppearanceOptionsWithoutEffectAreRejected) {
  for (const auto& [arguments, rejection] : std::vector<Idle>{
           {"--grey-width 400",
            "--grey-width requires --projection maximum, minimum or mean (found composite)"},
           {"--projection mean --appearance a.vp",
            "--appearance requires --projection composite (found mean)"},
           {"--projection mean --importance 1:2=1", "--importance requires --projection"},
           {"--projection mean --emphasis 1", "--emphasis requires --projection"},
           {"--projection mean --cutaway-outer 40", "--cutaway-outer requires --projection"},
           {"--appearance a.vp --transfer-function ct-bone",
            "--transfer-function cannot be combined with --appearance"},
           {"--projection mean --no-shading", "--no-shading requires --projection composite"},
           {"--projection mean --no-cutaway", "--no-cutaway requires --projection composite"},
           {"--rms-error 0.01 --pixel-error 0.1",
            "--rms-error cannot be combined with --pixel-error"},
           {"--engine reference --pixel-error 0.1",
            "--pixel-error requires --engine cpu or gl (found reference)"},
           {"--transfer-function nope", "--transfer-function: expected contextual, ct-bone, "},
           {"--no-shading --shading gooch", "--shading has no effect with --no-shading"},
           {"--no-shading --emphasis 1", "--emphasis has no effect with --no-shading"},
           {"--no-cutaway --cutaway-inner 20", "--cutaway-inner has no effect with --no-cutaway"},
           {"--no-cutaway --cutaway-around needle", "--cutaway-around "},
           {"--no-cutaway --cutaway-overlay 5",
            "--cutaway-overlay has no effect with --no-cutaway"},
           {"--step 1 --rms-error 0.01", "--rms-error cannot be combined with --step"}}) {
    expect_rejection("demo --out x " + arguments, 2, {rejection});
    expect_rejection("replay x.mha --print-session " + arguments, 2, {rejection});
  }
  const Outcome grey = sonde("replay x.mha --print-session --projection mean --grey-level 40");
  EXPECT_EQ(grey.code, 0) << grey.errors;
}

TEST_F(CommandLineTest, RetiredOptionsAreIgnoredWithAWarning) {
  const Outcome plain = sonde("replay x.mha --print-session");
  const Outcome outcome = sonde("replay x.mha --print-session --adaptive-error 0.1");
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_EQ(outcome.output, plain.output);
  EXPECT_TRUE(outcome.errors.starts_with("sonde: warning: --adaptive-error")) << outcome.errors;
  EXPECT_EQ(sonde("replay --help").output.find("--adaptive-error"), std::string::npos);
}

TEST_F(CommandLineTest, OptionsOfAReplayThatWouldDoNothingAreRejected) {
  const std::string ct = write_ct();
  for (const auto& [arguments, rejection] : std::vector<Idle>{
           {"--ct " + ct + " --series 1.2.3", "--series requires a DICOM folder (found "},
           {"--us-alone", "--us-alone requires --us-volume"},
           {"--height 200 --window-level 60",
            "--window-level requires a larger 3D view, beside which the CT fits (found 800 x 200)"},
           {"--ct-importance 1", "--ct-importance requires --us-volume"},
           {"--predicates layers", "--predicates requires --us-volume"},
           {"--labels a.mha", "--labels requires --us-volume"},
           {"--into 0 1 0", "--into requires --us-volume"},
           {"--us-volume u.mha --us-alone --ct-importance 1",
            "--ct-importance has no effect with --us-alone"},
           {"--us-volume u.mha --us-alone --rms-error 0.01",
            "--rms-error has no effect with --us-alone"},
           {"--us-volume u.mha --us-alone --classification post-classified",
            "--classification has no effect with --us-alone"},
           {"--us-volume u.mha --us-alone --transfer-function ct-bone",
            "--transfer-function has no effect with --us-alone"},
           {"--us-volume u.mha --us-alone --no-shading",
            "--no-shading has no effect with --us-alone"},
           {"--us-volume u.mha --pixel-error 0.1", "--pixel-error has no effect with --us-volume"},
           {"--us-volume u.mha --predicates carotid-vessel --labels a.mha",
            "--labels requires a predicate label (carotid-vessel has none)"},
           {"--us-volume u.mha --predicates layers --cache c",
            "--cache requires a predicate of a derived feature (layers has none)"},
           {"--us-volume u.mha --face-radius-mm 9", "--face-radius-mm requires --apex"},
           {"--us-volume u.mha --projection mean",
            "--us-volume requires --us-alone or --projection composite (found mean)"},
           {"--cutaway-around plane,needle",
            "--cutaway-around requires --needle-frame for the needle"},
           {"--needle-frame Needle --cutaway-around needle,targets",
            "--cutaway-around requires a session file with a plan for the targets"}}) {
    expect_rejection("replay x.mha --print-session " + arguments, 2, {rejection});
  }
  // Inputs in a session file count as given.
  const auto session = folder_ / "session.toml";
  std::ofstream(session) << "[predicates]\nvolume = \"u.mha\"\n";
  const std::string with_session = "replay --print-session --session " + session.string();
  EXPECT_EQ(sonde(with_session + " --us-alone --apex 0 0 0 --face-radius-mm 9").code, 0);
  std::ofstream(session) << "[plan]\nentry_mm = [0,-9,0]\ntarget_mm = [0,0,0]\n"
                            "target_radius_mm = 4\n";
  EXPECT_EQ(sonde(with_session + " --needle-frame N --cutaway-around needle,targets").code, 0);
  std::ofstream(session) << "[source]\nkind = \"simulated\"\n";
  EXPECT_EQ(sonde(with_session + " --out x --cutaway-around needle,targets").code, 0);
  EXPECT_EQ(sonde(with_session + " --out x --frames 2").code, 0);
  expect_rejection(with_session + " x.mha", 2,
                   {"sweep requires a session of a recording (found the simulated procedure)"});
  expect_rejection(with_session + " --ct " + ct, 2, {"--ct requires a session of a recording"});
}

TEST_F(CommandLineTest, RegistrationOptionsWithoutEffectAreRejected) {
  const std::string ct = write_ct();
  const std::string matrix = "--ct-from-reference '1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1'";
  for (const auto& [arguments, rejection] : std::vector<Idle>{
           {"--landmarks p.csv --series 1.2", "--series requires --ct"},
           {"--landmarks p.csv --accept-unknown-orientation", "-orientation requires --ct"},
           {"--landmarks p.csv --ct " + ct + " --series 1.2", "--series requires a DICOM folder"},
           {"--landmarks p.csv --config c.xml", "--config requires a sweep"},
           {"--landmarks p.csv --temporal-offset-ms 5", "--temporal-offset-ms requires a sweep"},
           {"--landmarks p.csv --effort quick", "--effort requires a sweep"},
           {"--landmarks p.csv --time-limit 5", "--time-limit requires a sweep"},
           {"--points p --surface s.vtk --threads 2", "--threads requires a sweep"},
           {"--landmarks p.csv --window-level 60", "--window-level requires a sweep"},
           {"x.mha --ct y.mha --window-width 9", "--window-width requires --out"},
           {"--landmarks p.csv " + matrix, "--ct-from-reference has no effect with --landmarks"},
           {"x.mha --landmarks p.csv " + matrix,
            "--ct-from-reference has no effect with --landmarks"}}) {
    expect_rejection("register " + arguments, 2, {rejection});
  }
  // Only the missing files are wrong here.
  expect_rejection("register x.mha --ct y.mha --effort quick --threads 1 --loss none", 3,
                   {"y.mha"});
  expect_rejection("register --points p --surface s.vtk " + matrix, 3, {"s.vtk"});
}

TEST_F(CommandLineTest, AValueOutOfRangeIsNamedByOptionAndKey) {
  for (const auto& [arguments, rejection] : std::vector<Idle>{
           {"replay s.mha --ct c --out o --width 0",
            "--width: expected a whole number of 16 to 8192 pixels, found 0"},
           {"replay s.mha --ct c --out o --cutaway-inner 60 --cutaway-outer 50",
            "--cutaway-inner (look.cutaway.theta1_deg): expected at most theta2_deg, found 60"},
           {"replay s.mha --ct c --out o --temporal-offset-ms nan",
            "--temporal-offset-ms: expected -10000 to 10000 ms, found nan"},
           {"register s.mha --ct c --threads 9999",
            "--threads: expected a whole number of 0 to 1024, found 9999"},
           {"demo --out o --grey-width 0 --projection mean", "--grey-width: expected more than 0"},
           {"predicates --print-session --phantom neck --black 9 --white 5",
            "--white (predicates.white): expected more than black, found 5"}}) {
    expect_rejection(arguments, 2, {rejection});
  }
}

TEST_F(CommandLineTest, AValueOutOfRangeInASessionFileIsNamedByItsKey) {
  const test::TemporaryFolder folder;
  const auto file = folder / "session.toml";
  std::ofstream(file) << "[output]\nwidth_px = 0\n";
  expect_rejection(
      "replay s.mha --ct c --out o --session " + file.string(), 3,
      {"session.toml: output.width_px: expected a whole number of 16 to 8192 pixels, found 0"});
}

TEST_F(CommandLineTest, OptionsOfPredicatesThatWouldDoNothingAreRejected) {
  for (const auto& [arguments, rejection] : std::vector<Idle>{
           {"predicates u.mha --print-session --phantom neck",
            "--phantom has no effect with volume"},
           {"predicates u.mha --print-session --phantom-side 64",
            "--phantom-side has no effect with volume"},
           {"predicates --print-session --scribble-share 0.5",
            "--scribble-share requires --scribbles, --show or --hide"},
           {"predicates --print-session --into 0 1 0 --face-radius-mm 9",
            "--face-radius-mm requires --apex"},
           {"slices c.mha --out o --mode mean", "--mode requires --slab"},
           {"derive u.mha --out o --feature depth --unknown 60",
            "--unknown requires a --feature of the values of the voxels (found depth)"},
           {"derive u.mha --out o --feature snr --smoothing-mm 1",
            "--smoothing-mm requires --feature gradient-magnitude, gradient-angle, "},
           {"derive u.mha --out o --face-radius-mm 9", "--face-radius-mm requires --apex"},
           {"derive u.mha --out o --feature snr --bright",
            "--bright requires --feature vesselness"},
           {"derive u.mha --out o --feature snr vesselness --apex 0 0 0",
            "--apex requires --feature confidence, gradient-angle, gradient-along, "}}) {
    expect_rejection(arguments, 2, {rejection});
  }
  const Outcome strokes = sonde(
      "predicates --print-session --phantom neck --show 1,2,3 --scribble-share 0.5 --apex 0 0 0 "
      "--face-radius-mm 9");
  EXPECT_EQ(strokes.code, 0) << strokes.errors;
}

TEST_F(CommandLineTest, AReplayTakesTheOptionsOfPredicatesForItsVolume) {
  const Outcome outcome = sonde(
      "replay x.mha --print-session --us-volume u.mha --predicates tendon-fibres --into 0 1 0 "
      "--labels a.mha --white 200");
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  for (const char* piece : {"u.mha'", "a.mha'", "into = [ 0.0, 1.0, 0.0 ]", "white = 200.0"}) {
    EXPECT_NE(outcome.output.find(piece), std::string::npos) << piece << "\n" << outcome.output;
  }
}

}  // namespace
}  // namespace nav::app
