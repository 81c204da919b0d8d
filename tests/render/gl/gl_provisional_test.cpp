// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Tests the images of a new predicate set while its data are being uploaded.

#include "render/skipping/coarse_volumes.hpp"
#include "tests/render/gl/gl_predicate_view.hpp"
#include "tests/render/predicates/predicate_scenes.hpp"

namespace nav::render {
namespace {

using E = PredicateExpression;

constexpr std::size_t kFewBytesAImage = std::size_t{16} << 10U;
constexpr int kMostImages = 200;  // More than any test here needs.

/// Runs with pairs of voxels and with textures.
class GlProvisionalTest : public test::GlPredicateViewTest,
                          public testing::WithParamInterface<bool> {
 protected:
  void SetUp() override {
    test::GlPredicateViewTest::SetUp();
    caster().set_voxel_pairs(GetParam());
    caster().set_bytes_a_image(kFewBytesAImage);
    ct_ = test::small_ultrasound(test::centred_grid({37, 33, 26}, {1, 0.8, 0.9}), 5);
    features_ = test::random_features(ct_, 4);
  }
  /// A scene that moves, with a predicate set.
  Scene asking(std::vector<std::pair<E, double>> entries) {
    Scene scene = test::plain_scene(ct_, test::fog(0.1), test::frontal(80, 30, false));
    scene.width = 48;
    scene.height = 36;
    scene.quality.provisional = true;
    scene.predicates.emplace();
    scene.predicates->model = test::model_of(std::move(entries));
    scene.predicates->features = features_;
    return scene;
  }
  Scene intensity() { return asking({{E::kind("intensity", {0.1, 0.9}), 1}}); }
  Scene features() {
    return asking({{E::kind("snr", {0.3, 0.8}), 2},
                   {E::kind("vesselness", {0.5, 1}), 3},
                   {E::all({E::kind("label", {1}), E::kind("intensity", {0.05, 1})}), 1}});
  }
  Scene confidence() { return asking({{E::kind("confidence", {0.4, 0.9}), 1}}); }
  /// Number of provisional images until the image is complete. last_ is then the complete image.
  int images_until_whole(const Scene& scene) {
    int images = 0;
    do {
      last_ = draw(scene);
    } while (last_.statistics.provisional && ++images < kMostImages);
    return images;
  }
  /// Returns the image of a caster that must not draw provisionally.
  std::vector<RgbaF> whole(Scene scene) {
    scene.quality.provisional = false;
    other_ = std::make_unique<SceneView>(window_->window());
    other_->raycaster().set_settled_after(0);
    other_->raycaster().set_voxel_pairs(GetParam());
    return draw_anew(scene);
  }
  void expect_whole(const Scene& scene) {
    EXPECT_FALSE(last_.statistics.provisional);
    EXPECT_TRUE(test::same_bits(caster().read(), whole(scene)));
  }
  int uploads() { return caster().predicates().features().uploads(); }

  std::shared_ptr<const StoredVolume> ct_;
  Features features_;
  RenderedImage last_{{1, 1, {RgbaF{}}}, {}};
};

INSTANTIATE_TEST_SUITE_P(Memory, GlProvisionalTest, testing::Bool());

TEST_P(GlProvisionalTest, TheCompleteImageHasEqualBytes) {
  std::mt19937 random(3);
  int provisional = 0;
  for (int i = 0; i < 6; ++i) {
    Scene scene = test::random_predicate_scene(random, ct_, features_);
    scene.quality.provisional = true;
    const int images = images_until_whole(scene);
    ASSERT_LT(images, kMostImages) << i;
    provisional += images;
    expect_whole(scene);
  }
  EXPECT_GT(provisional, 10);
}

TEST_P(GlProvisionalTest, UploadingEndsAfterAsManyImagesAsThereAreParts) {
  draw(intensity());
  const std::size_t voxels = ct_->grid().voxel_count();
  // Two features, marks of voxels without a value, labels, and two ranges of bricks to search. A
  // texture holds four components.
  const std::size_t bytes = voxels * (2 * (GetParam() ? 4 : 8) + 2 + 4 + 2 * 2);
  const auto parts = static_cast<int>(bytes / kFewBytesAImage);
  const int images = images_until_whole(features());
  EXPECT_LE(images, parts + 2);
  EXPECT_GE(images, parts / 2);
  expect_whole(features());
}

TEST_P(GlProvisionalTest, NothingIsUploadedBeforeTheFirstImage) {
  draw(intensity());
  const int before = uploads();
  EXPECT_TRUE(draw(features()).statistics.provisional);
  EXPECT_EQ(uploads(), before);
  draw(features());
  EXPECT_GT(uploads(), before);
}

TEST_P(GlProvisionalTest, ProvisionalImagesUseCoarseVolumes) {
  draw(intensity());
  const Scene scene = features();
  const RenderedImage found = draw(scene);
  EXPECT_TRUE(found.statistics.provisional);
  const auto set = PredicateSet::create(*scene.predicates, ct_, position_of(scene));
  ASSERT_TRUE(test::has_value(set));
  const RenderedImage expected = test::draw(*reference_, CoarseVolumes().of(scene, *set));
  EXPECT_LE(test::difference(found.pixels, expected.pixels, 2).fraction_above, 0.002);
  EXPECT_GT(test::difference(found.pixels, test::draw(*reference_, scene).pixels, 2).fraction_above,
            0.1)
      << "not to be told from the whole one";
}

TEST_P(GlProvisionalTest, ProvisionalImagesAreNeitherKeptNorDrawnTwice) {
  draw(intensity());
  Scene scene = features();
  const std::vector<RgbaF> first = (draw(scene), caster().read());
  const RenderedImage again = draw(scene);
  EXPECT_TRUE(again.statistics.provisional);
  EXPECT_EQ(again.statistics.volume_samples, 0U);
  EXPECT_TRUE(test::same_bits(caster().read(), first));
  scene.camera.eye_ct.mm.x() += 1;
  EXPECT_GT(draw(scene).statistics.volume_samples, 0U) << "moved";
  // Requested in full, whatever is still missing.
  scene.quality.provisional = false;
  last_ = draw(scene);
  EXPECT_GT(last_.statistics.volume_samples, 0U);
  expect_whole(scene);
  scene.quality.provisional = true;
  last_ = draw(scene);
  EXPECT_EQ(last_.statistics.volume_samples, 0U) << "it is there";
  expect_whole(scene);
}

TEST_P(GlProvisionalTest, HandlesPredicateSetsThatChangeDuringTheUpload) {
  draw(intensity());
  for (int i = 0; i < 4; ++i) {
    for (const Scene& scene : {features(), confidence(), features()}) {
      EXPECT_TRUE(draw(scene).statistics.provisional || i > 0);
    }
  }
  // One predicate set needs no upload, and one changes in the middle.
  last_ = draw(intensity());
  expect_whole(intensity());
  draw(features());
  last_ = draw(intensity());
  expect_whole(intensity());
  EXPECT_LT(images_until_whole(confidence()), kMostImages);
  expect_whole(confidence());
  EXPECT_LT(images_until_whole(features()), kMostImages);
  expect_whole(features());
}

TEST_P(GlProvisionalTest, HandlesFeaturesThatChangeDuringTheUpload) {
  draw(intensity());
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(draw(features()).statistics.provisional);
  features_ = test::random_features(ct_, 9);
  EXPECT_TRUE(draw(features()).statistics.provisional);
  EXPECT_LT(images_until_whole(features()), kMostImages);
  expect_whole(features());
}

TEST_P(GlProvisionalTest, DataOnTheDeviceAreNotUploadedAgain) {
  draw(intensity());
  images_until_whole(features());
  const int sent = uploads();
  const int alone = images_until_whole(asking({{E::kind("vesselness", {0.2, 1}), 1}}));
  EXPECT_EQ(alone, 0);
  EXPECT_EQ(uploads(), sent);
  EXPECT_EQ(images_until_whole(intensity()), 0);
  EXPECT_EQ(images_until_whole(features()), 0);
  EXPECT_EQ(uploads(), sent);
}

TEST_P(GlProvisionalTest, ANewVolumeIsCompleteAtOnce) {
  EXPECT_EQ(images_until_whole(features()), 0);
  expect_whole(features());
  draw(intensity());
  ct_ = test::small_ultrasound(ct_->grid(), 7);
  features_ = test::random_features(ct_, 8);
  EXPECT_EQ(images_until_whole(features()), 0);
  expect_whole(features());
}

TEST_P(GlProvisionalTest, CoarseVolumesAreFreedWhenTheUploadEnds) {
  draw(intensity());
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(draw(features()).statistics.provisional);
  const std::weak_ptr<const StoredVolume> snr = features_.volumes.at(feature::kSnr).codes();
  const std::weak_ptr<const StoredVolume> volume = ct_;
  ct_ = test::small_ultrasound(ct_->grid(), 7);
  features_ = test::random_features(ct_, 8);
  draw(intensity());
  EXPECT_TRUE(snr.expired());
  EXPECT_TRUE(volume.expired());
}

}  // namespace
}  // namespace nav::render
