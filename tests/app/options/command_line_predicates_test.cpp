// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Ultrasound by predicates and derived features on the command line.
#include <array>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include "io/atomic_file.hpp"
#include "io/ct.hpp"
#include "io/image_output.hpp"
#include "tests/app/options/command_line_support.hpp"
#include "tests/support/matchers.hpp"

namespace nav::app {
namespace {

/// Ultrasound volume of 16 bits: half of the voxels above 255, three above the range that is kept.
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

TEST_F(CommandLineTest, EveryEngineDrawsPredicatesBesideTheStandardRendering) {
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
  expect_rejection(arguments + " --into 0 1 0 --engine vulkan", 2, {"engine", "vulkan"});
}

TEST_F(CommandLineTest, TheFeaturesOfThePhantomDependOnTheOptions) {
  const auto set = folder_ / "steep.json";
  std::ofstream(set) << R"({"sonde_predicates": 1, "name": "steep", "predicates": [)"
                     << R"({"name": "steep", "importance": 1, "hue_deg": 30, "saturation": 1,)"
                     << R"( "where": {"gradient_angle": {}}}]})";
  std::set<std::string> images;
  const auto draw = [&](const std::string& options) {
    const auto out = folder_ / "steep.png";
    const Outcome outcome =
        sonde("predicates --phantom neck --phantom-side 32 --width 200 --height 200 --predicates " +
              set.string() + " --out " + out.string() + options);
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    images.insert(text_of(out));
  };
  draw("");
  draw(" --smoothing-mm 3");
  draw(" --into 1 0 0");
  EXPECT_EQ(images.size(), 3U);
}

TEST_F(CommandLineTest, LabelsOnOtherAxesAreRejectedByTheirAxes) {
  const auto labels = folder_ / "labels.mha";
  std::ofstream out(labels, std::ios::binary);
  out << "ObjectType = Image\nNDims = 3\nBinaryData = True\n"
      << "TransformMatrix = -1 0 0 0 -1 0 0 0 1\nOffset = 0 0 0\nElementSpacing = 1 1 1\n"
      << "DimSize = 20 24 18\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n"
      << std::string(20 * 24 * 18, '\1');
  out.close();
  expect_rejection("predicates " + write_ultrasound(folder_ / "us.mha") +
                       " --predicates layers --labels " + labels.string() + " --out " +
                       (folder_ / "x.png").string(),
                   3, {"labels.mha", "along (1 0 0), (0 1 0)", "along (-1"});
}

TEST_F(CommandLineTest, PredicatesWarnOnceOfWhatAnImageCannotShow) {
  const std::string arguments = "predicates " + write_wide_ultrasound(folder_ / "us.mha") +
                                " --width 200 --height 200 --out " + (folder_ / "x.png").string() +
                                " --predicates " + (folder_ / "set.json").string();
  const auto set = [&](const std::string& name) {
    std::ofstream(folder_ / "set.json") << R"({"sonde_predicates": 1, "predicates": [
            {"name": "Gefäß", "importance": 0.6, "where": {"intensity": {"low": 0.2}}},
            {"name": ")" << name << R"(", "importance": 0.4, "where": {"intensity": {}}}]})";
  };
  set("血管 血");
  const Outcome odd = sonde(arguments + " --white 255");
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

TEST_F(CommandLineTest, PredicatesNameTheWrongOptionOrKey) {
  expect_rejection("predicates --out x.png --phantom-side 32 --predicates nope.json", 2,
                   {"--predicates (predicates.set_up): expected a file, or a predicate preset"});
  const auto session = folder_ / "session.toml";
  std::ofstream(session) << "[predicates]\nset_up = \"nope.json\"\n";
  const Outcome of_key =
      sonde("predicates --out x.png --phantom-side 32 --session " + session.string());
  expect_rejection(of_key, "", 2, {"predicates.set_up: expected a file, or a predicate preset"});
  EXPECT_EQ(count_of("--predicates", of_key.errors), 0) << of_key.errors;
  const std::string painted = "predicates --print-session --predicates carotid-vessel --colour ";
  expect_rejection(painted + "vessel=40:1.5", 2,
                   {"--colour (predicates.histogram.saturation): expected 0 to 1, found 1.5"});
  expect_rejection(painted + "vessel=inf:0.5", 2, {"--colour: expected NAME=HUE:SATURATION"});
  EXPECT_EQ(sonde(painted + "vessel=400:0.5").code, 0);
}

