// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Appearances and galleries on the command line.
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>
#include <optional>
#include <string>

#include "app/options/exit_code.hpp"
#include "app/report.hpp"
#include "io/image_output.hpp"
#include "tests/app/options/command_line_support.hpp"
#include "tests/support/matchers.hpp"

namespace nav::app {
namespace {

TEST_F(CommandLineTest, OptionsOfTheCutawayOverrideAnAppearanceWithoutOne) {
  const std::string arguments = replay_arguments(write_sweep());
  const auto appearance = (folder_ / "look.json").string();
  ASSERT_EQ(sonde(arguments + " --no-cutaway --save-appearance " + appearance).code, 0);
  for (const char* option : {"--cutaway-around plane", "--cutaway-inner 20", "--cutaway-outer 60",
                             "--cutaway-overlay 5"}) {
    const auto saved = (folder_ / "cut.json").string();
    const Outcome outcome = sonde(arguments + " --appearance " + appearance + " " + option +
                                  " --save-appearance " + saved);
    EXPECT_EQ(outcome.code, 0) << option << ": " << outcome.errors;
    EXPECT_TRUE(read_json("cut.json")["cutaway"].is_object()) << option;
  }
}

TEST_F(CommandLineTest, InvalidAppearancesAreUsageErrors) {
  expect_rejection("demo --out x --shading flat", 2,
                   {"--shading: expected phong or gooch, found flat"});
  expect_rejection("demo --out x --emphasis 2", 2, {"--emphasis: expected 0 to 1, found 2"});
  expect_rejection("demo --out x --projection mip", 2, {"--projection", "mip"});
  expect_rejection("demo --out x --cutaway-inner 50 --cutaway-outer 20", 2, {"theta1_deg", "50"});
  expect_rejection("demo --out x --cutaway-overlay -1", 2, {"--cutaway-overlay", "-1"});
  expect_rejection("demo --out x --cutaway-around liver", 2, {"liver"});
  expect_rejection("demo --out x --importance 3", 2,
                   {"--importance", "LOW:HIGH=IMPORTANCE", "'3'"});
  expect_rejection("demo --out x --importance a:b=c", 2, {"--importance", "'a:b=c'"});
}

TEST_F(CommandLineTest, AppearanceOptionsEnterTheSession) {
  const auto session = folder_ / "session.toml";
  std::ofstream(session) << "[plan]\nentry_mm = [0,-9,0]\ntarget_mm = [0,0,0]\n"
                            "target_radius_mm = 4\n";
  const Outcome outcome = sonde(
      "replay x.mha --print-session --appearance a.vp --shading gooch --emphasis 0.5 "
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

TEST_F(CommandLineTest, TheWindowOfTheCtSuitsItUnlessItIsGiven) {
  const std::string arguments = replay_arguments(write_sweep(), "out", 400, 300) + " --frames 1";
  const auto window = [&](const std::string& options) {
    const Outcome outcome = sonde(arguments + options);
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    const io::Json json = read_json("replay.json")["ct_window"];
    return std::pair(json["level"], json["width"]);
  };
  // The middle of the CT's panel, right of the 3D view.
  const auto grey = [&] {
    const auto image = io::read_png(folder_ / "out/replay_00000.png");
    return image ? static_cast<int>(image->at(500, 230).r) : -1;
  };
  // The sweep's centre lies in the CT's, a block of 700 HU.
  EXPECT_EQ(window(""), std::pair(io::Json(200.0), io::Json(700.0)));
  EXPECT_EQ(grey(), 255);
  EXPECT_EQ(window(" --window-level 700"), std::pair(io::Json(700.0), io::Json(700.0)));
  EXPECT_EQ(grey(), 128);
  EXPECT_EQ(window(" --window-level 700 --window-width 1"),
            std::pair(io::Json(700.0), io::Json(1.0)));
  const auto session = folder_ / "window.toml";
  std::ofstream(session) << "[view]\nwindow_level = 1000\nwindow_width = 1200\n";
  const std::string with_session = " --session " + session.string();
  EXPECT_EQ(window(with_session), std::pair(io::Json(1000.0), io::Json(1200.0)));
  EXPECT_EQ(grey(), 64);
  EXPECT_EQ(window(with_session + " --window-width 900"),
            std::pair(io::Json(1000.0), io::Json(900.0)));
  const Outcome printed = sonde("replay x.mha --print-session --window-level -500");
  EXPECT_NE(printed.output.find("window_level = -500"), std::string::npos) << printed.errors;
  expect_rejection("replay x.mha --print-session --window-width -1", 2,
                   {"--window-width: expected 0.001 to 1000000 HU, found -1"});

  // Slices choose their window too, for the values that they show.
  const auto said = [&](const std::string& options) {
    const Outcome outcome = sonde("slices " + (folder_ / "ct.mha").string() + " --out " +
                                  (folder_ / "slices").string() + options);
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    return outcome.output + outcome.errors;
  };
  EXPECT_NE(said("").find("window: level 200, width 700"), std::string::npos) << said("");
  EXPECT_NE(said(with_session).find("window: level 1000, width 1200"), std::string::npos);
}

TEST_F(CommandLineTest, AProjectionHasTheWindowOfWhatItShowsAndSaysWhich) {
  const std::string replay = replay_arguments(write_sweep(), "out", 480, 300) + " --frames 1 ";
  const auto report = [&](const std::string& options) {
    const Outcome outcome = sonde(replay + options);
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    return read_json("replay.json");
  };
  EXPECT_TRUE(report("")["grey_window"].is_null());
  // Air and a block of 700 HU: air is left out; edge voxels, half air and half block, remain.
  const io::Json maximum = report("--projection maximum")["grey_window"];
  const double white = maximum["level"].get<double>() + maximum["width"].get<double>() / 2;
  EXPECT_NEAR(white, 700, 100) << maximum;
  EXPECT_EQ(report("--projection mean --grey-level 40 --grey-width 500")["grey_window"],
            (io::Json{{"level", 40.0}, {"width", 500.0}}));
  const io::Json half = report("--projection maximum --grey-level 40")["grey_window"];
  EXPECT_EQ(half["level"], 40.0);
  EXPECT_EQ(half["width"], maximum["width"]);
  // The written session has no window, so that it suits other data too.
  EXPECT_EQ(text_of(folder_ / "out" / "session.toml").find("grey_width_hu"), std::string::npos);
  const io::Json minimum = report("--projection minimum");
  bool told = false;
  for (const io::Json& entry : minimum["diagnostics"]) {
    told |= entry["message"].get<std::string>().find("only air") != std::string::npos;
  }
  EXPECT_TRUE(told) << minimum["diagnostics"];
}

TEST_F(CommandLineTest, EnginesAgreeOnAnOrthographicImage) {
  const std::string sweep = write_sweep();
  const auto image = [&](const std::string& options) -> std::optional<Image2d<Rgba8>> {
    const Outcome outcome =
        sonde(replay_arguments(sweep) + " --frames 1 --azimuth -30 --elevation 20 --distance 150 " +
              options);
    if (outcome.code == kExitDevice) return std::nullopt;
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    auto read = io::read_png(folder_ / "out" / "replay_00000.png");
    EXPECT_TRUE(test::has_value(read));
    return *read;
  };
  /// Largest difference of two images in the 3D view.
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
  const auto cpu = image("--orthographic");
  const auto reference = image("--orthographic --engine reference");
  const auto perspective = image("");
  ASSERT_TRUE(cpu && reference && perspective);
  constexpr int kEnginesApart = 4;  // On a scale of 255.
  EXPECT_LE(difference(*cpu, *reference), kEnginesApart);
  EXPECT_GT(difference(*cpu, *perspective), 40) << "another image";
  if (const auto gl = image("--orthographic --engine gl")) {
    EXPECT_LE(difference(*cpu, *gl), kEnginesApart);
  }
  const Outcome session = sonde("replay --print-session x.mha --orthographic");
  EXPECT_NE(session.output.find("orthographic = true"), std::string::npos) << session.output;
}

TEST_F(CommandLineTest, ASavedAppearanceGivesTheSameImage) {
  const std::string arguments = replay_arguments(write_sweep()) + " --frames 1 ";
  const std::string saved = (folder_ / "mine.json").string();
  const Outcome first =
      sonde(arguments + "--shading gooch --importance 500:900=0.9 --save-appearance " + saved);
  ASSERT_EQ(first.code, 0) << first.errors;
  const auto digest = read_json("replay.json")["image_sha256"];
  const Outcome again = sonde(arguments + "--appearance " + saved);
  ASSERT_EQ(again.code, 0) << again.errors;
  EXPECT_EQ(read_json("replay.json")["image_sha256"], digest);
  expect_rejection(arguments + "--save-appearance " + (folder_ / "no" / "look.json").string(), 3,
                   {"look.json"});
  expect_rejection(arguments + "--projection mean --save-appearance " + saved, 2,
                   {"--save-appearance requires --projection composite"});
}

TEST_F(CommandLineTest, SamplingAndObjectsOfInterestChangeTheImage) {
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
  expect_rejection(arguments + "--cutaway-mesh none.stl", 3, {"none.stl"});
  expect_rejection(arguments + "--no-cutaway --cutaway-mesh " + mesh.string(), 2,
                   {"--cutaway-mesh has no effect with --no-cutaway"});
  expect_rejection(arguments + "--classification none", 2, {"--classification", "none"});
  expect_rejection(arguments + "--jitter --pixel-error 0.1", 2, {"--pixel-error", "jitter"});
}

TEST_F(CommandLineTest, APresetThatIsNamedAndMissingIsAnError) {
  const std::string replay =
      replay_arguments(write_sweep()) + " --frames 1 --transfer-function contextual";
  const char* const before = std::getenv("SONDE_APPEARANCES");
  const std::string kept = before == nullptr ? "" : before;
  setenv("SONDE_APPEARANCES", "/nowhere/appearances", 1);
  expect_rejection(replay, 3, {"--transfer-function contextual", "/nowhere/appearances"});
  const Outcome unnamed = sonde(replay_arguments(write_sweep()) + " --frames 1");
  EXPECT_EQ(unnamed.code, 0) << unnamed.errors;
  EXPECT_NE(unnamed.errors.find("is drawn in place of contextual"), std::string::npos);
  if (before == nullptr) {
    unsetenv("SONDE_APPEARANCES");
  } else {
    setenv("SONDE_APPEARANCES", kept.c_str(), 1);
  }
}

}  // namespace
}  // namespace nav::app
