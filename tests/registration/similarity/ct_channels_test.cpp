// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/similarity/ct_channels.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <set>

#include "registration/prepared.hpp"
#include "registration/similarity/ct_structure.hpp"
#include "registration/similarity/ct_texels.hpp"
#include "registration/similarity/patch_channels.hpp"
#include "registration/similarity/similarity_cost.hpp"
#include "tests/registration/synthetic.hpp"
#include "tests/support/matchers.hpp"

namespace nav::registration {
namespace {

// Sums of a few hundred floats of magnitude 1.
constexpr double kTexelRounding = 3e-6;

Volume random_ct(std::array<int, 3> size, const Eigen::Vector3d& spacing_mm) {
  VoxelGrid grid;
  grid.size = size;
  grid.spacing_mm = spacing_mm;
  std::mt19937 random(7);
  std::vector<std::int16_t> hu;
  for (std::size_t i = 0; i < grid.voxel_count(); ++i) {
    hu.push_back(static_cast<std::int16_t>(static_cast<int>(random() % 3000) - 1500));
  }
  return *Volume::create(grid, std::move(hu), "random");
}

/// Channel f by its definition, in doubles: block means of the clamped HU, then a Gaussian along
/// each axis that is cut at three sigmas. Beyond the border the nearest texel counts.
class Definition {
 public:
  Definition(const Volume& ct, double sigma_mm, const CtChannels& channels)
      : ct_(ct), channels_(channels) {
    for (std::size_t a = 0; a < 3; ++a) {
      const auto e = static_cast<Eigen::Index>(a);
      const double voxel_mm = ct.grid().spacing_mm[e];
      block_[a] = static_cast<int>(std::lround(channels.spacing_mm[e] / voxel_mm));
      texels_[a] = std::max(ct.grid().size[a] / block_[a], 1);
      const double have = (block_[a] * block_[a] - 1) / 12.0 * voxel_mm * voxel_mm;
      sigma_[a] = std::sqrt(std::max(sigma_mm * sigma_mm - have, 0.0)) / channels.spacing_mm[e];
    }
  }

  [[nodiscard]] double f(std::array<int, 3> texel, std::size_t axis = 3) const {
    if (axis == 0) return mean(texel);
    const std::size_t a = axis - 1;
    const int radius = std::max(1, static_cast<int>(std::ceil(3 * sigma_[a])));
    double sum = 0;
    double total = 0;
    for (int t = -radius; t <= radius; ++t) {
      const double weight = std::exp(-0.5 * t * t / std::pow(std::max(sigma_[a], 1e-3), 2));
      std::array<int, 3> at = texel;
      at[a] = std::clamp(texel[a] + t, 0, texels_[a] - 1);
      sum += weight * f(at, a);
      total += weight;
    }
    return sum / total;
  }

 private:
  [[nodiscard]] double mean(const std::array<int, 3>& texel) const {
    double sum = 0;
    const auto& n = ct_.grid().size;
    for (int z = 0; z < block_[2]; ++z) {
      for (int y = 0; y < block_[1]; ++y) {
        for (int x = 0; x < block_[0]; ++x) {
          const int i = texel[0] * block_[0] + x;
          const int j = texel[1] * block_[1] + y;
          const int k = texel[2] * block_[2] + z;
          const int hu = ct_.hu()[static_cast<std::size_t>((k * n[1] + j) * n[0] + i)];
          sum += std::clamp(hu, -150, 250) / 100.0;
        }
      }
    }
    return sum / (block_[0] * block_[1] * block_[2]);
  }

