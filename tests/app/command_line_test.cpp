// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Runs the program as a user does.
#include "app/command_line.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <iterator>
#include <optional>
#include <set>
#include <span>
#include <sstream>
#include <sys/wait.h>
#include <unistd.h>
#include <wordexp.h>

#include "app/exit_code.hpp"
#include "app/option_keys.hpp"
#include "app/report.hpp"
#include "io/atomic_file.hpp"
#include "io/ct.hpp"
#include "io/picture.hpp"
#include "io/sequence_writer.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::app {
namespace {

struct Outcome {
  int code;
  std::string output;  ///< Standard output.
  std::string errors;  ///< Standard error.
};

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

int exit_code_of(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : -1; }

std::ptrdiff_t threads_here() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/task"), {});
}

/// Standard input, output and errors of this process from now on.
bool redirect(const std::filesystem::path& output, const std::filesystem::path& errors) {
  return std::freopen("/dev/null", "r", stdin) && std::freopen(output.c_str(), "w", stdout) &&
         std::freopen(errors.c_str(), "w", stderr);
}

class CommandLineTest : public ::testing::Test {
 protected:
  /// The program in a process of its own, which is a copy of this one: to load its hundred
  /// libraries takes longer than most of what is asked of it. arguments: as for a shell.
  Outcome sonde(const std::string& arguments) {
    wordexp_t words{};
    EXPECT_EQ(::wordexp(("sonde " + arguments).c_str(), &words, WRDE_NOCMD | WRDE_UNDEF), 0)
        << arguments;
    // A copy has none of the other threads, but waits for their locks.
    EXPECT_EQ(threads_here(), 1);
    const auto output = folder_ / "stdout.txt";
    const auto errors = folder_ / "stderr.txt";
    std::fflush(nullptr);
    const pid_t child = ::fork();
    if (child == 0) {
      if (!redirect(output, errors)) std::_Exit(127);
      const int code = run_command_line(static_cast<int>(words.we_wordc), words.we_wordv);
      std::fflush(nullptr);
      std::_Exit(code);  // std::exit() would take for leaks what the test still holds.
    }
    ::wordfree(&words);
    int status = 0;
    EXPECT_EQ(::waitpid(child, &status, 0), child);
    return {exit_code_of(status), text_of(output), text_of(errors)};
  }
  /// The program as it is built, by a shell.
  Outcome built_sonde(const std::string& arguments) {
    const auto output = folder_ / "stdout.txt";
    const auto errors = folder_ / "stderr.txt";
    const std::string command = std::string(SONDE_PROGRAM) + " </dev/null >" + output.string() +
                                " 2>" + errors.string() + " " + arguments;
    const int status = std::system(command.c_str());
    return {exit_code_of(status), text_of(output), text_of(errors)};
  }
  /// The program stops with a code and one line of error that holds every piece.
  void expect_refusal(const std::string& arguments, int code,
                      std::initializer_list<std::string> pieces) {
    expect_refusal(sonde(arguments), arguments, code, pieces);
  }
  static void expect_refusal(const Outcome& outcome, const std::string& arguments, int code,
                             std::initializer_list<std::string> pieces) {
    EXPECT_EQ(outcome.code, code) << arguments << "\n" << outcome.errors;
    std::istringstream lines(outcome.errors);
    int errors = 0;
    std::string error;
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with("sonde: error: ")) {
        ++errors;
        error = line;
      }
      EXPECT_FALSE(line.starts_with("sonde: bug: ")) << line;
    }
    EXPECT_EQ(errors, 1) << arguments << "\n" << outcome.errors;
    for (const std::string& piece : pieces) {
      EXPECT_NE(error.find(piece), std::string::npos) << "expected '" << piece << "' in: " << error;
    }
  }

  std::string write_ct() {
    VoxelGrid grid;
    grid.size = {30, 30, 30};
    grid.spacing_mm = {4, 4, 4};
    grid.origin_mm = {-60, -60, -60};
    std::vector<std::int16_t> hu(grid.voxel_count(), -1000);
    for (std::size_t i = 0; i < hu.size(); ++i) {
      if (i % 30 > 8 && i % 30 < 20 && i / 30 % 30 > 8 && i / 30 % 30 < 20) hu[i] = 700;
    }
    const auto path = folder_ / "ct.mha";
    EXPECT_TRUE(
        test::has_value(io::write_ct_mha(*Volume::create(grid, std::move(hu), "ct"), path)));
    return path.string();
  }

  /// A small tracked sweep; change makes it wrong.
  std::string write_sweep(const std::function<void(io::SequenceHeader&)>& change_header = {},
                          const std::function<void(io::SequenceFrame&)>& change_frame = {},
                          int frames = 6) {
    io::SequenceHeader header;
    header.width = 32;
    header.height = 24;
    header.orientation = "MF";
    header.image_type = "BRIGHTNESS";
    if (change_header) change_header(header);
    const auto path = folder_ / "sweep.igs.mha";
    auto writer = io::SequenceWriter::create(path, header);
    EXPECT_TRUE(test::has_value(writer));
    for (int i = 0; i < frames; ++i) {
      io::SequenceFrame frame;
      frame.index = i;
      frame.timestamp_s = 10 + 0.1 * i;
      frame.image_valid = true;
      frame.pixels.assign(header.frame_bytes(), static_cast<std::byte>(40 + 30 * i));
      Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
      pose(2, 3) = 2 * i;
      io::set_transform(frame, {"ProbeToTracker", pose, TrackingStatus::kOk});
      if (change_frame) change_frame(frame);
      EXPECT_TRUE(test::has_value(writer->append(frame)));
    }
    EXPECT_TRUE(test::has_value(writer->finish()));
    return path.string();
  }
  std::string write_config(const std::string& matrix = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1") {
    const auto path = folder_ / "plus.xml";
    std::ofstream(path) << "<PlusConfiguration version=\"2.3\"><CoordinateDefinitions>"
                        << "<Transform From=\"Image\" To=\"Probe\" Matrix=\"" << matrix
                        << "\"/></CoordinateDefinitions></PlusConfiguration>";
    return path.string();
  }
  std::string replay_arguments(const std::string& sweep, const std::string& out = "out",
                               int width = 96, int height = 64) {
    return "replay " + sweep + " --ct " + write_ct() + " --config " + write_config() + " --out " +
           (folder_ / out).string() + " --width " + std::to_string(width) + " --height " +
           std::to_string(height) + " --step 2 --json " + (folder_ / "replay.json").string();
  }
  Json read_json(const std::string& name) {
    std::ifstream file(folder_ / name);
    return Json::parse(file, nullptr, false);
  }
  test::TemporaryFolder folder_;
};

TEST_F(CommandLineTest, EveryOptionOfAKeyIsOneOfSomeVerb) {
  std::string help;
  for (const char* verb : {"demo", "replay", "slices", "predicates"}) {
    const Outcome outcome = sonde(std::string(verb) + " --help");
    ASSERT_EQ(outcome.code, kExitOk) << outcome.errors;
    help += outcome.output;
  }
  std::istringstream words(help);
  const std::set<std::string> known{std::istream_iterator<std::string>(words), {}};
  for (const auto& [key, option] : options_of_keys()) {
    const std::string name(option);
    EXPECT_TRUE(known.contains(name) || known.contains(name + ",")) << name << " for " << key;
  }
}

TEST_F(CommandLineTest, BuiltProgramIsTheOneTestedHere) {
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
  for (const char* verb : {"", "demo", "replay", "register", "info", "bench", "bench render",
                           "bench scaling", "gallery", "devices"}) {
    const Outcome help = sonde(std::string(verb) + " --help");
    EXPECT_EQ(help.code, 0) << verb;
    EXPECT_NE(help.output.find("Usage"), std::string::npos) << verb;
  }
}

TEST_F(CommandLineTest, UsageErrorsExitWithTwo) {
  expect_refusal("", 2, {});
  expect_refusal("levitate", 2, {"levitate"});
  expect_refusal("demo", 2, {"--out"});
  expect_refusal("demo --out x --engine vulkan", 2, {"engine", "vulkan"});
  expect_refusal("demo --out x --width 1", 2, {"width_px", "1"});
  expect_refusal("demo --out x --threads many", 2, {"threads", "many"});
  expect_refusal("demo --out x --start-error-mm nan", 2, {"--start-error-mm", "nan"});
  expect_refusal("demo --out x --start-error-deg -1", 2, {"--start-error-deg", "-1"});
  expect_refusal("demo --out x --seed -1", 2, {"--seed", "-1"});
  expect_refusal("register --landmarks x --target nan 0 0", 2, {"--target", "nan"});
  expect_refusal("replay", 2, {"sweep"});
  expect_refusal("register", 2, {"landmarks"});
  const std::string sweep = write_sweep();
  expect_refusal("replay " + sweep + " --out x", 2, {"--ct"});
  expect_refusal(replay_arguments(sweep) + " --ct-from-reference '1 2 3'", 2, {"16 numbers"});
}

TEST_F(CommandLineTest, WhatCannotBeParsedIsToldAsEverythingElse) {
  struct Wrong {
    std::string arguments;
    std::string sentence;
  };
  const std::string verbs =
      "demo, replay, register, info, slices, predicates, derive, bench, gallery, devices or "
      "simulate";
  for (const auto& [arguments, sentence] : std::vector<Wrong>{
           // Numbers.
           {"demo --out x --threads many", "--threads: expected a whole number, found many"},
           {"demo --out x --threads 1.5", "--threads: expected a whole number, found 1.5"},
           {"demo --out x --width 99999999999",
            "--width: expected a whole number of -2147483648 to 2147483647, found 99999999999"},
           {"demo --out x --step fine", "--step: expected a number, found fine"},
           {"demo --out x --rms-error 7", "--rms-error: expected 1e-05 to 1, found 7"},
           {"register --target 1 2 x", "--target: expected 3 numbers, found 1 2 x"},
           {"bench render --width five", "--width: expected 16 to 8192 pixels, found five"},
           {"bench scaling --largest 9999", "--largest: expected 64 to 768 voxels, found 9999"},
           {"bench registration --patients 0", "--patients: expected 1 to 100 patients, found 0"},
           {"simulate --out x.mha --rows many",
            "--rows: expected 0 (the probe's own) or 16 to 4096 pixels, found many"},
           {"simulate --out x.mha --frame-rate-hz fast",
            "--frame-rate-hz: expected more than 0 and at most 1000 Hz, found fast"},
           // How many.
           {"register --target 1 2",
            "--target: expected 3 numbers (x y z in the CT, LPS mm: where the error is judged), "
            "found 2"},
           {"simulate --out x.mha --look-at 1 2",
            "--look-at: expected 3 numbers (point of that CT, LPS mm), found 2"},
           {"replay --json", "--json: expected a value (write the report as JSON"},
           {"demo --out x --out y", "--out: expected it once, with a value, found 2 values"},
           {"demo", "--out: expected a value (folder to write to), found none"},
           {"info", "file: expected a value (file, or DICOM folder), found none"},
           // Names.
           {"bench render --part x", "--part: expected compare, live or skipping, found x"},
           {"bench registration --model x", "--model: expected rays or scatterers, found x"},
           {"bench registration --effort x", "--effort: expected quick or usual, found x"},
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
           // What does not go together, or is not known.
           {"predicates --apex 1 2 3 --into 0 1 0", "--into: expected it or --apex, found both"},
           {"demo --out x --foo",
            "sonde demo: expected an option that 'sonde demo --help' lists, found --foo"},
           {"bench render foo",
            "sonde bench render: expected no further argument than 'sonde bench render --help' "
            "lists, found foo"},
           {"", "verb: expected one of " + verbs + ", found none"},
           {"levitate", "verb: expected one of " + verbs + ", found 'levitate'"},
           {"bench foo",
            "sonde bench: expected one of render, predicates, scaling, registration or derived, "
            "found 'foo'"}}) {
    expect_refusal(arguments, 2, {"sonde: error: " + sentence});
  }
  // Each choice that is named is one.
  for (const char* given : {"--probe standard", "--needle none", "--family spine", "--path tilt"}) {
    expect_refusal(std::string("simulate --out x.mha --rows 1 ") + given, 2, {"--rows"});
  }
}

