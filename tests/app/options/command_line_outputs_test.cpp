// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Files that the program writes, and files that it never overwrites.
#include <array>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "app/output_folder.hpp"
#include "tests/app/options/command_line_support.hpp"

namespace nav::app {
namespace {

// The program rejects outputs that it cannot write before it computes for a minute.
TEST_F(CommandLineTest, UnwritableOutputsAreRejectedAtOnce) {
  const std::string nowhere = (folder_ / "none" / "x").string();
  const std::string ultrasound = write_ultrasound(folder_ / "us.mha");
  for (const auto& [arguments, option] : std::vector<std::pair<std::string, std::string>>{
           {"predicates --phantom-side 512 --out " + nowhere + ".png", "--out: "},
           {"predicates --phantom-side 512 --out x.png --save " + nowhere, "--save: "}}) {
    expect_rejection(arguments, 3, {option, "none/x"});
  }
  EXPECT_FALSE(std::filesystem::exists("x.png"));
  // A report may be written into a folder that the verb creates.
  const std::string sweep = write_sweep();
  const std::string arguments = "replay " + sweep + " --ct " + write_ct() + " --config " +
                                write_config() + " --width 96 --height 64 --step 2 --out " +
                                (folder_ / "new").string() + " --json " +
                                (folder_ / "new" / "report2.json").string();
  const Outcome made = sonde(arguments);
  EXPECT_EQ(made.code, 0) << made.errors;
  EXPECT_TRUE(std::filesystem::exists(folder_ / "new" / "report2.json"));
}

TEST_F(CommandLineTest, ARegistrationWithoutItsInputsRemovesNothing) {
  std::filesystem::create_directories(folder_ / "out");
  const std::string arguments =
      "register " + write_sweep() + " --ct missing.mha --out " + (folder_ / "out").string();
  const std::string earlier = R"({"verb": "register", "version": "1"})";
  std::ofstream(folder_ / "out/report.json") << earlier;
  std::ofstream(folder_ / "out/mine.png") << "mine";
  expect_rejection(arguments, 3, {"missing.mha"});
  EXPECT_EQ(text_of(folder_ / "out/report.json"), earlier);
  EXPECT_EQ(text_of(folder_ / "out/mine.png"), "mine");
  std::ofstream(folder_ / "out/registration.png") << "mine";
  expect_rejection(arguments, 3, {"registration.png", "Sonde did not write"});
  EXPECT_EQ(text_of(folder_ / "out/registration.png"), "mine");
}

TEST_F(CommandLineTest, ASecondRunIntoAFolderIsRejected) {
  const std::string sweep = write_sweep();
  ASSERT_EQ(sonde(replay_arguments(sweep)).code, 0);
  const std::string report = text_of(folder_ / "out/report.json");
  const auto first = OutputFolder::create(folder_ / "out");
  ASSERT_TRUE(test::has_value(first));
  expect_rejection(replay_arguments(sweep), 3, {"no other run", std::to_string(::getpid())});
  EXPECT_EQ(text_of(folder_ / "out/report.json"), report);
}

TEST_F(CommandLineTest, NoOutputReplacesAnInputOrAnother) {
  const std::string volume = write_ultrasound(folder_ / "us.mha");
  const std::string draw =
      "predicates --width 200 --height 200 --predicates layers --layers l " + volume + " --out ";
  const std::string before = *io::read_file(volume, 1 << 20);
  expect_rejection(draw + volume, 2, {"--out: expected a name that ends in .png"});
  const auto link = folder_ / "link.png";
  std::filesystem::create_symlink(volume, link);
  expect_rejection(draw + link.string(), 2,
                   {"--out: expected a file of its own", "that of volume"});
  const std::string both = (folder_ / "both.png").string();
  expect_rejection(draw + both + " --save " + both, 2,
                   {"--save: expected a file of its own", "that of --out"});
  expect_rejection(draw + (folder_ / "x.jpg").string(), 2, {"--out", ".png", "x.jpg"});
  EXPECT_EQ(*io::read_file(volume, 1 << 20), before);
  const std::string sweep = write_sweep();
  expect_rejection("replay " + sweep + " --ct " + write_ct() + " --out x --json " + sweep, 2,
                   {"--json: expected a file of its own", "that of sweep"});
  expect_rejection("register " + sweep + " --json " + sweep, 2, {"--json", "that of sweep"});
  expect_rejection("simulate --out a.mha --ct a.mha", 2, {"--ct", "that of --out"});
  expect_rejection("info " + sweep + " --json " + sweep, 2, {"--json", "that of file"});
}

/// Covers files that are read late, or only for an appearance or predicates.
TEST_F(CommandLineTest, NoOutputReplacesAnInputOfAnAppearanceOrSession) {
  const auto write = [&](const char* name) {
    std::ofstream(folder_ / name) << "mine";
    return (folder_ / name).string();
  };
  const std::string appearance = write("bone.vp");
  const std::string mesh = write("lesion.stl");
  const std::string other = write("of-predicates.json");
  const std::string replay = "replay s.mha --ct ct.mha --out o ";
  const std::string ultrasound = replay + "--us-volume us.mha ";
  for (const std::string& verb : {replay, std::string("demo --out o ")}) {
    expect_rejection(verb + "--appearance " + appearance + " --json " + appearance, 2,
                     {"--json: expected a file of its own", appearance, "that of --appearance"});
    expect_rejection(
        verb + "--appearance " + appearance + " --save-appearance " + appearance, 2,
        {"--save-appearance: expected a file of its own", appearance, "that of --appearance"});
    expect_rejection(verb + "--cutaway-mesh " + mesh + " --json " + mesh, 2,
                     {"--json: expected a file of its own", mesh, "that of --cutaway-mesh"});
    expect_rejection(verb + "--save-appearance x.json --json x.json", 2,
                     {"--save-appearance: expected a file of its own", "that of --json"});
    expect_rejection(verb + "--save-appearance o/report.json", 2,
                     {"--save-appearance", "that of --out"});
    expect_rejection(verb + "--appearance o/report.json", 2, {"--out", "that of --appearance"});
  }
  expect_rejection(ultrasound + "--predicates layers --labels " + other + " --json " + other, 2,
                   {"--json", other, "that of --labels"});
  expect_rejection(ultrasound + "--predicates layers --layers " + other + " --json " + other, 2,
                   {"--json", other, "that of --layers"});
  expect_rejection(ultrasound + "--predicates " + other + " --json " + other, 2,
                   {"--json", other, "that of --predicates"});
  const std::string session = (folder_ / "s.toml").string();
  std::ofstream(session) << "[predicates]\nvolume = \"us.mha\"\nscan_lines = \"" << other << "\"\n";
  expect_rejection(replay + "--session " + session + " --json " + other, 2,
                   {"--json", other, "that of --scan-lines"});
  std::ofstream(session) << "[source]\nkind = \"simulated\"\n[output]\nfolder = \"o\"\n";
  expect_rejection(
      "replay --session " + session + " --appearance " + appearance + " --json " + appearance, 2,
      {"--json", "that of --appearance"});
  expect_rejection("register --landmarks o/report.json --out o", 2,
                   {"--out", "that of --landmarks"});
  for (const std::string& file : {appearance, mesh, other})
    EXPECT_EQ(text_of(file), "mine") << file;
}

TEST_F(CommandLineTest, AReportReplacesNoOtherOutputOfItsRun) {
  const std::string sweep = write_sweep();
  const std::string ct = write_ct();
  const std::string out = (folder_ / "o").string();
  std::filesystem::create_directory(out);
  for (const char* name : {"pose_log.csv", "report.html", "session.toml", "replay.webp"}) {
    expect_rejection(
        "replay " + sweep + " --ct " + ct + " --out " + out + " --json " + out + "/" + name, 2,
        {"--json: expected a file of its own", name, "that of --out"});
  }
  expect_rejection(
      "replay " + sweep + " --ct " + ct + " --out " + out + " --json " + out + "/replay_00001.png",
      2, {"--json: expected a file of its own", "the name of an image"});
  expect_rejection(
      "register " + sweep + " --ct " + ct + " --out " + out + " --json " + out + "/report.html", 2,
      {"--json: expected a file of its own", "that of --out"});
  const std::string volume = (folder_ / "v.mha").string();
  expect_rejection("reconstruct " + sweep + " --out " + volume + " --json " + volume, 2,
                   {"--json: expected a file of its own", "that of --out"});
  expect_rejection("reconstruct " + sweep + " --out " + volume + " --json " + sweep, 2,
                   {"--json: expected a file of its own", "that of sweep"});
  EXPECT_TRUE(std::filesystem::is_empty(out));
}

TEST_F(CommandLineTest, FilesBesideAnOutputReplaceNoneOfTheUser) {
  const std::string truth = (folder_ / "s.truth.json").string();
  std::ofstream(truth) << "{\"notes\": 1}";
  const std::string simulate = "simulate --duration-s 0.5 --out " + (folder_ / "s.mha").string();
  expect_rejection(simulate, 3, {"truth beside --out", truth, "which Sonde did not write"});
  EXPECT_EQ(text_of(truth), "{\"notes\": 1}");
  std::filesystem::remove(truth);
  EXPECT_EQ(sonde(simulate).code, 0);
  EXPECT_EQ(sonde(simulate).code, 0) << "its own truth is replaced";

  const std::string sweep = write_sweep({}, {}, 30);
  const std::string reconstruct = "reconstruct " + sweep + " --config " +
                                  write_config("0.5 0 0 0 0 0.5 0 0 0 0 0.5 0 0 0 0 1") +
                                  " --method backward --fill 3 --out " +
                                  (folder_ / "v.mha").string();
  for (const char* name : {"v.origin.mha", "v.scan-lines.mha"}) {
    const std::string mine = (folder_ / name).string();
    std::ofstream(mine) << "ObjectType = Image\nNDims = 3\n";
    expect_rejection(reconstruct, 3, {"beside --out", mine, "which Sonde did not write"});
    EXPECT_EQ(text_of(mine), "ObjectType = Image\nNDims = 3\n");
    std::filesystem::remove(mine);
  }
  const Outcome first = sonde(reconstruct);
  EXPECT_EQ(first.code, 0) << first.errors;
  const Outcome second = sonde(reconstruct);
  EXPECT_EQ(second.code, 0) << "its own files are replaced: " << second.errors;
}

TEST_F(CommandLineTest, NoOutputReplacesAnImageInAFolder) {
  std::filesystem::create_directories(folder_ / "ct/deeper");
  const std::string slice = (folder_ / "ct/deeper/1.dcm").string();
  const std::string dicom = std::string(128, '\0') + "DICM";
  std::ofstream(slice, std::ios::binary) << dicom;
  const std::string ct = (folder_ / "ct").string();
  for (const std::string& verb :
       {"info " + ct, "register --landmarks l.csv --ct " + ct, "replay s.mha --out o --ct " + ct}) {
    expect_rejection(verb + " --json " + slice, 2,
                     {"--json: expected a file of its own", slice, "an image of that of"});
  }
  EXPECT_EQ(*io::read_file(slice, 1000), dicom);
  // read_ct accepts DICOM without the preamble; a file that only begins like it is not DICOM.
  const std::string old = (folder_ / "ct/old.dcm").string();
  std::ofstream(old, std::ios::binary) << std::string("\x08\0\x60\0CS\x02\0CT", 10);
  expect_rejection("info " + ct + " --json " + old, 2, {old, "an image of that of file"});
  const std::string alike = (folder_ / "ct/alike.json").string();
  std::ofstream(alike, std::ios::binary) << std::string("\x08\0\x60\0nothing of DICOM", 20);
  expect_rejection("info " + ct + " --json " + alike, 3, {"expected DICOM images, found none"});
  // Behind a link of the folder.
  const std::string linked = (folder_ / "elsewhere.dcm").string();
  std::ofstream(linked, std::ios::binary) << dicom;
  std::filesystem::create_symlink("../elsewhere.dcm", folder_ / "ct/link.dcm");
  expect_rejection("info " + ct + " --json " + linked, 2, {linked, "an image of that of file"});
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
    expect_rejection(
        arguments + path, 2,
        {"expected a file of its own", path, "the pixels of " + header, "that of " + option});
    EXPECT_EQ(*io::read_file(path, 100), pixels);
  };
  expect("info " + mhd + " --json ", mhd, "ct.raw", "file");
  expect("info " + nhdr + " --json ", nhdr, "2.raw", "file");
  expect("replay " + mhd + " --out o --ct " + nhdr + " --save-appearance ", nhdr, "1.raw", "--ct");
  expect("replay " + mhd + " --out o --ct " + nhdr + " --json ", mhd, "ct.raw", "sweep");
  EXPECT_EQ(sonde("info " + mhd + " --accept-unknown-orientation --json " +
                  (folder_ / "other.raw").string())
                .code,
            0);
}

TEST_F(CommandLineTest, AnUnwritableOutputLeavesNoFile) {
  const std::string sweep = write_sweep();
  const auto file = folder_ / "file";
  std::ofstream(file) << "x";
  expect_rejection("replay " + sweep + " --ct " + write_ct() + " --config " + write_config() +
                       " --out " + file.string(),
                   3, {"file", "folder"});
  expect_rejection("info " + sweep + " --json /dev/full", 3, {"/dev/full"});
  expect_rejection("info " + sweep + " --json /nonexistent/x.json", 3, {"/nonexistent"});
}

TEST_F(CommandLineTest, UnfinishedFilesOfKilledRunsAreRemovedBesideEveryOutput) {
  const std::string sweep = write_sweep();
  const auto leave_one = [&](const std::string& folder) {
    std::filesystem::create_directories(folder_ / folder);
    const pid_t child = ::fork();
    if (child == 0) {
      const auto killed = io::AtomicFile::create(folder_ / folder / "killed.txt");
      ::_exit(killed ? 0 : 1);
    }
    int status = 0;
    EXPECT_EQ(::waitpid(child, &status, 0), child);
    return folder_ / folder;
  };
  const auto unfinished = [](const std::filesystem::path& folder) {
    return std::ranges::count_if(std::filesystem::directory_iterator(folder), [](const auto& file) {
      return file.path().extension() == ".partial";
    });
  };
  const auto a = leave_one("a");
  ASSERT_EQ(unfinished(a), 1);
  EXPECT_EQ(sonde("info " + sweep + " --json " + (a / "i.json").string()).code, 0);
  EXPECT_EQ(unfinished(a), 0);
  const auto b = leave_one("b");
  const Outcome simulated = sonde("simulate --patient-ct none.mha --out " + (b / "s.mha").string());
  EXPECT_EQ(simulated.code, 3) << simulated.errors;
  EXPECT_EQ(unfinished(b), 0);
}

TEST_F(CommandLineTest, NoColourOutsideATerminal) {
  const Outcome outcome = sonde(replay_arguments(write_sweep()));
  EXPECT_EQ(outcome.errors.find('\033'), std::string::npos);
  EXPECT_EQ(outcome.errors.find('\r'), std::string::npos);
}

TEST_F(CommandLineTest, UnwritableStandardOutputIsAnError) {
  const std::string sweep = write_sweep();
  for (const std::string& arguments : {"info " + sweep + " >/dev/full", "info " + sweep + " >&-",
                                       replay_arguments(sweep) + " --print-session >/dev/full"}) {
    expect_rejection(built_sonde(arguments), arguments, 3, {"standard output"});
  }
}

TEST_F(CommandLineTest, AFailedReplayLeavesNoReportOfAnEarlierOne) {
  const std::string sweep = write_sweep();
  ASSERT_EQ(sonde(replay_arguments(sweep)).code, 0);
  // A folder with the name of an image stops the run in the middle.
  std::filesystem::remove(folder_ / "out/replay_00002.png");
  std::filesystem::create_directory(folder_ / "out/replay_00002.png");
  expect_rejection(replay_arguments(sweep), 3, {"replay_00002.png"});
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out/report.json"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out/report.html"));
  // A run whose inputs cannot be read leaves all results of the earlier one.
  std::filesystem::remove(folder_ / "out/replay_00002.png");
  ASSERT_EQ(sonde(replay_arguments(sweep)).code, 0);
  expect_rejection(replay_arguments(sweep) + " --registration no.json", 3, {"no.json"});
  expect_rejection(replay_arguments("no.igs.mha"), 3, {"no.igs.mha"});
  for (const char* name : {"report.json", "report.html", "replay_00001.png", "pose_log.csv"}) {
    EXPECT_TRUE(std::filesystem::exists(folder_ / "out" / name)) << name;
  }
}

