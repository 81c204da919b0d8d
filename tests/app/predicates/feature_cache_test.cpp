// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/predicates/feature_cache.hpp"

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <gtest/gtest.h>
#include <optional>
#include <set>
#include <spawn.h>
#include <string_view>
#include <sys/stat.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include "app/predicates/feature_maker.hpp"
#include "io/atomic_file.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::app {
namespace {

using render::features::ConfidenceOptions;
using render::features::DerivedOptions;
using render::features::DerivedRequest;
using render::features::DerivedVolume;
using render::features::ScalarVolume;
using render::features::ScanLines;
using render::features::SnrOptions;

ScalarVolume block(int side, std::int16_t first = 0) {
  VoxelGrid grid;
  grid.size = {side, side, side};
  std::vector<std::int16_t> voxels(grid.voxel_count());
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    voxels[i] = static_cast<std::int16_t>(i * 7919 % 200);
  }
  voxels[0] = first;
  return ScalarVolume::of(std::make_shared<const StoredVolume>(
      *StoredVolume::create(grid, std::move(voxels), "block")));
}

/// Environment variable that makes this program write into the cache of that folder.
constexpr const char* kWriteInto = "SONDE_TEST_WRITE_INTO";

ScanLines along(const Eigen::Vector3d& away) { return *ScanLines::parallel({away}, {{0, 0, 0}}); }

DerivedRequest request(const DerivedOptions& options = SnrOptions{}) {
  return {block(12), options, along({0, 1, 0})};
}

class FeatureCacheTest : public ::testing::Test {
 protected:
  bool hits(const DerivedRequest& wanted) { return cache_.find(wanted, *diagnostics_).has_value(); }
  /// Warnings about the file since the last call.
  std::string warnings() {
    std::string all;
    for (const auto& entry : diagnostics_->entries()) all += entry.message;
    diagnostics_.emplace();
    return all;
  }
  test::TemporaryFolder folder_;
  FeatureCache cache_{folder_ / "features"};
  std::optional<CollectingDiagnostics> diagnostics_{std::in_place};
};

TEST_F(FeatureCacheTest, ReturnsTheSameBytesAndTheNote) {
  EXPECT_FALSE(hits(request()));
  DerivedVolume made = *compute(request(), {});
  made.note = "7 iterations";
  cache_.keep(request(), made, *diagnostics_);
  const auto found = cache_.find(request(), *diagnostics_);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->note, "7 iterations");
  EXPECT_EQ(std::memcmp(found->volume.values->data(), made.volume.values->data(),
                        made.volume.values->size() * sizeof(float)),
            0);
  EXPECT_EQ(warnings(), "");
}

TEST_F(FeatureCacheTest, EveryInputOfAFeatureChangesItsKey) {
  const DerivedRequest kept = request(ConfidenceOptions{});
  cache_.keep(kept, *compute(kept, {}), *diagnostics_);
  ASSERT_TRUE(hits(kept));
  DerivedRequest other = kept;
  other.volume = block(12, 1);
  EXPECT_FALSE(hits(other)) << "a voxel";
  other = kept;
  ConfidenceOptions options;
  options.gamma = 0.06;
  other.options = options;
  EXPECT_FALSE(hits(other)) << "a parameter";
  other = kept;
  other.lines = along({0, 1, 1e-6});
  EXPECT_FALSE(hits(other)) << "the scan lines";
  other = kept;
  other.volume = block(11);
  EXPECT_FALSE(hits(other)) << "the grid";
  EXPECT_FALSE(hits(request(SnrOptions{}))) << "the feature";
  EXPECT_EQ(warnings(), "");
}

TEST_F(FeatureCacheTest, DamagedFilesAreReportedAndNeverUsed) {
  cache_.keep(request(), *compute(request(), {}), *diagnostics_);
  const auto path = cache_.path_of(request());
  const std::string whole = *io::read_file(path, 1 << 20);
  SnrOptions wider;
  wider.window_voxels = 9;
  for (const auto& [content, piece] :
       {std::pair<std::string, std::string>{whole.substr(0, whole.size() / 2), "bytes"},
        {"", "derived volume of this program"},
        {"PNG or whatever", "derived volume of this program"},
        {"sonde_feature 2" + whole.substr(15), "version 1"},
        {whole.substr(0, 20) + "zz" + whole.substr(22), "the key"},
        {whole + "x", "bytes"},
        {whole.substr(0, 900) + static_cast<char>(whole[900] ^ 1) + whole.substr(901), "digest"},
        {std::string(1 << 20, 'x'), "snr"}}) {
    std::ofstream(path, std::ios::binary) << content;
    EXPECT_FALSE(hits(request())) << piece;
    const std::string said = warnings();
    EXPECT_NE(said.find(path.string()), std::string::npos) << said;
    if (piece != "snr") {
      EXPECT_NE(said.find(piece), std::string::npos) << said;
    }
    EXPECT_NE(said.find("computed again"), std::string::npos) << said;
  }
  // A file under the name of another feature is not that feature.
  std::ofstream(cache_.path_of(request(wider)), std::ios::binary) << whole;
  EXPECT_FALSE(hits(request(wider)));
}