TEST_F(CommandLineTest, SimulateNamesTheOptionThatCannotBe) {
  const std::string out = (folder_ / "sweep.mha").string();
  const std::string simulate = "simulate --columns 16 --rows 16 --out " + out + " ";
  expect_refusal(simulate + "--frame-rate-hz 0", 2,
                 {"--frame-rate-hz: expected more than 0 and at most 1000 Hz, found 0"});
  expect_refusal(simulate + "--breathing-mm 5", 2, {"--breathing-mm: expected --breathing"});
  expect_refusal(simulate + "--seed -1", 2, {"--seed: expected a whole number", "found -1"});
  expect_refusal(simulate + "--seed 18446744073709551616", 2, {"found 18446744073709551616"});
  expect_refusal(simulate + "--needle bevel --needle-bending-mm 100", 2,
                 {"needle bending: expected 0 to ", " mm (a fifth of the path), found 100 mm"});
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST_F(CommandLineTest, WritesSlicesThroughAPoint) {
  VoxelGrid grid;
  grid.size = {20, 16, 12};
  grid.spacing_mm = {2, 2, 3};
  const auto ct = Volume::create(grid, std::vector<std::int16_t>(grid.voxel_count(), 60), "flat");
  const auto file = (folder_ / "ct.mha").string();
  ASSERT_TRUE(test::has_value(io::write_ct_mha(*ct, file)));
  const auto out = folder_ / "slices";
  const std::string arguments = "slices " + file + " --out " + out.string();
  const Outcome outcome = sonde(arguments + " --at 10 10 10 --slab 4 --mode mean --size 128");
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  for (const char* name : {"axial.png", "coronal.png", "sagittal.png"}) {
    EXPECT_TRUE(std::filesystem::exists(out / name)) << name;
  }
  expect_refusal(arguments + " --mode median", 2, {"--mode", "median"});
  expect_refusal(arguments + " --slab -1", 2, {"--slab", "-1"});
  expect_refusal(arguments + " --mm-per-pixel nan", 2, {"--mm-per-pixel", "nan"});
  expect_refusal(arguments + " --mm-per-pixel -1", 2, {"--mm-per-pixel", "-1"});
  expect_refusal(arguments + " --at 9999 0 0", 2, {"--at", "inside the CT", "9999"});
  expect_refusal(arguments + " --window-width 0", 2, {"--window-width", "0"});
  expect_refusal(arguments + " --at nan 0 0", 2, {"--at", "nan"});
  expect_refusal("slices missing.mha --out " + out.string(), 3, {"missing.mha"});
}

TEST_F(CommandLineTest, SlicesShowASecondVolumeInItsOwnWindowAndSayWhich) {
  // As MR has them: background, a dark body, and a few bright voxels.
  VoxelGrid grid;
  grid.size = {30, 30, 30};
  grid.spacing_mm = {4, 4, 4};
  grid.origin_mm = {-60, -60, -60};
  std::vector<std::int16_t> values;
  for (std::size_t i = 0; i < grid.voxel_count(); ++i) {
    const std::size_t column = i % 30;
    values.push_back(static_cast<std::int16_t>(column < 12 ? 0 : column < 24 ? 200 : 1000));
  }
  const auto second = (folder_ / "mr.mha").string();
  ASSERT_TRUE(
      test::has_value(io::write_ct_mha(*Volume::create(grid, std::move(values), "mr"), second)));
  const auto out = folder_ / "slices";
  const std::string arguments = "slices " + write_ct() + " --out " + out.string() +
                                " --size 128 --at 0 0 0 --fusion wipe --wipe 1 --second " + second;
  const Outcome outcome = sonde(arguments);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const std::string said = outcome.output + outcome.errors;
  EXPECT_NE(said.find("; of the second volume: level 500, width 1000"), std::string::npos) << said;
  const auto picture = io::read_png(out / "axial.png");
  ASSERT_TRUE(test::has_value(picture));
  EXPECT_EQ(picture->at(72, 80).r, 51) << "the body: a fifth of white";
  const Outcome chosen = sonde(arguments + " --second-level 200 --second-width 100");
  EXPECT_NE((chosen.output + chosen.errors).find("second volume: level 200, width 100"),
            std::string::npos);
}

TEST_F(CommandLineTest, SlicesOf64PixelsHaveTheLettersOfTheirEdges) {
  const auto session = folder_ / "session.toml";
  std::ofstream(session) << "[plan]\nentry_mm = [0, -50, 40]\ntarget_mm = [0, 0, 0]\n"
                            "target_radius_mm = 6\n";
  const std::string arguments = "slices " + write_ct() + " --out " + (folder_ / "slices").string();
  const Outcome outcome = sonde(arguments + " --normal 1 1 0.5 --needle 0 0 0 0 -50 40 --session " +
                                session.string() + " --size 64");
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  for (const char* name :
       {"axial", "coronal", "sagittal", "oblique", "needle-1", "needle-2", "path-1", "path-2"}) {
    const auto picture = io::read_png(folder_ / "slices" / (std::string(name) + ".png"));
    ASSERT_TRUE(test::has_value(picture)) << name;
    const auto yellow = [&](int left, int top) {
      int count = 0;
      for (int y = top; y < top + 24; ++y) {
        for (int x = left; x < left + 24; ++x) {
          const Rgba8 p = picture->at(x, y);
          count += p.r > p.b + 60 ? 1 : 0;
        }
      }
      return count;
    };
    for (const auto& [left, top] : {std::pair(0, 20), {40, 20}, {20, 0}, {20, 40}}) {
      EXPECT_GT(yellow(left, top), 10) << name << ' ' << left << ' ' << top;
    }
  }
  expect_refusal(arguments + " --size 63", 2, {"--size: expected 64 to 8192"});
}

TEST_F(CommandLineTest, WritesObliqueSlicesAndThoseAlongANeedle) {
  const auto out = folder_ / "slices";
  const std::string arguments =
      "slices " + write_ct() + " --out " + out.string() + " --size 192 --at 0 0 0";
  const auto bytes = [&](const char* name) { return text_of(out / name); };
  const Outcome outcome = sonde(arguments + " --normal 0 1 1 --needle 0 0 0 0 -50 40 --slab 8");
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  for (const char* name : {"oblique.png", "needle-1.png", "needle-2.png"}) {
    EXPECT_FALSE(bytes(name).empty()) << name;
  }
  const std::string oblique = bytes("oblique.png");
  for (const char* name : {"my-needle.png", "report.json"}) std::ofstream(out / name) << "mine";
  // The same plane by two directions of it: seen from the feet, the patient's left to the right.
  ASSERT_EQ(sonde(arguments + " --right 2 0 0 --down 1 3 -3 --slab 8").code, 0);
  EXPECT_EQ(bytes("oblique.png"), oblique);
  // This run knows of no needle; that of the one before must not seem to be its own.
  EXPECT_FALSE(std::filesystem::exists(out / "needle-1.png"));
  EXPECT_FALSE(std::filesystem::exists(out / "needle-2.png"));
  EXPECT_EQ(bytes("my-needle.png"), "mine");
  EXPECT_EQ(bytes("report.json"), "mine");

  expect_refusal(arguments + " --normal 0 0 0", 2, {"--normal", "not zero"});
  expect_refusal(arguments + " --normal nan 0 1", 2, {"--normal", "nan"});
  expect_refusal(arguments + " --right 1 0 0", 2, {"--right: expected --down beside it"});
  expect_refusal(arguments + " --right 1 0 0 --down 2 0 0", 2, {"--down", "other than --right"});
  expect_refusal(arguments + " --right 1 0 0 --normal 0 0 1", 2, {"--right", "--normal", "both"});
  expect_refusal(arguments + " --needle 1 1 1 1 1 1", 2, {"--needle", "apart from it"});
  expect_refusal(arguments + " --needle 900 0 0 0 0 0", 2, {"--needle", "inside the CT"});
  expect_refusal(arguments + " --frame 1", 2, {"--frame: expected --recording beside it"});
  expect_refusal(arguments + " --share 1", 2, {"--share: expected --recording or --second"});
}

TEST_F(CommandLineTest, WritesTheSliceAlongAPictureAndFusesBoth) {
  const auto out = folder_ / "slices";
  const std::string ct = write_ct();
  const std::string arguments = "slices " + ct + " --out " + out.string() + " --size 192";
  const std::string recording = arguments + " --recording " + write_sweep() + " --config " +
                                write_config() +
                                " --ct-from-reference \"1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\"";
  // Pictures are of 40 + 30 i, the CT is air about (0, 0, 2 i), at the face of the probe.
  const auto grey = [&](const std::string& options) {
    const Outcome outcome = sonde(options);
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    const auto picture = io::read_png(out / "ultrasound.png");
    return picture ? static_cast<int>(picture->at(70, 110).r) : -1;
  };
  EXPECT_EQ(grey(recording + " --frame 3 --share 1"), 130);
  EXPECT_EQ(grey(recording + " --frame 1 --share 1"), 70);
  EXPECT_EQ(grey(recording + " --frame 3 --share 0 --window-level 700"), 128);
  EXPECT_EQ(grey(recording + " --frame 3 --fusion wipe --wipe 0.5"), 130);
  EXPECT_EQ(grey(recording + " --frame 3 --fusion wipe --wipe 0 --window-level 700"), 128);
  expect_refusal("slices " + ct + " --out x --recording s.mha --size 128", 2,
                 {"--size: expected 192 to 8192"});
  expect_refusal(recording + " --frame 6", 2, {"--frame: expected 0 to 5, found 6"});
  expect_refusal(recording + " --frame -1", 2, {"--frame: expected 0 to 5, found -1"});
  expect_refusal(recording + " --needle-frame NeedleTip", 2, {"NeedleTip"});
  expect_refusal(recording + " --second " + ct, 2, {"--second", "--recording", "both"});
  expect_refusal(recording + " --wipe 0.5", 2, {"--wipe: expected --fusion wipe beside it"});

  const Outcome second = sonde(arguments + " --second " + ct + " --second-level 0 --share 1");
  EXPECT_EQ(second.code, 0) << second.errors;
  expect_refusal(arguments + " --second no.mha", 3, {"no.mha"});
}

TEST_F(CommandLineTest, SlicesOfASessionAreThoseOfItsFilesAndItsPath) {
  const auto session = folder_ / "session.toml";
  const auto out = folder_ / "slices";
  const auto bytes = [&](const std::string& name) { return text_of(out / name); };
  const std::string ct = write_ct();
  const std::string sweep = write_sweep();
  const std::string config = write_config();
  const std::string files =
      "[ct]\npath = \"" + ct + "\"\n[output]\nfolder = \"" + out.string() + "\"\n";
  const std::string plan =
      "[plan]\nentry_mm = [0, -50, 40]\ntarget_mm = [0, 0, 0]\ntarget_radius_mm = 6\n";
  const std::string recording = "[source]\nrecording = \"" + sweep + "\"\nplus_config = \"" +
                                config +
                                "\"\n[placement]\nct_from_reference_mm = "
                                "[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]\n";
  const std::string arguments = "slices --size 192 --session " + session.string();
  const std::vector<std::string> whole{"axial.png", "coronal.png", "sagittal.png"};

  // The path is drawn as a needle at the same place is, whose tip is the point of all slices too.
  const auto on_line = [&](const std::string& name) {
    const auto picture = io::read_png(out / name);
    if (!picture) return std::ptrdiff_t{-1};
    return std::ranges::count_if(picture->pixels(), [](const Rgba8& p) {
      return p.b > p.r + 30;  // The CT is grey, the words are yellow.
    });
  };
  std::ofstream(session) << files << plan;
  ASSERT_EQ(sonde(arguments).code, 0);
  std::map<std::string, std::string> of_plan;
  for (const std::string& name : whole) of_plan[name] = bytes(name);
  const auto along_path = std::pair(on_line("path-1.png"), on_line("path-2.png"));
  EXPECT_GT(along_path.first, 20);
  EXPECT_FALSE(std::filesystem::exists(out / "needle-1.png"));
  std::filesystem::remove_all(out);
  std::ofstream(session) << files;
  ASSERT_EQ(sonde(arguments + " --needle 0 0 0 0 -50 40").code, 0);
  for (const std::string& name : whole) EXPECT_EQ(bytes(name), of_plan[name]) << name;
  EXPECT_EQ(std::pair(on_line("needle-1.png"), on_line("needle-2.png")), along_path);
  EXPECT_FALSE(std::filesystem::exists(out / "path-1.png"));

  // Its recording is laid over the CT, unless an option says what is.
  std::ofstream(session) << files << recording << plan;
  const Outcome along = sonde(arguments + " --frame 3 --share 1");
  ASSERT_EQ(along.code, 0) << along.errors;
  EXPECT_EQ(static_cast<int>(io::read_png(out / "ultrasound.png")->at(70, 110).r), 130);
  std::filesystem::remove_all(out);
  const Outcome second = sonde(arguments + " --second " + ct + " --out " + out.string());
  ASSERT_EQ(second.code, 0) << second.errors;
  EXPECT_FALSE(std::filesystem::exists(out / "ultrasound.png"));
  EXPECT_TRUE(std::filesystem::exists(out / "path-1.png"));
  expect_refusal(arguments + " --second " + ct + " --frame 3", 2,
                 {"--frame: expected --recording beside it"});
  EXPECT_NE(sonde(arguments + " --print-session").output.find(sweep), std::string::npos);

  std::ofstream(session) << files
                         << "[plan]\nentry_mm = [0, -50, 40]\ntarget_mm = [0, 900, 0]\n"
                            "target_radius_mm = 6\n";
  expect_refusal(arguments, 2, {"plan.target_mm", "inside the CT", "900"});
  std::ofstream(session) << "[source]\nkind = \"simulated\"\n";
  expect_refusal(arguments, 2, {"source.kind", "simulated"});
  expect_refusal("slices --out x", 2, {"ct: expected a CT, found nothing"});
  expect_refusal("slices " + ct, 2, {"--out: expected a folder, found nothing"});
}

/// A small ultrasound volume of 20 x 24 x 18 voxels of 1 mm.
std::string write_ultrasound(const std::filesystem::path& file) {
  VoxelGrid grid;
  grid.size = {20, 24, 18};
  std::vector<std::int16_t> voxels(grid.voxel_count());
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    voxels[i] = static_cast<std::int16_t>(i % 20 < 10 ? i * 37 % 100 : 150 + i * 37 % 100);
  }
  const auto volume = Volume::create(grid, std::move(voxels), "ultrasound");
  EXPECT_TRUE(test::has_value(io::write_ct_mha(*volume, file)));
  return file.string();
}

TEST_F(CommandLineTest, PredicatesAreDrawnBesideTheStandardByEveryEngine) {
  const auto out = (folder_ / "both.png").string();
  const std::string arguments = "predicates " + write_ultrasound(folder_ / "us.mha") +
                                " --width 200 --height 200 --out " + out +
                                " --predicates carotid-context";
  for (const char* engine : {"cpu", "reference"}) {
    const Outcome outcome = sonde(arguments + " --apex 10 -20 9 --engine " + engine);
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    EXPECT_TRUE(std::filesystem::remove(out)) << engine;
  }
  const Outcome moved = sonde(arguments + " --into 0 1 0 --importance skin=0.9 --save " +
                              (folder_ / "mine.json").string());
  EXPECT_EQ(moved.code, 0) << moved.errors;
  EXPECT_NEAR(read_json("mine.json")["predicates"][2]["importance"].get<double>(), 0.9, 1e-12);
  expect_refusal(arguments + " --into 0 1 0 --engine vulkan", 2, {"engine", "vulkan"});
}

/// The same of 16 bits: half of the voxels above 255, three above what is kept of them.
std::string write_wide_ultrasound(const std::filesystem::path& file) {
  std::vector<std::uint16_t> voxels(20 * 24 * 18);
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    voxels[i] = static_cast<std::uint16_t>(i % 2 == 0 ? 100 : 300 + i % 1000);
  }
  for (std::size_t i = 0; i < 3; ++i) voxels[i] = 40000;
  std::ofstream out(file, std::ios::binary);
  out << "ObjectType = Image\nNDims = 3\nBinaryData = True\n"
      << "TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 0 0 0\nElementSpacing = 1 1 1\n"
      << "DimSize = 20 24 18\nElementType = MET_USHORT\nElementDataFile = LOCAL\n";
  const auto bytes = std::as_bytes(std::span(voxels));
  out.write(reinterpret_cast<const char*>(bytes.data()),
            static_cast<std::streamsize>(bytes.size()));
  return file.string();
}

std::ptrdiff_t count_of(const std::string& piece, const std::string& text) {
  std::ptrdiff_t count = 0;
  for (auto at = text.find(piece); at != std::string::npos; at = text.find(piece, at + 1)) ++count;
  return count;
}

TEST_F(CommandLineTest, PredicatesSayOnceWhatAPictureCannotShow) {
  const std::string arguments = "predicates " + write_wide_ultrasound(folder_ / "us.mha") +
                                " --width 200 --height 200 --out " + (folder_ / "x.png").string() +
                                " --predicates " + (folder_ / "set.json").string();
  const auto set = [&](const std::string& name) {
    std::ofstream(folder_ / "set.json") << R"({"sonde_predicates": 1, "predicates": [
            {"name": "Gefäß", "importance": 0.6, "where": {"intensity": {"low": 0.2}}},
            {"name": ")" << name << R"(", "importance": 0.4, "where": {"intensity": {}}}]})";
  };
  set("血管 血");
  const Outcome odd = sonde(arguments);
  EXPECT_EQ(odd.code, 0) << odd.errors;
  EXPECT_EQ(count_of("us.mha: 3 voxels above 32767 set to 32767\n", odd.errors), 1) << odd.errors;
  EXPECT_EQ(count_of("HU", odd.errors), 0) << odd.errors;
  EXPECT_EQ(count_of("found 50 %, up to 32767", odd.errors), 1) << odd.errors;
  EXPECT_EQ(count_of("(predicates.white)", odd.errors), 1) << odd.errors;
  EXPECT_EQ(count_of("found 血 (U+8840), 管 (U+7BA1): drawn as '?'", odd.errors), 1) << odd.errors;
  set("muscle à gauche");
  const Outcome plain = sonde(arguments + " --white 1300");
  EXPECT_EQ(plain.code, 0) << plain.errors;
  EXPECT_EQ(count_of("white", plain.errors), 0) << plain.errors;
  EXPECT_EQ(count_of("drawn as", plain.errors), 0) << plain.errors;
}