  const Volume& ct_;
  const CtChannels& channels_;
  std::array<int, 3> block_{}, texels_{};
  std::array<double, 3> sigma_{};
};

std::size_t index_of(const CtChannels& channels, int i, int j, int k) {
  return static_cast<std::size_t>((k * channels.size[1] + j) * channels.size[0] + i);
}

TEST(CtChannelsTest, TexelsAreSmoothedBlockMeansAndTheirDifferences) {
  // Radii of one to five texels, blocks of one to three voxels, and a border within every radius.
  for (const double sigma_mm : {0.5, 1.5, 3.75}) {
    for (const double texel_sigmas : {0.3, 0.7, 1.0}) {
      const Volume ct = random_ct({11, 9, 7}, {1.5, 1.0, 2.0});
      const auto made = make_ct_channels(ct, box_of(ct.grid()), sigma_mm, texel_sigmas);
      ASSERT_TRUE(test::has_value(made));
      const Definition definition(ct, sigma_mm, *made);
      const auto& n = made->size;
      double worst = 0;
      for (int k = 0; k < n[2]; ++k) {
        for (int j = 0; j < n[1]; ++j) {
          for (int i = 0; i < n[0]; ++i) {
            const auto& texel = made->texels[index_of(*made, i, j, k)];
            worst = std::max(worst, std::abs(texel[0] - definition.f({i, j, k})));
            for (std::size_t a = 0; a < 3; ++a) {
              std::array<int, 3> low{i, j, k};
              std::array<int, 3> high = low;
              low[a] = std::max(low[a] - 1, 0);
              high[a] = std::min(high[a] + 1, n[a] - 1);
              const double scale =
                  sigma_mm / made->spacing_mm[static_cast<Eigen::Index>(a)] / (high[a] - low[a]);
              const double slope = scale * (definition.f(high) - definition.f(low));
              worst = std::max(worst, std::abs(texel[1 + a] - slope));
            }
          }
        }
      }
      EXPECT_LT(worst, kTexelRounding) << "sigma " << sigma_mm << ", texels " << texel_sigmas;
    }
  }
}

TEST(CtChannelsTest, TexelsOfAPartAreExactlyThoseOfTheWhole) {
  const Volume ct = random_ct({23, 19, 17}, {0.8, 1.0, 2.5});
  for (const double sigma_mm : {0.9, 2.25}) {
    CtChannels whole;
    const auto lattice = lattice_over(ct, box_of(ct.grid()), sigma_mm, kTexelSigmas, whole);
    ASSERT_TRUE(test::has_value(lattice));
    fill_texels(ct, *lattice, {{0, 0, 0}, whole.size}, whole.texels);
    std::mt19937 random(3);
    for (int trial = 0; trial < 40; ++trial) {
      TexelPart part{};
      for (std::size_t a = 0; a < 3; ++a) {
        const auto n = static_cast<unsigned>(whole.size[a]);
        part.size[a] = static_cast<int>(2 + random() % (n - 1));
        part.first[a] = static_cast<int>(random() % (n - static_cast<unsigned>(part.size[a]) + 1));
      }
      TexelArray texels;
      fill_texels(ct, *lattice, part, texels);
      std::size_t at = 0;
      std::size_t other = 0;
      for (int k = 0; k < part.size[2]; ++k) {
        for (int j = 0; j < part.size[1]; ++j) {
          for (int i = 0; i < part.size[0]; ++i, ++at) {
            const auto& expected = whole.texels[index_of(whole, part.first[0] + i,
                                                         part.first[1] + j, part.first[2] + k)];
            other += texels.at(at) == expected ? 0 : 1;
          }
        }
      }
      EXPECT_EQ(other, 0u) << "trial " << trial;
      EXPECT_EQ(at, texels.size());
    }
  }
}

TEST(CtChannelsTest, RunsOfSeveralPartsHaveExactlyTheTexelsOfTheWhole) {
  const Volume ct = random_ct({29, 23, 31}, {1.0, 1.2, 1.1});
  for (const double sigma_mm : {1.4, 2.9}) {
    CtChannels whole;
    const auto lattice = lattice_over(ct, box_of(ct.grid()), sigma_mm, kTexelSigmas, whole);
    ASSERT_TRUE(test::has_value(lattice));
    fill_texels(ct, *lattice, {{0, 0, 0}, whole.size}, whole.texels);
    constexpr std::array<float, 4> kUntouched{-1e9f, 0, 0, 0};
    std::mt19937 random(5);
    const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
    for (int trial = 0; trial < 30; ++trial) {
      // The parts are far apart, overlap, or reach beyond the ends of the lattice. Some rows and
      // slices are not needed by any part.
      std::vector<TexelOrder> orders(static_cast<std::size_t>(1 + trial % 4));
      std::vector<TexelArray> out(orders.size());
      for (std::size_t n = 0; n < orders.size(); ++n) {
        TexelPart& part = orders[n].part;
        for (std::size_t a = 0; a < 3; ++a) {
          part.size[a] = 2 + below(whole.size[a]);
          part.first[a] = below(whole.size[a] + 2) - 2;
        }
        out[n].assign(static_cast<std::size_t>(part.size[0] * part.size[1] * part.size[2]),
                      kUntouched);
        orders[n].out = out[n];
        for (int row = 0; row < part.size[1] * part.size[2]; ++row) {
          const int from = below(part.size[0]);
          orders[n].runs.push_back({from, from + below(part.size[0] - from + 1)});
        }
      }
      fill_texels(ct, *lattice, orders);
      std::size_t other = 0;
      for (const TexelOrder& order : orders) {
        std::size_t at = 0;
        for (std::size_t row = 0; row < order.runs.size(); ++row) {
          const int j = static_cast<int>(row) % order.part.size[1];
          const int k = static_cast<int>(row) / order.part.size[1];
          for (int i = 0; i < order.part.size[0]; ++i, ++at) {
            const auto held = [&](std::size_t a, int index) {
              return std::clamp(order.part.first[a] + index, 0, lattice->size[a] - 1);
            };
            const bool wanted = i >= order.runs[row].from && i < order.runs[row].to;
            const auto& expected =
                wanted ? whole.texels[index_of(whole, held(0, i), held(1, j), held(2, k))]
                       : kUntouched;
            other += order.out[at] == expected ? 0 : 1;
          }
        }
      }
      EXPECT_EQ(other, 0u) << "trial " << trial;
    }
  }
}

TEST(CtChannelsTest, ManyRowsOfOneBlockDoNotOverflow) {
  // 15 x 15 rows of one voxel each, all at the upper end of the window. The sum does not fit into
  // 16 bits.
  VoxelGrid grid;
  grid.size = {30, 30, 30};
  grid.spacing_mm.setConstant(0.2);
  const auto ct =
      Volume::create(grid, std::vector<std::int16_t>(grid.voxel_count(), 32767), "metal");
  ASSERT_TRUE(test::has_value(ct));
  const auto channels = make_ct_channels(*ct, box_of(grid), 4.3);
  ASSERT_TRUE(test::has_value(channels));
  EXPECT_EQ(channels->size, (std::array<int, 3>{2, 2, 2}));
  for (const auto& texel : channels->texels) EXPECT_NEAR(texel[0], 2.5, kTexelRounding);
}

TEST(CtChannelsTest, AnAxisOfOneVoxelIsRepeatedAndHasNoSlope) {
  const Volume ct = random_ct({6, 5, 1}, {2, 2, 2});
  const auto channels = make_ct_channels(ct, box_of(ct.grid()), 1.5);
  ASSERT_TRUE(test::has_value(channels));
  ASSERT_EQ(channels->size[2], 2);
  for (int j = 0; j < channels->size[1]; ++j) {
    for (int i = 0; i < channels->size[0]; ++i) {
      EXPECT_EQ(channels->texels[index_of(*channels, i, j, 0)],
                channels->texels[index_of(*channels, i, j, 1)]);
      EXPECT_EQ(channels->texels[index_of(*channels, i, j, 0)][3], 0.0f);
    }
  }
}

TEST(CtChannelsTest, GaussiansReachNoFartherThanTheTexels) {
  // The slices are a tenth of a micrometre apart, so three sigmas are 45 000 slices.
  const Volume thick = random_ct({6, 5, 1}, {2, 2, 2});
  const Volume thin = random_ct({6, 5, 1}, {2, 2, 1e-4});
  CtChannels channels;
  const auto lattice = lattice_over(thin, box_of(thin.grid()), 1.5, kTexelSigmas, channels);
  ASSERT_TRUE(test::has_value(lattice));
  for (const auto& kernel : lattice->kernel) EXPECT_LE(kernel.size(), 6u);
  const auto expected = make_ct_channels(thick, box_of(thick.grid()), 1.5);
  const auto found = make_ct_channels(thin, box_of(thin.grid()), 1.5);
  ASSERT_TRUE(test::has_value(expected));
  ASSERT_TRUE(test::has_value(found));
  ASSERT_EQ(found->texels.size(), expected->texels.size());
  for (std::size_t i = 0; i < found->texels.size(); ++i) {
    for (std::size_t c = 0; c < 4; ++c) {
      EXPECT_NEAR(found->texels[i][c], expected->texels[i][c], kTexelRounding);
    }
  }
}

/// Patches of a level with the whole CT, and with the CT near each patch.
struct ChannelScene {
  Volume ct = test::blob_ct(test::BlobPatient(11), test::oblique_grid());
  CtChannels whole = *make_ct_channels(ct, box_of(ct.grid()), 1.5);
  Sweep sweep = test::blob_sweep(test::BlobPatient(11), {});
  PatchSet patches = make_patches(sweep, *shadow_masks(sweep, {}), {2.0, 7, 120, 6.0}, 1.5);
};

TEST(PatchChannelsTest, CostAndDerivativesEqualThoseOfTheWholeCt) {
  const ChannelScene scene;
  auto near = PatchChannels::create(scene.ct, 1.5, kTexelSigmas, scene.patches.patches.size());
  ASSERT_TRUE(test::has_value(near));
  constexpr double kRidge = 0.02;
  const SimilarityCost dense(scene.whole, scene.patches, kRidge, 1);
  const SimilarityCost sparse =
      SimilarityCost(near->whole(), scene.patches, kRidge, 2).where(&*near);
  // Within the margin of the first boxes, beyond it, half outside the CT, and far away.
  for (const double off_mm : {0.0, 0.5, 1.5, 9.0, 60.0, 3000.0}) {
    const Pose pose = test::off_by(test::true_pose(), off_mm, 0.01 * std::min(off_mm, 20.0), 4);
    const Eigen::Vector3d centre(5, -8, 3);
    const CostTerms expected = dense.terms(pose, centre);
    const CostTerms found = sparse.terms(pose, centre);
    EXPECT_NEAR(found.cost, expected.cost, 1e-6) << off_mm;
    EXPECT_NEAR(sparse.cost(pose).cost, expected.cost, 1e-6) << off_mm;
    EXPECT_LT((found.gradient - expected.gradient).norm(), 1e-5 * (1 + expected.gradient.norm()));
    EXPECT_LT((found.hessian - expected.hessian).norm(), 1e-4 * (1 + expected.hessian.norm()));
  }
}

TEST(PatchChannelsTest, SubsetsOfPatchesUseTheSameBoxes) {
  const ChannelScene scene;
  auto near = PatchChannels::create(scene.ct, 1.5, kTexelSigmas, scene.patches.patches.size());
  ASSERT_TRUE(test::has_value(near));
  const PatchSet odd =
      subset(scene.patches, [&](const Patch& patch) { return patch.index % 2 == 1; });
  ASSERT_EQ(odd.patches.size(), scene.patches.patches.size() / 2);
  const SimilarityCost dense = SimilarityCost(scene.whole, scene.patches, 0.02, 1);
  const SimilarityCost sparse = SimilarityCost(near->whole(), scene.patches, 0.02, 1).where(&*near);
  const Pose pose = test::true_pose();
  EXPECT_NEAR(sparse.on(odd).cost(pose).cost, dense.on(odd).cost(pose).cost, 1e-6);
}

/// Counts the texels of the box from which a patch is interpolated and that differ from those of
/// the whole CT.
std::size_t other_texels(const CtChannels& box, const CtChannels& whole,
                         const PlacedPatch& placed) {
  const Eigen::Vector3d first =
      whole.grid_of(box.origin_ct_mm).cwiseQuotient(whole.spacing_mm).array().round();
  const double half = 0.5 * (placed.side - 1);
  const Eigen::Vector3d reach = half * (placed.step_a.cwiseAbs() + placed.step_b.cwiseAbs());
  std::array<int, 3> low{};
  std::array<int, 3> high{};
  for (std::size_t a = 0; a < 3; ++a) {
    const auto axis = static_cast<Eigen::Index>(a);
    const double middle = placed.centre[axis] / box.spacing_mm[axis];
    const double wide = reach[axis] / box.spacing_mm[axis];
    // Beyond the border, which is the border of the whole CT, the nearest texels count.
    low[a] = std::clamp(static_cast<int>(std::floor(middle - wide)), 0, box.size[a] - 1);
    high[a] = std::clamp(static_cast<int>(std::floor(middle + wide)) + 1, 0, box.size[a] - 1);
  }
  std::size_t other = 0;
  for (int k = low[2]; k <= high[2]; ++k) {
    for (int j = low[1]; j <= high[1]; ++j) {
      for (int i = low[0]; i <= high[0]; ++i) {
        const auto at = index_of(whole, static_cast<int>(first.x()) + i,
                                 static_cast<int>(first.y()) + j, static_cast<int>(first.z()) + k);
        other += box.texels.at(index_of(box, i, j, k)) == whole.texels.at(at) ? 0 : 1;
      }
    }
  }
  return other;
}

TEST(PatchChannelsTest, SharedBoxesHoldTheirPatchesAndExactlyTheTexelsOfTheWhole) {
  ChannelScene scene;
  // A non-finite or distant patch must not spoil the box of others.
  scene.patches.patches[3].centre_mm.x() = std::nan("");
  scene.patches.patches[4].centre_mm.y() = 1e300;
  scene.patches.patches[5].centre_mm.y() += 4000;
  const std::size_t count = scene.patches.patches.size();
  auto near = PatchChannels::create(scene.ct, 1.5, kTexelSigmas, count);
  ASSERT_TRUE(test::has_value(near));
  const CtChannels whole = *make_ct_channels(scene.ct, box_of(scene.ct.grid()), 1.5);
  std::vector<IndexedPatch> all;
  const GridPose pose = grid_pose(near->whole(), test::true_pose());
  for (std::size_t i = 0; i < count; ++i) all.push_back({i, place(scene.patches, i, pose)});
  near->share(all);
  std::set<const CtChannels*> boxes;
  double texels = 0;
  double texels_of_each = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (i == 3 || i == 4) continue;
    PlacedPatch placed = all[i].placed;
    const CtChannels& box = near->around(i, placed);
    texels_of_each += near->texels_for(all[i].placed);
    if (boxes.insert(&box).second) texels += static_cast<double>(box.texels.size());
    EXPECT_EQ(other_texels(box, whole, placed), 0u) << "patch " << i;
    // The patch is moved within its margin, and then beyond it.
    for (const Eigen::Vector3d& off : {Eigen::Vector3d(1, -1, 1), Eigen::Vector3d(-2, 2, 2),
                                       Eigen::Vector3d(3.9, 3.9, -3.9), Eigen::Vector3d(0, 0, 9)}) {
      PlacedPatch moved = all[i].placed;
      moved.centre += off;
      const bool seen = near->sees(i, moved);
      EXPECT_TRUE(seen || off.cwiseAbs().maxCoeff() > 4) << "patch " << i << " by " << off;
      if (!seen) continue;
      const CtChannels& same = near->around(i, moved);
      ASSERT_EQ(&same, &box);
      EXPECT_EQ(other_texels(same, whole, moved), 0u) << "patch " << i << " by " << off;
    }
  }
  EXPECT_LT(boxes.size(), count / 2);
  EXPECT_LT(texels, 0.7 * texels_of_each);
  // No new box is made for a patch that lies inside its box.
  near->share(all);
  PlacedPatch again = all[0].placed;
  EXPECT_EQ(boxes.count(&near->around(0, again)), 1u);
}

TEST(PatchChannelsTest, SharedBoxesMatchForAllPoses) {
  const ChannelScene scene;
  auto near = PatchChannels::create(scene.ct, 1.5, kTexelSigmas, scene.patches.patches.size());
  ASSERT_TRUE(test::has_value(near));
  const SimilarityCost dense(scene.whole, scene.patches, 0.02, 1);
  const SimilarityCost sparse = SimilarityCost(near->whole(), scene.patches, 0.02, 1).where(&*near);
  for (const double off_mm : {0.0, 1.5, 9.0, 60.0, 0.5}) {
    const Pose pose = test::off_by(test::true_pose(), off_mm, 0.01 * std::min(off_mm, 20.0), 4);
    if (off_mm != 1.5) {  // Some poses share boxes again, some do not.
      std::vector<IndexedPatch> all;
      const GridPose at = grid_pose(near->whole(), pose);
      for (std::size_t i = 0; i < scene.patches.patches.size(); ++i) {
        all.push_back({i, place(scene.patches, i, at)});
      }
      near->share(all);
    }
    EXPECT_NEAR(sparse.cost(pose).cost, dense.cost(pose).cost, 1e-6) << off_mm;
  }
}

TEST(PatchChannelsTest, ComputesBoxesOnlyForPatchesWithStructure) {
  ChannelScene scene;
  scene.patches =
      make_patches(scene.sweep, *shadow_masks(scene.sweep, {}), {2.0, 7, 600, 3.0}, 1.5);
  const std::size_t count = scene.patches.patches.size();
  const CtChannels smoother = *make_ct_channels(scene.ct, box_of(scene.ct.grid()), 4.0);
  const Pose pose = test::true_pose();
  for (const double least_hu : {8.0, 10.0}) {
    auto near = PatchChannels::create(scene.ct, 1.5, kTexelSigmas, count);
    ASSERT_TRUE(test::has_value(near));
    const PatchSet all = with_ct_structure(scene.whole, scene.patches, pose, least_hu);
    const PatchSet found =
        with_ct_structure(near->whole(), scene.patches, pose, least_hu, &*near, &smoother);
    std::size_t smooth = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const bool seen = near->sees(i, place(scene.patches, i, grid_pose(near->whole(), pose)));
      const double contrast_hu =
          ct_contrast_hu(smoother, scene.patches, i, grid_pose(smoother, pose));
      EXPECT_EQ(seen, contrast_hu >= 0.3 * least_hu) << contrast_hu;
      smooth += seen ? 0 : 1;
    }
    EXPECT_GT(smooth, 5u);
    EXPECT_LT(all.patches.size(), count);
    // The patches that were left out had no structure, except for one in a hundred.
    EXPECT_LE(found.patches.size(), all.patches.size());
    EXPECT_GE(100 * found.patches.size(), 99 * all.patches.size());
  }
}

