// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <iterator>
#include <sstream>
#include <string>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>
#include <wordexp.h>

#include "app/options/command_line.hpp"
#include "app/report.hpp"
#include "io/atomic_file.hpp"
#include "io/ct.hpp"
#include "io/sequence_writer.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::app {

struct Outcome {
  int code;
  std::string output;  ///< Standard output.
  std::string errors;  ///< Standard error.
};

inline std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline int exit_code_of(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : -1; }

inline std::ptrdiff_t threads_here() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/task"), {});
}

/// Redirects standard output and errors of this process to files, and closes its standard input.
inline bool redirect(const std::filesystem::path& output, const std::filesystem::path& errors) {
  return std::freopen("/dev/null", "r", stdin) && std::freopen(output.c_str(), "w", stdout) &&
         std::freopen(errors.c_str(), "w", stderr);
}

class CommandLineTest : public ::testing::Test {
 protected:
  /// Runs the program in a copy of this process, because loading its hundred libraries takes longer
  /// than most tests. arguments: as for a shell.
  Outcome sonde(const std::string& arguments) {
    wordexp_t words{};
    EXPECT_EQ(::wordexp((program_ + " " + arguments).c_str(), &words, WRDE_NOCMD | WRDE_UNDEF), 0)
        << arguments;
    // A copy does not have the other threads, but would wait for their locks.
    EXPECT_EQ(threads_here(), 1);
    const auto output = folder_ / "stdout.txt";
    const auto errors = folder_ / "stderr.txt";
    std::fflush(nullptr);
    const pid_t child = ::fork();
    if (child == 0) {
      if (!redirect(output, errors)) std::_Exit(127);
      const int code = run_(static_cast<int>(words.we_wordc), words.we_wordv);
      std::fflush(nullptr);
      std::_Exit(code);  // std::exit() would report the test's own memory as leaks.
    }
    ::wordfree(&words);
    int status = 0;
    EXPECT_EQ(::waitpid(child, &status, 0), child);
    return {exit_code_of(status), text_of(output), text_of(errors)};
  }
  /// Runs the built program in a shell.
  Outcome built_sonde(const std::string& arguments) {
    const auto output = folder_ / "stdout.txt";
    const auto errors = folder_ / "stderr.txt";
    const std::string command = std::string(SONDE_PROGRAM) + " </dev/null >" + output.string() +
                                " 2>" + errors.string() + " " + arguments;
    const int status = std::system(command.c_str());
    return {exit_code_of(status), text_of(output), text_of(errors)};
  }
  /// Expects the program to stop with a code and one line of error that contains every piece.
  void expect_rejection(const std::string& arguments, int code,
                        std::initializer_list<std::string> pieces) {
    expect_rejection(sonde(arguments), arguments, code, pieces);
  }
  void expect_rejection(const Outcome& outcome, const std::string& arguments, int code,
                        std::initializer_list<std::string> pieces) const {
    EXPECT_EQ(outcome.code, code) << arguments << "\n" << outcome.errors;
    std::istringstream lines(outcome.errors);
    int errors = 0;
    std::string error;
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with(program_ + ": error: ")) {
        ++errors;
        error = line;
      }
      EXPECT_FALSE(line.starts_with(program_ + ": bug: ")) << line;
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

  /// Writes a small tracked sweep; the change functions may add errors.
  std::string write_sweep(const std::function<void(io::SequenceHeader&)>& change_header = {},
                          const std::function<void(io::SequenceImage&)>& change_frame = {},
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
      io::SequenceImage frame;
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
  io::Json read_json(const std::string& name) {
    std::ifstream file(folder_ / name);
    return io::Json::parse(file, nullptr, false);
  }
  test::TemporaryFolder folder_;
  std::string program_ = "sonde";  ///< Its name in messages.
  int (*run_)(int argc, const char* const* argv) = &run_command_line;
};

/// Writes a small ultrasound volume of 20 x 24 x 18 voxels of 1 mm.
inline std::string write_ultrasound(const std::filesystem::path& file) {
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

}  // namespace nav::app
