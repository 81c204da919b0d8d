// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/output_folder.hpp"

#include <fstream>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "io/atomic_file.hpp"
#include "io/image_output.hpp"
#include "io/own_mark.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::app {
namespace {

using test::rejects;

Image2d<Rgba8> small_image() { return {2, 1, {Rgba8{1, 2, 3, 255}, Rgba8{4, 5, 6, 255}}}; }

void put_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

std::string text_in(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Number of a process that has ended.
pid_t ended_process() {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(0);
  ::waitpid(child, nullptr, 0);
  return child;
}

class OutputFolderTest : public ::testing::Test {
 protected:
  test::TemporaryFolder folder_;
  CollectingDiagnostics diagnostics_;
};

TEST_F(OutputFolderTest, OneRunHoldsAFolder) {
  {
    const auto first = OutputFolder::create(folder_.path());
    ASSERT_TRUE(test::has_value(first));
    EXPECT_TRUE(rejects(
        OutputFolder::create(folder_.path()), ErrorCode::kIo,
        {folder_.path().string(), "no other run", "process " + std::to_string(::getpid())}));
    EXPECT_TRUE(rejects(OutputFolder::open(folder_.path(), {}), ErrorCode::kIo, {"no other run"}));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path())) << "the lock goes with its run";
  EXPECT_TRUE(test::has_value(OutputFolder::create(folder_.path())));
}

TEST_F(OutputFolderTest, TakesOverTheLockOfARunThatWasKilled) {
  put_text(folder_ / ".sonde-lock",
           "process " + std::to_string(ended_process()) + "\nhost elsewhere\n");
  const auto out = OutputFolder::create(folder_.path());
  ASSERT_TRUE(test::has_value(out));
  EXPECT_NE(text_in(folder_ / ".sonde-lock").find(std::to_string(::getpid())), std::string::npos);
}

TEST_F(OutputFolderTest, AFileOfTheUserWithTheNameOfALockStays) {
  const std::string ended = std::to_string(ended_process());
  for (const std::string& text :
       {std::string("my notes\n"), "process " + ended + "\nhost here\nand more\n",
        std::string("process x\nhost here\n"), std::string(2000, 'x')}) {
    put_text(folder_ / ".sonde-lock", text);
    EXPECT_TRUE(rejects(OutputFolder::create(folder_.path()), ErrorCode::kIo,
                        {".sonde-lock", "that it did not write"}));
    EXPECT_EQ(text_in(folder_ / ".sonde-lock"), text);
  }
  put_text(folder_ / ".sonde-lock", "");
  EXPECT_TRUE(test::has_value(OutputFolder::create(folder_.path()))) << "killed before it wrote";
}

TEST_F(OutputFolderTest, RemovesUnfinishedFilesOfEndedProcessesOnly) {
  const pid_t child = ::fork();
  if (child == 0) {
    const auto killed = io::AtomicFile::create(folder_ / "killed.txt");
    ::_exit(killed ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  const std::string dead = std::filesystem::directory_iterator(folder_.path())->path().filename();
  EXPECT_TRUE(dead.starts_with("sonde-" + std::to_string(child) + "-")) << dead;
  const std::vector<std::string> mine{"sonde-" + std::to_string(child) + "-0.partial",
                                      "sonde-" + std::to_string(child) + "-7-00000000.partial",
                                      "sonde-x-0.partial", "mine.partial"};
  for (const std::string& name : mine) put_text(folder_ / name, "half");
  auto own = io::AtomicFile::create(folder_ / "own.txt");
  ASSERT_TRUE(test::has_value(own));
  ASSERT_TRUE(test::has_value(OutputFolder::create(folder_.path())));
  EXPECT_FALSE(std::filesystem::exists(folder_ / dead));
  for (const std::string& name : mine) EXPECT_EQ(text_in(folder_ / name), "half") << name;
  ASSERT_TRUE(test::has_value(own->write("whole")));
  ASSERT_TRUE(test::has_value(own->commit()));
  EXPECT_EQ(text_in(folder_ / "own.txt"), "whole");
}

TEST_F(OutputFolderTest, RemovesAndReplacesOnlyFilesOfSonde) {
  const RunFiles run{{"report.json", "log.csv"}, {"sweep"}};
  auto out = OutputFolder::create(folder_.path());
  ASSERT_TRUE(test::has_value(out));
  ASSERT_TRUE(test::has_value(out->write_image("sweep_001.png", small_image())));
  ASSERT_TRUE(
      test::has_value(out->write_text("report.json", R"({"verb": "replay", "version": "1"})")));
  ASSERT_TRUE(test::has_value(out->forget_earlier_run(run)));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "sweep_001.png"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "report.json"));

  ASSERT_TRUE(test::has_value(out->write_image("sweep_001.png", small_image())));
  for (const std::string name : {"report.json", "sweep_002.png", "log.csv"}) {
    put_text(folder_ / name, "mine");
    EXPECT_TRUE(rejects(out->forget_earlier_run(run), ErrorCode::kIo,
                        {name, "that Sonde did not write", "another folder"}));
    EXPECT_TRUE(rejects(out->write_image(name, small_image()), ErrorCode::kIo, {name}));
    EXPECT_TRUE(rejects(out->write_text(name, "x"), ErrorCode::kIo, {name}));
    EXPECT_EQ(text_in(folder_ / name), "mine");
    EXPECT_TRUE(std::filesystem::exists(folder_ / "sweep_001.png")) << "nothing was removed";
    std::filesystem::remove(folder_ / name);
  }
  put_text(folder_ / "sweep_notes.png", "mine");  // No name of the run.
  ASSERT_TRUE(test::has_value(out->forget_earlier_run(run)));
  EXPECT_EQ(text_in(folder_ / "sweep_notes.png"), "mine");
}

TEST_F(OutputFolderTest, ASessionFileThatWasWrittenByHandStays) {
  auto out = OutputFolder::create(folder_.path());
  ASSERT_TRUE(test::has_value(out));
  ASSERT_TRUE(test::has_value(out->write_session("session.toml", "a = 1\n", diagnostics_)));
  ASSERT_TRUE(test::has_value(out->write_session("session.toml", "a = 2\n", diagnostics_)));
  EXPECT_NE(text_in(folder_ / "session.toml").find("a = 2"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "session.written.toml"));
  EXPECT_TRUE(diagnostics_.entries().empty());

  std::ofstream(folder_ / "session.toml", std::ios::app) << "# a remark\n";
  const std::string changed = text_in(folder_ / "session.toml");
  ASSERT_TRUE(test::has_value(out->write_session("session.toml", "a = 3\n", diagnostics_)));
  EXPECT_EQ(text_in(folder_ / "session.toml"), changed);
  EXPECT_NE(text_in(folder_ / "session.written.toml").find("a = 3"), std::string::npos);
  ASSERT_EQ(diagnostics_.entries().size(), 1U);
  EXPECT_NE(diagnostics_.entries()[0].message.find("session.written.toml"), std::string::npos);
}

TEST_F(OutputFolderTest, EveryKindOfFileHasItsMark) {
  ASSERT_TRUE(test::has_value(io::write_png(small_image(), folder_ / "a.png")));
  ASSERT_TRUE(test::has_value(
      io::write_animation({small_image(), small_image()}, 100, folder_ / "a.webp")));
  for (const char* name : {"a.png", "a.webp"}) {
    EXPECT_TRUE(*io::is_own_file(folder_ / name)) << name;
  }
  const auto read = io::read_png(folder_ / "a.png");
  ASSERT_TRUE(test::has_value(read));
  EXPECT_EQ(read->pixels()[1], (Rgba8{4, 5, 6, 255}));
  for (const char* name : {"b.png", "b.webp", "b.json", "b.html", "b.csv", "b.toml", "b.txt"}) {
    for (const char* text : {"", "mine", "{\"verb\": 1}", "RIFF....WEBP"}) {
      put_text(folder_ / name, text);
      const auto own = io::is_own_file(folder_ / name);
      ASSERT_TRUE(test::has_value(own));
      EXPECT_FALSE(*own) << name << ": " << text;
    }
  }
  EXPECT_TRUE(rejects(io::is_own_file(folder_ / "none.png"), ErrorCode::kNotFound, {"none.png"}));
}

}  // namespace
}  // namespace nav::app