/// Starts this test program again with a single test. Not a fork alone: a fork while other threads
/// run would copy locks that they hold, such as the allocator's.
pid_t start_writer(const std::string& test, const std::filesystem::path& folder) {
  const std::string filter = "--gtest_filter=" + test;
  const std::string cache = std::string(kWriteInto) + "=" + folder.string();
  std::vector<char*> environment{const_cast<char*>(cache.c_str())};  // NOLINT
  for (char** variable = environ; *variable != nullptr; ++variable) {
    const bool of_this_run = std::string_view(*variable).starts_with(
        "GTEST_");  // Settings of this run, such as its shard.
    if (!of_this_run) environment.push_back(*variable);
  }
  environment.push_back(nullptr);
  const std::array<char*, 3> words{const_cast<char*>("app_test"),      // NOLINT
                                   const_cast<char*>(filter.c_str()),  // NOLINT
                                   nullptr};
  pid_t writer = -1;
  const int failed =
      ::posix_spawn(&writer, "/proc/self/exe", nullptr, nullptr, words.data(), environment.data());
  EXPECT_EQ(failed, 0) << std::strerror(failed);
  return failed == 0 ? writer : -1;
}

TEST_F(FeatureCacheTest, ProcessesMayWriteAtTheSameTime) {
  const DerivedVolume made = *compute(request(), {});
  if (const char* folder = std::getenv(kWriteInto)) {
    const FeatureCache shared{folder};
    for (int i = 0; i < 100; ++i) shared.keep(request(), made, *diagnostics_);
    EXPECT_EQ(warnings(), "");
    return;
  }
  std::set<pid_t> writers;
  for (int n = 0; n < 2; ++n) {
    const pid_t writer =
        start_writer("FeatureCacheTest.ProcessesMayWriteAtTheSameTime", folder_ / "features");
    ASSERT_GT(writer, 0);
    writers.insert(writer);
  }
  // A reader finds no file or a complete one at any time.
  int found = 0;
  while (!writers.empty()) {
    found += hits(request()) ? 1 : 0;
    int status = -1;
    const pid_t ended = ::waitpid(-1, &status, WNOHANG);
    ASSERT_GE(ended, 0) << std::strerror(errno);
    if (ended == 0) continue;
    EXPECT_EQ(status, 0);
    writers.erase(ended);
  }
  EXPECT_GT(found, 0);
  EXPECT_EQ(warnings(), "");
  EXPECT_TRUE(hits(request()));
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "features")) {
    EXPECT_EQ(entry.path(), cache_.path_of(request()));
    ++files;
  }
  EXPECT_EQ(files, 1);
}

TEST_F(FeatureCacheTest, ReportsAFolderThatCannotBeCreated) {
  std::ofstream(folder_ / "file") << "x";
  const FeatureCache none(folder_ / "file");
  none.keep(request(), *compute(request(), {}), *diagnostics_);
  EXPECT_NE(warnings().find("not cached"), std::string::npos);
}

TEST_F(FeatureCacheTest, DoesNotWaitForAPipeOfThatName) {
  std::filesystem::create_directories(folder_ / "features");
  ASSERT_EQ(::mkfifo(cache_.path_of(request()).c_str(), 0600), 0);
  EXPECT_FALSE(hits(request()));
  cache_.keep(request(), *compute(request(), {}), *diagnostics_);
  EXPECT_NE(warnings().find("special file"), std::string::npos);
  EXPECT_TRUE(std::filesystem::is_fifo(cache_.path_of(request())));
}

class FeatureMakerTest : public FeatureCacheTest {
 protected:
  Console console_{false};
};

TEST_F(FeatureMakerTest, ComputesOnceAndThenReadsTheCache) {
  FeatureMaker first(1, folder_ / "features", console_);
  ASSERT_TRUE(test::has_value(first.make("snr", request())));
  ASSERT_TRUE(hits(request()));
  // A complete file with other values shows that the cache is read.
  DerivedVolume other = *compute(request(), {});
  other.volume.values = std::make_shared<const std::vector<float>>(12 * 12 * 12, 42.0F);
  cache_.keep(request(), other, *diagnostics_);
  FeatureMaker second(1, folder_ / "features", console_);
  EXPECT_EQ(second.make("snr", request())->volume.at(3, 4, 5), 42.0F);
  FeatureMaker without(1, {}, console_);
  EXPECT_NE(without.make("snr", request())->volume.at(3, 4, 5), 42.0F);
}

TEST_F(FeatureMakerTest, CtrlCEndsTheComputationWithOneSentenceAndCachesNothing) {
  const DerivedRequest slow{block(128), ConfidenceOptions{}, along({0, 1, 0})};
  {
    FeatureMaker maker(1, folder_ / "features", console_);
    std::thread user([] {
      std::this_thread::sleep_for(std::chrono::milliseconds(120));
      ::kill(::getpid(), SIGINT);
    });
    const auto made = maker.make("confidence", slow);
    user.join();
    EXPECT_TRUE(test::rejects(made, ErrorCode::kCancelled, {"confidence", "cancelled"}));
    EXPECT_TRUE(test::rejects(maker.make("snr", request()), ErrorCode::kCancelled, {"snr"}));
  }
  EXPECT_FALSE(std::filesystem::exists(folder_ / "features"));
  FeatureMaker next(1, folder_ / "features", console_);
  EXPECT_TRUE(test::has_value(next.make("snr", request()))) << "a new one knows nothing of it";
}

TEST_F(FeatureMakerTest, ARejectedFeatureIsNotCached) {
  FeatureMaker maker(1, folder_ / "features", console_);
  SnrOptions even;
  even.window_voxels = 4;
  EXPECT_FALSE(maker.make("snr", request(even)));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "features"));
}

}  // namespace
}  // namespace nav::app