TEST_F(CommandLineTest, TheOpacityOfAPredicateSetIsDrawnAndSaved) {
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
    expect_rejection(arguments + "x.png", 3, {"set.json", "opacity_length_mm", "[0.001, 10000]"});
    expect_rejection("predicates --print-session --opacity-length-mm " + std::string(length), 2,
                     {"--opacity-length-mm", "0.001 to 10000"});
  }
}

TEST_F(CommandLineTest, HugeNumbersAreDrawnOrRejectedByName) {
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
  expect_rejection(deep + " --apex 1e300 0 0", 2, {"--apex", "10000000 mm", "1e300"});
  expect_rejection(deep + " --into 0 1 0 --needle 1e300 0 0 0 0 0", 2, {"--needle", "10000000 mm"});
  expect_rejection(deep + " --into 0 1 0 --target 1e300 0 0 1", 2, {"--target", "10000000 mm"});
  const Outcome stroke = sonde(deep + " --into 0 1 0 --show '10,10,10 normal=1e300,0,0'");
  EXPECT_EQ(stroke.code, 0) << stroke.errors;
  expect_rejection(deep + " --into 0 1 0 --show '1e300,10,10 20,10,25'", 2, {"--show", "1e6 mm"});
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
  expect_rejection(strokes("[[1e300, 9, 9]]"), 3, {"strokes.json", "points_mm", "1e6 mm"});
  expect_rejection(strokes(R"([[9, 9, 9]], "thickness_mm": -3)"), 3, {"thickness_mm", "-3"});
  expect_rejection(strokes(R"([[9, 9, 9]], "normal": [0, 0, 0])"), 3, {"normal", "not all 0"});
  std::string heights = "1e300";
  for (int n = 1; n < 16; ++n) heights += ", 1";
  const std::string layers = write("layers.json", R"({"sonde_layers": 1, "axis": 1, "columns": 4,
      "rows": 4, "surfaces": [{"heights_mm": [)" + heights +
                                                      "]}]}");
  expect_rejection(arguments + (folder_ / "set.json").string() + " --into 0 1 0 --layers " + layers,
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
  expect_rejection(deep + " --scan-lines " +
                       write("reach.json", R"({"sonde_scan_lines": 1, "reach_mm": 1e300})"),
                   3, {"reach.json", "reach_mm", "(0, 100]", "1e+300"});
  expect_rejection(sweep("1e300", ""), 3, {"lines.json", "ct_from_image", "1e6"});
  expect_rejection(sweep("100000", ""), 3,
                   {"lines.json", "within reach_mm of a voxel", "found none"});
  expect_rejection(sweep("0", R"(, "sector": {"apex_mm": [0, -40], "radius_min_mm": 90,
                                "radius_max_mm": 40, "half_angle_deg": 30})"),
                   3, {"sector.radius_max_mm", "more than radius_min_mm", "40"});
  expect_rejection(sweep("0", R"(, "sector": {"apex_mm": [0, -40], "radius_min_mm": 30,
                                "radius_max_mm": 90, "half_angle_deg": 200})"),
                   3, {"sector.half_angle_deg", "(0, 180]", "200"});
  const std::string derive =
      "derive " + volume + " --out " + (folder_ / "derived").string() + " --feature depth ";
  EXPECT_EQ(sonde(derive + "--into 1e300 0 0").code, 0);
  expect_rejection(derive + "--apex 1e300 0 0", 2,
                   {"--apex: expected 3 numbers of -10000000 to 10000000 mm", "1e300"});
  for (const char* threads : {"100000", "-3"}) {
    expect_rejection(derive + "--threads " + threads, 2, {"--threads", "0 to 1024", threads});
    expect_rejection(deep + " --into 0 1 0 --threads " + threads, 2, {"--threads", "1024"});
  }
  for (const char* value : {"65536", "-40000"}) {
    expect_rejection(derive + "--unknown " + value, 2, {"--unknown", "-32768 to 32767", value});
    expect_rejection("predicates --print-session --unknown " + std::string(value), 2,
                     {"--unknown"});
  }
}

// The face is at the first known voxel along the lines, or at the user's point.
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
    const auto image = io::read_png(out);
    EXPECT_TRUE(test::has_value(image));
    int count = 0;
    // Between the letters at the edges.
    for (int y = 60; y < 200; ++y) {
      for (int x = 230; x < 370; ++x) count += image->at(x, y).r > 60 ? 1 : 0;
    }
    return std::pair(count, outcome.errors);
  };
  const std::string padded = write("padded.mha", kEmptyRows);
  EXPECT_GT(lit(write("whole.mha", 0), "").first, 1000);
  EXPECT_GT(lit(padded, "--unknown 0").first, 500);
  EXPECT_GT(lit(padded, "--face 5 0 7").first, 500);
  // Measured from the box's own face those depths are empty; a warning says so.
  const auto [count, errors] = lit(padded, "");
  EXPECT_EQ(count, 0);
  EXPECT_NE(errors.find("the image by predicates is empty"), std::string::npos) << errors;
  expect_rejection("predicates --print-session --predicates " +
                       (folder_ / "shallow.json").string() + " --face 0 0 0",
                   2, {"--face", "requires predicates.into"});
  const std::string derive =
      "derive " + padded + " --feature depth --out " + (folder_ / "d").string();
  EXPECT_NE(sonde(derive + " --into 0 1 0 --face 0 0 0").output.find("-10"), std::string::npos);
  expect_rejection(derive + " --face 0 0 0 --apex 0 0 0", 2, {"--face requires --into"});
}

