// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Tests the images of the CPU engine for a new predicate set while its data are being prepared.

#include <gtest/gtest.h>

#include "render/engine.hpp"
#include "render/skipping/coarse_volumes.hpp"
#include "tests/render/predicates/predicate_scenes.hpp"

namespace nav::render {
namespace {

using E = PredicateExpression;

constexpr int kMostImages = 20;  // More than any test here needs.

class CpuProvisionalTest : public ::testing::Test {
 protected:
  /// Copies and ranges of two features of this volume take longer than one image may wait.
  static void SetUpTestSuite() {
    ct_ = test::small_ultrasound(test::centred_grid({250, 136, 132}, {0.2, 0.3, 0.3}), 5);
    features_ = test::random_features(ct_, 4);
    inside_ = test::make_volume(test::centred_grid({31, 31, 31}, {2, 2, 2}), [](int i, int, int k) {
      return 100 * std::sin(0.5 * i) * std::cos(0.4 * k);
    });
  }
  static void TearDownTestSuite() {
    ct_.reset();
    inside_.reset();
    features_ = {};
  }
  static Scene asking(std::vector<std::pair<E, double>> entries) {
    Scene scene = test::plain_scene(ct_, test::fog(0.1), test::frontal(80, 40, false));
    scene.width = 40;
    scene.height = 30;
    scene.quality.provisional = true;
    scene.plane = test::upright_plane(test::grey_image(20, 16, 120), 1, {0, 0, 0});
    scene.plane->opacity = 0.5;
    scene.predicates.emplace();
    scene.predicates->model = test::model_of(std::move(entries));
    scene.predicates->features = features_;
    return scene;
  }
  static Scene intensity() { return asking({{E::kind("intensity", {0.1, 0.9}), 1}}); }
  static Scene features() {
    return asking({{E::kind("snr", {0.3, 0.8}), 2},
                   {E::kind("vesselness", {0.5, 1}), 3},
                   {E::all({E::kind("label", {1}), E::kind("intensity", {0.05, 1})}), 1}});
  }
  static Scene other_features() {
    return asking({{E::kind("snr", {0.1, 0.5}), 2}, {E::kind("confidence", {0.4, 0.9}), 1}});
  }
  /// Moves the volume of a scene into a CT as its ultrasound volume.
  static Scene beside_ct(Scene scene) {
    scene.ultrasound = UltrasoundVolume{ct_, *scene.predicates, 1};
    scene.predicates.reset();
    scene.ct = inside_;
    return scene;
  }
  RenderedImage draw(const Scene& scene) { return test::draw(*engine_, scene); }
  /// Returns the image of an engine that must not draw provisionally.
  static RenderedImage whole(Scene scene) {
    scene.quality.provisional = false;
    return test::draw(*make_cpu_engine({1}), scene);
  }
  /// Number of provisional images until the image is complete. Expects that it has the right bytes.
  int images_until_whole(const Scene& scene) {
    for (int images = 0; images < kMostImages; ++images) {
      const RenderedImage image = draw(scene);
      if (image.statistics.provisional) continue;
      EXPECT_TRUE(test::same_bytes(image, whole(scene)));
      return images;
    }
    return kMostImages;
  }

  static std::shared_ptr<const StoredVolume> ct_;
  static std::shared_ptr<const StoredVolume> inside_;
  static Features features_;
  std::unique_ptr<Engine> engine_ = make_cpu_engine({2});
};

std::shared_ptr<const StoredVolume> CpuProvisionalTest::ct_;
std::shared_ptr<const StoredVolume> CpuProvisionalTest::inside_;
Features CpuProvisionalTest::features_;

TEST_F(CpuProvisionalTest, TheCompleteImageFollowsWithEqualBytes) {
  EXPECT_EQ(images_until_whole(intensity()), 0) << "a new volume";
  const int images = images_until_whole(features());
  EXPECT_GE(images, 2);
  EXPECT_LT(images, 6);
  EXPECT_EQ(images_until_whole(intensity()), 0);
}

TEST_F(CpuProvisionalTest, ProvisionalImagesUseCoarseVolumes) {
  draw(intensity());
  const Scene scene = features();
  const RenderedImage found = draw(scene);
  EXPECT_TRUE(found.statistics.provisional);
  const auto set = PredicateSet::create(*scene.predicates, ct_, position_of(scene));
  ASSERT_TRUE(test::has_value(set));
  EXPECT_TRUE(test::same_bytes(found, whole(CoarseVolumes().of(scene, *set))));
  EXPECT_FALSE(test::same_bytes(found, whole(scene)));
}

TEST_F(CpuProvisionalTest, ProvisionalImagesAreNeitherKeptNorDrawnTwice) {
  draw(intensity());
  Scene scene = features();
  const RenderedImage first = draw(scene);
  const RenderedImage again = draw(scene);
  EXPECT_TRUE(first.statistics.provisional && again.statistics.provisional);
  EXPECT_GT(first.statistics.volume_samples, 0U);
  EXPECT_EQ(again.statistics.volume_samples, 0U);
  EXPECT_TRUE(test::same_bytes(first, again));
  // Requested in full, whatever is still missing.
  scene.quality.provisional = false;
  const RenderedImage full = draw(scene);
  EXPECT_FALSE(full.statistics.provisional);
  EXPECT_TRUE(test::same_bytes(full, whole(scene)));
  scene.quality.provisional = true;
  EXPECT_EQ(draw(scene).statistics.volume_samples, 0U) << "it is there";
  EXPECT_EQ(images_until_whole(scene), 0);
}

TEST_F(CpuProvisionalTest, HandlesPredicateSetsThatChangeDuringPreparation) {
  draw(intensity());
  for (const Scene& scene : {features(), other_features(), features()}) {
    EXPECT_TRUE(draw(scene).statistics.provisional);
  }
  EXPECT_EQ(images_until_whole(intensity()), 0);
  EXPECT_LT(images_until_whole(other_features()), kMostImages);
  EXPECT_LT(images_until_whole(features()), kMostImages);
}

TEST_F(CpuProvisionalTest, BesideACtOnlyTheUltrasoundIsCoarse) {
  EXPECT_EQ(images_until_whole(beside_ct(intensity())), 0) << "a new volume";
  const Scene alone = features();
  const Scene scene = beside_ct(alone);
  const RenderedImage found = draw(scene);
  EXPECT_TRUE(found.statistics.provisional);
  const auto set = PredicateSet::create(*alone.predicates, ct_, position_of(alone));
  ASSERT_TRUE(test::has_value(set));
  const Scene coarse = CoarseVolumes().of(alone, *set);
  Scene expected = scene;
  expected.ultrasound->volume = coarse.ct;
  expected.ultrasound->predicates = *coarse.predicates;
  EXPECT_TRUE(test::same_bytes(found, whole(expected)));
  EXPECT_FALSE(test::same_bytes(found, whole(scene)));
  EXPECT_EQ(draw(scene).statistics.volume_samples, 0U) << "drawn twice";
  const int images = images_until_whole(scene);
  EXPECT_GE(images, 1);
  EXPECT_LT(images, 6);
}

}  // namespace
}  // namespace nav::render
