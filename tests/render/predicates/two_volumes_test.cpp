// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Tests a CT with a 3D ultrasound volume in it. See "Two volumes" in ray_spec.hpp.
#include "render/two_volumes.hpp"

#include "render/scene_compare.hpp"
#include "tests/render/predicates/two_volume_scenes.hpp"

namespace nav::render {
namespace {

/// A CT with a bright slab, y from -6 to -4 mm. The rest is air.
std::shared_ptr<const StoredVolume> slab_in_front() {
  return test::make_volume(test::centred_grid({31, 31, 31}, {1, 1, 1}),
                           [](int, int j, int) { return j >= 9 && j <= 11 ? 1000 : -1000; });
}

class TwoVolumesTest : public test::EngineTest {};
INSTANTIATE_TEST_SUITE_P(Engines, TwoVolumesTest, ::testing::ValuesIn(test::engine_cases()),
                         [](const auto& engine) { return std::string(engine.param.name); });

TEST_P(TwoVolumesTest, TwoMediaAtOnePositionMixWithSecondOrder) {
  Scene scene = test::fog_scene(test::centred_grid({31, 31, 31}, {1, 1, 1}), 0.08);
  const double tau = 0.08 + test::grey_tau();
  const double alpha = -std::expm1(-tau * 30);
  const double red = alpha * (0.08 * 1 + test::grey_tau() * test::kGrey) / tau;
  const double blue = alpha * (0.08 * 0.25 + test::grey_tau() * test::kGrey) / tau;
  for (const double step : {2.0, 1.0, 0.5, 0.25, 0.125}) {
    scene.quality.step_voxels = step;
    const RgbaF pixel = test::middle(test::draw(*engine_, scene));
    const double error = std::max(std::abs(pixel.r - red), std::abs(pixel.b - blue));
    // The order of two media in one slab has this error. Pairs of slabs cancel it.
    EXPECT_LT(error, 0.5 * 0.08 * test::grey_tau() * step * step + 2e-5) << step;
  }
}

TEST_P(TwoVolumesTest, AVolumeOutsideTheOtherIsCompositedInExactOrder) {
  // Ultrasound of 4 mm thickness, first in front of the box of the CT, then behind it.
  for (const double y : {-25.0, 25.0}) {
    VoxelGrid thin = test::centred_grid({31, 9, 31}, {1, 0.5, 1});
    thin.origin_mm.y() += y;
    const Scene scene = test::fog_scene(thin, 0.05);
    const double fog = -std::expm1(-0.05 * 30);
    const double grey = -std::expm1(-test::grey_tau() * 4);
    const double expected =
        y < 0 ? grey * test::kGrey + (1 - grey) * fog : fog + (1 - fog) * grey * test::kGrey;
    EXPECT_NEAR(test::middle(test::draw(*engine_, scene)).r, expected, 2e-5) << y;
  }
}

TEST_P(TwoVolumesTest, ImportanceDecidesWhetherUltrasoundShinesThroughTheCt) {
  VoxelGrid behind = test::centred_grid({31, 21, 31}, {1, 0.5, 1});
  behind.origin_mm.y() += 3;
  Scene scene = test::fog_scene(behind, 0);
  scene.ct = slab_in_front();
  scene.transfer = test::solid({1, 0, 0});
  scene.ultrasound->predicates.opacity_length_mm = 0.2;
  const RgbaF hidden = test::middle(test::draw(*engine_, scene));
  EXPECT_NEAR(hidden.r, 1, 1e-3);
  EXPECT_NEAR(hidden.b, 0, 1e-3);
  scene.ultrasound->ct_importance = 0;
  // One predicate has impact 1, so the bone keeps exp(-1) of its weight.
  const double kept = std::exp(-1.0);
  const RgbaF shown = test::middle(test::draw(*engine_, scene));
  EXPECT_NEAR(shown.b, (1 - kept) * test::kGrey, 2e-3);
  EXPECT_NEAR(shown.r, kept + (1 - kept) * test::kGrey, 2e-3);
}

TEST_P(TwoVolumesTest, InvisibleUltrasoundDoesNotChangeTheCt) {
  Scene scene = test::fog_scene(test::centred_grid({21, 21, 21}, {0.7, 0.9, 0.8}), 0.1);
  scene.ultrasound->volume =
      test::make_volume(scene.ultrasound->volume->grid(), [](int, int, int) { return 0; });
  scene.plane = test::upright_plane(test::grey_image(8, 8, 200), 1, {0, 2, 4});
  scene.plane->opacity = 0.5;
  const RenderedImage both = test::draw(*engine_, scene);
  scene.ultrasound.reset();
  EXPECT_LT(test::max_difference(both, test::draw(*engine_, scene)), 2e-5F);
}

TEST_P(TwoVolumesTest, ProjectionsIgnoreTheUltrasound) {
  Scene scene = test::fog_scene(test::centred_grid({21, 21, 21}, {1, 1, 1}), 0.1);
  scene.projection = Projection::kMean;
  const RenderedImage both = test::draw(*engine_, scene);
  scene.ultrasound.reset();
  EXPECT_TRUE(test::same_bytes(both, test::draw(*engine_, scene)));
}

class TwoVolumesCpuTest : public ::testing::TestWithParam<CpuLanes> {};
INSTANTIATE_TEST_SUITE_P(Instructions, TwoVolumesCpuTest, test::every_lanes(), test::lanes_name);

TEST_P(TwoVolumesCpuTest, AgreesWithTheReferenceOnRandomScenes) {
  constexpr float kTwoGreyLevels = 2.0F / 255;
  std::mt19937 random(21);
  const auto engine = make_cpu_engine({0, GetParam()});
  const auto reference = make_reference_engine();
  constexpr int kScenes = 24;
  double beyond = 0;
  for (int i = 0; i < kScenes; ++i) {
    const Scene scene = test::random_two(random, i);
    const RenderedImage fast = test::draw(*engine, scene);
    const RenderedImage exact = test::draw(*reference, scene);
    const auto pixels = fast.pixels.pixels();
    double here = 0;
    for (std::size_t p = 0; p < pixels.size(); ++p) {
      here += test::difference(pixels[p], exact.pixels.pixels()[p]) > kTwoGreyLevels ? 1 : 0;
    }
    here /= static_cast<double>(pixels.size());
    EXPECT_LT(here, 0.02) << i;
    beyond += here / kScenes;
  }
  EXPECT_LE(beyond, 0.003);  // Values that lie at an end of a range, except for rounding.
}

TEST_P(TwoVolumesCpuTest, SkippingIsBitIdenticalToNotSkipping) {
  std::mt19937 random(3);
  const auto engine = make_cpu_engine({1, GetParam()});
  std::uint64_t with = 0;
  std::uint64_t without = 0;
  for (int i = 0; i < 24; ++i) {
    Scene scene = test::random_two(random, i);
    const RenderedImage skipped = test::draw(*engine, scene);
    scene.quality.skip_empty_bricks = false;
    const RenderedImage full = test::draw(*engine, scene);
    ASSERT_TRUE(test::same_bytes(skipped, full)) << i;
    with += skipped.statistics.volume_samples;
    without += full.statistics.volume_samples;
  }
  EXPECT_LT(with, without);
}

TEST_P(TwoVolumesCpuTest, EarlyTerminationStaysWithinItsError) {
  std::mt19937 random(8);
  const auto engine = make_cpu_engine({0, GetParam()});
  float worst = 0;
  std::uint64_t with = 0;
  std::uint64_t without = 0;
  for (int i = 0; i < 24; ++i) {
    Scene scene = test::random_two(random, i);
    scene.ultrasound->predicates.opacity_length_mm = 0.15;
    const RenderedImage full = test::draw(*engine, scene);
    scene.ultrasound->predicates.termination_error = 1.0 / 255;
    const RenderedImage fast = test::draw(*engine, scene);
    worst = std::max(worst, test::max_difference(fast, full));
    with += fast.statistics.volume_samples;
    without += full.statistics.volume_samples;
  }
  EXPECT_LE(worst, 1.0F / 255 + 1e-5F);
  EXPECT_LT(with, without);
}

TEST_P(TwoVolumesCpuTest, MeshesOfManyTrianglesCutBothVolumes) {
  auto ball = std::make_shared<MeshObject>();
  constexpr int kAround = 24;
  constexpr int kRings = 12;
  for (int ring = 0; ring <= kRings; ++ring) {
    for (int i = 0; i < kAround; ++i) {
      const double polar = M_PI * ring / kRings;
      const double azimuth = 2 * M_PI * i / kAround;
      ball->vertices_ct.push_back(
          {4 * Eigen::Vector3d(std::sin(polar) * std::cos(azimuth),
                               std::sin(polar) * std::sin(azimuth), std::cos(polar))});
      const int next = (i + 1) % kAround;
      if (ring == kRings) continue;
      const int here = ring * kAround;
      ball->triangles.push_back({here + i, here + next, here + kAround + i});
      ball->triangles.push_back({here + next, here + kAround + next, here + kAround + i});
    }
  }
  std::mt19937 random(5);
  const auto engine = make_cpu_engine({0, GetParam()});
  Scene scene = test::random_two(random, 1);
  scene.cutaway.emplace();
  const RenderedImage uncut = test::draw(*engine, scene);
  scene.cutaway->meshes.push_back(ball);
  const RenderedImage cut = test::draw(*engine, scene);
  EXPECT_GT(test::max_difference(uncut, cut), 0.05F);
  EXPECT_LT(test::max_difference(cut, test::draw(*make_reference_engine(), scene)), 0.02F);
}

TEST(TwoVolumes, ANewUltrasoundOrImportanceChangesTheView) {
  const Scene before = test::fog_scene(test::centred_grid({9, 9, 9}, {1, 1, 1}), 0.1);
  Scene after = before;
  EXPECT_EQ(change_between(before, after), SceneChange::kNothing);
  after.ultrasound->ct_importance = 0.5;
  EXPECT_EQ(change_between(before, after), SceneChange::kView);
  after = before;
  after.ultrasound->volume = std::make_shared<StoredVolume>(*before.ultrasound->volume);
  EXPECT_EQ(change_between(before, after), SceneChange::kView);
  after.ultrasound.reset();
  EXPECT_EQ(change_between(before, after), SceneChange::kView);
}

TEST(TwoVolumes, ASlabHasTheSizeOfTheCoarserVolume) {
  Scene scene = test::fog_scene(test::centred_grid({9, 9, 9}, {1, 1, 1}), 0.1);
  scene.quality.step_voxels = 0.5;
  for (const double mm : {0.25, 3.0}) {
    scene.ultrasound->volume = test::make_volume(test::centred_grid({9, 9, 9}, {mm, mm, mm}),
                                                 [](int, int, int) { return 0; });
    EXPECT_EQ(slab_mm(scene), 0.5 * std::max(mm, 1.0));
  }
}

TEST(TwoVolumes, RejectsInvalidScenes) {
  const Scene good = test::fog_scene(test::centred_grid({9, 9, 9}, {1, 1, 1}), 0.1);
  EXPECT_TRUE(test::has_value(validate(good)));
  const auto message = [](const Scene& scene) {
    const auto ok = validate(scene);
    return ok ? std::string() : ok.error().message;
  };
  Scene bad = good;
  bad.ultrasound->volume.reset();
  EXPECT_EQ(message(bad), "ultrasound.volume: expected a volume, found none");
  bad = good;
  bad.ultrasound->ct_importance = std::nan("");
  EXPECT_EQ(message(bad), "ultrasound.ct_importance: expected a number in [0, 1024], found nan");
  bad = good;
  bad.predicates = good.ultrasound->predicates;
  EXPECT_EQ(message(bad),
            "ultrasound: expected no predicates of the CT together with it, found both");
  bad = good;
  VoxelGrid far = good.ct->grid();
  far.origin_mm.x() = 2e7;
  bad.ultrasound->volume = test::make_volume(far, [](int, int, int) { return 0; });
  EXPECT_THAT(message(bad), ::testing::StartsWith("ultrasound.volume.grid.origin_mm"));
  bad = good;
  bad.ultrasound->predicates.opacity_length_mm = 0;
  EXPECT_THAT(message(bad), ::testing::StartsWith("ultrasound.predicates.opacity_length_mm"));
}

}  // namespace
}  // namespace nav::render