TEST_F(CommandLineTest, DeriveComputesTheFeaturesThatPredicatesRead) {
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
           {"confidence --into 0 1 0 --confidence-gamma 2",
            "--confidence-gamma: expected 0 to 1, found 2"},
           {"gradient-magnitude --white -1", "--white: expected more than --black, 0, found -1"},
           {"confidence", "--feature confidence requires scan lines (--into, --apex or "},
           {"snr depth", "--feature depth requires scan lines"},
           {"snr --white 9", "--white requires --feature gradient-magnitude"},
           {"snr --confidence-beta 9", "--confidence-beta requires --feature confidence"},
           {"depth --snr-window 3", "--snr-window requires --feature snr"}}) {
    expect_rejection(derive + options, 2, {pieces});
  }
}

TEST_F(CommandLineTest, ASavedPredicateSetGivesTheSameImage) {
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

TEST_F(CommandLineTest, OptionsThatNoPredicateUsesAreRejected) {
  std::ofstream(folder_ / "bright.json") << R"({"sonde_predicates": 1, "predicates": [
      {"name": "bright", "where": {"intensity": {"low": 0.5}}}]})";
  const std::string arguments =
      "predicates --print-session --predicates " + (folder_ / "bright.json").string() + " ";
  for (const auto& [options, expected] : std::vector<std::pair<std::string, std::string>>{
           {"--into 0 1 0", "--into requires a predicate depth, gradient_angle or confidence"},
           {"--apex 0 1 0", "--apex requires a predicate depth"},
           {"--labels l.mha", "--labels requires a predicate label"},
           {"--bright", "--bright requires a predicate vesselness"},
           {"--smallest-radius 1", "--smallest-radius requires a predicate vesselness"},
           {"--smoothing-mm 1", "--smoothing-mm requires a predicate gradient_magnitude"}}) {
    expect_rejection(arguments + options, 2, {expected});
  }
  expect_rejection("predicates --print-session --smallest-radius 6", 2,
                   {"smallest_radius_mm", "largest radius", "4.5"});
  expect_rejection("predicates --out x.png --phantom-side 32 --predicates " +
                       (folder_ / "bright.json").string() + " --importance bright=0.2",
                   2, {"--importance", "only one predicate", "0.2"});
  const Outcome linear = sonde(arguments + "--hue-mean linear");
  EXPECT_NE(linear.output.find("hue_mean = 'linear'"), std::string::npos) << linear.output;
  expect_rejection(arguments + "--hue-mean square", 2, {"--hue-mean", "circular or linear"});
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
  expect_rejection(arguments + " --show 1,2", 2, {"--show", "'1,2'"});
  expect_rejection(arguments + " --show 900,0,0", 2, {"stroke 1", "found none"});
  expect_rejection("predicates nowhere.mha --out x.png --show '9,9,9 radius=-1'", 2,
                   {"--show", "radius_mm", "-1"});
  expect_rejection(arguments + " --hide '15,2,9 15,20,12 normal=0,0,1'", 2,
                   {"stroke 1", "point 2", "3 mm away"});
  std::ofstream(folder_ / "strokes.json") << R"({"sonde_scribbles": 1, "strokes": [
      {"points_mm": [[4, 2, 9], [4, 20, 9], [9, 20, 9], [9, 2, 14]]}]})";
  // Strokes of a file are input, and the file is named.
  const std::string by_file = arguments + " --scribbles " + (folder_ / "strokes.json").string();
  expect_rejection(by_file, 3, {"strokes.json: stroke 1", "point 2", "mm away"});
  std::ofstream(folder_ / "strokes.json")
      << R"({"sonde_scribbles": 1, "strokes": [{"points_mm": [[900, 0, 0]]}]})";
  expect_rejection(by_file, 3, {"strokes.json: stroke 1", "found none"});
  // Twice the same voxels is no mistake.
  EXPECT_NE(sonde(arguments + " --show '9,9,9 radius=3' --show '9,9,9 radius=2'")
                .errors.find("123 voxels to show, 0 to hide"),
            std::string::npos);
  // The last stroke that covers a voxel counts.
  const std::string hide = " --hide '9,9,9 radius=3'";
  const std::string show = " --show '9,9,9 radius=3'";
  EXPECT_NE(sonde(arguments + show + hide).errors.find("0 voxels to show, 123 to hide"),
            std::string::npos);
  EXPECT_NE(sonde(arguments + hide + show).errors.find("123 voxels to show, 0 to hide"),
            std::string::npos);
}

