// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Runs the program as a user does.
#include "app/options/command_line.hpp"

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "app/options/exit_code.hpp"
#include "app/report.hpp"
#include "io/atomic_file.hpp"
#include "io/ct.hpp"
#include "io/sequence_writer.hpp"
#include "tests/app/options/command_line_support.hpp"
#include "tests/support/matchers.hpp"

namespace nav::app {
namespace {

TEST_F(CommandLineTest, TheBuiltProgramIsTheTestedOne) {
  for (const char* arguments : {"--version", "levitate"}) {
    const Outcome built = built_sonde(arguments);
    const Outcome here = sonde(arguments);
    EXPECT_EQ(built.code, here.code);
    EXPECT_EQ(built.output, here.output);
    EXPECT_EQ(built.errors, here.errors);
  }
}

TEST_F(CommandLineTest, HelpAndVersionSucceedEverywhere) {
  EXPECT_EQ(sonde("--version").code, 0);
  EXPECT_NE(sonde("--version").output.find("sonde "), std::string::npos);
  for (const char* verb : {"", "demo", "replay", "register", "info", "devices"}) {
    const Outcome help = sonde(std::string(verb) + " --help");
    EXPECT_EQ(help.code, 0) << verb;
    EXPECT_NE(help.output.find("Usage"), std::string::npos) << verb;
  }
}

TEST_F(CommandLineTest, BenchAndGalleryNeedTheProgramBesideIt) {
  // Neither this test's folder nor the PATH has it.
  const char* path = std::getenv("PATH");
  const std::string before = path == nullptr ? "" : path;
  ::setenv("PATH", folder_.path().c_str(), 1);
  for (const char* arguments : {"bench render --quick", "-v bench --help", "gallery --out x"}) {
    expect_rejection(arguments, kExitDevice,
                     {"sonde-bench is not installed", "SONDE_BUILD_BENCH=ON"});
  }
  ::setenv("PATH", before.c_str(), 1);
}

TEST_F(CommandLineTest, HelpOfAVerbHasExamplesAndItsUsualOptionsAndHelpAllHasAll) {
  const std::string help = sonde("replay --help").output;
  EXPECT_EQ(sonde("help replay").output, help);
  EXPECT_EQ(sonde("help").output, sonde("--help").output);
  for (const char* piece :
       {"Examples:\n  sonde replay ", "\n3D view:\n", "  --width N",
        "height of the 3D view (16 to 8192 pixels; default: 600)", "more options: sonde replay "}) {
    EXPECT_NE(help.find(piece), std::string::npos) << piece << "\n" << help;
  }
  EXPECT_EQ(help.find("--skip-bad-frames"), std::string::npos) << help;
  const std::string all = sonde("replay --help-all").output;
  EXPECT_NE(all.find("--skip-bad-frames"), std::string::npos) << all;
  EXPECT_EQ(all.find("--adaptive-error"), std::string::npos) << "retired";
  EXPECT_EQ(sonde("help replay --help-all").output, all);
  for (const char* verb : {"help", "completion"}) {
    const std::string text = sonde(std::string("help ") + verb).output;
    EXPECT_NE(text.find("Examples:\n  sonde " + std::string(verb)), std::string::npos) << text;
    EXPECT_EQ(sonde(std::string(verb) + " --help-all").output, text);
  }
  EXPECT_NE(sonde("--help").output.find("  slices"), std::string::npos);
}

TEST_F(CommandLineTest, ManualPagesAndCompletionKnowEveryOption) {
  const std::string page = sonde("help --man slices").output;
  EXPECT_TRUE(page.starts_with(".TH SONDE\\-slices 1")) << page;
  for (const char* piece :
       {".SH EXAMPLES", "\\-\\-mm\\-per\\-pixel MM", "0 to 100 mm; default: 0"}) {
    EXPECT_NE(page.find(piece), std::string::npos) << piece << "\n" << page;
  }
  const auto script = folder_ / "completion.bash";
  std::ofstream(script) << sonde("completion bash").output
                        << "COMP_WORDS=(sonde replay --engine g) COMP_CWORD=3; _sonde\n"
                           "echo \"${COMPREPLY[*]}\"\n"
                           "COMP_WORDS=(sonde slices --mm) COMP_CWORD=2; _sonde\n"
                           "echo \"${COMPREPLY[*]}\"\n"
                           "COMP_WORDS=(sonde regi) COMP_CWORD=1; _sonde\n"
                           "echo \"${COMPREPLY[*]}\"\n";
  const auto out = folder_ / "completed.txt";
  ASSERT_EQ(std::system(("bash " + script.string() + " > " + out.string()).c_str()), 0);
  EXPECT_EQ(text_of(out), "gl\n--mm-per-pixel\nregister\n");
}

TEST_F(CommandLineTest, UsageErrorsExitWithTwo) {
  expect_rejection("", 2, {});
  expect_rejection("levitate", 2, {"levitate"});
  expect_rejection("demo", 2, {"--out"});
  expect_rejection("demo --out x --engine vulkan", 2, {"engine", "vulkan"});
  expect_rejection("demo --out x --width 1", 2, {"--width", "1"});
  expect_rejection("demo --out x --threads many", 2, {"threads", "many"});
  expect_rejection("demo --out x --start-error-mm nan", 2, {"--start-error-mm", "nan"});
  expect_rejection("demo --out x --start-error-deg -1", 2, {"--start-error-deg", "-1"});
  expect_rejection("demo --out x --seed -1", 2, {"--seed", "-1"});
  expect_rejection("register --landmarks x --target nan 0 0", 2, {"--target", "nan"});
  expect_rejection("replay", 2, {"sweep"});
  expect_rejection("register", 2, {"landmarks"});
  const std::string sweep = write_sweep();
  expect_rejection("replay " + sweep + " --out x", 2, {"--ct"});
  expect_rejection(replay_arguments(sweep) + " --ct-from-reference '1 2 3'", 2, {"16 numbers"});
}

TEST_F(CommandLineTest, ParseErrorsHaveTheFormOfOtherErrors) {
  struct Wrong {
    std::string arguments;
    std::string sentence;
  };
  const std::string verbs =
      "demo, replay, live, window, record, export, serve, emulate, reconstruct, register, info, "
      "slices, "
      "predicates, "
      "derive, "
      "bench, gallery, devices, "
      "simulate, help or completion";
  for (const auto& [arguments, sentence] : std::vector<Wrong>{
           // Numbers.
           {"demo --out x --threads many",
            "--threads: expected a whole number of 0 to 1024, found many"},
           {"demo --out x --threads 1.5",
            "--threads: expected a whole number of 0 to 1024, found 1.5"},
           {"demo --out x --width 99999999999",
            "--width: expected a whole number of 16 to 8192 pixels, found 99999999999"},
           {"demo --out x --step fine", "--step: expected 0.015625 to 16 voxels, found fine"},
           {"demo --out x --rms-error 7", "--rms-error: expected 1e-05 to 1, found 7"},
           {"register --target 1 2 x",
            "--target: expected 3 numbers of -10000000 to 10000000 mm, found 1 2 x"},
           {"simulate --out x.mha --rows many",
            "--rows: expected 0 (the probe's own) or 16 to 4096 pixels, found many"},
           {"simulate --out x.mha --frame-rate-hz fast",
            "--frame-rate-hz: expected more than 0 and at most 1000 Hz, found fast"},
           // Numbers of values.
           {"register --target 1 2",
            "--target: expected 3 numbers (point at which the error is judged, LPS), found 2"},
           {"simulate --out x.mha --look-at 1 2",
            "--look-at: expected 3 numbers (point that the probe looks at in that CT, LPS), found "
            "2"},
           {"replay --json", "--json: expected a value (also write the report as JSON"},
           {"demo --out x --out y", "--out: expected it once, with a value, found 2 values"},
           {"demo", "--out: expected a value (folder to write to), found none"},
           {"info",
            "file: expected a value (sequence, recording, volume (file or DICOM folder), "
            "registration, "
            "transform, points, surface or PLUS configuration), found "},
           // Names.
           {"demo --out x --cutaway-around liver",
            "--cutaway-around: expected plane, needle or targets, found liver"},
           {"simulate --out x.mha --tracker laser",
            "--tracker: expected ideal, optical, electromagnetic or arm, found laser"},
           {"simulate --out x.mha --path zig", "--path: expected sweep, fan, rock or tilt, found"},
           {"simulate --out x.mha --breathing deep",
            "--breathing: expected none, rigid, affine or smooth, found deep"},
           {"simulate --out x.mha --model x", "--model: expected rays or scatterers, found x"},
           {"simulate --out x.mha --ct y.mha --contrast x",
            "--contrast: expected native, arterial, portal or mr, found x"},
           {"simulate --out x.mha --probe x",
            "--probe: expected standard, convex, linear or sector, found x"},
           {"simulate --out x.mha --needle x",
            "--needle: expected none, straight, bevel or tip-load, found x"},
           {"simulate --out x.mha --family x",
            "--family: expected abdomen, neck, shoulder, tendon, head or spine, found x"},
           {"demo --out x --no-shading=maybe", "--no-shading: expected true or false, found maybe"},
           // Contradicting or unknown options.
           {"predicates --apex 1 2 3 --into 0 1 0", "--into cannot be combined with --apex"},
           {"demo --out x --foo",
            "sonde demo: expected an option that 'sonde demo --help-all' lists, found --foo"},
           {"demo --out x --widht 3",
            "sonde demo: expected an option that 'sonde demo --help-all' lists, found --widht; did "
            "you mean --width?"},
           {"demo --out x --rms_error=3",
            "sonde demo: expected an option that 'sonde demo --help-all' lists, found "
            "--rms_error=3; did you mean --rms-error?"},
           {"demo --widht 3",  // Not that --out is missing.
            "sonde demo: expected an option that 'sonde demo --help-all' lists, found --widht; did "
            "you mean --width?"},
           {"reply", "verb: expected one of " + verbs + ", found 'reply'; did you mean replay?"},
           {"help levitate", "help: expected a verb, or --man and a verb, found 'levitate'"},
           {"help --man levitate", "help: expected a verb, or --man and a verb, found 'levitate'"},
           {"completion fish", "completion: expected bash, found 'fish'"},
           {"", "verb: expected one of " + verbs + ", found none"},
           {"levitate", "verb: expected one of " + verbs + ", found 'levitate'"}}) {
    expect_rejection(arguments, 2, {"sonde: error: " + sentence});
  }
  // Each of these choices is valid.
  for (const char* given : {"--probe standard", "--needle none", "--family spine", "--path tilt"}) {
    expect_rejection(std::string("simulate --out x.mha --rows 1 ") + given, 2, {"--rows"});
  }
}

TEST_F(CommandLineTest, SimulateNamesTheInvalidOption) {
  const std::string out = (folder_ / "sweep.mha").string();
  const std::string simulate = "simulate --columns 16 --rows 16 --out " + out + " ";
  expect_rejection(simulate + "--frame-rate-hz 0", 2,
                   {"--frame-rate-hz: expected more than 0 and at most 1000 Hz, found 0"});
  expect_rejection(simulate + "--breathing-mm 5", 2, {"--breathing-mm requires --breathing"});
  expect_rejection(simulate + "--seed -1", 2, {"--seed: expected a whole number", "found -1"});
  expect_rejection(simulate + "--seed 18446744073709551616", 2, {"found 18446744073709551616"});
  expect_rejection(simulate + "--needle bevel --needle-bending-mm 100", 2,
                   {"needle bending", "a fifth of the path", "found 100 mm"});
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST_F(CommandLineTest, NamesAVolumeThatLiesTooFarAway) {
  VoxelGrid grid;
  grid.size = {4, 4, 4};
  grid.origin_mm = {1e9, 0, 0};
  const auto file = (folder_ / "far.mha").string();
  ASSERT_TRUE(test::has_value(
      io::write_ct_mha(*Volume::create(grid, std::vector<std::int16_t>(64, 7), "far"), file)));
  for (const std::string& arguments :
       {"slices " + file + " --out x", "info " + file, "predicates " + file + " --out x.png"}) {
    expect_rejection(arguments, 3, {"far.mha: expected voxels within 1e7 mm", "1e+09"});
  }
  expect_rejection("slices " + write_ct() + " --out x --needle 0 0 0 1e300 0 0", 2,
                   {"--needle", "10000000 mm"});
  expect_rejection(
      "replay x.mha --print-session --ct-from-reference \"1 0 0 1e9 0 1 0 0 0 0 1 0 0 0 0 1\"", 2,
      {"--ct-from-reference (placement.ct_from_reference_mm)", "1e7 mm", "1e+09"});
}

TEST_F(CommandLineTest, BadFilesExitWithThreeAndNameThemselves) {
  const std::string sweep = write_sweep();
  const std::string ct = write_ct();
  expect_rejection("info /nonexistent/file.mha", 3, {"/nonexistent/file.mha"});
  expect_rejection("replay /nonexistent.igs.mha --ct " + ct + " --out " + (folder_ / "o").string(),
                   3, {"/nonexistent.igs.mha"});
  expect_rejection(
      "replay " + folder_.path().string() + " --ct " + ct + " --out " + (folder_ / "o").string(), 3,
      {folder_.path().string()});
  expect_rejection("replay " + sweep + " --ct /nonexistent.nii --config " + write_config() +
                       " --out " + (folder_ / "o").string(),
                   3, {"/nonexistent.nii"});
  expect_rejection("replay " + sweep + " --ct " + ct + " --out " + (folder_ / "o").string(), 3,
                   {"Image", "Probe"});
  const auto truncated = folder_ / "truncated.mha";
  std::ofstream(truncated) << "ObjectType = Image\nNDims = 3\nDimSi";
  expect_rejection("info " + truncated.string(), 3, {"truncated.mha"});
  const auto session = folder_ / "session.toml";
  std::ofstream(session) << "[output]\ncolour = \"red\"\n";
  expect_rejection("replay --session " + session.string(), 3, {"output.colour", ":2"});
  std::ofstream(session) << "[source]\nkind = \"device\"\n";
  expect_rejection("replay --session " + session.string(), 3, {"device"});
}

TEST_F(CommandLineTest, InfoDescribesASequence) {
  const Outcome outcome = sonde("info " + write_sweep() + " --json -");
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const io::Json report = io::Json::parse(outcome.output);
  EXPECT_EQ(report["kind"], "sequence");
  EXPECT_EQ(report["dimensions"], (io::Json{32, 24}));
  EXPECT_EQ(report["frames"], 6);
  EXPECT_EQ(report["transforms"]["ProbeToTracker"]["ok"], 6);
  EXPECT_DOUBLE_EQ(report["first_timestamp_s"].get<double>(), 10.0);
  EXPECT_DOUBLE_EQ(report["last_timestamp_s"].get<double>(), 10.5);
}

TEST_F(CommandLineTest, InfoDescribesACt) {
  const Outcome outcome = sonde("info " + write_ct() + " --json -");
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const io::Json report = io::Json::parse(outcome.output);
  EXPECT_EQ(report["kind"], "ct");
  EXPECT_EQ(report["dimensions"], (io::Json{30, 30, 30}));
  EXPECT_EQ(report["hu_max"], 700);
  ASSERT_EQ(report["value_range"].size(), 2U);
  EXPECT_LT(report["value_range"][0].get<double>(), report["value_range"][1].get<double>());
}

TEST_F(CommandLineTest, NamesTheWrongField) {
  const auto change = [&](const std::string& from, const std::string& to) {
    const std::string sweep = write_sweep();
    std::ifstream in(sweep, std::ios::binary);
    std::string text(std::istreambuf_iterator<char>(in), {});
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
      text.replace(at, from.size(), to);
    }
    std::ofstream(sweep, std::ios::binary) << text;
    return sweep;
  };
  for (const char* spacing : {"0 1 1", "-1 1 1", "nan 1 1"}) {
    const std::string sweep =
        change("ElementSpacing = 1 1 1", std::string("ElementSpacing = ") + spacing);
    expect_rejection("info " + sweep, 3, {"sweep.igs.mha", "ElementSpacing", "positive", spacing});
  }
  const std::string sweep = change("_Timestamp = 10", "_Timestamp = noon");
  expect_rejection(replay_arguments(sweep), 3, {"frame 0", "Timestamp", "noon"});
  // If no image gives a pose, the error has the file and the gate's reason.
  const std::string scaled = write_sweep({}, [](io::SequenceImage& frame) {
    io::set_transform(
        frame, {"ProbeToTracker", 2 * Eigen::Matrix4d::Identity().eval(), TrackingStatus::kOk});
  });
  expect_rejection(replay_arguments(scaled), 3,
                   {"sweep.igs.mha", "the probe is not tracked", "expected a rigid"});
}

}  // namespace
}  // namespace nav::app