TEST_F(CommandLineTest, PredicatesNameTheOptionOrTheKeyThatIsWrong) {
  expect_refusal("predicates --out x.png --phantom-side 32 --predicates nope.json", 2,
                 {"--predicates (predicates.set_up): expected a file, or a predicate preset"});
  const auto session = folder_ / "session.toml";
  std::ofstream(session) << "[predicates]\nset_up = \"nope.json\"\n";
  const Outcome of_key =
      sonde("predicates --out x.png --phantom-side 32 --session " + session.string());
  expect_refusal(of_key, "", 2, {"predicates.set_up: expected a file, or a predicate preset"});
  EXPECT_EQ(count_of("--predicates", of_key.errors), 0) << of_key.errors;
  const std::string painted = "predicates --print-session --predicates carotid-vessel --colour ";
  expect_refusal(painted + "vessel=40:1.5", 2,
                 {"--colour (predicates.histogram.saturation): expected 0 to 1, found 1.5"});
  expect_refusal(painted + "vessel=inf:0.5", 2, {"--colour: expected NAME=HUE:SATURATION"});
  EXPECT_EQ(sonde(painted + "vessel=400:0.5").code, 0);
}

TEST_F(CommandLineTest, TheOpacityOfASetUpIsDrawnAndSaved) {
  const auto set = [&](const std::string& length) {
    std::ofstream(folder_ / "set.json")
        << R"({"sonde_predicates": 1, "predicates": [{"name": "a", "where": {"intensity": {}}}],
               "opacity_length_mm": )"
        << length << "}";
  };
  const std::string arguments = "predicates " + write_ultrasound(folder_ / "us.mha") +
                                " --width 200 --height 200 --predicates " +
                                (folder_ / "set.json").string() + " --out ";
  const auto draw = [&](const std::string& name, const std::string& more) {
    const Outcome outcome = sonde(arguments + (folder_ / (name + ".png")).string() + more +
                                  " --save " + (folder_ / (name + ".json")).string());
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    return text_of(folder_ / (name + ".png"));
  };
  set("0.5");
  const std::string dense = draw("dense", "");
  EXPECT_EQ(read_json("dense.json")["opacity_length_mm"], 0.5);
  const std::string thin = draw("thin", " --opacity-length-mm 50");
  EXPECT_EQ(read_json("thin.json")["opacity_length_mm"], 50);
  EXPECT_NE(dense, thin);
  EXPECT_NE(draw("densest", " --opacity-length-mm 0.001"), dense);
  set("50");
  EXPECT_EQ(draw("file", ""), thin);
  for (const char* length : {"0", "-3", "1e300"}) {
    set(length);
    expect_refusal(arguments + "x.png", 3, {"set.json", "opacity_length_mm", "[0.001, 10000]"});
    expect_refusal("predicates --print-session --opacity-length-mm " + std::string(length), 2,
                   {"--opacity-length-mm", "0.001 to 10000"});
  }
}

TEST_F(CommandLineTest, HugeNumbersAreDrawnOrRefusedByName) {
  const std::string volume = write_ultrasound(folder_ / "us.mha");
  std::ofstream(folder_ / "set.json")
      << R"({"sonde_predicates": 1, "predicates": [{"name": "a", "where": {"any": [
             {"depth": {}}, {"gradient_angle": {}}, {"confidence": {}}, {"label": {"mask": 1}}]}}]})";
  std::ofstream(folder_ / "deep.json")
      << R"({"sonde_predicates": 1, "predicates": [{"name": "a", "where": {"any": [
             {"depth": {}}, {"gradient_angle": {}}, {"confidence": {}}]}}]})";
  const std::string arguments = "predicates " + volume + " --width 200 --height 200 --out " +
                                (folder_ / "x.png").string() + " --predicates ";
  const std::string deep = arguments + (folder_ / "deep.json").string();
  for (const char* into : {"1e300 0 0", "1e200 1e200 0", "0 1e-300 0"}) {
    const Outcome drawn = sonde(deep + " --into " + into + " --from 1e300 1e300 1e300");
    EXPECT_EQ(drawn.code, 0) << into << ": " << drawn.errors;
  }
  expect_refusal(deep + " --apex 1e300 0 0", 2, {"--apex", "1e7 mm", "1e+300"});
  expect_refusal(deep + " --into 0 1 0 --needle 1e300 0 0 0 0 0", 2, {"--needle", "1e7 mm"});
  expect_refusal(deep + " --into 0 1 0 --target 1e300 0 0 1", 2, {"--target", "1e7 mm"});
  const Outcome stroke = sonde(deep + " --into 0 1 0 --show '10,10,10 normal=1e300,0,0'");
  EXPECT_EQ(stroke.code, 0) << stroke.errors;
  expect_refusal(deep + " --into 0 1 0 --show '1e300,10,10 20,10,25'", 2, {"--show", "1e6 mm"});
  const auto write = [&](const char* name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  };
  const auto strokes = [&](const std::string& members) {
    return deep + " --into 0 1 0 --scribbles " +
           write("strokes.json",
                 R"({"sonde_scribbles": 1, "strokes": [{"points_mm": )" + members + "}]}");
  };
  EXPECT_EQ(sonde(strokes(R"([[9, 9, 9]], "normal": [1e300, 0, 0])")).code, 0);
  expect_refusal(strokes("[[1e300, 9, 9]]"), 3, {"strokes.json", "points_mm", "1e6 mm"});
  expect_refusal(strokes(R"([[9, 9, 9]], "thickness_mm": -3)"), 3, {"thickness_mm", "-3"});
  expect_refusal(strokes(R"([[9, 9, 9]], "normal": [0, 0, 0])"), 3, {"normal", "not all 0"});
  std::string heights = "1e300";
  for (int n = 1; n < 16; ++n) heights += ", 1";
  const std::string layers = write("layers.json", R"({"sonde_layers": 1, "axis": 1, "columns": 4,
      "rows": 4, "surfaces": [{"heights_mm": [)" + heights +
                                                      "]}]}");
  expect_refusal(arguments + (folder_ / "set.json").string() + " --into 0 1 0 --layers " + layers,
                 3, {"layers.json", "heights_mm", "1e6 mm"});
  const auto sweep = [&](const std::string& x, const std::string& sector) {
    return deep + " --scan-lines " +
           write("lines.json",
                 R"({"sonde_scan_lines": 1, "planes": [{"ct_from_image": [1, 0, 0, )" + x +
                     R"(, 0, 1, 0, 0, 0, 0, 1, 9, 0, 0, 0, 1], "low_mm": [0, 0],
                                   "high_mm": [20, 24])" +
                     sector + "}]}");
  };
  EXPECT_EQ(sonde(sweep("0", "")).code, 0);
  expect_refusal(deep + " --scan-lines " +
                     write("reach.json", R"({"sonde_scan_lines": 1, "reach_mm": 1e300})"),
                 3, {"reach.json", "reach_mm", "(0, 100]", "1e+300"});
  expect_refusal(sweep("1e300", ""), 3, {"lines.json", "ct_from_image", "1e6"});
  expect_refusal(sweep("100000", ""), 3,
                 {"lines.json", "within reach_mm of a voxel", "found none"});
  expect_refusal(sweep("0", R"(, "sector": {"apex_mm": [0, -40], "radius_min_mm": 90,
                                "radius_max_mm": 40, "half_angle_deg": 30})"),
                 3, {"sector.radius_max_mm", "more than radius_min_mm", "40"});
  expect_refusal(sweep("0", R"(, "sector": {"apex_mm": [0, -40], "radius_min_mm": 30,
                                "radius_max_mm": 90, "half_angle_deg": 200})"),
                 3, {"sector.half_angle_deg", "(0, 180]", "200"});
  const std::string derive =
      "derive " + volume + " --out " + (folder_ / "derived").string() + " --feature depth ";
  EXPECT_EQ(sonde(derive + "--into 1e300 0 0").code, 0);
  expect_refusal(derive + "--apex 1e300 0 0", 2,
                 {"--apex: expected 3 numbers within 1e7 mm", "1e+300"});
  for (const char* threads : {"100000", "-3"}) {
    expect_refusal(derive + "--threads " + threads, 2, {"--threads", "0 to 1024", threads});
    expect_refusal("bench derived --threads " + std::string(threads), 2, {"--threads", "1024"});
    expect_refusal(deep + " --into 0 1 0 --threads " + threads, 2, {"--threads", "1024"});
  }
  for (const char* value : {"65536", "-40000"}) {
    expect_refusal(derive + "--unknown " + value, 2, {"--unknown", "-32768 to 32767", value});
    expect_refusal("predicates --print-session --unknown " + std::string(value), 2, {"--unknown"});
  }
}

// The first known voxel along the lines, or where the user says.
TEST_F(CommandLineTest, ParallelLinesBeginAtTheFace) {
  constexpr int kEmptyRows = 25;
  const auto write = [&](const char* name, int empty_rows) {
    VoxelGrid grid;
    grid.size = {20, 20 + empty_rows, 20};
    grid.spacing_mm = {0.4, 0.4, 0.4};
    grid.origin_mm = {0, -0.4 * empty_rows, 0};
    std::vector<std::int16_t> hu(grid.voxel_count(), 200);
    for (std::size_t n = 0; n < hu.size(); ++n) {
      if (static_cast<int>(n / 20 % static_cast<std::size_t>(grid.size[1])) < empty_rows) hu[n] = 0;
    }
    const auto path = folder_ / name;
    EXPECT_TRUE(
        test::has_value(io::write_ct_mha(*Volume::create(grid, std::move(hu), name), path)));
    return path.string();
  };
  std::ofstream(folder_ / "shallow.json") << R"({"sonde_predicates": 1, "predicates": [
      {"name": "near", "where": {"depth": {"low_mm": -1, "high_mm": 3}}}]})";
  const auto lit = [&](const std::string& volume, const std::string& more) {
    const auto out = folder_ / "near.png";
    const Outcome outcome =
        sonde("predicates " + volume + " --into 0 1 0 --predicates " +
              (folder_ / "shallow.json").string() + " --width 200 --height 200 --from 0 0 1 " +
              more + " --out " + out.string());
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    const auto picture = io::read_png(out);
    EXPECT_TRUE(test::has_value(picture));
    int count = 0;
    for (int y = 40; y < 200; ++y) {
      for (int x = 200; x < 400; ++x) count += picture->at(x, y).r > 60 ? 1 : 0;
    }
    return std::pair(count, outcome.errors);
  };
  const std::string padded = write("padded.mha", kEmptyRows);
  EXPECT_GT(lit(write("whole.mha", 0), "").first, 1000);
  EXPECT_GT(lit(padded, "--unknown 0").first, 500);
  EXPECT_GT(lit(padded, "--face 5 0 7").first, 500);
  // From the box's own face those depths hold nothing, which is said.
  const auto [count, errors] = lit(padded, "");
  EXPECT_EQ(count, 0);
  EXPECT_NE(errors.find("the picture by predicates is empty"), std::string::npos) << errors;
  expect_refusal("predicates --print-session --predicates " + (folder_ / "shallow.json").string() +
                     " --face 0 0 0",
                 2, {"--face", "expected into beside it, found none"});
  const std::string derive =
      "derive " + padded + " --feature depth --out " + (folder_ / "d").string();
  EXPECT_NE(sonde(derive + " --into 0 1 0 --face 0 0 0").output.find("-10"), std::string::npos);
  expect_refusal(derive + " --face 0 0 0 --apex 0 0 0", 2,
                 {"--face: expected --into, parallel scan lines,"});
}

TEST_F(CommandLineTest, FeaturesAreDerivedAsPredicatesReadThem) {
  const std::string derive = "derive " + write_ultrasound(folder_ / "us.mha") + " --out " +
                             (folder_ / "d").string() + " --feature ";
  const auto greatest = [&](const std::string& options) {
    const Outcome outcome = sonde(derive + options);
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    std::istringstream lines(outcome.output);
    std::string header, name, unit;
    std::getline(lines, header);
    double least = 0, low = 0, high = 0, most = 0;
    lines >> name >> unit >> least >> low >> high >> most;
    return std::pair(unit, most);
  };
  const auto [of_white, share] = greatest("gradient-magnitude");
  EXPECT_EQ(of_white, "white/mm");
  EXPECT_GT(share, 0);
  EXPECT_NEAR(greatest("gradient-magnitude --black 5 --white 132.5").second, 2 * share,
              1e-3 * share);
  const auto [degrees, angle] = greatest("gradient-angle --into 0 1 0");
  EXPECT_EQ(degrees, "deg");
  EXPECT_GT(angle, 10);
  EXPECT_LE(angle, 180);
  EXPECT_NE(greatest("snr --snr-window 3").second, greatest("snr").second);
  EXPECT_NE(greatest("snr --snr-gaussian").second, greatest("snr").second);
  for (const char* one : {"alpha 0", "beta 10", "gamma 1"}) {
    EXPECT_EQ(greatest("confidence --into 0 1 0 --confidence-" + std::string(one)).second, 1)
        << one;
  }
  for (const auto& [options, pieces] : std::vector<std::pair<std::string, std::string>>{
           {"snr --snr-window 4", "window_voxels odd in [3, 31], found 4"},
           {"confidence --into 0 1 0 --confidence-gamma 2", "gamma in [0, 1], found 2"},
           {"gradient-magnitude --white -1", "--white: expected more than --black, 0, found -1"},
           {"confidence", "--feature confidence: expected scan lines (--into, --apex or "},
           {"snr depth", "--feature depth: expected scan lines"},
           {"snr --white 9", "--white: expected --feature gradient-magnitude"},
           {"snr --confidence-beta 9", "--confidence-beta: expected --feature confidence"},
           {"depth --snr-window 3", "--snr-window: expected --feature snr"}}) {
    expect_refusal(derive + options, 2, {pieces});
  }
}

TEST_F(CommandLineTest, WhatASavedSetUpDrawsIsWhatWasDrawn) {
  std::ofstream(folder_ / "edges.json") << R"({"sonde_predicates": 1, "predicates": [
      {"name": "edge", "where": {"gradient_magnitude": {"low_per_mm": 0.02}}}]})";
  const auto draw = [&](const std::string& set_up, const std::string& more) {
    const auto out = folder_ / "drawn.png";
    const Outcome outcome = sonde("predicates " + write_ultrasound(folder_ / "us.mha") +
                                  " --predicates " + (folder_ / set_up).string() +
                                  " --width 200 --height 200 --out " + out.string() + " " + more);
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    return text_of(out);
  };
  const std::string usual = draw("edges.json", "");
  const std::string smooth =
      draw("edges.json", "--smoothing-mm 1.5 --save " + (folder_ / "smooth.json").string());
  EXPECT_NE(smooth, usual);
  EXPECT_EQ(draw("smooth.json", ""), smooth);
  EXPECT_EQ(draw("smooth.json", "--smoothing-mm 0.4"), usual);
}

// A report, picture or set-up that cannot be written is no reason to compute for a minute.
TEST_F(CommandLineTest, WhatCannotBeWrittenIsRefusedAtOnce) {
  const std::string nowhere = (folder_ / "none" / "x").string();
  const std::string ultrasound = write_ultrasound(folder_ / "us.mha");
  for (const auto& [arguments, option] : std::vector<std::pair<std::string, std::string>>{
           {"bench render --quick --json " + nowhere, "--json: "},
           {"bench predicates --quick --json " + nowhere, "--json: "},
           {"bench derived --json " + nowhere, "--json: "},
           {"bench registration --json " + nowhere, "--json: "},
           {"predicates --phantom-side 512 --out " + nowhere + ".png", "--out: "},
           {"predicates --phantom-side 512 --out x.png --save " + nowhere, "--save: "}}) {
    expect_refusal(arguments, 3, {option, "none/x"});
  }
  EXPECT_FALSE(std::filesystem::exists("x.png"));
  // Where the verb makes the folder, a report may lie in it.
  const std::string sweep = write_sweep();
  const std::string arguments = "replay " + sweep + " --ct " + write_ct() + " --config " +
                                write_config() + " --width 96 --height 64 --step 2 --out " +
                                (folder_ / "new").string() + " --json " +
                                (folder_ / "new" / "report2.json").string();
  const Outcome made = sonde(arguments);
  EXPECT_EQ(made.code, 0) << made.errors;
  EXPECT_TRUE(std::filesystem::exists(folder_ / "new" / "report2.json"));
}

