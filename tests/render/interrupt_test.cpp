// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Interrupted images leave an engine as if they had never been asked for.
#include <atomic>
#include <functional>
#include <gtest/gtest.h>

#include "render/quality/sparse_rays.hpp"
#include "tests/render/predicates/two_volume_scenes.hpp"

namespace nav::render {
namespace {

struct InterruptCase {
  std::string name;
  std::function<std::unique_ptr<Engine>()> engine;
  std::function<Scene()> scene;
  int stride;  ///< Every how many questions an image is interrupted.
};
void PrintTo(const InterruptCase& c, std::ostream* out) { *out << c.name; }

/// Blobs in air, cut around a plane, with a needle.
Scene wavy_scene() {
  const auto ct =
      test::make_volume(test::centred_grid({40, 36, 33}, {1.0, 1.2, 1.5}), [](int i, int j, int k) {
        return 300 * std::sin(0.35 * i) * std::cos(0.3 * j) * std::sin(0.4 * k + 1) - 50;
      });
  Scene scene = test::plain_scene(ct, test::solid({0.9, 0.4, 0.2}), test::frontal(120, 60, false));
  scene.transfer = *TransferFunction::create("tissue", {{-200, {0.9, 0.7, 0.5}, 0, 0.1},
                                                        {0, {0.9, 0.7, 0.5}, 0.05, 0.1},
                                                        {200, {1, 0.2, 0.1}, 0.6, 1}});
  scene.quality.opaque_at = 0.99;
  scene.width = 97;
  scene.height = 71;
  scene.background_rgb = {0.1, 0.2, 0.3};
  scene.plane = test::upright_plane(test::grey_image(64, 48, 120), 0.5, {0, 0, 12});
  scene.needle = test::needle({0, 0, 0}, {20, -20, 20});
  scene.cutaway.emplace();
  scene.cutaway->overlay_mm = 4;
  return scene;
}

Scene sparse_waves() {
  Scene scene = wavy_scene();
  scene.camera =
      test::frontal(120, 25, false);  // Near, so that a lattice of rays is narrow enough.
  scene.quality.pixel_error = 0.1;
  EXPECT_TRUE(sparse_rays(scene).has_value());
  return scene;
}

Scene predicate_waves() {
  const auto ultrasound = test::small_ultrasound(test::centred_grid({25, 23, 21}, {1, 1, 1}), 5);
  std::mt19937 random(4);
  Scene scene =
      test::random_predicate_scene(random, ultrasound, test::random_features(ultrasound, 4));
  scene.width = 97;
  scene.height = 71;
  scene.plane = test::upright_plane(test::grey_image(20, 16, 120), 1, {0, 0, 0});
  return scene;
}

Scene two_in_one() {
  std::mt19937 random(7);
  Scene scene = test::random_two(random, 1);
  scene.width = 97;
  scene.height = 71;
  scene.plane = test::upright_plane(test::grey_image(20, 16, 120), 1, {0, 0, 0});
  return scene;
}

void move_plane(Scene& scene) { scene.plane->frame.grid.origin_mm.x() += 3; }
void move_camera(Scene& scene) { scene.camera.eye_ct.mm.x() += 20; }
void new_pixels(Scene& scene) {
  const auto& before = scene.plane->frame.pixels;
  scene.plane->frame.pixels = test::grey_image(before.width(), before.height(), 200);
}
void smaller(Scene& scene) { scene.width = 61; }
void nothing(Scene& /*scene*/) {}

class InterruptTest : public ::testing::TestWithParam<InterruptCase> {
 protected:
  /// Draws a scene, and gives up at a question, counted from 1. False: there were fewer questions,
  /// and the image is whole.
  static bool interrupt(Engine& engine, const Scene& scene, int at) {
    std::atomic<int> questions{0};
    const auto image = engine.render(scene, Interrupt([&] { return ++questions >= at; }));
    if (image) return false;
    EXPECT_EQ(image.error().code, ErrorCode::kCancelled);
    EXPECT_NE(image.error().message.find("interrupted"), std::string::npos);
    return true;
  }
  using Change = void (*)(Scene&);
};

TEST_P(InterruptTest, TheNextImageHasTheBytesOfAnEngineThatWasNeverInterrupted) {
  for (const Change interrupted : {&move_plane, &move_camera, &smaller}) {
    for (const Change next : {&nothing, &move_plane, &move_camera, &new_pixels}) {
      Scene scene = GetParam().scene();
      interrupted(scene);
      next(scene);
      const RenderedImage expected = test::draw(*GetParam().engine(), scene);
      const auto engine = GetParam().engine();
      int times = 0;
      for (int at = 1;; at += GetParam().stride) {
        scene = GetParam().scene();
        test::draw(*engine, scene);
        interrupted(scene);
        if (!interrupt(*engine, scene, at)) break;
        ++times;
        next(scene);
        ASSERT_TRUE(test::same_bytes(test::draw(*engine, scene), expected)) << at;
      }
      EXPECT_GT(times, 1);
    }
  }
}

TEST_P(InterruptTest, SeveralInterruptedImagesInARowChangeNothing) {
  const auto engine = GetParam().engine();
  Scene scene = GetParam().scene();
  test::draw(*engine, scene);
  for (const Change change : {&move_plane, &move_camera, &move_plane, &new_pixels, &move_plane}) {
    change(scene);
    interrupt(*engine, scene, 2);
  }
  EXPECT_TRUE(
      test::same_bytes(test::draw(*engine, scene), test::draw(*GetParam().engine(), scene)));
}

TEST_P(InterruptTest, AnImageThatIsWantedIsDrawn) {
  const auto engine = GetParam().engine();
  const Scene scene = GetParam().scene();
  std::atomic<int> questions{0};
  const auto image = engine->render(scene, Interrupt([&] {
                                      ++questions;
                                      return false;
                                    }));
  ASSERT_TRUE(test::has_value(image));
  EXPECT_GT(questions, 1);
  EXPECT_TRUE(test::same_bytes(*image, test::draw(*GetParam().engine(), scene)));
}

std::unique_ptr<Engine> one_thread() { return make_cpu_engine({1}); }
std::unique_ptr<Engine> two_threads() { return make_cpu_engine({2}); }
std::unique_ptr<Engine> reference() { return make_reference_engine({2}); }

INSTANTIATE_TEST_SUITE_P(
    Engines, InterruptTest,
    ::testing::Values(InterruptCase{"one_thread", one_thread, wavy_scene, 1},
                      InterruptCase{"two_threads", two_threads, wavy_scene, 2},
                      InterruptCase{"sparse_rays", one_thread, sparse_waves, 3},
                      InterruptCase{"sparse_rays_two_threads", two_threads, sparse_waves, 5},
                      InterruptCase{"predicates", two_threads, predicate_waves, 2},
                      InterruptCase{"two_volumes", two_threads, two_in_one, 3},
                      InterruptCase{"reference", reference, wavy_scene, 30}),
    [](const auto& each) { return each.param.name; });

TEST(InterruptedRaysTest, RaysOfAnInterruptedImageAreKeptWhileTheViewRests) {
  const auto engine = make_cpu_engine({1});
  Scene scene = wavy_scene();
  scene.cutaway.reset();
  const auto all = test::draw(*engine, scene).statistics.rays;
  for (int i = 0; i < 3; ++i) {
    move_plane(scene);
    EXPECT_FALSE(engine->render(scene, Interrupt([] { return true; })));
  }
  const auto image = test::draw(*engine, scene);
  EXPECT_GT(image.statistics.rays, 0U);
  EXPECT_LT(image.statistics.rays, all / 2);
}

}  // namespace
}  // namespace nav::render
