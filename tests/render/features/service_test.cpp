// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/service.hpp"

#include <set>
#include <string>

#include "nav/check.hpp"
#include "tests/render/features/derived_support.hpp"

namespace nav::render::features {
namespace {

ScalarVolume small(unsigned seed) {
  return test::speckled(test::centred_grid({20, 18, 16}, {0.5, 0.5, 0.5}), seed);
}

/// A request that takes long enough to be stopped on any machine.
DerivedRequest slow(unsigned seed) {
  VesselnessOptions options;
  options.smallest_radius_mm = 4;
  options.largest_radius_mm = 8;
  options.scales = 16;
  options.truncate = 8;
  return {test::speckled(test::centred_grid({64, 64, 64}, {0.5, 0.5, 0.5}), seed), options, {}};
}

TEST(DerivedVolumesTest, ComputesEveryFeatureLikeTheDirectCall) {
  DerivedVolumes service;
  const auto volume = small(1);
  const auto lines = ScanLines::fan({{0, -20, 0}}, 10);
  ASSERT_TRUE(test::has_value(lines));
  for (const DerivedOptions& options :
       {DerivedOptions(SnrOptions{}), DerivedOptions(VesselnessOptions{}),
        DerivedOptions(ConfidenceOptions{}), DerivedOptions(GradientPartOptions{}),
        DerivedOptions(GradientPartOptions{GradientPart::kAngle}),
        DerivedOptions(GradientPartOptions{GradientPart::kAlong}),
        DerivedOptions(GradientPartOptions{GradientPart::kAcross}),
        DerivedOptions(ScanDepthOptions{})}) {
    const DerivedRequest request{volume, options, *lines};
    auto ticket = service.request(request);
    ASSERT_TRUE(test::has_value(ticket));
    const auto found = ticket->wait();
    ASSERT_TRUE(test::has_value(found));
    EXPECT_EQ(ticket->progress(), 1);
    const auto direct = compute(request, {});
    ASSERT_TRUE(test::has_value(direct));
    EXPECT_TRUE(test::same_bytes(*found->volume.values, *direct->volume.values));
  }
  EXPECT_EQ(service.counts().computed, 8U);
}

TEST(DerivedVolumesTest, FindsEqualContentAgainAndComputesAnythingElse) {
  DerivedVolumes service;
  const auto ask = [&](const DerivedRequest& request) {
    auto ticket = service.request(request);
    EXPECT_TRUE(test::has_value(ticket));
    return ticket->wait()->volume.values;
  };
  const auto first = ask({small(1), SnrOptions{}, {}});
  EXPECT_EQ(ask({small(1), SnrOptions{}, {}}), first);  // Another volume object with equal content.
  EXPECT_EQ(service.counts().computed, 1U);
  EXPECT_EQ(service.counts().found, 1U);
  EXPECT_NE(ask({small(2), SnrOptions{}, {}}), first);
  EXPECT_NE(ask({small(1), SnrOptions{5, WindowWeights::kUniform}, {}}), first);
  EXPECT_NE(ask({small(1), SnrOptions{7, WindowWeights::kGaussian}, {}}), first);
  EXPECT_EQ(service.counts().computed, 4U);
  const auto up = *ScanLines::parallel({{0, -1, 0}}, {{0, 0, 0}});
  const auto down = *ScanLines::parallel({{0, 1, 0}}, {{0, 0, 0}});
  EXPECT_NE(ask({small(1), ScanDepthOptions{}, up}), ask({small(1), ScanDepthOptions{}, down}));
  EXPECT_EQ(ask({small(1), SnrOptions{}, up}), first);  // The result does not depend on scan lines.
}

TEST(DerivedVolumesTest, ScanLinesThatDifferHaveDifferentDigests) {
  const auto grid = test::centred_grid({2, 2, 2}, {1, 1, 1});
  const std::vector<PackedDirection> away(8, PackedDirection::pack({0, 1, 0}));
  std::vector<PackedDirection> other_away = away;
  other_away[5] = PackedDirection::pack({1, 0, 0});
  const std::vector<float> depth(8, 2.0F);
  std::vector<float> other_depth = depth;
  other_depth[7] = 2.5F;
  VoxelGrid other_grid = grid;
  other_grid.origin_mm.x() += 1;
  const std::vector<ScanLines> lines{*ScanLines::parallel({{0, 1, 0}}, {{0, 0, 0}}),
                                     *ScanLines::parallel({{0, -1, 0}}, {{0, 0, 0}}),
                                     *ScanLines::parallel({{0, 1, 0}}, {{0, 3, 0}}),
                                     *ScanLines::fan({{0, 0, 0}}, 0),
                                     *ScanLines::fan({{0, -9, 0}}, 0),
                                     *ScanLines::fan({{0, 0, 0}}, 4),
                                     *ScanLines::per_voxel(grid, away, depth),
                                     *ScanLines::per_voxel(grid, other_away, depth),
                                     *ScanLines::per_voxel(grid, away, other_depth),
                                     *ScanLines::per_voxel(other_grid, away, depth)};
  std::set<std::string> digests;
  for (const ScanLines& one : lines) digests.insert(one.digest());
  EXPECT_EQ(digests.size(), lines.size());
  EXPECT_EQ(lines[2].digest(), ScanLines::parallel({{0, 1, 0}}, {{0, 3, 0}})->digest());
}

TEST(DerivedVolumesTest, RemovesTheLeastRecentlyUsedResult) {
  DerivedLimits limits;
  limits.cache_bytes = 2 * 20 * 18 * 16 * sizeof(float);
  DerivedVolumes service(limits);
  const auto ask = [&](unsigned seed) {
    auto ticket = service.request({small(seed), SnrOptions{}, {}});
    EXPECT_TRUE(ticket->wait());
  };
  ask(1);
  ask(2);
  ask(1);
  ask(3);  // The result of seed 2 is removed.
  ask(1);
  EXPECT_EQ(service.counts().computed, 3U);
  EXPECT_LE(service.counts().cached_bytes, limits.cache_bytes);
  ask(2);
  EXPECT_EQ(service.counts().computed, 4U);
}

TEST(DerivedVolumesTest, KeepsResultsButNotTheirInputs) {
  DerivedVolumes service;
  const auto grid = test::centred_grid({8, 8, 8}, {0.5, 0.5, 0.5});
  auto voxels = std::make_shared<const StoredVolume>(
      *StoredVolume::create(grid, std::vector<std::int16_t>(grid.voxel_count(), 7), "volume"));
  const std::weak_ptr<const StoredVolume> watched = voxels;
  {
    auto ticket = service.request({ScalarVolume::of(std::move(voxels)), SnrOptions{}, {}});
    ASSERT_TRUE(test::has_value(ticket));
    EXPECT_TRUE(test::has_value(ticket->wait()));
  }
  EXPECT_EQ(service.counts().cached_bytes, grid.voxel_count() * sizeof(float));
  EXPECT_TRUE(watched.expired());
}

TEST(DerivedVolumesTest, StopsWhenEveryRequestIsCancelled) {
  DerivedVolumes service;
  auto running = service.request(slow(1));
  auto waiting = service.request({small(1), SnrOptions{}, {}});
  ASSERT_TRUE(test::has_value(running));
  ASSERT_TRUE(test::has_value(waiting));
  running->cancel();
  EXPECT_EQ(running->wait().error().code, ErrorCode::kCancelled);
  EXPECT_TRUE(waiting->wait());  // The next request is computed.
}

TEST(DerivedVolumesTest, ContinuesWhileAnotherRequestIsActive) {
  DerivedVolumes service;
  const DerivedRequest request{test::speckled(test::centred_grid({48, 48, 48}, {0.5, 0.5, 0.5}), 3),
                               VesselnessOptions{},
                               {}};
  auto one = service.request(request);
  auto other = service.request(request);
  one->cancel();
  EXPECT_TRUE(other->wait());
  EXPECT_EQ(service.counts().computed, 1U);
}

TEST(DerivedVolumesTest, TheDestructorCancelsTheRemainingWork) {
  std::optional<DerivedVolumes::Ticket> left;
  {
    DerivedVolumes service;
    auto ticket = service.request(slow(2));
    auto other = service.request(slow(3));
    left.emplace(std::move(*ticket));
  }
  EXPECT_EQ(left->wait().error().code, ErrorCode::kCancelled);
}

TEST(DerivedVolumesTest, ExceptionsOfAComputationReachTheCaller) {
  DerivedVolumes service({}, [](const DerivedRequest& request, const RunOptions& run) {
    if (std::holds_alternative<ScanDepthOptions>(request.options)) throw Bug("a broken check");
    return compute(request, run);
  });
  const auto lines = ScanLines::fan({{0, -20, 0}}, 10);
  ASSERT_TRUE(test::has_value(lines));
  auto ticket = service.request({small(1), ScanDepthOptions{}, *lines});
  ASSERT_TRUE(test::has_value(ticket));
  EXPECT_THROW(static_cast<void>(ticket->wait()), Bug);
  EXPECT_THROW(static_cast<void>(ticket->poll()), Bug);
  EXPECT_EQ(ticket->progress(), 1);
  EXPECT_EQ(service.counts().cached_bytes, 0U);
  // The next request is computed.
  auto next = service.request({small(1), SnrOptions{}, {}});
  ASSERT_TRUE(test::has_value(next));
  EXPECT_TRUE(test::has_value(next->wait()));
}

TEST(DerivedVolumesTest, RejectsInvalidRequestsAtOnce) {
  DerivedVolumes service;
  EXPECT_NE(service.request({small(1), ConfidenceOptions{}, {}}).error().message.find("scan-line"),
            std::string::npos);
  VesselnessOptions wrong;
  wrong.scales = 0;
  EXPECT_FALSE(service.request({small(1), wrong, {}}));
  DerivedLimits limits;
  limits.memory_limit = 1000;
  DerivedVolumes tight(limits);
  EXPECT_EQ(tight.request({small(1), SnrOptions{}, {}})->wait().error().code,
            ErrorCode::kUnsupportedData);
}

}  // namespace
}  // namespace nav::render::features