TEST_F(CommandLineTest, AReplayRemovesFilesOfAnEarlierReplay) {
  const std::string sweep = write_sweep();
  ASSERT_EQ(sonde(replay_arguments(sweep)).code, 0);
  const auto there = [&](const char* name) {
    return std::filesystem::exists(folder_ / "out" / name);
  };
  const std::array earlier = {"replay_00004.png", "replay_123456.png", "replay.webp",
                              "pose_log.csv", "following.csv"};
  const std::array others = {"replay_notes.png", "replay_12.png", "replay_00004.png.txt",
                             "my_replay_00004.png", "session.toml"};
  for (const char* name : {"replay_00004.png", "replay_123456.png"}) {
    std::filesystem::copy_file(folder_ / "out/replay_00000.png", folder_ / "out" / name,
                               std::filesystem::copy_options::skip_existing);
  }
  std::ofstream(folder_ / "out/following.csv") << "sequence,acquired_ns,state,cost,\n";
  for (const char* name : others) std::ofstream(folder_ / "out" / name, std::ios::app);
  std::filesystem::create_symlink("replay_notes.png", folder_ / "out/replay_00009.png");
  // A run that stops before it draws removes nothing.
  expect_rejection(replay_arguments(sweep) + " --registration no.json", 3, {"no.json"});
  for (const char* name : earlier) EXPECT_TRUE(there(name)) << name;
  // A folder with the name of an image stops the run in the middle.
  std::filesystem::remove(folder_ / "out/replay_00002.png");
  std::filesystem::create_directory(folder_ / "out/replay_00002.png");
  expect_rejection(replay_arguments(sweep), 3, {"replay_00002.png"});
  for (const char* name : earlier) EXPECT_FALSE(there(name)) << name;
  for (const char* name : others) EXPECT_TRUE(there(name)) << name;
  EXPECT_TRUE(there("replay_00001.png"));
  EXPECT_TRUE(std::filesystem::is_symlink(folder_ / "out/replay_00009.png"));
}

TEST_F(CommandLineTest, AReplayReplacesNoInput) {
  const std::string sweep = write_sweep();
  std::filesystem::create_directory(folder_ / "out");
  const std::string report = (folder_ / "out/report.json").string();
  std::ofstream(report) << "of sonde register";
  expect_rejection(replay_arguments(sweep) + " --registration " + report, 2,
                   {"--out: expected a file of its own", report, "that of --registration"});
  EXPECT_EQ(*io::read_file(report, 100), "of sonde register");
}

}  // namespace
}  // namespace nav::app