TEST_F(CommandLineTest, EmptyValuesAreRefused) {
  for (const char* option : {"--look", "--session", "--json", "--save-look", "--us-volume",
                             "--config", "--registration", "--series"}) {
    expect_refusal("replay x.mha --print-session " + std::string(option) + " ''", 2,
                   {std::string(option) + ": expected a value, found ''"});
  }
  expect_refusal("predicates ''", 2, {"volume: expected a value, found ''"});
  EXPECT_EQ(sonde("replay x.mha --print-session --needle-frame ''").code, 0);
}

TEST_F(CommandLineTest, OptionsOfTheCutawayWinOverALookThatHasNone) {
  const std::string arguments = replay_arguments(write_sweep());
  const auto look = (folder_ / "look.json").string();
  ASSERT_EQ(sonde(arguments + " --no-cutaway --save-look " + look).code, 0);
  for (const char* option : {"--cutaway-around plane", "--cutaway-inner 20", "--cutaway-outer 60",
                             "--cutaway-overlay 5"}) {
    const auto saved = (folder_ / "cut.json").string();
    const Outcome outcome =
        sonde(arguments + " --look " + look + " " + option + " --save-look " + saved);
    EXPECT_EQ(outcome.code, 0) << option << ": " << outcome.errors;
    EXPECT_TRUE(read_json("cut.json")["cutaway"].is_object()) << option;
  }
}

TEST_F(CommandLineTest, OptionsThatNoPredicateOfTheSetUsesAreRefused) {
  std::ofstream(folder_ / "bright.json") << R"({"sonde_predicates": 1, "predicates": [
      {"name": "bright", "where": {"intensity": {"low": 0.5}}}]})";
  const std::string arguments =
      "predicates --print-session --predicates " + (folder_ / "bright.json").string() + " ";
  for (const auto& [options, expected] : std::vector<std::pair<std::string, std::string>>{
           {"--into 0 1 0", "--into: expected a predicate depth, gradient_angle or confidence"},
           {"--apex 0 1 0", "--apex: expected a predicate depth"},
           {"--labels l.mha", "--labels: expected a predicate label"},
           {"--bright", "--bright: expected a predicate vesselness"},
           {"--smallest-radius 1", "--smallest-radius: expected a predicate vesselness"},
           {"--smoothing-mm 1", "--smoothing-mm: expected a predicate gradient_magnitude"}}) {
    expect_refusal(arguments + options, 2, {expected});
  }
  expect_refusal("predicates --print-session --smallest-radius 6", 2,
                 {"smallest_radius_mm", "largest radius", "4.5"});
  expect_refusal("predicates --out x.png --phantom-side 32 --predicates " +
                     (folder_ / "bright.json").string() + " --importance bright=0.2",
                 2, {"--importance", "1 of the only predicate", "0.2"});
  const Outcome linear = sonde(arguments + "--hue-mean linear");
  EXPECT_NE(linear.output.find("hue_mean = 'linear'"), std::string::npos) << linear.output;
  expect_refusal(arguments + "--hue-mean square", 2, {"--hue-mean", "circular or linear"});
}

TEST_F(CommandLineTest, StrokesChangeTheHistogram) {
  std::ofstream(folder_ / "two.json") << R"({"sonde_predicates": 1, "predicates": [
      {"name": "bright", "where": {"intensity": {"low": 0.5}}},
      {"name": "dark", "where": {"intensity": {"high": 0.5}}}]})";
  std::ofstream(folder_ / "strokes.json") << R"({"sonde_scribbles": 1, "strokes": [
      {"paint": "hide", "points_mm": [[4, 2, 9], [4, 20, 9]], "normal": [0, 0, 1]}]})";
  const std::string arguments = "predicates " + write_ultrasound(folder_ / "us.mha") +
                                " --width 200 --height 200 --predicates " +
                                (folder_ / "two.json").string() + " --out " +
                                (folder_ / "strokes.png").string();
  const Outcome outcome =
      sonde(arguments + " --show '15,2,9 15,20,9 normal=0,0,1' --scribbles " +
            (folder_ / "strokes.json").string() + " --save " + (folder_ / "after.json").string());
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_TRUE(std::filesystem::exists(folder_ / "strokes.png"));
  EXPECT_NEAR(read_json("after.json")["predicates"][0]["importance"].get<double>(), 0.625, 0.01);
  expect_refusal(arguments + " --show 1,2", 2, {"--show", "'1,2'"});
  expect_refusal(arguments + " --show 900,0,0", 2, {"stroke 1", "found none"});
  expect_refusal("predicates nowhere.mha --out x.png --show '9,9,9 radius=-1'", 2,
                 {"--show", "radius_mm", "-1"});
  expect_refusal(arguments + " --hide '15,2,9 15,20,12 normal=0,0,1'", 2,
                 {"stroke 1", "point 2", "3 mm off"});
  std::ofstream(folder_ / "strokes.json") << R"({"sonde_scribbles": 1, "strokes": [
      {"points_mm": [[4, 2, 9], [4, 20, 9], [9, 20, 9], [9, 2, 14]]}]})";
  expect_refusal(arguments + " --scribbles " + (folder_ / "strokes.json").string(), 2,
                 {"stroke 1", "point 2", "mm off"});
  // Twice the same voxels is no mistake.
  EXPECT_NE(sonde(arguments + " --show '9,9,9 radius=3' --show '9,9,9 radius=2'")
                .errors.find("123 voxels to show, 0 to hide"),
            std::string::npos);
  // The last one that covers a voxel counts.
  const std::string hide = " --hide '9,9,9 radius=3'";
  const std::string show = " --show '9,9,9 radius=3'";
  EXPECT_NE(sonde(arguments + show + hide).errors.find("0 voxels to show, 123 to hide"),
            std::string::npos);
  EXPECT_NE(sonde(arguments + hide + show).errors.find("123 voxels to show, 0 to hide"),
            std::string::npos);
}

TEST_F(CommandLineTest, ARegistrationThatStopsLeavesNothingOfAnEarlierOne) {
  std::filesystem::create_directories(folder_ / "out");
  for (const char* name : {"report.json", "registration.png", "mine.png"}) {
    std::ofstream(folder_ / "out" / name) << "{}";
  }
  expect_refusal(
      "register " + write_sweep() + " --ct missing.mha --out " + (folder_ / "out").string(), 3,
      {"missing.mha"});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out/report.json"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out/registration.png"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/mine.png"));
}

TEST_F(CommandLineTest, NoOutputReplacesAnInputOrAnother) {
  const std::string volume = write_ultrasound(folder_ / "us.mha");
  const std::string draw =
      "predicates --width 200 --height 200 --predicates layers --layers l " + volume + " --out ";
  const std::string before = *io::read_file(volume, 1 << 20);
  expect_refusal(draw + volume, 2, {"--out: expected a name that ends in .png"});
  const auto link = folder_ / "link.png";
  std::filesystem::create_symlink(volume, link);
  expect_refusal(draw + link.string(), 2, {"--out: expected a file of its own", "that of volume"});
  const std::string both = (folder_ / "both.png").string();
  expect_refusal(draw + both + " --save " + both, 2,
                 {"--save: expected a file of its own", "that of --out"});
  expect_refusal(draw + (folder_ / "x.jpg").string(), 2, {"--out", ".png", "x.jpg"});
  EXPECT_EQ(*io::read_file(volume, 1 << 20), before);
  const std::string sweep = write_sweep();
  expect_refusal("replay " + sweep + " --ct " + write_ct() + " --out x --json " + sweep, 2,
                 {"--json: expected a file of its own", "that of sweep"});
  expect_refusal("register " + sweep + " --json " + sweep, 2, {"--json", "that of sweep"});
  expect_refusal("simulate --out a.mha --ct a.mha", 2, {"--ct", "that of --out"});
  expect_refusal("info " + sweep + " --json " + sweep, 2, {"--json", "that of file"});
  const std::string ct = write_ct();
  expect_refusal("bench render --ct " + ct + " --json " + ct, 2, {"--json", "that of --ct"});
}

/// Files that are read late, or only where a look or predicates ask for them.
TEST_F(CommandLineTest, NoOutputReplacesWhatALookOrASessionReads) {
  const auto write = [&](const char* name) {
    std::ofstream(folder_ / name) << "mine";
    return (folder_ / name).string();
  };
  const std::string look = write("bone.vp");
  const std::string mesh = write("lesion.stl");
  const std::string other = write("of-predicates.json");
  const std::string replay = "replay s.mha --ct ct.mha --out o ";
  const std::string ultrasound = replay + "--us-volume us.mha ";
  for (const std::string& verb : {replay, std::string("demo --out o ")}) {
    expect_refusal(verb + "--look " + look + " --json " + look, 2,
                   {"--json: expected a file of its own", look, "that of --look"});
    expect_refusal(verb + "--look " + look + " --save-look " + look, 2,
                   {"--save-look: expected a file of its own", look, "that of --look"});
    expect_refusal(verb + "--cutaway-mesh " + mesh + " --json " + mesh, 2,
                   {"--json: expected a file of its own", mesh, "that of --cutaway-mesh"});
    expect_refusal(verb + "--save-look x.json --json x.json", 2,
                   {"--save-look: expected a file of its own", "that of --json"});
    expect_refusal(verb + "--save-look o/report.json", 2, {"--save-look", "that of --out"});
    expect_refusal(verb + "--look o/report.json", 2, {"--out", "that of --look"});
  }
  expect_refusal(ultrasound + "--predicates layers --labels " + other + " --json " + other, 2,
                 {"--json", other, "that of --labels"});
  expect_refusal(ultrasound + "--predicates layers --layers " + other + " --json " + other, 2,
                 {"--json", other, "that of --layers"});
  expect_refusal(ultrasound + "--predicates " + other + " --json " + other, 2,
                 {"--json", other, "that of --predicates"});
  const std::string session = (folder_ / "s.toml").string();
  std::ofstream(session) << "[predicates]\nvolume = \"us.mha\"\nscan_lines = \"" << other << "\"\n";
  expect_refusal(replay + "--session " + session + " --json " + other, 2,
                 {"--json", other, "that of --scan-lines"});
  std::ofstream(session) << "[source]\nkind = \"simulated\"\n[output]\nfolder = \"o\"\n";
  expect_refusal("replay --session " + session + " --look " + look + " --json " + look, 2,
                 {"--json", "that of --look"});
  expect_refusal("register --landmarks o/report.json --out o", 2, {"--out", "that of --landmarks"});
  expect_refusal("bench registration --trials x --json x", 2, {"--trials", "that of --json"});
  for (const std::string& file : {look, mesh, other}) EXPECT_EQ(text_of(file), "mine") << file;
}

TEST_F(CommandLineTest, NoOutputReplacesAPictureOfAFolder) {
  std::filesystem::create_directories(folder_ / "ct/deeper");
  const std::string slice = (folder_ / "ct/deeper/1.dcm").string();
  const std::string dicom = std::string(128, '\0') + "DICM";
  std::ofstream(slice, std::ios::binary) << dicom;
  const std::string ct = (folder_ / "ct").string();
  for (const std::string& verb :
       {"info " + ct, "register --landmarks l.csv --ct " + ct, "replay s.mha --out o --ct " + ct}) {
    expect_refusal(verb + " --json " + slice, 2,
                   {"--json: expected a file of its own", slice, "a picture of that of"});
  }
  EXPECT_EQ(*io::read_file(slice, 1000), dicom);
  // Without the preamble, as read_ct takes it; one that begins alike is no picture.
  const std::string old = (folder_ / "ct/old.dcm").string();
  std::ofstream(old, std::ios::binary) << std::string("\x08\0\x60\0CS\x02\0CT", 10);
  expect_refusal("info " + ct + " --json " + old, 2, {old, "a picture of that of file"});
  const std::string alike = (folder_ / "ct/alike.json").string();
  std::ofstream(alike, std::ios::binary) << std::string("\x08\0\x60\0nothing of DICOM", 20);
  expect_refusal("info " + ct + " --json " + alike, 3, {"expected DICOM pictures, found none"});
  // Behind a link of the folder.
  const std::string linked = (folder_ / "elsewhere.dcm").string();
  std::ofstream(linked, std::ios::binary) << dicom;
  std::filesystem::create_symlink("../elsewhere.dcm", folder_ / "ct/link.dcm");
  expect_refusal("info " + ct + " --json " + linked, 2, {linked, "a picture of that of file"});
}

TEST_F(CommandLineTest, NoOutputReplacesThePixelsOfAHeader) {
  const std::string pixels(2 * 2 * 2, '\0');
  for (const char* name : {"ct.raw", "1.raw", "2.raw"}) {
    std::ofstream(folder_ / name, std::ios::binary) << pixels;
  }
  const auto write = [&](const char* name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  };
  const std::string mhd = write("ct.mhd",
                                "NDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\n"
                                "ElementSpacing = 1 1 1\nElementDataFile = ct.raw\n");
  const std::string nhdr = write("ct.nhdr",
                                 "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\n"
                                 "encoding: raw\ndata file: %d.raw 1 2 1\n");
  const auto expect = [&](const std::string& arguments, const std::string& header,
                          const std::string& raw, const std::string& option) {
    const std::string path = (folder_ / raw).string();
    expect_refusal(
        arguments + path, 2,
        {"expected a file of its own", path, "the pixels of " + header, "that of " + option});
    EXPECT_EQ(*io::read_file(path, 100), pixels);
  };
  expect("info " + mhd + " --json ", mhd, "ct.raw", "file");
  expect("info " + nhdr + " --json ", nhdr, "2.raw", "file");
  expect("replay " + mhd + " --out o --ct " + nhdr + " --save-look ", nhdr, "1.raw", "--ct");
  expect("replay " + mhd + " --out o --ct " + nhdr + " --json ", mhd, "ct.raw", "sweep");
  EXPECT_EQ(sonde("info " + mhd + " --accept-unknown-orientation --json " +
                  (folder_ / "other.raw").string())
                .code,
            0);
}

TEST_F(CommandLineTest, APresetKeepsItsNameBesideAFileOfThatName) {
  const auto session = folder_ / "session.toml";
  std::ofstream(session) << "[predicates]\nset_up = \"carotid-context\"\n";
  const auto there = std::filesystem::current_path();
  std::filesystem::current_path(folder_.path());
  std::ofstream("carotid-context") << R"({"sonde_predicates": 1, "predicates": [
      {"name": "only", "where": {"intensity": {}}}]})";
  const std::string names = "predicates --out x.png --phantom-side 32 --importance none=1";
  expect_refusal(names + " --predicates carotid-context", 2,
                 {"--importance", "expected one of interfaces"});
  expect_refusal(names + " --session " + session.string(), 2, {"expected one of interfaces"});
  expect_refusal(names + " --predicates ./carotid-context", 2, {"expected one of only"});
  std::filesystem::current_path(there);
}