TEST_F(CommandLineTest, TheNameOfAPresetNeverMeansAFile) {
  const auto session = folder_ / "session.toml";
  std::ofstream(session) << "[predicates]\nset_up = \"carotid-context\"\n";
  const auto there = std::filesystem::current_path();
  std::filesystem::current_path(folder_.path());
  std::ofstream("carotid-context") << R"({"sonde_predicates": 1, "predicates": [
      {"name": "only", "where": {"intensity": {}}}]})";
  const std::string names = "predicates --out x.png --phantom-side 32 --importance none=1";
  expect_rejection(names + " --predicates carotid-context", 2,
                   {"--importance", "expected one of interfaces"});
  expect_rejection(names + " --session " + session.string(), 2, {"expected one of interfaces"});
  expect_rejection(names + " --predicates ./carotid-context", 2, {"expected one of only"});
  std::filesystem::current_path(there);
}

TEST_F(CommandLineTest, OneSliceOfUltrasoundIsAVolumeForAnyAxis) {
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

TEST_F(CommandLineTest, AFocusThatCannotBeSeenIsSaid) {
  VoxelGrid grid;
  grid.size = {24, 24, 24};
  std::ofstream(folder_ / "focus.json") << R"({"sonde_predicates": 1, "predicates": [
      {"name": "focus", "where": {"intensity": {"low": 0.02, "high": 1}}}]})";
  const auto errors = [&](std::int16_t value) {
    std::vector<std::int16_t> voxels(grid.voxel_count(), 0);
    for (std::size_t i = 0; i < voxels.size(); ++i) voxels[i] = i % 24 > 8 ? value : 0;
    const auto file = (folder_ / "focus.mha").string();
    EXPECT_TRUE(test::has_value(io::write_ct_mha(*Volume::create(grid, voxels, "f"), file)));
    const Outcome outcome =
        sonde("predicates " + file + " --predicates " + (folder_ / "focus.json").string() +
              " --black 0 --white 255 --width 200 --height 200 --out " +
              (folder_ / "focus.png").string());
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    return outcome.errors;
  };
  EXPECT_NE(errors(8).find("'focus', the most important predicate (1), can hardly be seen"),
            std::string::npos);
  EXPECT_EQ(errors(230).find("can hardly be seen"), std::string::npos);
}

