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
  std::string refusal;
};

TEST_F(CommandLineTest, EmptyValuesAreRejected) {
  for (const char* option : {"--look", "--session", "--json", "--save-look", "--us-volume",
                             "--config", "--registration", "--series"}) {
    expect_refusal("replay x.mha --print-session " + std::string(option) + " ''", 2,
                   {std::string(option) + ": expected a value, found ''"});
  }
  expect_refusal("predicates ''", 2, {"volume: expected a value, found ''"});
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
  for (const auto& [arguments, refusal] : std::vector<Idle>{
           {"--ct-spacing-mm 2", "--ct-spacing-mm: expected --ct beside it, found none"},
           {"--contrast native", "--contrast: expected --ct beside it, found none"},
           {"--look-at 1 2 3", "--look-at: expected --patient-ct beside it, found none"},
           {"--patient-ct x --family neck",
            "--family: expected no --patient-ct, of which the patient is made, beside it, found "
            "both"},
           {"--patient-ct x --ct y.mha --contrast native", "--contrast: expected no --patient-ct"},
           {"--needle-speed-mm-s 4",
            "--needle-speed-mm-s: expected --needle straight, bevel or tip-load beside it, found "
            "none"},
           {"--needle none --needle-bending-mm 4", "--needle-bending-mm: expected --needle"},
           {"--needle none --needle-length-mm 90", "--needle-length-mm: expected --needle"},
           {"--needle-bevel-deg 9", "--needle-bevel-deg: expected --needle"},
           {"--needle straight --needle-bevel-deg 9",
            "--needle-bevel-deg: expected --needle bevel or tip-load, which bend, beside it, found "
            "straight"},
           {"--path rock --length-mm 30",
            "--length-mm: expected --path sweep or tilt, which slide, beside it, found rock"},
           {"--path fan --length-mm 30", "--length-mm: expected --path sweep or tilt"},
           {"--angle-deg 30",
            "--angle-deg: expected --path fan, rock or tilt, which swing, beside it, found "
            "sweep"}}) {
    expect_refusal("simulate --columns 16 --rows 16 --out " + out + " " + arguments, 2, {refusal});
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
  for (const auto& [arguments, refusal] : std::vector<Idle>{
           {"--grey-width 400",
            "--grey-width: expected --projection maximum, minimum or mean beside it, found "
            "composite"},
           {"--projection mean --look a.vp",
            "--look: expected --projection composite beside it, found mean"},
           {"--projection mean --importance 1:2=1", "--importance: expected --projection"},
           {"--projection mean --emphasis 1", "--emphasis: expected --projection"},
           {"--projection mean --cutaway-outer 40", "--cutaway-outer: expected --projection"},
           {"--look a.vp --transfer-function ct-bone",
            "--transfer-function: expected it or --look, found both"},
           {"--projection mean --no-shading", "--no-shading: expected --projection composite"},
           {"--projection mean --no-cutaway", "--no-cutaway: expected --projection composite"},
           {"--rms-error 0.01 --pixel-error 0.1",
            "--rms-error: expected no --pixel-error, which it would choose, beside it, found both"},
           {"--engine reference --pixel-error 0.1",
            "--pixel-error: expected --engine cpu or gl, which may spare rays, beside it, found "
            "reference"},
           {"--transfer-function nope", "--transfer-function: expected ct-bone, "},
           {"--no-shading --shading gooch",
            "--shading: expected shading that is on beside it, found it off"},
           {"--no-shading --emphasis 1", "--emphasis: expected shading"},
           {"--no-cutaway --cutaway-inner 20",
            "--cutaway-inner: expected a cutaway that is on beside it, found it off"},
           {"--no-cutaway --cutaway-around needle", "--cutaway-around: expected a cutaway"},
           {"--no-cutaway --cutaway-overlay 5", "--cutaway-overlay: expected a cutaway"},
           {"--step 1 --rms-error 0.01", "--step: expected it or --rms-error, found both"}}) {
    expect_refusal("demo --out x " + arguments, 2, {refusal});
    expect_refusal("replay x.mha --print-session " + arguments, 2, {refusal});
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

TEST_F(CommandLineTest, OptionsOfAReplayThatWouldDoNothingAreRefused) {
  const std::string ct = write_ct();
  for (const auto& [arguments, refusal] : std::vector<Idle>{
           {"--ct " + ct + " --series 1.2.3",
            "--series: expected a DICOM folder beside it, found "},
           {"--us-alone", "--us-alone: expected --us-volume beside it, found none"},
           {"--height 200 --window-level 60",
            "--window-level: expected a 3D view that has room for the CT's panel beside it, found "
            "800 x 200"},
           {"--ct-importance 1", "--ct-importance: expected --us-volume"},
           {"--predicates layers", "--predicates: expected --us-volume"},
           {"--labels a.mha", "--labels: expected --us-volume"},
           {"--into 0 1 0", "--into: expected --us-volume"},
           {"--us-volume u.mha --us-alone --ct-importance 1",
            "--ct-importance: expected a CT, which --us-alone leaves out"},
           {"--us-volume u.mha --us-alone --rms-error 0.01",
            "--rms-error: expected a CT, whose step it chooses, beside it, found "
            "--us-alone"},
           {"--us-volume u.mha --us-alone --classification post-classified",
            "--classification: expected a CT, whose values they sample, beside it, found "
            "--us-alone"},
           {"--us-volume u.mha --us-alone --transfer-function ct-bone",
            "--transfer-function: expected a CT, which they show, beside it, found --us-alone"},
           {"--us-volume u.mha --us-alone --no-shading", "--no-shading: expected a CT"},
           {"--us-volume u.mha --pixel-error 0.1",
            "--pixel-error: expected a CT alone, whose rays may be spared, beside it, found "
            "--us-volume"},
           {"--us-volume u.mha --predicates carotid-vessel --labels a.mha",
            "--labels: expected a predicate label beside it, found none in carotid-vessel"},
           {"--us-volume u.mha --predicates layers --cache c",
            "--cache: expected a predicate of a derived feature beside it, found none in layers"},
           {"--us-volume u.mha --face-radius-mm 9",
            "--face-radius-mm: expected --apex beside it, found none"},
           {"--us-volume u.mha --projection mean",
            "--us-volume: expected --us-alone or --projection composite beside it, found mean"},
           {"--cutaway-around plane,needle",
            "--cutaway-around: expected --needle-frame, the needle that it names, beside it, found "
            "none"},
           {"--needle-frame Needle --cutaway-around needle,targets",
            "--cutaway-around: expected a session file with a plan, whose targets it names, beside "
            "it, found none"}}) {
    expect_refusal("replay x.mha --print-session " + arguments, 2, {refusal});
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
  expect_refusal(with_session + " x.mha", 2,
                 {"sweep: expected a session of a recording beside it, found one of the simulated "
                  "procedure"});
  expect_refusal(with_session + " --ct " + ct, 2, {"--ct: expected a session of a recording"});
}

TEST_F(CommandLineTest, RegistrationOptionsWithoutEffectAreRejected) {
  const std::string ct = write_ct();
  const std::string matrix = "--ct-from-reference '1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1'";
  for (const auto& [arguments, refusal] : std::vector<Idle>{
           {"--landmarks p.csv --series 1.2", "--series: expected --ct beside it, found none"},
           {"--landmarks p.csv --accept-unknown-orientation", "-orientation: expected --ct"},
           {"--landmarks p.csv --ct " + ct + " --series 1.2", "--series: expected a DICOM folder"},
           {"--landmarks p.csv --config c.xml", "--config: expected a sweep beside it, found none"},
           {"--landmarks p.csv --temporal-offset-ms 5", "--temporal-offset-ms: expected a sweep"},
           {"--landmarks p.csv --effort quick", "--effort: expected a sweep"},
           {"--landmarks p.csv --time-limit 5", "--time-limit: expected a sweep"},
           {"--points p --surface s.vtk --threads 2", "--threads: expected a sweep"},
           {"--landmarks p.csv --window-level 60", "--window-level: expected a sweep"},
           {"x.mha --ct y.mha --window-width 9", "--window-width: expected --out beside it"},
           {"--landmarks p.csv " + matrix,
            "--ct-from-reference: expected no --landmarks, which are the start, beside it, found "
            "both"},
           {"x.mha --landmarks p.csv " + matrix, "--ct-from-reference: expected no --landmarks"}}) {
    expect_refusal("register " + arguments, 2, {refusal});
  }
  // Only the missing files are wrong here.
  expect_refusal("register x.mha --ct y.mha --effort quick --threads 1 --loss none", 3, {"y.mha"});
  expect_refusal("register --points p --surface s.vtk " + matrix, 3, {"s.vtk"});
}

TEST_F(CommandLineTest, AValueOutOfRangeIsNamedByOptionAndKey) {
  for (const auto& [arguments, refusal] : std::vector<Idle>{
           {"replay s.mha --ct c --out o --width 0",
            "--width (output.width_px): expected 16 to 8192, found 0"},
           {"replay s.mha --ct c --out o --cutaway-inner 60 --cutaway-outer 50",
            "--cutaway-inner (look.cutaway.theta1_deg): expected at most theta2_deg, found 60"},
           {"replay s.mha --ct c --out o --temporal-offset-ms nan",
            "--temporal-offset-ms (source.temporal_offset_ms): expected -10000 to 10000"},
           {"register s.mha --ct c --threads 9999", "--threads (output.threads): expected 0"},
           {"demo --out o --grey-width 0 --projection mean",
            "--grey-width (look.grey_width_hu): expected more than 0"},
           {"predicates --print-session --phantom neck --black 9 --white 5",
            "--white (predicates.white): expected more than black, found 5"}}) {
    expect_refusal(arguments, 2, {refusal});
  }
}

TEST_F(CommandLineTest, AValueOutOfRangeInASessionFileIsNamedByItsKey) {
  const test::TemporaryFolder folder;
  const auto file = folder / "session.toml";
  std::ofstream(file) << "[output]\nwidth_px = 0\n";
  expect_refusal("replay s.mha --ct c --out o --session " + file.string(), 3,
                 {"session.toml: output.width_px: expected 16 to 8192, found 0"});
}

TEST_F(CommandLineTest, OptionsOfPredicatesThatWouldDoNothingAreRefused) {
  for (const auto& [arguments, refusal] : std::vector<Idle>{
           {"predicates u.mha --print-session --phantom neck",
            "--phantom: expected no volume, which is drawn instead, beside it, found u.mha"},
           {"predicates u.mha --print-session --phantom-side 64",
            "--phantom-side: expected no vol"},
           {"predicates --print-session --scribble-share 0.5",
            "--scribble-share: expected --scribbles, --show or --hide beside it, found none"},
           {"predicates --print-session --into 0 1 0 --face-radius-mm 9",
            "--face-radius-mm: expected --apex"},
           {"slices c.mha --out o --mode mean", "--mode: expected --slab beside it, found thin"},
           {"derive u.mha --out o --feature depth --unknown 60",
            "--unknown: expected a --feature of what the voxels hold beside it, found depth"},
           {"derive u.mha --out o --feature snr --smoothing-mm 1",
            "--smoothing-mm: expected --feature gradient-magnitude, -angle, -along or -across"},
           {"derive u.mha --out o --face-radius-mm 9", "--face-radius-mm: expected --apex"},
           {"derive u.mha --out o --feature snr --bright",
            "--bright: expected --feature vesselness beside it, found others"},
           {"derive u.mha --out o --feature snr vesselness --apex 0 0 0",
            "--apex: expected --feature confidence, gradient-angle, -along, -across or depth "
            "beside it"}}) {
    expect_refusal(arguments, 2, {refusal});
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