TEST_F(CommandLineTest, AnOptionReplacesWhatTheSessionSaysInAnotherWay) {
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

TEST_F(CommandLineTest, AVolumeThatLiesTooFarAwayIsNamed) {
  VoxelGrid grid;
  grid.size = {4, 4, 4};
  grid.origin_mm = {1e9, 0, 0};
  const auto file = (folder_ / "far.mha").string();
  ASSERT_TRUE(test::has_value(
      io::write_ct_mha(*Volume::create(grid, std::vector<std::int16_t>(64, 7), "far"), file)));
  for (const std::string& arguments :
       {"slices " + file + " --out x", "info " + file, "predicates " + file + " --out x.png"}) {
    expect_refusal(arguments, 3, {"far.mha: expected voxels within 1e7 mm", "1e+09"});
  }
  expect_refusal("slices " + write_ct() + " --out x --needle 0 0 0 1e300 0 0", 2,
                 {"--needle", "1e7 mm"});
  expect_refusal(
      "replay x.mha --print-session --ct-from-reference \"1 0 0 1e9 0 1 0 0 0 0 1 0 0 0 0 1\"", 2,
      {"--ct-from-reference (placement.ct_from_reference_mm)", "1e7 mm", "1e+09"});
}

TEST_F(CommandLineTest, OneSliceOfUltrasoundIsAVolumeWhateverItsAxis) {
  for (const std::array<int, 3>& size : {std::array{20, 24, 1}, {20, 1, 24}, {1, 20, 24}}) {
    VoxelGrid grid;
    grid.size = size;
    std::vector<std::int16_t> voxels(grid.voxel_count());
    for (std::size_t i = 0; i < voxels.size(); ++i) voxels[i] = static_cast<std::int16_t>(i % 200);
    const auto file = (folder_ / "one.mha").string();
    ASSERT_TRUE(
        test::has_value(io::write_ct_mha(*Volume::create(grid, std::move(voxels), "one"), file)));
    const Outcome outcome =
        sonde("predicates " + file + " --width 200 --height 200 --out " +
              (folder_ / "one.png").string() + " --predicates shoulder-muscle --into 0 1 0");
    EXPECT_EQ(outcome.code, 0) << size[2] << outcome.errors;
    const Outcome derived = sonde("derive " + file + " --out " + (folder_ / "one").string());
    EXPECT_EQ(derived.code, 0) << derived.errors;
    EXPECT_NE(derived.errors.find("left out: confidence, gradient-angle, gradient-along, "
                                  "gradient-across, depth; they need scan lines (--into"),
              std::string::npos)
        << derived.errors;
  }
}

TEST_F(CommandLineTest, WhatNoPictureReachedIsDarkAndKeepsItsValue) {
  VoxelGrid grid;
  grid.size = {24, 24, 24};
  std::vector<std::int16_t> voxels(grid.voxel_count());
  std::ofstream(folder_ / "bright.json") << R"({"sonde_predicates": 1, "predicates": [
      {"name": "bright", "where": {"intensity": {}}}]})";
  const auto lit = [&](std::int16_t unknown, const std::string& more) {
    // Known and black but for the outer half, which nobody has seen.
    for (std::size_t i = 0; i < voxels.size(); ++i) voxels[i] = i % 24 < 12 ? unknown : 0;
    const auto file = (folder_ / "u.mha").string();
    EXPECT_TRUE(test::has_value(io::write_ct_mha(*Volume::create(grid, voxels, "u"), file)));
    const auto out = folder_ / "u.png";
    const Outcome outcome =
        sonde("predicates " + file + " --predicates " + (folder_ / "bright.json").string() +
              " --width 200 --height 200 --out " + out.string() + more);
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    const auto picture = io::read_png(out);
    EXPECT_TRUE(test::has_value(picture));
    int count = 0;
    for (int y = 40; y < 220; ++y) {
      for (int x = 0; x < 400; ++x) count += picture->at(x, y).r > 100 ? 1 : 0;
    }
    return std::pair(count, outcome.errors);
  };
  EXPECT_GT(lit(255, "").first, 1000);
  EXPECT_EQ(lit(255, " --unknown 255").first, 0);
  EXPECT_EQ(lit(-2000, " --unknown -2000").second.find("no voxel has"), std::string::npos)
      << "values below air are not changed";
  EXPECT_NE(lit(255, " --unknown 254").second.find("no voxel has the value 254"),
            std::string::npos);
}

TEST_F(CommandLineTest, PredicatesThatCannotBeDrawnSayWhyInOneSentence) {
  const std::string volume = write_ultrasound(folder_ / "us.mha");
  const std::string arguments =
      "predicates " + volume + " --out " + (folder_ / "x.png").string() + " --predicates ";
  const auto file = [&](const std::string& where) {
    std::ofstream(folder_ / "set.json")
        << R"({"sonde_predicates": 1, "predicates": [{"name": "a", "where": )" << where << "}]}";
    return arguments + (folder_ / "set.json").string();
  };
  // What the command line asks for and cannot have.
  expect_refusal("predicates " + volume, 2, {"--out"});
  expect_refusal(arguments + "kidney", 2, {"--predicates", "carotid-context", "kidney"});
  expect_refusal(arguments + "carotid-vessel", 2, {"depth", "scan-line directions", "--into"});
  expect_refusal(file(R"({"confidence": {}})"), 2, {"confidence", "scan-line directions"});
  expect_refusal(arguments + "layers", 2, {"label", "--labels"});
  expect_refusal(file(R"({"needle_distance": {}})"), 2, {"needle_distance", "--needle"});
  expect_refusal(file(R"({"target_distance": {}})"), 2, {"target_distance", "--target"});
  expect_refusal(arguments + "layers --white -1", 2, {"predicates.white", "-1"});
  expect_refusal(arguments + "layers --into 0 0 0", 2, {"predicates.into", "not all 0"});
  expect_refusal(arguments + "layers --importance liver=1", 2, {"skin, muscle, target", "liver"});
  expect_refusal(arguments + "layers --largest-radius -1", 2, {"largest_radius_mm", "-1"});
  expect_refusal("predicates --phantom liver --out x.png", 2, {"--phantom", "carotid", "liver"});
  // What a file holds.
  expect_refusal(file(R"({"sharpness": {}})"), 3, {"where", "sharpness"});
  expect_refusal(file(R"({"intensity": {"low": 0.8, "high": 0.2}})"), 3, {"low <= high"});
  expect_refusal(file(R"({"entry": "a"})"), 3, {"cycle"});
  std::string many = R"({"sonde_predicates": 1, "predicates": [)";
  for (int n = 0; n < 33; ++n) {
    many += (n > 0 ? ", " : "") + (R"({"name": ")" + std::to_string(n)) +
            R"(", "where": {"intensity": {}}})";
  }
  std::ofstream(folder_ / "set.json") << many << "]}";
  expect_refusal(arguments + (folder_ / "set.json").string(), 3, {"32", "33"});
  std::ofstream(folder_ / "set.json") << R"({"sonde_predicates": 2})";
  expect_refusal(arguments + (folder_ / "set.json").string(), 3, {"version 1", "newer"});
  VoxelGrid grid;
  grid.size = {20, 24, 17};
  const auto labels = Volume::create(grid, std::vector<std::int16_t>(grid.voxel_count()), "labels");
  ASSERT_TRUE(test::has_value(io::write_ct_mha(*labels, folder_ / "labels.mha")));
  expect_refusal(arguments + "layers --labels " + (folder_ / "labels.mha").string(), 3,
                 {"labels.mha", "20 x 24 x 18", "20 x 24 x 17"});
}

TEST_F(CommandLineTest, LooksThatCannotBeAreUsageErrors) {
  expect_refusal("demo --out x --shading flat", 2, {"look.style", "phong or gooch", "flat"});
  expect_refusal("demo --out x --emphasis 2", 2, {"look.emphasis", "2"});
  expect_refusal("demo --out x --projection mip", 2, {"look.projection", "mip"});
  expect_refusal("demo --out x --cutaway-inner 50 --cutaway-outer 20", 2, {"theta1_deg", "50"});
  expect_refusal("demo --out x --cutaway-overlay -1", 2, {"overlay_mm", "-1"});
  expect_refusal("demo --out x --cutaway-around liver", 2, {"liver"});
  expect_refusal("demo --out x --importance 3", 2, {"--importance", "LOW:HIGH=IMPORTANCE", "'3'"});
  expect_refusal("demo --out x --importance a:b=c", 2, {"--importance", "'a:b=c'"});
}

TEST_F(CommandLineTest, OptionsOfTheLookAreResolvedIntoTheSession) {
  const auto session = folder_ / "session.toml";
  std::ofstream(session) << "[plan]\nentry_mm = [0,-9,0]\ntarget_mm = [0,0,0]\n"
                            "target_radius_mm = 4\n";
  const Outcome outcome = sonde(
      "replay x.mha --print-session --look a.vp --shading gooch --emphasis 0.5 "
      "--importance 150:300=1 --importance bone:400:2000=0.99 --cutaway-inner 20 "
      "--cutaway-overlay inf --cutaway-around needle,targets --needle-frame N --session " +
      session.string());
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  for (const char* piece :
       {"a.vp'", "style = 'gooch'", "shading = true", "emphasis = 0.5", "component = 'bone'",
        "high_hu = 300.0", "theta1_deg = 20.0", "overlay_mm = inf", "around_plane = false",
        "around_needle = true", "around_targets = true"}) {
    EXPECT_NE(outcome.output.find(piece), std::string::npos) << piece << "\n" << outcome.output;
  }
  const Outcome off = sonde("replay x.mha --print-session --no-cutaway --no-shading");
  EXPECT_NE(off.output.find("enabled = false"), std::string::npos) << off.output;
  EXPECT_NE(off.output.find("shading = false"), std::string::npos) << off.output;
}

struct Idle {
  std::string arguments;
  std::string refusal;
};

