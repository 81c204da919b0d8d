// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Slices on the command line.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <string>
#include <vector>

#include "io/atomic_file.hpp"
#include "io/ct.hpp"
#include "io/image_output.hpp"
#include "tests/app/options/command_line_support.hpp"
#include "tests/support/matchers.hpp"

namespace nav::app {
namespace {

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
  expect_rejection(arguments + " --mode median", 2, {"--mode", "median"});
  expect_rejection(arguments + " --slab -1", 2, {"--slab", "-1"});
  expect_rejection(arguments + " --mm-per-pixel nan", 2, {"--mm-per-pixel", "nan"});
  expect_rejection(arguments + " --mm-per-pixel -1", 2, {"--mm-per-pixel", "-1"});
  expect_rejection(arguments + " --at 9999 0 0", 2, {"--at", "inside the CT", "9999"});
  expect_rejection(arguments + " --window-width 0", 2, {"--window-width", "0"});
  expect_rejection(arguments + " --at nan 0 0", 2, {"--at", "nan"});
  expect_rejection("slices missing.mha --out " + out.string(), 3, {"missing.mha"});
}

TEST_F(CommandLineTest, SlicesShowASecondVolumeInItsReportedWindow) {
  // Values like in MR: background, a dark body and a few bright voxels.
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
  EXPECT_NE(said.find("second volume: level 500, width 1000"), std::string::npos) << said;
  const auto image = io::read_png(out / "axial.png");
  ASSERT_TRUE(test::has_value(image));
  EXPECT_EQ(image->at(72, 80).r, 51) << "the body: a fifth of white";
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
    const auto image = io::read_png(folder_ / "slices" / (std::string(name) + ".png"));
    ASSERT_TRUE(test::has_value(image)) << name;
    const auto yellow = [&](int left, int top) {
      int count = 0;
      for (int y = top; y < top + 24; ++y) {
        for (int x = left; x < left + 24; ++x) {
          const Rgba8 p = image->at(x, y);
          count += p.r > p.b + 60 ? 1 : 0;
        }
      }
      return count;
    };
    for (const auto& [left, top] : {std::pair(0, 20), {40, 20}, {20, 0}, {20, 40}}) {
      EXPECT_GT(yellow(left, top), 10) << name << ' ' << left << ' ' << top;
    }
  }
  expect_rejection(arguments + " --size 63", 2,
                   {"--size: expected a whole number of 64 to 8192 pixels"});
}

TEST_F(CommandLineTest, WritesObliqueSlicesAndSlicesAlongANeedle) {
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
  // Two directions give the same plane: seen from the feet, the patient's left is at the right.
  ASSERT_EQ(sonde(arguments + " --right 2 0 0 --down 1 3 -3 --slab 8").code, 0);
  EXPECT_EQ(bytes("oblique.png"), oblique);
  // This run has no needle; the needle slices of the earlier run must be gone.
  EXPECT_FALSE(std::filesystem::exists(out / "needle-1.png"));
  EXPECT_FALSE(std::filesystem::exists(out / "needle-2.png"));
  EXPECT_EQ(bytes("my-needle.png"), "mine");
  EXPECT_EQ(bytes("report.json"), "mine");

  expect_rejection(arguments + " --normal 0 0 0", 2, {"--normal", "not zero"});
  expect_rejection(arguments + " --normal nan 0 1", 2, {"--normal", "nan"});
  expect_rejection(arguments + " --right 1 0 0", 2, {"--right requires --down"});
  expect_rejection(arguments + " --right 1 0 0 --down 2 0 0", 2, {"--down", "other than --right"});
  expect_rejection(arguments + " --right 1 0 0 --normal 0 0 1", 2,
                   {"--normal cannot be combined with --right"});
  expect_rejection(arguments + " --needle 1 1 1 1 1 1", 2, {"--needle", "apart from each other"});
  expect_rejection(arguments + " --needle 900 0 0 0 0 0", 2, {"--needle", "inside the CT"});
  expect_rejection(arguments + " --frame 1", 2, {"--frame requires --recording"});
  expect_rejection(arguments + " --share 1", 2, {"--share requires --recording or --second"});
}

