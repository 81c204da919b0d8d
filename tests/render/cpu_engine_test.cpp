// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The CPU engine against itself (skipping, threads, vectors) and against the reference.
#include <algorithm>
#include <cstring>
#include <random>

#include "bench/support/synthetic_ct.hpp"
#include "tests/render/scene_support.hpp"

namespace nav::render {
namespace {

bool same_bytes(const RenderedImage& a, const RenderedImage& b) {
  const auto x = a.pixels.pixels();
  const auto y = b.pixels.pixels();
  return x.size() == y.size() && std::memcmp(x.data(), y.data(), x.size_bytes()) == 0;
}

/// Blobs of tissue with single bright voxels, half of them at the corners of bricks.
std::shared_ptr<const Volume> random_volume(std::mt19937& random, const VoxelGrid& grid) {
  std::uniform_real_distribution<double> unit(0, 1);
  Eigen::Vector3d centre;
  for (int a = 0; a < 3; ++a) centre[a] = unit(random) * grid.size[static_cast<std::size_t>(a)];
  const double radius = 3 + 10 * unit(random);
  std::vector<std::array<int, 3>> specks;
  for (int i = 0; i < 12; ++i) {
    std::array<int, 3> at{};
    for (std::size_t a = 0; a < 3; ++a) {
      at[a] = static_cast<int>(unit(random) * grid.size[a]);
      if (i % 2 == 0) at[a] = at[a] / 8 * 8;
    }
    specks.push_back(at);
  }
  return test::make_volume(grid, [&](int i, int j, int k) {
    if (std::find(specks.begin(), specks.end(), std::array<int, 3>{i, j, k}) != specks.end()) {
      return 900.0;
    }
    const double r = (Eigen::Vector3d(i, j, k) - centre).norm();
    return r < radius ? 300 * (1 - r / radius) + 40 : -1000.0;
  });
}

TransferFunction random_transfer(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<TransferNode> nodes;
  double hu = -1100 + 300 * unit(random);
  const bool air_is_clear = unit(random) < 0.7;
  for (int i = 0; i < 6; ++i) {
    const bool clear = unit(random) < 0.6 || (air_is_clear && i < 2);
    nodes.push_back({std::round(hu),
                     {unit(random), unit(random), unit(random)},
                     clear ? 0 : 0.9 * std::pow(unit(random), 3),
                     1});
    hu += 2 + 500 * unit(random);
  }
  return *TransferFunction::create("random", nodes);
}

/// A scene with everything in it, seen from anywhere, sometimes from within.
Scene random_scene(std::mt19937& random, std::shared_ptr<const Volume> ct) {
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto vector = [&](double size) {
    return Eigen::Vector3d(size * unit(random), size * unit(random), size * unit(random));
  };
  Camera camera{{vector(60)}, {vector(8)}, {vector(1)}};
  camera.orthographic = unit(random) > 0.5;
  camera.orthographic_height_mm = 45;
  camera.vertical_fov_rad = 0.8;
  if (unit(random) > 0.7) camera.eye_ct.mm = camera.look_at_ct.mm + Eigen::Vector3d(0, -40, 0);
  Scene scene{std::move(ct), random_transfer(random), {}, {}, {}, {}, camera, {}};
  scene.shading.enabled = unit(random) > 0;
  scene.quality.step_voxels = std::pow(2.0, 1.5 * unit(random));
  scene.quality.opaque_at = unit(random) > 0 ? 0.98 : 1.0;
  scene.width = 27;
  scene.height = 21;
  if (unit(random) > 0) {
    scene.plane = test::upright_plane(test::grey_picture(30, 20, 120), 1, vector(10));
    scene.plane->opacity = 0.6;
  }
  if (unit(random) > 0) {
    scene.needle = test::needle(vector(10), vector(40), SafetyState::kStale);
  }
  return scene;
}

/// 33 × 29 × 41 voxels and smaller, one in three oblique and left-handed.
VoxelGrid random_grid(int i) {
  const Eigen::Vector3d spacing(1, i % 2 == 0 ? 1.0 : 1.7, i % 5 == 0 ? 3.0 : 0.8);
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  if (i % 3 == 0) {
    turn = Eigen::AngleAxisd(0.3 + i, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix() *
           Eigen::Vector3d(1, -1, 1).asDiagonal();
  }
  if (i % 11 == 0) return test::centred_grid({25, 1, 16}, spacing, turn);
  return test::centred_grid({33, 29, 17 + 8 * (i % 4)}, spacing, turn);
}

class SkippingTest : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Vector, SkippingTest, ::testing::Bool());

TEST_P(SkippingTest, IsBitIdenticalToNotSkipping) {
  std::mt19937 random(GetParam() ? 1 : 2);
  const auto engine = make_cpu_engine({1, GetParam()});
  std::uint64_t with = 0;
  std::uint64_t without = 0;
  constexpr int kVolumes = 40;
  constexpr int kScenesEach = 6;
  for (int v = 0; v < kVolumes; ++v) {
    const auto ct = random_volume(random, random_grid(v));
    for (int s = 0; s < kScenesEach; ++s) {
      Scene scene = random_scene(random, ct);
      const RenderedImage skipped = test::draw(*engine, scene);
      scene.quality.skip_empty_bricks = false;
      const RenderedImage full = test::draw(*engine, scene);
      ASSERT_TRUE(same_bytes(skipped, full))
          << "volume " << v << ", scene " << s << ": " << test::max_difference(skipped, full);
      EXPECT_LE(skipped.statistics.volume_samples, full.statistics.volume_samples);
      EXPECT_EQ(skipped.statistics.gradient_samples, full.statistics.gradient_samples);
      with += skipped.statistics.volume_samples;
      without += full.statistics.volume_samples;
    }
  }
  EXPECT_LT(with, without * 3 / 4) << "nothing was skipped";
}

TEST(CpuEngineTest, PictureDoesNotDependOnThreads) {
  std::mt19937 random(3);
  const auto one = make_cpu_engine({1, true});
  const auto two = make_cpu_engine({2, true});
  for (int i = 0; i < 20; ++i) {
    Scene scene = random_scene(random, random_volume(random, random_grid(i)));
    scene.width = 131;
    scene.height = 97;
    const RenderedImage a = test::draw(*one, scene);
    const RenderedImage b = test::draw(*two, scene);
    ASSERT_TRUE(same_bytes(a, b)) << i;
    EXPECT_EQ(a.statistics.volume_samples, b.statistics.volume_samples);
  }
}

TEST(CpuEngineTest, VectorAndPortablePathsAgree) {
  constexpr float kTolerance = 1e-4F;  // Fused against separate rounding, over whole rays.
  const auto vector = make_cpu_engine({0, true});
  const auto portable = make_cpu_engine({0, false});
  if (vector->device().substr(0, 4) != "AVX2") GTEST_SKIP() << "this processor has no AVX2";
  EXPECT_EQ(portable->device().substr(0, 8), "portable");
  std::mt19937 random(4);
  for (int i = 0; i < 60; ++i) {
    Scene scene = random_scene(random, random_volume(random, random_grid(i)));
    scene.quality.opaque_at = 1;  // A last bit decides where a ray ends otherwise.
    EXPECT_LT(test::max_difference(test::draw(*vector, scene), test::draw(*portable, scene)),
              kTolerance)
        << i;
  }
}

TEST(CpuEngineTest, CachesFollowTheVolumeAndTheTransferFunction) {
  std::mt19937 random(6);
  const auto kept = make_cpu_engine();
  const auto ct_a = random_volume(random, random_grid(1));
  const auto ct_b = random_volume(random, random_grid(2));
  Scene scene = random_scene(random, ct_a);
  const TransferFunction first = scene.transfer;
  const TransferFunction second = random_transfer(random);
  for (const auto& [ct, transfer] :
       {std::pair{ct_a, first}, {ct_b, first}, {ct_b, second}, {ct_a, second}, {ct_a, first}}) {
    scene.ct = ct;
    scene.transfer = transfer;
    EXPECT_TRUE(same_bytes(test::draw(*kept, scene), test::draw(*make_cpu_engine(), scene)));
  }
}

/// Share of pixels that differ by more than a limit.
double share_beyond(const RenderedImage& a, const RenderedImage& b, float limit) {
  std::size_t beyond = 0;
  for (std::size_t i = 0; i < a.pixels.pixels().size(); ++i) {
    if (test::difference(a.pixels.pixels()[i], b.pixels.pixels()[i]) > limit) ++beyond;
  }
  return static_cast<double>(beyond) / static_cast<double>(a.pixels.pixels().size());
}

TEST(CpuEngineTest, AgreesWithTheReferenceOnAnAbdomen) {
  constexpr float kTwoGreyLevels = 2.0F / 255;
  constexpr double kShare = 0.001;
  const auto ct = test::SyntheticAbdomen::volume(96);
  const auto cpu = make_cpu_engine();
  const auto reference = make_reference_engine();
  for (const char* preset : {"ct-bone", "ct-soft-tissue", "cta-vessels"}) {
    Camera camera{{{-180, -620, 160}}, {{0, 0, 0}}, {{0, 0, 1}}};
    Scene scene{ct, *preset_transfer_function(preset), {}, {}, {}, {}, camera, {}};
    scene.plane = test::upright_plane(test::grey_picture(150, 120, 120), 1, {-50, -20, 90});
    scene.needle = test::needle({-30, -30, 55}, {-110, -190, 90}, SafetyState::kValid);
    scene.width = 160;
    scene.height = 120;
    const RenderedImage fast = test::draw(*cpu, scene);
    const RenderedImage exact = test::draw(*reference, scene);
    EXPECT_LE(share_beyond(fast, exact, kTwoGreyLevels), kShare) << preset;
    scene.quality.opaque_at = 1;  // Without early termination nothing but rounding is left.
    scene.shading.enabled = false;
    EXPECT_LE(share_beyond(test::draw(*cpu, scene), test::draw(*reference, scene), 1e-3F), kShare)
        << preset << ", unshaded";
  }
}

}  // namespace
}  // namespace nav::render