TEST_F(CommandLineTest, UnknownVoxelsAreDarkAndKeepTheirValue) {
  VoxelGrid grid;
  grid.size = {24, 24, 24};
  std::vector<std::int16_t> voxels(grid.voxel_count());
  std::ofstream(folder_ / "bright.json") << R"({"sonde_predicates": 1, "predicates": [
      {"name": "bright", "where": {"intensity": {}}}]})";
  const auto lit = [&](std::int16_t unknown, const std::string& more) {
    // One half is known and black, the outer half is unknown.
    for (std::size_t i = 0; i < voxels.size(); ++i) voxels[i] = i % 24 < 12 ? unknown : 0;
    const auto file = (folder_ / "u.mha").string();
    EXPECT_TRUE(test::has_value(io::write_ct_mha(*Volume::create(grid, voxels, "u"), file)));
    const auto out = folder_ / "u.png";
    const Outcome outcome =
        sonde("predicates " + file + " --predicates " + (folder_ / "bright.json").string() +
              " --width 200 --height 200 --out " + out.string() + more);
    EXPECT_EQ(outcome.code, 0) << outcome.errors;
    const auto image = io::read_png(out);
    EXPECT_TRUE(test::has_value(image));
    int count = 0;
    // Between the letters at the edges.
    for (int y = 60; y < 200; ++y) {
      for (int x = 30; x < 170; ++x) {
        count += image->at(x, y).r > 100 ? 1 : 0;
        count += image->at(200 + x, y).r > 100 ? 1 : 0;
      }
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

TEST_F(CommandLineTest, ErrorsOfPredicatesAreOneSentence) {
  const std::string volume = write_ultrasound(folder_ / "us.mha");
  const std::string arguments =
      "predicates " + volume + " --out " + (folder_ / "x.png").string() + " --predicates ";
  const auto file = [&](const std::string& where) {
    std::ofstream(folder_ / "set.json")
        << R"({"sonde_predicates": 1, "predicates": [{"name": "a", "where": )" << where << "}]}";
    return arguments + (folder_ / "set.json").string();
  };
  // Errors on the command line.
  expect_rejection("predicates " + volume, 2, {"--out"});
  expect_rejection(arguments + "kidney", 2, {"--predicates", "carotid-context", "kidney"});
  expect_rejection(arguments + "carotid-vessel", 2, {"depth", "scan-line directions", "--into"});
  expect_rejection(file(R"({"confidence": {}})"), 2, {"confidence", "scan-line directions"});
  expect_rejection(arguments + "layers", 2, {"label", "--labels"});
  expect_rejection(file(R"({"needle_distance": {}})"), 2, {"needle_distance", "--needle"});
  expect_rejection(file(R"({"target_distance": {}})"), 2, {"target_distance", "--target"});
  expect_rejection(arguments + "layers --white -1", 2, {"predicates.white", "-1"});
  expect_rejection(arguments + "layers --into 0 0 0", 2, {"predicates.into", "not all 0"});
  expect_rejection(arguments + "layers --importance liver=1", 2, {"skin, muscle, target", "liver"});
  expect_rejection(arguments + "layers --largest-radius -1", 2, {"--largest-radius", "-1"});
  expect_rejection("predicates --phantom liver --out x.png", 2, {"--phantom", "carotid", "liver"});
  // Errors in a file.
  expect_rejection(file(R"({"sharpness": {}})"), 3, {"where", "sharpness"});
  expect_rejection(file(R"({"intensity": {"low": 0.8, "high": 0.2}})"), 3, {"low <= high"});
  expect_rejection(file(R"({"entry": "a"})"), 3, {"cycle"});
  std::string many = R"({"sonde_predicates": 1, "predicates": [)";
  for (int n = 0; n < 33; ++n) {
    many += (n > 0 ? ", " : "") + (R"({"name": ")" + std::to_string(n)) +
            R"(", "where": {"intensity": {}}})";
  }
  std::ofstream(folder_ / "set.json") << many << "]}";
  expect_rejection(arguments + (folder_ / "set.json").string(), 3, {"32", "33"});
  std::ofstream(folder_ / "set.json") << R"({"sonde_predicates": 2})";
  expect_rejection(arguments + (folder_ / "set.json").string(), 3, {"version 1", "newer"});
  VoxelGrid grid;
  grid.size = {20, 24, 17};
  const auto labels = Volume::create(grid, std::vector<std::int16_t>(grid.voxel_count()), "labels");
  ASSERT_TRUE(test::has_value(io::write_ct_mha(*labels, folder_ / "labels.mha")));
  expect_rejection(arguments + "layers --labels " + (folder_ / "labels.mha").string(), 3,
                   {"labels.mha", "20 x 24 x 18", "20 x 24 x 17"});
}

TEST_F(CommandLineTest, DerivedFeaturesAreCachedOnRequest) {
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
  // Predicates read the cache of derive: same voxels, scan lines and parameters.
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
  expect_rejection("replay x.mha --print-session --cache d", 2, {"--cache requires --us-volume"});
}

}  // namespace
}  // namespace nav::app