TEST_F(CommandLineTest, WritesAndFusesTheSliceAlongAnImage) {
  const auto out = folder_ / "slices";
  const std::string ct = write_ct();
  const std::string arguments = "slices " + ct + " --out " + out.string() + " --size 192";
  const std::string recording = arguments + " --recording " + write_sweep() + " --config " +
                                write_config() +
                                " --ct-from-reference \"1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\"";
  // Image i has the value 40 + 30 i; the CT is air around (0, 0, 2 i), at the face of the probe.
  const auto grey = [&](const std::string& options) {
    const Outcome outcome = sonde(options);
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    const auto image = io::read_png(out / "ultrasound.png");
    return image ? static_cast<int>(image->at(70, 110).r) : -1;
  };
  EXPECT_EQ(grey(recording + " --frame 3 --share 1"), 130);
  EXPECT_EQ(grey(recording + " --frame 1 --share 1"), 70);
  EXPECT_EQ(grey(recording + " --frame 3 --share 0 --window-level 700"), 128);
  EXPECT_EQ(grey(recording + " --frame 3 --fusion wipe --wipe 0.5"), 130);
  EXPECT_EQ(grey(recording + " --frame 3 --fusion wipe --wipe 0 --window-level 700"), 128);
  expect_rejection("slices " + ct + " --out x --recording s.mha --size 128", 2,
                   {"--size: expected 192 to 8192"});
  expect_rejection(recording + " --frame 6", 2, {"--frame: expected 0 to 5, found 6"});
  expect_rejection(recording + " --frame -1", 2, {"--frame: expected 0 to 5, found -1"});
  expect_rejection(recording + " --needle-frame NeedleTip", 2, {"NeedleTip"});
  expect_rejection(recording + " --second " + ct, 2,
                   {"--recording cannot be combined with --second"});
  expect_rejection(recording + " --wipe 0.5", 2, {"--wipe requires --fusion wipe"});

  const Outcome second = sonde(arguments + " --second " + ct + " --second-level 0 --share 1");
  EXPECT_EQ(second.code, 0) << second.errors;
  expect_rejection(arguments + " --second no.mha", 3, {"no.mha"});
}

TEST_F(CommandLineTest, SlicesOfASessionUseItsFilesAndItsPath) {
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

  // The path is drawn like a needle at the same position; its target is the point of all slices.
  const auto on_line = [&](const std::string& name) {
    const auto image = io::read_png(out / name);
    if (!image) return std::ptrdiff_t{-1};
    return std::ranges::count_if(image->pixels(), [](const Rgba8& p) {
      return p.b > p.r + 30;  // The CT is grey, the text is yellow.
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

  // The slices show the session's recording over the CT, unless an option replaces it.
  std::ofstream(session) << files << recording << plan;
  const Outcome along = sonde(arguments + " --frame 3 --share 1");
  ASSERT_EQ(along.code, 0) << along.errors;
  EXPECT_EQ(static_cast<int>(io::read_png(out / "ultrasound.png")->at(70, 110).r), 130);
  std::filesystem::remove_all(out);
  const Outcome second = sonde(arguments + " --second " + ct + " --out " + out.string());
  ASSERT_EQ(second.code, 0) << second.errors;
  EXPECT_FALSE(std::filesystem::exists(out / "ultrasound.png"));
  EXPECT_TRUE(std::filesystem::exists(out / "path-1.png"));
  expect_rejection(arguments + " --second " + ct + " --frame 3", 2,
                   {"--frame requires --recording"});
  EXPECT_NE(sonde(arguments + " --print-session").output.find(sweep), std::string::npos);

  std::ofstream(session) << files
                         << "[plan]\nentry_mm = [0, -50, 40]\ntarget_mm = [0, 900, 0]\n"
                            "target_radius_mm = 6\n";
  expect_rejection(arguments, 2, {"plan.target_mm", "inside the CT", "900"});
  std::ofstream(session) << "[source]\nkind = \"simulated\"\n";
  expect_rejection(arguments, 2, {"source.kind", "simulated"});
  expect_rejection("slices --out x", 2, {"ct: expected a CT, found nothing"});
  expect_rejection("slices " + ct, 2, {"--out: expected a folder, found nothing"});
}

}  // namespace
}  // namespace nav::app