TEST_F(CommandLineTest, OptionsOfASimulationThatWouldDoNothingAreRefused) {
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

TEST_F(CommandLineTest, OptionsOfALookThatWouldDoNothingAreRefused) {
  for (const auto& [arguments, refusal] : std::vector<Idle>{
           {"--grey-width 400",
            "--grey-width: expected --projection maximum, minimum or mean beside it, found "
            "composite"},
           {"--projection mean --look a.vp",
            "--look: expected --projection composite beside it, found mean"},
           {"--projection mean --importance 1:2=1", "--importance: expected --projection"},
           {"--projection mean --emphasis 1", "--emphasis: expected --projection"},
           {"--projection mean --cutaway-outer 40", "--cutaway-outer: expected --projection"},
           {"--projection mean --rms-error 0.01", "--rms-error: expected a CT in colours"},
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
            "--rms-error: expected a CT in colours, whose step it chooses, beside it, found "
            "--us-alone"},
           {"--us-volume u.mha --us-alone --adaptive-error 0.1",
            "--adaptive-error: expected a CT, whose values they sample, beside it, found "
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
  // What a session file says is there.
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

TEST_F(CommandLineTest, OptionsOfARegistrationThatWouldDoNothingAreRefused) {
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
           {"--points p --surface s.vtk --similarity mi", "--similarity: expected a sweep"},
           {"--points p --surface s.vtk --threads 2", "--threads: expected a sweep"},
           {"--landmarks p.csv --window-level 60", "--window-level: expected a sweep"},
           {"x.mha --ct y.mha --window-width 9", "--window-width: expected --out beside it"},
           {"--landmarks p.csv " + matrix,
            "--ct-from-reference: expected no --landmarks, which are the start, beside it, found "
            "both"},
           {"x.mha --landmarks p.csv " + matrix, "--ct-from-reference: expected no --landmarks"}}) {
    expect_refusal("register " + arguments, 2, {refusal});
  }
  // The files that are not there are what is wrong with these.
  expect_refusal("register x.mha --ct y.mha --effort quick --threads 1 --loss none", 3, {"y.mha"});
  expect_refusal("register --points p --surface s.vtk " + matrix, 3, {"s.vtk"});
}

TEST_F(CommandLineTest, AValueOutOfRangeIsNamedByItsOptionAndItsKey) {
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

TEST_F(CommandLineTest, OptionsOfPredicatesAndBenchesThatWouldDoNothingAreRefused) {
  for (const auto& [arguments, refusal] : std::vector<Idle>{
           {"predicates u.mha --print-session --phantom neck",
            "--phantom: expected no volume, which is drawn instead, beside it, found u.mha"},
           {"predicates u.mha --print-session --phantom-side 64",
            "--phantom-side: expected no vol"},
           {"predicates --print-session --scribble-share 0.5",
            "--scribble-share: expected --scribbles, --show or --hide beside it, found none"},
           {"predicates --print-session --into 0 1 0 --face-radius-mm 9",
            "--face-radius-mm: expected --apex"},
           {"bench render --part live --scene x",
            "--scene: expected --part compare or skipping beside it, found live"},
           {"bench render --part live --ct x", "--ct: expected --part compare or skipping"},
           {"bench render --part skipping --costs", "--costs: expected --part live"},
           {"bench render --part skipping --width 64", "--width: expected --part compare or live"},
           {"bench render --quick --height 64", "--height: expected no --quick"},
           {"bench predicates --quick --side 64", "--side: expected no --quick"},
           {"bench predicates --volume prostate --side 64",
            "--side: expected a simulated --volume beside it, found prostate"},
           {"bench predicates --engine gl --threads 1", "--threads: expected --engine cpu or both"},
           {"bench predicates --volume two --threads 1", "--threads: expected a --volume"},
           {"bench predicates --volume features --width 300", "--width: expected a --volume that"},
           {"bench predicates --volume features --look vessel", "--look: expected a --volume that"},
           {"bench predicates --look vessel",
            "--look: expected a --volume that has some beside it"},
           {"bench predicates --volume features --engine gl", "--engine: expected --volume of"},
           {"bench registration --part skin --trials t.csv", "--trials: expected --part cohort"},
           {"bench registration --part skin --effort quick",
            "--effort: expected --part cohort, faults"},
           {"bench registration --part skin --no-evaluation", "--no-evaluation: expected --part"},
           {"bench registration --part curve --patients 2", "--patients: expected a --part other"},
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
            "beside it"},
           {"bench derived --quick --side 64",
            "--side: expected no --quick, which has a side of its own, beside it, found both"}}) {
    expect_refusal(arguments, 2, {refusal});
  }
  const Outcome strokes = sonde(
      "predicates --print-session --phantom neck --show 1,2,3 --scribble-share 0.5 --apex 0 0 0 "
      "--face-radius-mm 9");
  EXPECT_EQ(strokes.code, 0) << strokes.errors;
}

TEST_F(CommandLineTest, OptionsOfAnUltrasoundVolumeAreThoseOfPredicatesInAReplayToo) {
  const Outcome outcome = sonde(
      "replay x.mha --print-session --us-volume u.mha --predicates tendon-fibres --into 0 1 0 "
      "--labels a.mha --white 200");
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  for (const char* piece : {"u.mha'", "a.mha'", "into = [ 0.0, 1.0, 0.0 ]", "white = 200.0"}) {
    EXPECT_NE(outcome.output.find(piece), std::string::npos) << piece << "\n" << outcome.output;
  }
}

TEST_F(CommandLineTest, DerivedFeaturesAreKeptWhereAsked) {
  const std::string ct = write_ct();
  const std::string derive = "derive " + ct + " --into 0 1 0 --feature snr confidence --out " +
                             (folder_ / "slices").string() + " --cache " +
                             (folder_ / "features").string();
  const Outcome first = sonde(derive);
  ASSERT_EQ(first.code, 0) << first.errors;
  EXPECT_EQ(first.errors.find("from the cache"), std::string::npos) << first.errors;
  EXPECT_NE(first.errors.find("relative residual"), std::string::npos) << first.errors;
  const Outcome again = sonde(derive);
  ASSERT_EQ(again.code, 0) << again.errors;
  EXPECT_NE(again.errors.find("snr: from the cache"), std::string::npos) << again.errors;
  EXPECT_NE(again.errors.find("relative residual"), std::string::npos) << again.errors;
  // Predicates read what derive kept: the same voxels, scan lines and parameters.
  const auto set = folder_ / "confident.json";
  std::ofstream(set) << R"({"sonde_predicates": 1, "name": "c", "predicates": [{"name": "c",)"
                     << R"( "importance": 1, "hue_deg": 0, "saturation": 1,)"
                     << R"( "where": {"confidence": {}}}]})";
  const Outcome drawn = sonde("predicates " + ct + " --into 0 1 0 --predicates " + set.string() +
                              " --cache " + (folder_ / "features").string() +
                              " --width 200 --height 200 --out " + (folder_ / "c.png").string());
  EXPECT_EQ(drawn.code, 0) << drawn.errors;
  EXPECT_NE(drawn.errors.find("relative residual"), std::string::npos) << drawn.errors;
  EXPECT_NE(drawn.errors.find("from the cache"), std::string::npos) << drawn.errors;
  expect_refusal("replay x.mha --print-session --cache d", 2, {"--cache: expected --us-volume"});
}

TEST_F(CommandLineTest, AReplayMeasuresDistancesFromItsNeedleAndItsTarget) {
  const std::string sweep = write_sweep({}, [](io::SequenceFrame& frame) {
    Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
    pose(0, 3) = 3.0 * static_cast<double>(frame.index);
    const auto status = frame.index < 4 ? TrackingStatus::kOk : TrackingStatus::kOccluded;
    io::set_transform(frame, {"NeedleTipToTracker", pose, status});
  });
  const std::string ct = write_ct();
  const auto set = [&](const std::string& kind) {
    const auto path = folder_ / (kind + ".json");
    std::ofstream(path) << R"({"sonde_predicates": 1, "name": "near", "predicates": [)"
                        << R"({"name": "near", "importance": 1, "hue_deg": 120, "saturation": 1,)"
                        << R"( "where": {")" << kind << R"(": {"low_mm": -1, "high_mm": 9}}}]})";
    return path.string();
  };
  const std::string base = replay_arguments(sweep) + " --us-volume " + ct + " --white 700";
  const std::string needle = base + " --predicates " + set("needle_distance");
  expect_refusal(needle, 2, {"needle_distance", "needle of the recording (--needle-frame NAME)"});
  const Outcome live = sonde(needle +
                             " --needle-frame NeedleTip --ct-from-reference "
                             "'1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1'");
  EXPECT_EQ(live.code, 0) << live.errors;
  EXPECT_EQ(read_json("replay.json")["frames"].size(), 7U) << "6 pictures and the animation";
  const std::string target = base + " --predicates " + set("target_distance");
  expect_refusal(target, 2, {"target_distance", "predicates.target_mm"});
  const auto session = folder_ / "target.toml";
  std::ofstream(session) << "[predicates]\ntarget_mm = [0.0, 0.0, 0.0, 10.0]\n";
  const Outcome aimed = sonde(target + " --session " + session.string());
  EXPECT_EQ(aimed.code, 0) << aimed.errors;
}

TEST_F(CommandLineTest, ReplaysASweepAndSaysThatItIsNotRegistered) {
  const Outcome outcome = sonde(replay_arguments(write_sweep()));
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const Json report = read_json("replay.json");
  EXPECT_EQ(report["ledger"]["received"], 6);
  EXPECT_EQ(report["ledger"]["shown"], 6);
  EXPECT_EQ(report["placement"]["kind"], "centred");
  EXPECT_NE(report["placement"]["statement"].get<std::string>().find("not registered"),
            std::string::npos);
  EXPECT_NE(report["reference"].get<std::string>().find("nothing tracks the patient"),
            std::string::npos);
  for (const char* file : {"report.json", "report.html", "pose_log.csv", "session.toml",
                           "replay_00000.png", "replay_00005.png", "replay.webp"}) {
    EXPECT_TRUE(std::filesystem::exists(folder_ / "out" / file)) << file;
  }
}

TEST_F(CommandLineTest, AReplayWarnsOfASweepThatTheCtIsFarFrom) {
  const std::string arguments = replay_arguments(write_sweep());
  const auto warnings = [&](const std::string& x_mm) {
    const Outcome outcome =
        sonde(arguments + " --ct-from-reference \"1 0 0 " + x_mm + " 0 1 0 0 0 0 1 0 0 0 0 1\"");
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    const Json report = read_json("replay.json");
    const bool said = outcome.errors.find("the sweep lies outside of the CT") != std::string::npos;
    EXPECT_EQ(said, !report["placement"]["warnings"].empty()) << outcome.errors;
    return report["placement"]["warnings"].dump();
  };
  EXPECT_EQ(warnings("0"), "[]");
  // The CT ends at x = 58 mm.
  EXPECT_NE(warnings("5000").find("its nearest picture 49"), std::string::npos);
  EXPECT_NE(text_of(folder_ / "out/report.html").find("the sweep lies outside"), std::string::npos);
}

TEST_F(CommandLineTest, AReplayWarnsOfAPlanThatLiesFarFromTheCt) {
  const std::string arguments = replay_arguments(write_sweep());
  const auto session = folder_ / "plan.toml";
  const auto said = [&](const std::string& entry, const std::string& target) {
    std::ofstream(session) << "[plan]\nentry_mm = " << entry << "\ntarget_mm = " << target
                           << "\ntarget_radius_mm = 6\n";
    const Outcome outcome = sonde(arguments + " --session " + session.string());
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    return outcome.errors;
  };
  // The CT is 120 mm wide; the skin may lie a little beside it.
  EXPECT_EQ(said("[0, -90, 0]", "[0, 0, 0]").find("plan."), std::string::npos);
  const std::string far_target = said("[0, -90, 0]", "[1500, 0, 0]");
  EXPECT_NE(far_target.find("plan.target_mm: it lies 1442 mm outside of the CT"), std::string::npos)
      << far_target;
  EXPECT_EQ(far_target.find("plan.entry_mm"), std::string::npos);
  const std::string far_entry = said("[0, -900, 0]", "[0, 0, 0]");
  EXPECT_NE(far_entry.find("plan.entry_mm: it lies 838 mm outside of the CT"), std::string::npos)
      << far_entry;
}

TEST_F(CommandLineTest, WordsThatHaveNoRoomStopNoPicture) {
  const Outcome outcome = sonde("replay " + write_sweep() + " --ct " + write_ct() + " --config " +
                                write_config() + " --out " + (folder_ / "out").string() +
                                " --frames 1 --step 4 --width 16 --height 1024");
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
}

TEST_F(CommandLineTest, TheWindowOfTheCtSuitsItOrIsAsOneSays) {
  const std::string arguments = replay_arguments(write_sweep(), "out", 400, 300) + " --frames 1";
  const auto window = [&](const std::string& options) {
    const Outcome outcome = sonde(arguments + options);
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    const Json json = read_json("replay.json")["ct_window"];
    return std::pair(json["level"], json["width"]);
  };
  // The middle of the CT's panel, right of the 3D view.
  const auto grey = [&] {
    const auto picture = io::read_png(folder_ / "out/replay_00000.png");
    return picture ? static_cast<int>(picture->at(500, 230).r) : -1;
  };
  // The sweep's centre lies in the CT's, a block of 700 HU.
  EXPECT_EQ(window(""), std::pair(Json(200.0), Json(700.0)));
  EXPECT_EQ(grey(), 255);
  EXPECT_EQ(window(" --window-level 700"), std::pair(Json(700.0), Json(700.0)));
  EXPECT_EQ(grey(), 128);
  EXPECT_EQ(window(" --window-level 700 --window-width 1"), std::pair(Json(700.0), Json(1.0)));
  const auto session = folder_ / "window.toml";
  std::ofstream(session) << "[view]\nwindow_level = 1000\nwindow_width = 1200\n";
  const std::string with_session = " --session " + session.string();
  EXPECT_EQ(window(with_session), std::pair(Json(1000.0), Json(1200.0)));
  EXPECT_EQ(grey(), 64);
  EXPECT_EQ(window(with_session + " --window-width 900"), std::pair(Json(1000.0), Json(900.0)));
  const Outcome printed = sonde("replay x.mha --print-session --window-level -500");
  EXPECT_NE(printed.output.find("window_level = -500"), std::string::npos) << printed.errors;
  expect_refusal("replay x.mha --print-session --window-width -1", 2,
                 {"--window-width (view.window_width): expected 0.001 to 10^6, found -1"});

  // So do slices, for what they show.
  const auto said = [&](const std::string& options) {
    const Outcome outcome = sonde("slices " + (folder_ / "ct.mha").string() + " --out " +
                                  (folder_ / "slices").string() + options);
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    return outcome.output + outcome.errors;
  };
  EXPECT_NE(said("").find("window: level 200, width 700"), std::string::npos) << said("");
  EXPECT_NE(said(with_session).find("window: level 1000, width 1200"), std::string::npos);
}

TEST_F(CommandLineTest, AGallerySaysWhichPicturesThereAre) {
  expect_refusal("gallery --only nope --out " + (folder_ / "gallery").string(), 2,
                 {"--only", "fig2a", "registration-sweep", "simulator-spine", "predicates-inside",
                  "found nope"});
}

TEST_F(CommandLineTest, AGalleryOfNothingFails) {
  const std::string out = " --out " + (folder_ / "gallery").string();
  expect_refusal("gallery --engine foo --only simulator-vessel" + out, 2,
                 {"cpu, gl or reference", "foo"});
  const char* data = std::getenv("SONDE_DATA_DIR");
  const std::string before = data == nullptr ? "" : data;
  ::setenv("SONDE_DATA_DIR", (folder_ / "no-data").c_str(), 1);
  expect_refusal("gallery --only fig2a" + out, 3,
                 {"no-data", "expected the data of fig2a", "SONDE_DATA_DIR", "nothing was drawn"});
  if (data == nullptr) {
    ::unsetenv("SONDE_DATA_DIR");
  } else {
    ::setenv("SONDE_DATA_DIR", before.c_str(), 1);
  }
}

TEST_F(CommandLineTest, AProjectionHasTheWindowOfWhatItShowsAndSaysWhich) {
  const std::string replay = replay_arguments(write_sweep(), "out", 480, 300) + " --frames 1 ";
  const auto report = [&](const std::string& options) {
    const Outcome outcome = sonde(replay + options);
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    return read_json("replay.json");
  };
  EXPECT_TRUE(report("")["grey_window"].is_null());
  // Air, and a block of 700 HU: air is left out, and what is half of each at its edge remains.
  const Json maximum = report("--projection maximum")["grey_window"];
  const double white = maximum["level"].get<double>() + maximum["width"].get<double>() / 2;
  EXPECT_NEAR(white, 700, 100) << maximum;
  EXPECT_EQ(report("--projection mean --grey-level 40 --grey-width 500")["grey_window"],
            (Json{{"level", 40.0}, {"width", 500.0}}));
  const Json half = report("--projection maximum --grey-level 40")["grey_window"];
  EXPECT_EQ(half["level"], 40.0);
  EXPECT_EQ(half["width"], maximum["width"]);
  // The session that was written has no window, so that it may be laid over other data.
  EXPECT_EQ(text_of(folder_ / "out" / "session.toml").find("grey_width_hu"), std::string::npos);
  const Json minimum = report("--projection minimum");
  bool told = false;
  for (const Json& entry : minimum["diagnostics"]) {
    told |= entry["message"].get<std::string>().find("nothing but air") != std::string::npos;
  }
  EXPECT_TRUE(told) << minimum["diagnostics"];
}

TEST_F(CommandLineTest, SkippingIsMeasuredAboutACubicPatientAlone) {
  const auto json = folder_ / "bench.json";
  const Outcome outcome =
      sonde("bench render --quick --part skipping --scene patient-256/vessels-only --json " +
            json.string());
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const Json report = read_json("bench.json");
  ASSERT_EQ(report["skip_bounds"].size(), 1U);
  EXPECT_EQ(report["skip_bounds"][0]["scene"], "patient-256/vessels-only/perspective/shaded");
  EXPECT_EQ(report["skip_bounds"][0]["bit_identical"], true);
  EXPECT_TRUE(report["ratios"]["samples_skip_off_over_on"]["bit_identical"].is_null());
  expect_refusal("bench render --part skipping --scene patient-257", 2, {"--scene", "patient-257"});
}

TEST_F(CommandLineTest, EnginesAgreeOnAnOrthographicPicture) {
  const std::string sweep = write_sweep();
  const auto picture = [&](const std::string& options) -> std::optional<Image2d<Rgba8>> {
    const Outcome outcome =
        sonde(replay_arguments(sweep) + " --frames 1 --azimuth -30 --elevation 20 --distance 150 " +
              options);
    if (outcome.code == kExitDevice) return std::nullopt;
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    auto read = io::read_png(folder_ / "out" / "replay_00000.png");
    EXPECT_TRUE(test::has_value(read));
    return *read;
  };
  /// Greatest difference in the 3D view.
  const auto difference = [](const Image2d<Rgba8>& a, const Image2d<Rgba8>& b) {
    int most = 0;
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 96; ++x) {
        const Rgba8& p = a.at(x, y);
        const Rgba8& q = b.at(x, y);
        most = std::max({most, std::abs(p.r - q.r), std::abs(p.g - q.g), std::abs(p.b - q.b)});
      }
    }
    return most;
  };
  const auto cpu = picture("--orthographic");
  const auto reference = picture("--orthographic --engine reference");
  const auto perspective = picture("");
  ASSERT_TRUE(cpu && reference && perspective);
  constexpr int kEnginesApart = 4;  // Of 255.
  EXPECT_LE(difference(*cpu, *reference), kEnginesApart);
  EXPECT_GT(difference(*cpu, *perspective), 40) << "another picture";
  if (const auto gl = picture("--orthographic --engine gl")) {
    EXPECT_LE(difference(*cpu, *gl), kEnginesApart);
  }
  const Outcome session = sonde("replay --print-session x.mha --orthographic");
  EXPECT_NE(session.output.find("orthographic = true"), std::string::npos) << session.output;
}

TEST_F(CommandLineTest, ASavedLookDrawsTheSamePicture) {
  const std::string arguments = replay_arguments(write_sweep()) + " --frames 1 ";
  const std::string saved = (folder_ / "mine.json").string();
  const Outcome first =
      sonde(arguments + "--shading gooch --importance 500:900=0.9 --save-look " + saved);
  ASSERT_EQ(first.code, 0) << first.errors;
  const auto digest = read_json("replay.json")["image_sha256"];
  const Outcome again = sonde(arguments + "--look " + saved);
  ASSERT_EQ(again.code, 0) << again.errors;
  EXPECT_EQ(read_json("replay.json")["image_sha256"], digest);
  expect_refusal(arguments + "--save-look " + (folder_ / "no" / "look.json").string(), 3,
                 {"look.json"});
  expect_refusal(arguments + "--projection mean --save-look " + saved, 2,
                 {"--save-look: expected --projection composite"});
}

