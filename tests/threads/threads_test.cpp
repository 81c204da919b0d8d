// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <gtest/gtest.h>
#include <memory>
#include <tbb/global_control.h>
#include <thread>
#include <vector>

#include "nav/diagnostics.hpp"
#include "registration/background.hpp"
#include "render/engine.hpp"
#include "render/features/service.hpp"
#include "sim/ultrasound.hpp"
#include "tests/support/matchers.hpp"

namespace nav {
namespace {

constexpr int kThreads = 4;

/// TBB is not instrumented, so the thread sanitizer would report each hand-over to its workers.
/// These tests are about our own threads, so TBB runs only on the calling thread. The tests of each
/// folder check that results do not depend on the number of TBB workers.
const tbb::global_control kNoWorkers(tbb::global_control::max_allowed_parallelism, 1);

TEST(ThreadsTest, DiagnosticsCountEveryReportOfEveryThread) {
  CollectingDiagnostics diagnostics;
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&diagnostics, t] {
      for (int i = 0; i < 1000; ++i) {
        diagnostics.report(Severity::kInfo, "source", "text " + std::to_string(i % 10));
        if (i % 100 == t) (void)diagnostics.entries();
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  std::size_t total = 0;
  for (const DiagnosticEntry& entry : diagnostics.entries()) total += entry.count;
  EXPECT_EQ(total, 1000u * kThreads);
}

render::Scene scene() {
  VoxelGrid grid;
  grid.size = {48, 48, 48};
  grid.spacing_mm = {4, 4, 4};
  grid.origin_mm = {-94, -94, -94};
  std::vector<std::int16_t> hu(grid.voxel_count());
  for (std::size_t i = 0; i < hu.size(); ++i) {
    const Eigen::Vector3d index(static_cast<double>(i % 48), static_cast<double>(i / 48 % 48),
                                static_cast<double>(i / 2304));
    hu[i] = static_cast<std::int16_t>(1200 - 40 * (index.array() - 23.5).matrix().norm());
  }
  const render::Camera camera{{{0, -600, 0}}, {{0, 0, 0}}, {{0, 0, 1}}};
  render::Scene made{
      .ct = std::make_shared<const Volume>(*Volume::create(grid, std::move(hu), "ball")),
      .transfer = *render::preset_transfer_function("ct-bone"),
      .camera = camera};
  made.width = 96;
  made.height = 64;
  return made;
}

TEST(ThreadsTest, EnginesRunInParallelAndGiveEqualImages) {
  const render::Scene shown = scene();
  std::vector<Image2d<Rgba8>> images(kThreads);
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      const auto engine = render::make_cpu_engine({.threads = 1 + t % 3});
      const auto image = engine->render(shown);
      ASSERT_TRUE(image) << image.error().message;
      images[static_cast<std::size_t>(t)] = render::to_8bit(image->pixels);
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const auto& image : images) {
    ASSERT_FALSE(image.empty());
    EXPECT_TRUE(
        std::equal(image.pixels().begin(), image.pixels().end(), images[0].pixels().begin()));
  }
}

TEST(ThreadsTest, ManyThreadsCanUseOneSimulator) {
  const sim::AbdomenPhantom phantom;
  sim::ProbeModel probe = sim::convex_abdominal();
  probe.columns = 60;
  probe.rows = 48;
  probe.lines = 32;
  const sim::UltrasoundSimulator simulator(phantom, probe, 1);
  const Transform<frames::Ct, frames::Image> view(
      Eigen::Quaterniond(Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ())), {-60, -95, 0});
  std::vector<UltrasoundImage> frames(kThreads);
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back(
        [&, t] { frames[static_cast<std::size_t>(t)] = simulator.simulate(view, Timestamp{}, 7); });
  }
  for (std::thread& thread : threads) thread.join();
  for (const auto& frame : frames) {
    ASSERT_FALSE(frame.pixels.empty());
    EXPECT_TRUE(std::equal(frame.pixels.pixels().begin(), frame.pixels.pixels().end(),
                           frames[0].pixels.pixels().begin()));
  }
}

TEST(ThreadsTest, ManyThreadsCanRequestCancelAndReadFeatures) {
  using namespace render::features;
  const auto volume = ScalarVolume::of(scene().ct, std::nullopt);
  const auto request_of = [&](int window) {
    return DerivedRequest{volume, SnrOptions{.window_voxels = window}, {}};
  };
  DerivedVolumes service;
  std::vector<std::vector<float>> found(kThreads);
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      for (int round = 0; round < 6; ++round) {
        auto given_up = service.request(request_of(5));
        auto kept = service.request(request_of(3));
        if (!given_up || !kept) return;
        while (!kept->wait_for(std::chrono::milliseconds(1))) (void)given_up->progress();
        given_up->cancel();
        const auto made = kept->wait();
        if (made) found[static_cast<std::size_t>(t)] = *made->volume.values;
        (void)service.counts();
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  const auto direct = compute(request_of(3), {});
  ASSERT_TRUE(test::has_value(direct));
  for (const auto& values : found) EXPECT_EQ(values, *direct->volume.values);
}

TEST(ThreadsTest, WorkInTheBackgroundCanBeWatchedAndCancelled) {
  using Count = registration::InBackground<int>;
  const auto work = [](const Count::Progress& progress) -> Result<int> {
    for (int i = 0; i < 100000; ++i) {
      if (!progress(1e-5 * i)) return Error{ErrorCode::kCancelled, "count"};
      std::this_thread::yield();
    }
    return 100000;
  };
  Count whole(work);
  Count cancelled(work);
  std::thread watcher([&] {
    while (whole.progress() < 0.5) std::this_thread::yield();
    cancelled.cancel();
  });
  EXPECT_EQ(*whole.wait(), 100000);
  watcher.join();
  const Result<int>& ended = cancelled.wait();
  EXPECT_TRUE(ended.has_value() || ended.error().code == ErrorCode::kCancelled);
}

}  // namespace
}  // namespace nav