TEST(PatchChannelsTest, ANonFinitePatchIsNoMatch) {
  ChannelScene scene;
  scene.patches.patches[3].centre_mm.x() = std::nan("");
  scene.patches.patches[4].centre_mm.y() = 1e300;
  auto near = PatchChannels::create(scene.ct, 1.5, kTexelSigmas, scene.patches.patches.size());
  ASSERT_TRUE(test::has_value(near));
  const SimilarityCost sparse = SimilarityCost(near->whole(), scene.patches, 0.02, 1).where(&*near);
  const CostTerms found = sparse.terms(test::true_pose(), Eigen::Vector3d::Zero());
  EXPECT_EQ(found.non_finite, 2);
  EXPECT_TRUE(std::isfinite(found.cost));
}

TEST(CtChannelsTest, ReportsHowFarABoxLiesOutsideTheCt) {
  const Volume ct = random_ct({20, 20, 20}, {2, 2, 3});  // The CT spans 0 to 38, 38 and 57 mm.
  const CtBox beyond{{0, 0, 60.5}, {10, 10, 70}};
  EXPECT_TRUE(test::rejects(make_ct_channels(ct, beyond, 2), ErrorCode::kRefused,
                            {"random", "outside along axis 2, 3.5 mm beyond"}));
  const CtBox before{{0, -30, 0}, {10, -25, 10}};
  EXPECT_TRUE(test::rejects(make_ct_channels(ct, before, 2), ErrorCode::kRefused,
                            {"outside along axis 1, 25.0 mm beyond"}));
}

}  // namespace
}  // namespace nav::registration