TEST_F(CommandLineTest, SamplingAndObjectsOfInterestChangeThePicture) {
  const std::string arguments =
      replay_arguments(write_sweep()) + " --frames 1 --azimuth -20 --elevation 10 ";
  const auto digest = [&](const std::string& options) {
    const Outcome outcome = sonde(arguments + options);
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    return read_json("replay.json")["image_sha256"].get<std::string>();
  };
  const std::string plain = digest("");
  EXPECT_NE(digest("--classification post-classified"), plain);
  EXPECT_NE(digest("--jitter"), plain);
  const auto mesh = folder_ / "lesion.stl";
  std::ofstream(mesh) << "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 30 -30\nvertex 30 30 "
                         "20\nvertex -30 30 20\nendloop\nendfacet\nendsolid a\n";
  const std::string cut = digest("--cutaway-mesh " + mesh.string());
  EXPECT_NE(cut, plain);
  const auto session = folder_ / "session.toml";
  std::ofstream(session) << "[[cutaway_objects]]\ntype = \"polygon\"\n"
                            "vertices_mm = [[0,30,-30], [30,30,20], [-30,30,20]]\n";
  EXPECT_EQ(digest("--session " + session.string()), cut) << "the same triangle";
  expect_refusal(arguments + "--cutaway-mesh none.stl", 3, {"none.stl"});
  expect_refusal(arguments + "--no-cutaway --cutaway-mesh " + mesh.string(), 2,
                 {"--cutaway-mesh: expected a cutaway that is on"});
  expect_refusal(arguments + "--classification none", 2, {"--classification", "none"});
  expect_refusal(arguments + "--adaptive-error 0.1 --classification post-classified", 2,
                 {"--adaptive-error", "post-classified"});
  expect_refusal(arguments + "--jitter --pixel-error 0.1", 2, {"--pixel-error", "jitter"});
}

TEST_F(CommandLineTest, ReplayIsTheSameForOneAndTwoThreadsAndFromItsSessionFile) {
  const std::string sweep = write_sweep();
  const std::string arguments = replay_arguments(sweep);
  ASSERT_EQ(sonde(arguments + " --threads 1").code, 0);
  const Json one = read_json("replay.json");
  ASSERT_EQ(sonde(arguments + " --threads 2").code, 0);
  const Json two = read_json("replay.json");
  EXPECT_EQ(one["image_sha256"], two["image_sha256"]);
  EXPECT_EQ(one["pose_log_sha256"], two["pose_log_sha256"]);
  const Outcome again = sonde("replay --session " + (folder_ / "out/session.toml").string() +
                              " --json " + (folder_ / "again.json").string());
  ASSERT_EQ(again.code, 0) << again.errors;
  EXPECT_EQ(read_json("again.json")["image_sha256"], one["image_sha256"]);
}

TEST_F(CommandLineTest, AccountsForBadPosesAndTimes) {
  const std::string sweep = write_sweep({}, [](io::SequenceFrame& frame) {
    Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
    if (frame.index == 1) {
      pose(0, 0) = -1;  // A reflection.
      io::set_transform(frame, {"ProbeToTracker", pose, TrackingStatus::kOk});
    }
    if (frame.index == 2) frame.timestamp_s = 10.0;  // Backwards.
    if (frame.index == 3) {
      io::set_transform(frame, {"ProbeToTracker", pose, TrackingStatus::kOutOfVolume});
    }
  });
  expect_refusal(replay_arguments(sweep), 3,
                 {"sweep.igs.mha", "frame 1", "ProbeToTracker", "reflection", "2 of 6"});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out/report.json"));
  const Outcome outcome = sonde(replay_arguments(sweep) + " --skip-bad-frames");
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const Json report = read_json("replay.json");
  EXPECT_EQ(report["ledger"]["received"], 6);
  EXPECT_EQ(report["ledger"]["shown"], 3);
  EXPECT_TRUE(report["ledger"]["balanced"]);
  EXPECT_EQ(report["ledger"]["rejected"]["Probe.not_tracked"], 2);
  EXPECT_EQ(report["rejected_poses"]["Probe.not_rigid"], 1);
  EXPECT_EQ(report["rejected_poses"]["Probe.status_not_ok"], 1);
}

TEST_F(CommandLineTest, APictureWhoseCalibrationCannotBeIsNotShown) {
  const auto sweep_with = [&](const Eigen::Matrix4d& second, TrackingStatus status) {
    return write_sweep({}, [&](io::SequenceFrame& frame) {
      const Eigen::Matrix4d usual = Eigen::Matrix4d::Identity();
      const bool odd = frame.index == 2;
      io::set_transform(frame,
                        {"ImageToProbe", odd ? second : usual, odd ? status : TrackingStatus::kOk});
    });
  };
  const Eigen::Matrix4d none = Eigen::Matrix4d::Constant(std::nan(""));
  expect_refusal(replay_arguments(sweep_with(none, TrackingStatus::kOk)), 3,
                 {"sweep.igs.mha", "frame 2: ImageToProbe", "nan", "1 of 6"});
  const std::string skipping = " --skip-bad-frames";
  const auto expect_one_hidden = [&](const std::string& arguments) {
    const Outcome outcome = sonde(arguments);
    ASSERT_EQ(outcome.code, 0) << outcome.errors;
    EXPECT_NE(outcome.errors.find("frame 2: ImageToProbe"), std::string::npos) << outcome.errors;
    const Json report = read_json("replay.json");
    EXPECT_EQ(report["ledger"]["shown"], 5);
    EXPECT_EQ(report["ledger"]["rejected"]["unusable_picture"], 1);
  };
  expect_one_hidden(replay_arguments(sweep_with(none, TrackingStatus::kOk)) + skipping);
  expect_one_hidden(replay_arguments(sweep_with(none, TrackingStatus::kInvalid)));
  Eigen::Matrix4d moved = Eigen::Matrix4d::Identity();
  moved(0, 3) = 5;
  expect_refusal(replay_arguments(sweep_with(moved, TrackingStatus::kOk)) + skipping, 3,
                 {"sweep.igs.mha", "frame 2: ImageToProbe", "frame 0", "5 mm away"});
}

TEST_F(CommandLineTest, NamesTimesThatDoNotIncrease) {
  expect_refusal(replay_arguments(write_sweep({},
                                              [](io::SequenceFrame& frame) {
                                                if (frame.index == 4)
                                                  frame.timestamp_s = 10.3;  // As frame 3.
                                              })),
                 3, {"frame 4", "Timestamp", "after 10.3", "found 10.3"});
}

TEST_F(CommandLineTest, SaysThatAMissingStatusDegrades) {
  const Outcome outcome = sonde(replay_arguments(write_sweep({}, [](io::SequenceFrame& frame) {
    io::set_transform(frame,
                      {"ProbeToTracker", Eigen::Matrix4d::Identity(), TrackingStatus::kUnknown});
  })));
  EXPECT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_NE(outcome.errors.find("expected a status"), std::string::npos) << outcome.errors;
}

TEST_F(CommandLineTest, RefusesRecordingsThatHoldNoUsablePicture) {
  const auto refuse = [&](const std::string& sweep, std::initializer_list<std::string> pieces) {
    expect_refusal(replay_arguments(sweep), 3, pieces);
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out/report.json"));
  };
  refuse(write_sweep([](auto& h) {
           h.components = 3;
           h.image_type = "RGB_COLOR";
         }),
         {"frame 0"});
  refuse(write_sweep([](auto& h) { h.pixel_type = io::PixelType::kUint16; }), {"frame 0", "8-bit"});
  refuse(write_sweep([](auto& h) { h.orientation = "XX"; }), {"orientation", "XX"});
  refuse(write_sweep({},
                     [](auto& f) {
                       io::set_transform(f,
                                         {"ProbeToTracker", Eigen::Matrix4d::Constant(std::nan("")),
                                          TrackingStatus::kInvalid});
                     }),
         {"Probe"});
  refuse(write_sweep({}, [](auto& f) { f.timestamp_s.reset(); }), {"Timestamp"});
}

TEST_F(CommandLineTest, ARegistrationNeverSpeaksOfAReplay) {
  const std::string arguments =
      "register " + write_sweep() + " --ct " + write_ct() + " --config " + write_config();
  const Outcome refused = sonde(arguments + " --probe-frame Stylus --image-frame Sono");
  EXPECT_EQ(refused.code, 3);
  EXPECT_NE(refused.errors.find("mha: expected frames that place Stylus in Tracker"),
            std::string::npos)
      << refused.errors;
  // Nothing tracks the patient, which is said.
  const Outcome flat = sonde(arguments);
  EXPECT_NE(flat.errors.find("recording: nothing tracks the patient"), std::string::npos);
  EXPECT_EQ((refused.errors + flat.errors).find("replay"), std::string::npos) << flat.errors;
}

TEST_F(CommandLineTest, PicturesWaitForThePosesThatAnOffsetNames) {
  // Six pictures and poses, 100 ms apart.
  const std::string replay = replay_arguments(write_sweep());
  ASSERT_EQ(sonde(replay + " --temporal-offset-ms=-450").code, 0);
  EXPECT_EQ(read_json("replay.json")["ledger"]["rejected"]["Probe.no_pose_yet"], 5);
  ASSERT_EQ(sonde(replay + " --temporal-offset-ms=450").code, 0);
  EXPECT_EQ(read_json("replay.json")["ledger"]["rejected"]["Probe.before_first_pose"], 5);
  expect_refusal(replay + " --temporal-offset-ms=-2000", 3,
                 {"none of 6 frames usable: by --temporal-offset-ms -2000, 6 of 6 pictures lie "
                  "after the last pose, by 1500 to 2000 ms"});
  expect_refusal(replay + " --temporal-offset-ms=600", 3,
                 {"by --temporal-offset-ms 600, 6 of 6 pictures lie before the first pose, by 100 "
                  "to 600 ms"});
}

TEST_F(CommandLineTest, BadFilesExitWithThreeAndNameThemselves) {
  const std::string sweep = write_sweep();
  const std::string ct = write_ct();
  expect_refusal("info /nonexistent/file.mha", 3, {"/nonexistent/file.mha"});
  expect_refusal("replay /nonexistent.igs.mha --ct " + ct + " --out " + (folder_ / "o").string(), 3,
                 {"/nonexistent.igs.mha"});
  expect_refusal(
      "replay " + folder_.path().string() + " --ct " + ct + " --out " + (folder_ / "o").string(), 3,
      {folder_.path().string()});
  expect_refusal("replay " + sweep + " --ct /nonexistent.nii --config " + write_config() +
                     " --out " + (folder_ / "o").string(),
                 3, {"/nonexistent.nii"});
  expect_refusal("replay " + sweep + " --ct " + ct + " --out " + (folder_ / "o").string(), 3,
                 {"Image", "Probe"});
  const auto truncated = folder_ / "truncated.mha";
  std::ofstream(truncated) << "ObjectType = Image\nNDims = 3\nDimSi";
  expect_refusal("info " + truncated.string(), 3, {"truncated.mha"});
  const auto session = folder_ / "session.toml";
  std::ofstream(session) << "[output]\ncolour = \"red\"\n";
  expect_refusal("replay --session " + session.string(), 3, {"output.colour", ":2"});
  std::ofstream(session) << "[source]\nkind = \"device\"\n";
  expect_refusal("replay --session " + session.string(), 4, {"device"});
}

TEST_F(CommandLineTest, RefusesACalibrationThatCannotBe) {
  const std::string sweep = write_sweep();
  const std::string base = "replay " + sweep + " --ct " + write_ct() + " --out " +
                           (folder_ / "o").string() + " --config ";
  expect_refusal(base + write_config("nan 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"), 3, {"plus.xml"});
  expect_refusal(base + write_config("0 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"), 3, {});
  expect_refusal(base + write_config("1 2 3"), 3, {"16"});
}

TEST_F(CommandLineTest, AnOutputThatCannotBeWrittenLeavesNothing) {
  const std::string sweep = write_sweep();
  const auto file = folder_ / "file";
  std::ofstream(file) << "x";
  expect_refusal("replay " + sweep + " --ct " + write_ct() + " --config " + write_config() +
                     " --out " + file.string(),
                 3, {"file", "folder"});
  expect_refusal("info " + sweep + " --json /dev/full", 3, {"/dev/full"});
  expect_refusal("info " + sweep + " --json /nonexistent/x.json", 3, {"/nonexistent"});
}

TEST_F(CommandLineTest, InfoDescribesASequence) {
  const Outcome outcome = sonde("info " + write_sweep() + " --json -");
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const Json report = Json::parse(outcome.output);
  EXPECT_EQ(report["kind"], "sequence");
  EXPECT_EQ(report["dimensions"], (Json{32, 24}));
  EXPECT_EQ(report["frames"], 6);
  EXPECT_EQ(report["transforms"]["ProbeToTracker"]["ok"], 6);
  EXPECT_DOUBLE_EQ(report["first_timestamp_s"].get<double>(), 10.0);
  EXPECT_DOUBLE_EQ(report["last_timestamp_s"].get<double>(), 10.5);
}

TEST_F(CommandLineTest, InfoDescribesACt) {
  const Outcome outcome = sonde("info " + write_ct() + " --json -");
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const Json report = Json::parse(outcome.output);
  EXPECT_EQ(report["kind"], "ct");
  EXPECT_EQ(report["dimensions"], (Json{30, 30, 30}));
  EXPECT_EQ(report["hu_max"], 700);
  ASSERT_EQ(report["value_range"].size(), 2U);
  EXPECT_LT(report["value_range"][0].get<double>(), report["value_range"][1].get<double>());
}

TEST_F(CommandLineTest, RegistersByLandmarksAndReplayUsesTheResult) {
  const auto points = folder_ / "points.csv";
  std::ofstream(points) << "name,reference_x_mm,reference_y_mm,reference_z_mm,ct_x_mm,ct_y_mm,"
                           "ct_z_mm\nA,0,0,0,10,0,0\nB,50,0,0,60,0,0\nC,0,40,0,10,40,0\nD,0,0,30,"
                           "10,0,30\n";
  const std::string sweep = write_sweep();
  const std::string ct = write_ct();
  const auto result = folder_ / "registration.json";
  const Outcome outcome = sonde("register --landmarks " + points.string() + " --ct " + ct +
                                " --json " + result.string());
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const Json report = read_json("registration.json");
  EXPECT_NEAR(report["registration"]["fre_rms_mm"].get<double>(), 0, 1e-9);
  EXPECT_NEAR(report["registration"]["ct_from_reference_mm"][3].get<double>(), 10, 1e-9);
  const Outcome replay = sonde(replay_arguments(sweep) + " --registration " + result.string());
  ASSERT_EQ(replay.code, 0) << replay.errors;
  EXPECT_EQ(read_json("replay.json")["placement"]["kind"], "registered");
  // One that holds at a phase of the breath is not shown at all times.
  Json moving = report;
  moving["breath"] = {{"supported", true}, {"accepted", true}};
  std::ofstream(result) << moving;
  expect_refusal(replay_arguments(sweep) + " --registration " + result.string(), 5,
                 {"registration.json", "breath"});
}

TEST_F(CommandLineTest, RegistersByTheLandmarksThatAgreeAndNamesTheOthers) {
  const auto points = folder_ / "points.csv";
  std::ofstream(points) << "name,reference_x_mm,reference_y_mm,reference_z_mm,ct_x_mm,ct_y_mm,"
                           "ct_z_mm,reference_sigma_x_mm,reference_sigma_y_mm,"
                           "reference_sigma_z_mm,ct_sigma_x_mm,ct_sigma_y_mm,ct_sigma_z_mm\n"
                           "A,0,0,0,10,0,0,.2,.2,1,.3,.3,1\nB,50,0,0,60,0,0,.2,.2,1,.3,.3,1\n"
                           "C,0,40,0,10,40,0,.2,.2,1,.3,.3,1\nD,0,0,30,10,0,30,.2,.2,1,.3,.3,1\n"
                           "Slipped,40,40,0,50,40,25,.2,.2,1,.3,.3,1\n";
  const Outcome outcome =
      sonde("register --landmarks " + points.string() + " --ct " + write_ct() + " --json -");
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_NE(outcome.errors.find("'Slipped' is not used"), std::string::npos) << outcome.errors;
  const Json found = Json::parse(outcome.output)["registration"];
  ASSERT_EQ(found["rejected"].size(), 1u);
  EXPECT_EQ(found["rejected"][0]["name"], "Slipped");
  EXPECT_NEAR(found["rejected"][0]["distance_mm"].get<double>(), 25, 1e-6);
  EXPECT_EQ(found["landmarks"].size(), 4u);
  EXPECT_EQ(found["anisotropic"], true);
  EXPECT_NEAR(found["ct_from_reference_mm"][3].get<double>(), 10, 1e-6);
  EXPECT_GT(found["error_map"]["worst_rms_mm"].get<double>(),
            found["target_error_rms_mm"].get<double>());
}

