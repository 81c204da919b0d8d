// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Compares the CPU engine with itself (skipping, threads, vector instructions) and with the
// reference.
#include <algorithm>
#include <cstring>
#include <limits>
#include <random>
#include <sstream>

#include "render/cpu/cpu_inputs.hpp"
#include "sim/synthetic_ct.hpp"
#include "tests/render/scene_support.hpp"
#include "tests/support/trials.hpp"

namespace nav::render {
namespace {

/// Blobs of tissue with single bright voxels. Half of these lie at the corners of bricks.
std::shared_ptr<const StoredVolume> random_volume(std::mt19937& random, const VoxelGrid& grid) {
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

double random_importance(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  const double kind = unit(random);
  return kind < 0.2 ? 0.0 : kind < 0.4 ? 1.0 : kind < 0.5 ? 0.5 : unit(random);
}

std::vector<TransferNode> random_nodes(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<TransferNode> nodes;
  double hu = -1100 + 300 * unit(random);
  const bool air_is_clear = unit(random) < 0.7;
  for (int i = 0; i < 6; ++i) {
    const bool clear = unit(random) < 0.6 || (air_is_clear && i < 2);
    nodes.push_back({std::round(hu),
                     {unit(random), unit(random), unit(random)},
                     clear ? 0 : 0.9 * std::pow(unit(random), 3),
                     random_importance(random)});
    hu += 2 + 500 * unit(random);
  }
  return nodes;
}

/// One component, two components, or two of which one has a window of gradients.
TransferFunction random_transfer(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<TransferComponent> components{{"first", random_nodes(random), {}}};
  const double kind = unit(random);
  if (kind > 0.6) components.push_back({"second", random_nodes(random), {}});
  if (kind > 0.85) {
    const double from = 100 * unit(random);
    const double to = from + 20 + 200 * unit(random);
    components.back().gradient = GradientWindow{0.5 * from, from, to, 1.5 * to};
  }
  return *TransferFunction::blend("random", components);
}

Shading random_shading(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  Shading shading;
  shading.enabled = unit(random) > 0;
  if (unit(random) > 0) shading.style = ShadingStyle::kGooch;
  if (unit(random) > 0) shading.emphasis = std::min(1.0, 0.3 + std::abs(unit(random)));
  shading.full_gradient_per_mm = 5 + 200 * std::abs(unit(random));
  return shading;
}

/// Cutaway around all objects. Some are simple, and some have no clear region.
Cutaway random_cutaway(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto point = [&] {
    return Point<frames::Ct>{{12 * unit(random), 12 * unit(random), 12 * unit(random)}};
  };
  Cutaway cutaway;
  cutaway.theta1_rad = 0.2 + 0.3 * std::abs(unit(random));
  cutaway.theta2_rad = cutaway.theta1_rad + 0.4 * std::abs(unit(random));
  cutaway.overlay_mm = 12 * std::abs(unit(random));
  if (unit(random) > 0.8) cutaway.overlay_mm = std::numeric_limits<double>::infinity();
  cutaway.around_needle = unit(random) > 0;
  cutaway.around_spheres = unit(random) > 0;
  if (unit(random) > 0) cutaway.polygons.push_back({{point(), point(), point()}});
  if (unit(random) > 0.5) {
    cutaway.boxes.push_back({point(), Eigen::Vector3d(3, 5, 2).asDiagonal()});
  }
  return cutaway;
}

/// Surfaces of every kind, each with a probability of one half.
void add_surfaces(std::mt19937& random, Scene& scene) {
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto vector = [&](double size) {
    return Eigen::Vector3d(size * unit(random), size * unit(random), size * unit(random));
  };
  if (unit(random) > 0) {
    scene.plane = test::upright_plane(test::grey_image(30, 20, 120), 1, vector(10));
    scene.plane->opacity = 0.6;
    if (unit(random) > 0) scene.plane->frame.outline = SectorOutline{{0, -4}, 6, 20, 0.5};
  }
  if (unit(random) > 0) {
    scene.needle = test::needle(vector(10), vector(40), SafetyState::kStale);
  }
  if (unit(random) > 0) scene.spheres.push_back({{vector(10)}, 3, {1, 0.8, 0.1}, 0.5});
  if (unit(random) > 0) {
    scene.lines.push_back({.from_ct = {vector(10)},
                           .to_ct = {vector(40)},
                           .radius_mm = 0.7,
                           .rgb = {0.2, 0.7, 1.0},
                           .opacity = 0.4});
  }
}

/// A scene with all elements, from any view, sometimes from inside.
Scene random_scene(std::mt19937& random, std::shared_ptr<const StoredVolume> ct) {
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto vector = [&](double size) {
    return Eigen::Vector3d(size * unit(random), size * unit(random), size * unit(random));
  };
  Camera camera{{vector(60)}, {vector(8)}, {vector(1)}};
  camera.orthographic = unit(random) > 0.5;
  camera.orthographic_height_mm = 45;
  camera.vertical_fov_rad = 0.8;
  if (unit(random) > 0.7) camera.eye_ct.mm = camera.look_at_ct.mm + Eigen::Vector3d(0, -40, 0);
  Scene scene{.ct = std::move(ct), .transfer = random_transfer(random), .camera = camera};
  scene.shading = random_shading(random);
  scene.quality.step_voxels = std::pow(2.0, 1.5 * unit(random));
  if (unit(random) > 0.9) scene.quality.step_voxels = 5 + 4 * std::abs(unit(random));
  scene.quality.opaque_at = unit(random) > 0 ? 0.98 : 1.0;
  if (unit(random) > 0.4) scene.quality.classification = Classification::kPostClassified;
  scene.quality.jitter = unit(random) > 0.5;
  scene.width = 27;
  scene.height = 21;
  add_surfaces(random, scene);
  if (unit(random) > 0) scene.cutaway = random_cutaway(random);
  if (unit(random) > 0.7) {
    const double kind = unit(random);
    scene.projection = kind < -0.3  ? Projection::kMaximum
                       : kind < 0.3 ? Projection::kMinimum
                                    : Projection::kMean;
    scene.grey = {100, 1500};
  }
  return scene;
}

/// Grids of up to 33 × 29 × 41 voxels. One in three is oblique and left-handed.
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

class SkippingTest : public ::testing::TestWithParam<CpuLanes> {};
INSTANTIATE_TEST_SUITE_P(Instructions, SkippingTest, test::every_lanes(), test::lanes_name);

TEST_P(SkippingTest, SkippingGivesBitIdenticalImages) {
  std::mt19937 random(GetParam() == CpuLanes::kPortable ? 2 : 1);
  const auto engine = make_cpu_engine({1, GetParam()});
  std::uint64_t with = 0;
  std::uint64_t without = 0;
  int by_cells = 0;
  constexpr int kVolumes = 40;
  const int kScenesEach = test::trials(26);  // 1040 transfer functions and poses.
  for (int v = 0; v < kVolumes; ++v) {
    const auto ct = random_volume(random, random_grid(v));
    for (int s = 0; s < kScenesEach; ++s) {
      Scene scene = random_scene(random, ct);
      const RenderedImage skipped = test::draw(*engine, scene);
      scene.quality.skip_empty_bricks = false;
      const RenderedImage full = test::draw(*engine, scene);
      ASSERT_TRUE(test::same_bytes(skipped, full))
          << "volume " << v << ", scene " << s << ": " << test::max_difference(skipped, full);
      // A leap costs two samples in front of the next region, and may be a single cell long.
      EXPECT_LE(skipped.statistics.volume_samples, full.statistics.volume_samples * 101 / 100 + 9);
      EXPECT_EQ(skipped.statistics.gradient_samples, full.statistics.gradient_samples);
      with += skipped.statistics.volume_samples;
      without += full.statistics.volume_samples;
      // At this point the visible cells of smaller volumes are known.
      scene.quality.skip_empty_bricks = true;
      const RenderedImage passed = test::draw(*engine, scene);
      ASSERT_TRUE(test::same_bytes(passed, full)) << "volume " << v << ", scene " << s;
      if (passed.statistics.passed_samples == 0) continue;
      // Passing over a cell may also cost samples.
      EXPECT_LE(passed.statistics.volume_samples,
                skipped.statistics.volume_samples * 101 / 100 + 9);
      EXPECT_EQ(passed.statistics.gradient_samples, full.statistics.gradient_samples);
      ++by_cells;
    }
  }
  EXPECT_GT(by_cells, kVolumes * kScenesEach / 10);
  EXPECT_LT(with, without * 3 / 4) << "nothing was skipped";
}

TEST_P(SkippingTest, VisibleCellsOfASpeckledVolumeChangeNoBit) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0, 1);
  // Every brick is occupied, but most cells are invisible. Values lie on both sides of the visible
  // range.
  const auto ct =
      test::make_volume(test::centred_grid({37, 30, 43}, {1, 1.3, 0.9}), [&](int, int, int) {
        const double u = unit(random);
        return u < 0.005 ? 300.0 : u < 0.98 ? -1000 + 500 * unit(random) : 900 + 500 * unit(random);
      });
  const auto shell = *TransferFunction::create(
      "shell", {{-200, {1, 0, 0}, 0, 0.2}, {300, {0, 1, 0}, 0.4, 1}, {700, {0, 0, 1}, 0, 0.6}});
  for (const double step : {0.1, 0.5, 0.94, 0.96, 1.0, 1.4, 1.89, 1.95, 3.0}) {
    for (int kind = 0; kind < 6; ++kind) {
      const auto engine = make_cpu_engine({2, GetParam()});
      Scene scene = test::plain_scene(ct, shell, test::frontal(90, 40, kind % 2 == 0));
      scene.quality.step_voxels = step;
      scene.quality.opaque_at = kind == 1 ? 0.95 : 1;
      if (kind == 2) scene.quality.classification = Classification::kPostClassified;
      scene.shading.enabled = kind == 3 || kind == 4;
      if (kind == 4) scene.shading.style = ShadingStyle::kGooch;
      if (kind == 5) {
        scene.plane = test::upright_plane(test::grey_image(50, 50, 120), 1, {0, 20, 25});
        scene.cutaway = Cutaway{};
        scene.cutaway->theta2_rad = 1.2;  // Much of the volume lies in the transition.
      }
      scene.width = scene.height = 50;
      const RenderedImage first = test::draw(*engine, scene);
      scene.quality.skip_empty_bricks = false;
      const RenderedImage full = test::draw(*engine, scene);
      scene.quality.skip_empty_bricks = true;
      const RenderedImage second = test::draw(*engine, scene);
      const std::string what = std::to_string(step) + ", " + std::to_string(kind);
      EXPECT_TRUE(test::same_bytes(first, full)) << what;
      EXPECT_TRUE(test::same_bytes(second, full)) << what;
      EXPECT_EQ(first.statistics.passed_samples, 0U) << what;
      EXPECT_EQ(first.statistics.faded_cells > 0, kind == 5) << what;
      const bool passes = kind == 2 || step < 1.9;
      EXPECT_EQ(second.statistics.passed_samples > 0, passes) << what;
      if (passes && (kind == 2 || step < 0.95) && kind != 5) {
        EXPECT_LT(second.statistics.volume_samples, first.statistics.volume_samples * 2 / 3)
            << what;
      }
    }
  }
}

TEST_P(SkippingTest, LongCellsMissNothingBetweenEmptyOnes) {
  const auto engine = make_cpu_engine({1, GetParam()});
  (void)test::draw(*engine, test::sheet_scene(100, 64));  // From now on the engine tests visible
                                                          // cells.
  for (const double step : {0.9, 0.95, 1.0, 1.3, 1.9, 2.0, 3.4, 4.0, 6.0, 7.4, 9.0, 12.0, 16.0}) {
    for (int shift = 0; shift < 16; ++shift) {  // Shifts the lattice of samples.
      Scene scene = test::sheet_scene(100 + shift * step / 16, 8);
      scene.quality.step_voxels = step;
      scene.quality.skip_empty_bricks = true;
      const RenderedImage skipped = test::draw(*engine, scene);
      scene.quality.skip_empty_bricks = false;
      EXPECT_TRUE(test::same_bytes(skipped, test::draw(*engine, scene))) << step << ' ' << shift;
      EXPECT_GT(test::middle(skipped).r, 0.1F) << step << ' ' << shift;
      EXPECT_EQ(skipped.statistics.passed_samples > 0, step <= 1.9) << step;
    }
  }
}

TEST_P(SkippingTest, VisibleCellsFollowTheVolumeAndTheTransferFunction) {
  std::mt19937 random(6);
  std::uniform_int_distribution<int> hu(-1000, 1000);
  const auto noise = [&] {
    return test::make_volume(test::centred_grid({25, 25, 25}, {1, 1, 1}),
                             [&](int, int, int) { return hu(random); });
  };
  const auto from = [](double least) {
    return *TransferFunction::create("from", {{least, {1, 1, 1}, 0, 1}, {1500, {1, 1, 1}, 0.5, 1}});
  };
  const auto engine = make_cpu_engine({1, GetParam()});
  Scene scene = test::plain_scene(noise(), from(900), test::frontal(90, 40, false));
  const auto expect_anew = [&] {
    for (int i = 0; i < 3; ++i) {
      scene.camera.eye_ct.mm.x() += 1;
      const RenderedImage kept = test::draw(*engine, scene);
      EXPECT_TRUE(test::same_bytes(kept, test::draw(*make_cpu_engine({1, GetParam()}), scene)));
      EXPECT_EQ(kept.statistics.passed_samples > 0, i > 0);
    }
  };
  expect_anew();
  scene.transfer = from(600);
  expect_anew();
  scene.ct = noise();
  expect_anew();
  scene.quality.step_voxels = 1.5;  // A step of 1.5 voxels needs blocks of cells.
  scene.camera.eye_ct.mm.x() += 1;
  EXPECT_TRUE(test::same_bytes(test::draw(*engine, scene),
                               test::draw(*make_cpu_engine({1, GetParam()}), scene)));
}

/// Invisible below -500 HU.
TransferFunction from_tissue_on() {
  return *TransferFunction::create("tissue", {{-500, {1, 1, 1}, 0, 1}, {500, {1, 1, 1}, 0.1, 1}});
}

TEST_P(SkippingTest, DoesNotTestCellsIfNearlyAllAreVisible) {
  const auto engine = make_cpu_engine({1, GetParam()});
  for (const int side : {4, 5}) {
    // 27 or 64 of 512 cells are hidden in the middle of each brick, but no whole eighth of a brick.
    const auto hole = [&](int i) { return i % 8 >= 2 && i % 8 < 2 + side; };
    const auto ct = test::make_volume(
        test::centred_grid({33, 33, 33}, {1, 1, 1}),
        [&](int i, int j, int k) { return hole(i) && hole(j) && hole(k) ? -1000 : 500; });
    Scene scene = test::plain_scene(ct, from_tissue_on(), test::frontal(90, 40, false));
    scene.width = scene.height = 50;
    (void)test::draw(*engine, scene);
    scene.camera.eye_ct.mm.x() += 1;
    EXPECT_EQ(test::draw(*engine, scene).statistics.passed_samples > 0, side == 5);
  }
}

TEST_P(SkippingTest, CountsTheSamplesThatVisibleCellsNeed) {
  const auto engine = make_cpu_engine({1, GetParam()});
  // The sheets lie anywhere in a brick and in a run. They are far enough apart for leaps between
  // them, or too near for any.
  for (int first = 16; first < 25; ++first) {
    for (const int between : {5, 6, 7, 8, 9, 10, 30}) {
      const int other = first + between;
      std::vector<std::uint64_t> samples;
      for (const auto& sheets : {std::pair{first, first}, {other, other}, {first, other}}) {
        const auto ct = test::make_volume(
            test::centred_grid({25, 64, 25}, {1, 1, 1}),
            [&](int, int j, int) { return j == sheets.first || j == sheets.second ? 300 : -1000; });
        Scene scene = test::plain_scene(ct, from_tissue_on(), test::frontal(100, 20, true));
        scene.quality.step_voxels = 0.4;
        scene.width = scene.height = 40;
        (void)test::draw(*engine, scene);
        scene.camera.eye_ct.mm.x() += 0.01;
        scene.camera.look_at_ct.mm.x() += 0.01;
        const auto drawn = test::draw(*engine, scene);
        EXPECT_GT(drawn.statistics.passed_samples, 0U);
        samples.push_back(drawn.statistics.volume_samples);
      }
      EXPECT_EQ(samples[2], samples[0] + samples[1]) << first << ' ' << other;
    }
  }
}

TEST_P(SkippingTest, TakesNoSampleWhereTheCutawayHidesTheVolume) {
  const auto ct = test::make_volume(test::centred_grid({48, 48, 48}, {1, 1, 1}),
                                    [](int, int, int) { return 100; });
  const auto haze =
      TransferFunction::create("unimportant", {{0, {1, 1, 1}, 1e-3, 0}, {300, {1, 1, 1}, 1e-3, 0}});
  Scene scene = test::plain_scene(ct, *haze, test::frontal(120, 40, true));
  // The plane fills the view, so half of the volume lies in front of it and nothing is empty.
  scene.plane = test::upright_plane(test::grey_image(60, 60, 120), 1, {0, 0, 30});
  scene.cutaway = Cutaway{};
  const auto engine = make_cpu_engine({1, GetParam()});
  const RenderedImage skipped = test::draw(*engine, scene);
  scene.quality.skip_empty_bricks = false;
  const RenderedImage full = test::draw(*engine, scene);
  EXPECT_TRUE(test::same_bytes(skipped, full));
  EXPECT_GT(full.statistics.volume_samples, 0U);
  EXPECT_LT(skipped.statistics.volume_samples, full.statistics.volume_samples / 4);
}

/// Text that describes a scene, for messages.
std::string description(const Scene& s) {
  std::ostringstream out;
  out << "projection " << static_cast<int>(s.projection) << ", step " << s.quality.step_voxels
      << ", post " << (s.quality.classification == Classification::kPostClassified) << ", windows "
      << s.transfer.uses_gradient() << ", shading " << s.shading.enabled << " style "
      << static_cast<int>(s.shading.style) << " emphasis " << s.shading.emphasis << ", jitter "
      << s.quality.jitter << ", cutaway " << s.cutaway.has_value() << ", orthographic "
      << s.camera.orthographic;
  return out.str();
}

TEST_P(SkippingTest, EmptyAndFullVolumesGiveIdenticalImages) {
  const auto engine = make_cpu_engine({1, GetParam()});
  for (const int hu : {-1000, 40, 900}) {
    const auto ct = test::make_volume(test::centred_grid({33, 25, 17}, {1, 1, 1}),
                                      [&](int, int, int) { return hu; });
    Scene scene{.ct = ct,
                .transfer = *preset_transfer_function("ct-bone"),
                .camera = test::frontal(70, 40, false)};
    scene.width = 33;
    scene.height = 25;
    const RenderedImage skipped = test::draw(*engine, scene);
    scene.quality.skip_empty_bricks = false;
    const RenderedImage full = test::draw(*engine, scene);
    EXPECT_TRUE(test::same_bytes(skipped, full)) << hu;
    if (hu < 900) {
      EXPECT_EQ(skipped.statistics.volume_samples, 0U) << hu;
    }
  }
}

class AgreementTest : public ::testing::TestWithParam<CpuLanes> {};
INSTANTIATE_TEST_SUITE_P(Instructions, AgreementTest, test::every_lanes(), test::lanes_name);

TEST_P(AgreementTest, AgreesWithTheReferenceOnRandomScenes) {
  constexpr float kTwoGreyLevels = 2.0F / 255;
  std::mt19937 random(11);
  const auto engine = make_cpu_engine({0, GetParam()});
  const auto reference = make_reference_engine();
  constexpr int kScenes = 150;
  constexpr float kRounding = 2e-5F;  // Rounding of single precision. Steep colours in noise have
                                      // larger differences.
  int within_rounding = 0;
  for (int i = 0; i < kScenes; ++i) {
    Scene scene = random_scene(random, random_volume(random, random_grid(i)));
    scene.quality.opaque_at = 1;
    const float difference =
        test::max_difference(test::draw(*engine, scene), test::draw(*reference, scene));
    EXPECT_LE(difference, kTwoGreyLevels) << i << ": " << description(scene);
    if (difference <= kRounding) ++within_rounding;
  }
  EXPECT_GE(within_rounding, kScenes * 4 / 5);
}

TEST(CpuEngineTest, ImageDoesNotDependOnTheNumberOfThreads) {
  std::mt19937 random(3);
  const auto one = make_cpu_engine({1});
  const auto two = make_cpu_engine({2});
  for (int i = 0; i < 20; ++i) {
    Scene scene = random_scene(random, random_volume(random, random_grid(i)));
    scene.width = 131;
    scene.height = 97;
    const RenderedImage a = test::draw(*one, scene);
    const RenderedImage b = test::draw(*two, scene);
    ASSERT_TRUE(test::same_bytes(a, b)) << i;
    EXPECT_EQ(a.statistics.volume_samples, b.statistics.volume_samples);
  }
}

TEST(CpuEngineTest, VectorAndPortablePathsAgree) {
  // Fused and separate rounding differ, over whole rays.
  constexpr float kTolerance = 1e-4F;
  constexpr float kRounding = 2e-5F;
  constexpr int kScenes = 200;
  int beyond_rounding = 0;
  const auto vector = make_cpu_engine({0});
  const auto portable = make_cpu_engine({0, CpuLanes::kPortable});
  if (vector->device().substr(0, 3) != "AVX") GTEST_SKIP() << "this processor has no AVX2";
  EXPECT_EQ(portable->device().substr(0, 8), "portable");
  std::mt19937 random(4);
  for (int i = 0; i < kScenes; ++i) {
    Scene scene = random_scene(random, random_volume(random, random_grid(i)));
    scene.quality.opaque_at = 1;  // With early termination, the last bit may decide where a ray
                                  // ends.
    const float difference =
        test::max_difference(test::draw(*vector, scene), test::draw(*portable, scene));
    EXPECT_LT(difference, kTolerance) << i << ": " << description(scene);
    if (difference > kRounding) ++beyond_rounding;
  }
  EXPECT_LE(beyond_rounding, kScenes / 50);
}

TEST(CpuEngineTest, AllVectorInstructionsGiveEqualBytes) {
  const auto eight = make_cpu_engine({0, CpuLanes::kAvx2});
  const auto sixteen = make_cpu_engine({0, CpuLanes::kAvx512});
  if (sixteen->device().substr(0, 7) != "AVX-512") GTEST_SKIP() << "this processor has no AVX-512";
  EXPECT_EQ(eight->device().substr(0, 4), "AVX2");
  std::mt19937 random(14);
  for (int i = 0; i < 120; ++i) {
    const Scene scene = random_scene(random, random_volume(random, random_grid(i)));
    const RenderedImage image = test::draw(*sixteen, scene);
    EXPECT_TRUE(test::same_bytes(test::draw(*eight, scene), image)) << i << description(scene);
  }
}

TEST(CpuEngineTest, PrefetchesVoxelsOfLargeVolumes) {
  struct Row {
    int side;
    double step_voxels;
    MarchPrefetch expected;
  };
  for (const Row& row :
       {Row{144, 0.5, MarchPrefetch::kNone}, Row{145, 0.5, MarchPrefetch::kCorners},
        Row{256, 1, MarchPrefetch::kCorners}, Row{289, 0.5, MarchPrefetch::kAll},
        Row{125, 1.2, MarchPrefetch::kNone}, Row{126, 1.2, MarchPrefetch::kAll}}) {
    Quality quality;
    quality.step_voxels = row.step_voxels;
    const VoxelGrid grid = test::centred_grid({row.side, row.side, row.side}, {1, 1, 1});
    EXPECT_EQ(march_prefetch(grid, quality), row.expected) << row.side << ' ' << row.step_voxels;
  }
}

TEST(CpuEngineTest, PrefetchingDoesNotChangeTheImage) {
  // Noise in more than 3 million voxels. Prefetching also reaches outside of the volume.
  const auto ct = test::make_volume(
      test::centred_grid({150, 145, 142}, {0.5, 0.5, 0.5}),
      [](int i, int j, int k) { return (i * 37 + j * 101 + k * 53) % 400 - 100; });
  const auto reference = make_reference_engine();
  for (const bool orthographic : {false, true}) {
    Scene scene = test::plain_scene(ct, test::fog(0.02), test::frontal(120, 60, orthographic));
    scene.width = 40;
    scene.height = 30;
    for (const double step : {0.5, 1.5}) {
      scene.quality.step_voxels = step;
      const RenderedImage expected = test::draw(*reference, scene);
      ASSERT_GT(std::abs(expected.pixels.at(20, 15).r - scene.background_rgb[0]), 0.05);
      for (const CpuLanes lanes : {CpuLanes::kPortable, CpuLanes::kAvx2, CpuLanes::kAvx512}) {
        const auto engine = make_cpu_engine({0, lanes});
        EXPECT_LT(test::max_difference(test::draw(*engine, scene), expected), 1e-3F)
            << engine->device() << ' ' << orthographic << ' ' << step;
      }
    }
  }
}

TEST(CpuEngineTest, ProjectionsOfGrazingRaysStayWithinTheVolume) {
  // The outer columns look along edges of the box, a millionth of a micrometre inside.
  const auto ct = test::make_volume(test::centred_grid({9, 9, 9}, {1, 1, 1}),
                                    [](int, int, int) { return 100; });
  Scene scene = test::plain_scene(ct, test::fog(0.1), test::frontal(300, 200, true));
  scene.width = scene.height = 16;
  scene.background_rgb.setZero();
  scene.camera.eye_ct = {Eigen::Vector3d(300, 300, 0)};
  scene.camera.orthographic_height_mm = 16 * (4 * std::sqrt(2.0) - 1e-9) / 7.5;
  scene.grey = {100, 200};
  const auto engine = make_cpu_engine();
  for (const Projection projection :
       {Projection::kMaximum, Projection::kMinimum, Projection::kMean}) {
    scene.projection = projection;
    const auto image = engine->render(scene);
    ASSERT_TRUE(test::has_value(image));
    int inside = 0;
    for (int y = 0; y < 16; ++y) {
      for (const int x : {0, 15}) {
        const float grey = image->pixels.at(x, y).r;
        EXPECT_TRUE(grey == 0 || std::abs(grey - 0.5F) < 1e-3F) << x << ' ' << y << ' ' << grey;
        inside += grey > 0 ? 1 : 0;
      }
    }
    EXPECT_GT(inside, 0);
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
    EXPECT_TRUE(test::same_bytes(test::draw(*kept, scene), test::draw(*make_cpu_engine(), scene)));
  }
}

/// Share of the pixels that differ by more than a limit.
double share_beyond(const RenderedImage& a, const RenderedImage& b, float limit) {
  std::size_t beyond = 0;
  for (std::size_t i = 0; i < a.pixels.pixels().size(); ++i) {
    if (test::difference(a.pixels.pixels()[i], b.pixels.pixels()[i]) > limit) ++beyond;
  }
  return static_cast<double>(beyond) / static_cast<double>(a.pixels.pixels().size());
}

TEST(CpuEngineTest, ShadesNoisyTissueAtSeveralPointsOfACell) {
  // Gradients of noise change direction within a voxel. With one point per cell the errors are
  // 0.0108 and 0.0031, with several points 0.0029 and 0.0024.
  std::mt19937 random(1);
  std::normal_distribution<double> noise(40, 30);
  Scene scene = test::plain_scene(test::make_volume(test::centred_grid({24, 24, 24}, {2, 2, 2}),
                                                    [&](int, int, int) { return noise(random); }),
                                  test::fog(0.06, {0.8, 0.6, 0.5}), test::frontal(200, 60, false));
  scene.shading.enabled = true;
  scene.shading.full_gradient_per_mm = 5;
  const auto engine = make_cpu_engine();
  const auto at_step = [&](double voxels) {
    scene.quality.step_voxels = voxels;
    return test::draw(*engine, scene);
  };
  const auto truth = at_step(1.0 / 32);
  const auto coarse = at_step(1);
  EXPECT_LT(rms_difference(coarse.pixels, truth.pixels), 0.006);
  const auto fine = at_step(0.5);
  EXPECT_LT(rms_difference(fine.pixels, truth.pixels), 0.0028);
  EXPECT_GT(coarse.statistics.gradient_samples, coarse.statistics.volume_samples);
  EXPECT_LT(fine.statistics.gradient_samples, 3 * fine.statistics.volume_samples);
}

TEST(CpuEngineTest, AgreesWithTheReferenceOnAnAbdomen) {
  constexpr float kTwoGreyLevels = 2.0F / 255;
  constexpr double kShare = 0.001;
  const auto ct = sim::SyntheticAbdomen::volume(96);
  const auto cpu = make_cpu_engine();
  const auto reference = make_reference_engine();
  for (const char* preset : test::trials({"ct-bone", "ct-soft-tissue", "cta-vessels"})) {
    Camera camera{{{-180, -620, 160}}, {{0, 0, 0}}, {{0, 0, 1}}};
    Scene scene{.ct = ct, .transfer = *preset_transfer_function(preset), .camera = camera};
    scene.plane = test::upright_plane(test::grey_image(150, 120, 120), 1, {-50, -20, 90});
    scene.needle = test::needle({-30, -30, 55}, {-110, -190, 90}, SafetyState::kValid);
    scene.width = 160;
    scene.height = 120;
    const RenderedImage fast = test::draw(*cpu, scene);
    const RenderedImage exact = test::draw(*reference, scene);
    EXPECT_LE(share_beyond(fast, exact, kTwoGreyLevels), kShare) << preset;
    scene.quality.opaque_at = 1;  // Without early termination, only rounding remains.
    scene.shading.enabled = false;
    EXPECT_LE(share_beyond(test::draw(*cpu, scene), test::draw(*reference, scene), 1e-3F), kShare)
        << preset << ", unshaded";
  }
}

}  // namespace
}  // namespace nav::render