TEST_F(CommandLineTest, RegistersPointsToASurfaceAndNamesWhatSlides) {
  // A hip roof of 80 x 60 mm, and the same without its ends: that slides along the ridge.
  const auto points = folder_ / "points.txt";
  std::ofstream touched(points);
  for (int i = -9; i <= 9; ++i) {
    for (int j = -6; j <= 6; ++j) {
      const double x = 4.0 * i;
      const double y = 4.0 * j;
      touched << x + 5 << ' ' << y << ' ' << std::min(30 - std::abs(y), 40 - std::abs(x)) << '\n';
    }
  }
  touched.close();
  const auto mesh = [&](const std::string& name, const std::string& polygons) {
    std::ofstream(folder_ / name)
        << "# vtk DataFile Version 3.0\nroof\nASCII\nDATASET POLYDATA\nPOINTS 6 float\n-40 -30 0 "
           "40 -30 0 40 30 0 -40 30 0 -10 0 30 10 0 30\nPOLYGONS "
        << polygons << '\n';
    return (folder_ / name).string();
  };
  const std::string tail = " --points " + points.string() +
                           " --ct-from-reference '1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1' --json -";
  const Outcome outcome =
      sonde("register --surface " +
            mesh("roof.vtk", "4 18\n4 0 1 5 4\n4 3 4 5 2\n3 0 4 3\n3 1 2 5") + tail);
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const Json found = Json::parse(outcome.output);
  EXPECT_EQ(found["method"], "surface");
  EXPECT_NEAR(found["registration"]["ct_from_reference_mm"][3].get<double>(), -5, 0.2);
  // Cells of 4 mm round the ridges.
  EXPECT_LT(found["registration"]["distance"]["mean_mm"].get<double>(), 0.5);
  const std::string tent =
      "register --surface " + mesh("tent.vtk", "2 10\n4 0 1 5 4\n4 3 4 5 2") + tail;
  expect_refusal(tent, 5, {"does not determine"});
  const Json slides = Json::parse(sonde(tent).output)["registration"];
  EXPECT_FALSE(slides.contains("ct_from_reference_mm"));
  EXPECT_EQ(slides["refused_ct_from_reference_mm"].size(), 16U);
  expect_refusal("register --points " + points.string(), 2, {"--landmarks"});
  // Points do not breathe: an option that would do nothing is refused.
  const std::string by_points = "register --surface x.vtk --points " + points.string();
  expect_refusal(by_points + " --breath-period 4", 2, {"--points", "--breath-period"});
  expect_refusal(by_points + " --deformable", 2, {"--points", "--deformable"});
  // What all points share goes into the pose by the surface; landmarks show it.
  const auto landmarks = [&](double shared_mm) {
    const auto path = folder_ / "second.csv";
    std::ofstream file(path);
    file << "name,reference_x_mm,reference_y_mm,reference_z_mm,ct_x_mm,ct_y_mm,ct_z_mm\n";
    for (int i = 0; i < 6; ++i) {
      const double x = 25.0 * (i % 3) - 25;
      const double y = 30.0 * (i / 3) - 15;
      const double z = 4.0 * i;
      file << i << ',' << x + 5 << ',' << y << ',' << z + shared_mm << ',' << x << ',' << y << ','
           << z << '\n';
    }
    return path.string();
  };
  const std::string by_both =
      "register --surface " + (folder_ / "roof.vtk").string() + " --points " + points.string();
  const Outcome agreed = sonde(by_both + " --landmarks " + landmarks(0) + " --json -");
  ASSERT_EQ(agreed.code, 0) << agreed.errors;
  const Json said = Json::parse(agreed.output)["registration"]["landmarks"];
  EXPECT_LT(said["apart_mm"].get<double>(), 0.5);
  EXPECT_LT(said["apart_mm"].get<double>(), said["limit_mm"].get<double>());
  expect_refusal(by_both + " --landmarks " + landmarks(8), 5, {"landmarks and shape", "apart"});
  expect_refusal("register --surface x.vtk", 2, {"--points"});
  const std::string by_image = "register " + write_sweep() + " --ct " + write_ct();
  expect_refusal(by_image + " --similarity ssd", 2, {"--similarity", "ssd"});
  expect_refusal(by_image + " --effort lazy", 2, {"--effort", "quick", "usual", "lazy"});
  expect_refusal(by_image + " --effort quick --deformable", 2, {"--effort quick", "--deformable"});
  expect_refusal(by_image + " --time-limit 0", 2, {"time_limit_s", "0"});
  expect_refusal(by_image + " --loss huber", 2, {"--loss", "cauchy", "huber"});
  expect_refusal(by_image + " --stretch wide", 2, {"--stretch", "wide"});
  expect_refusal(by_image + " --stretch affine --similarity mi", 2, {"stretch"});
  expect_refusal(by_image + " --breath-period 0.5", 2, {"--breath-period", "1 to 20", "0.5"});
  expect_refusal("register --deformable --ct " + write_ct(), 2, {"--deformable", "sweep"});
  expect_refusal(by_image + " --marker-towards up", 2, {"--marker-towards", "anterior", "up"});
  expect_refusal(by_image + " --marker-towards left" +
                     " --ct-from-reference '1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1'",
                 2, {"--marker-towards", "no start pose"});
  expect_refusal(by_points + " --marker-towards left", 2, {"--marker-towards", "sweep"});
}

TEST_F(CommandLineTest, NoColourOutsideATerminal) {
  const Outcome outcome = sonde(replay_arguments(write_sweep()));
  EXPECT_EQ(outcome.errors.find('\033'), std::string::npos);
  EXPECT_EQ(outcome.errors.find('\r'), std::string::npos);
}

TEST_F(CommandLineTest, LandmarksThatDoNotFitAreRefusedAndNeverShownAsRegistered) {
  const auto points = folder_ / "points.csv";
  std::ofstream(points) << "name,reference_x_mm,reference_y_mm,reference_z_mm,ct_x_mm,ct_y_mm,"
                           "ct_z_mm\nA,0,0,0,50,0,0\nB,50,0,0,0,0,0\nC,0,40,0,0,0,30\nD,0,0,30,"
                           "0,40,0\n";
  const auto result = folder_ / "registration.json";
  expect_refusal("register --landmarks " + points.string() + " --ct " + write_ct() + " --json " +
                     result.string(),
                 5, {"residual of the landmarks"});
  const Json refused = read_json("registration.json")["registration"];
  EXPECT_EQ(refused["accepted"], false);
  EXPECT_FALSE(refused.contains("ct_from_reference_mm"));
  EXPECT_EQ(refused["refused_ct_from_reference_mm"].size(), 16U);
  expect_refusal(replay_arguments(write_sweep()) + " --registration " + result.string(), 5,
                 {"registration.json", "not accepted"});
}

TEST_F(CommandLineTest, RefusesRecordingsThatAreCutShort) {
  for (const bool compressed : {false, true}) {
    const std::string sweep = write_sweep([&](auto& h) { h.compressed = compressed; });
    ASSERT_EQ(sonde("info " + sweep).code, 0);
    std::filesystem::resize_file(sweep, std::filesystem::file_size(sweep) - 5);
    expect_refusal("info " + sweep, 3, {"sweep.igs.mha"});
    expect_refusal(replay_arguments(sweep), 3, {"sweep.igs.mha"});
    EXPECT_FALSE(std::filesystem::exists(folder_ / "out"));
  }
}

TEST_F(CommandLineTest, NamesTheFieldThatIsWrong) {
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
    expect_refusal("info " + sweep, 3, {"sweep.igs.mha", "ElementSpacing", "positive", spacing});
  }
  const std::string sweep = change("_Timestamp = 10", "_Timestamp = noon");
  expect_refusal(replay_arguments(sweep), 3, {"frame 0", "Timestamp", "noon"});
  // A pose that no frame gives is told by the gate's reason, with the file.
  const std::string scaled = write_sweep({}, [](io::SequenceFrame& frame) {
    io::set_transform(
        frame, {"ProbeToTracker", 2 * Eigen::Matrix4d::Identity().eval(), TrackingStatus::kOk});
  });
  expect_refusal(replay_arguments(scaled), 3,
                 {"sweep.igs.mha", "Probe.not_tracked", "expected a rigid"});
}

TEST_F(CommandLineTest, StandardOutputThatCannotBeWrittenIsAnError) {
  const std::string sweep = write_sweep();
  for (const std::string& arguments : {"info " + sweep + " >/dev/full", "info " + sweep + " >&-",
                                       replay_arguments(sweep) + " --print-session >/dev/full"}) {
    expect_refusal(built_sonde(arguments), arguments, 3, {"standard output"});
  }
}

TEST_F(CommandLineTest, ThePlacementOnTheCommandLineWinsOverTheFile) {
  const std::string arguments = replay_arguments(write_sweep());
  const std::string matrix = "'1 0 0 5 0 1 0 0 0 0 1 0 0 0 0 1'";
  expect_refusal(arguments + " --registration r.json --ct-from-reference " + matrix, 2,
                 {"--ct-from-reference", "--registration"});
  const auto session = folder_ / "session.toml";
  std::ofstream(session) << "[placement]\nregistration = \"missing.json\"\n";
  const std::string with_session = arguments + " --session " + session.string();
  expect_refusal(with_session, 3, {"missing.json"});
  const Outcome declared = sonde(with_session + " --ct-from-reference " + matrix);
  ASSERT_EQ(declared.code, 0) << declared.errors;
  EXPECT_EQ(read_json("replay.json")["placement"]["kind"], "declared");
  std::ofstream(session) << "[placement]\nregistration = \"missing.json\"\n"
                            "ct_from_reference_mm = [1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]\n";
  expect_refusal(with_session, 3, {"placement.registration", "both"});
}

TEST_F(CommandLineTest, AFailedReplayLeavesNoReportOfAnEarlierOne) {
  const std::string sweep = write_sweep();
  ASSERT_EQ(sonde(replay_arguments(sweep)).code, 0);
  // A folder in the place of a picture stops the run in the middle.
  std::filesystem::remove(folder_ / "out/replay_00002.png");
  std::filesystem::create_directory(folder_ / "out/replay_00002.png");
  expect_refusal(replay_arguments(sweep), 3, {"replay_00002.png"});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out/report.json"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out/report.html"));
  // Nor one that stops before it draws.
  std::filesystem::remove(folder_ / "out/replay_00002.png");
  ASSERT_EQ(sonde(replay_arguments(sweep)).code, 0);
  expect_refusal(replay_arguments(sweep) + " --registration no.json", 3, {"no.json"});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out/report.json"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out/report.html"));
  ASSERT_EQ(sonde(replay_arguments(sweep)).code, 0);
  expect_refusal(replay_arguments("no.igs.mha"), 3, {"no.igs.mha"});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out/report.json"));
}

TEST_F(CommandLineTest, WhatAReplayLeavesIsItsOwn) {
  const std::string sweep = write_sweep();
  ASSERT_EQ(sonde(replay_arguments(sweep)).code, 0);
  const auto there = [&](const char* name) {
    return std::filesystem::exists(folder_ / "out" / name);
  };
  const std::array earlier = {"replay_00004.png", "replay_123456.png", "replay.webp",
                              "pose_log.csv", "following.csv"};
  const std::array others = {"replay_notes.png", "replay_12.png", "replay_00004.png.txt",
                             "my_replay_00004.png", "session.toml"};
  for (const auto& names : {earlier, others}) {
    for (const char* name : names) std::ofstream(folder_ / "out" / name, std::ios::app);
  }
  std::filesystem::create_symlink("replay_notes.png", folder_ / "out/replay_00009.png");
  // One that stops before it draws takes nothing but the report away.
  expect_refusal(replay_arguments(sweep) + " --registration no.json", 3, {"no.json"});
  for (const char* name : earlier) EXPECT_TRUE(there(name)) << name;
  // A folder in the place of a picture stops the run in the middle.
  std::filesystem::remove(folder_ / "out/replay_00002.png");
  std::filesystem::create_directory(folder_ / "out/replay_00002.png");
  expect_refusal(replay_arguments(sweep), 3, {"replay_00002.png"});
  for (const char* name : earlier) EXPECT_FALSE(there(name)) << name;
  for (const char* name : others) EXPECT_TRUE(there(name)) << name;
  EXPECT_TRUE(there("replay_00001.png"));
  EXPECT_TRUE(std::filesystem::is_symlink(folder_ / "out/replay_00009.png"));
}

TEST_F(CommandLineTest, StampsMayBeginBeforeTheOriginOfTheClock) {
  const auto played = [&](double shift_s) {
    const std::string sweep =
        write_sweep({}, [&](io::SequenceFrame& frame) { *frame.timestamp_s += shift_s; });
    const Outcome outcome = sonde(replay_arguments(sweep));
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    return read_json("replay.json");
  };
  const Json usual = played(0);
  const Json early = played(-1000);
  EXPECT_EQ(early["ledger"], usual["ledger"]);
  EXPECT_EQ(early["image_sha256"], usual["image_sha256"]);
}

/// TOML is UTF-8, names of files need not be: the session would name another file.
TEST_F(CommandLineTest, ASessionNamesNoOtherFileThanTheOneThatWasGiven) {
  const std::string latin = "c\xe9t.mha";
  for (const char* verb : {"replay s.mha --ct ", "slices ", "predicates "}) {
    expect_refusal(verb + latin + " --print-session", 2, {"UTF-8", latin});
  }
  const std::string sweep = write_sweep();
  std::filesystem::create_directory(folder_ / "out");
  std::ofstream(folder_ / "out/report.html") << "earlier";
  const std::string look = (folder_ / "\xff.json").string();
  expect_refusal(replay_arguments(sweep) + " --save-look " + look, 2,
                 {"look.save: expected", "UTF-8", look});
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/report.html"));
  EXPECT_EQ(sonde("replay c\xc3\xa9t.mha --print-session").code, 0);
}

TEST_F(CommandLineTest, AReplayReplacesNothingThatItReads) {
  const std::string sweep = write_sweep();
  std::filesystem::create_directory(folder_ / "out");
  const std::string report = (folder_ / "out/report.json").string();
  std::ofstream(report) << "of sonde register";
  expect_refusal(replay_arguments(sweep) + " --registration " + report, 2,
                 {"--out: expected a file of its own", report, "that of --registration"});
  EXPECT_EQ(*io::read_file(report, 100), "of sonde register");
}

TEST_F(CommandLineTest, MoreThreadsThanCoresMakeNoNoise) {
  const Outcome outcome = sonde(replay_arguments(write_sweep()) + " --threads 1000");
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  EXPECT_EQ(outcome.errors.find("TBB"), std::string::npos) << outcome.errors;
}

}  // namespace
}  // namespace nav::app
