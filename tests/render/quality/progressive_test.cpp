// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/quality/progressive.hpp"

#include <gtest/gtest.h>

#include "tests/render/scene_support.hpp"

namespace nav::render {
namespace {

/// Records each request. Each image is a ramp and takes the given time.
class SlowEngine final : public Engine {
 public:
  [[nodiscard]] std::string name() const override { return "slow"; }
  [[nodiscard]] std::string device() const override { return "test"; }
  Result<RenderedImage> render_image(const Scene& scene, const Interrupt& interrupt) override {
    asked = {scene.width, scene.height};
    asked_pixel_error = scene.quality.pixel_error;
    asked_ct = scene.ct;
    ++images;
    may_be_interrupted = interrupt.possible();
    if (interrupt.requested()) return Error{ErrorCode::kCancelled, "interrupted"};
    std::vector<RgbaF> pixels;
    for (int y = 0; y < scene.height; ++y) {
      for (int x = 0; x < scene.width; ++x) {
        // A ramp over the view, not over the pixels.
        const auto u = static_cast<float>((x + 0.5 - 0.5 * scene.width) / scene.height);
        const auto v = static_cast<float>((y + 0.5) / scene.height);
        pixels.push_back({0.5F + 0.25F * u, 0.5F * v, 0, 1});
      }
    }
    RenderedImage image{{scene.width, scene.height, std::move(pixels)}, {}};
    image.statistics.cast_s = asked_pixel_error > 0 ? sparse_s : takes_s;
    image.statistics.provisional = sends && scene.quality.provisional;
    return image;
  }
  std::pair<int, int> asked;
  double asked_pixel_error = 0;
  double takes_s = 0.2;
  double sparse_s = 0.1;
  std::shared_ptr<const StoredVolume> asked_ct;
  int images = 0;
  bool may_be_interrupted = false;
  bool sends = false;  ///< True if the engine sends what images need.
};

Scene scene() {
  const auto ct = test::make_volume(test::centred_grid({4, 4, 4}, {1, 1, 1}),
                                    [](int, int, int) { return 0.0; });
  Scene scene = test::plain_scene(ct, test::fog(0.1), test::frontal(100, 10, false));
  scene.width = 81;
  scene.height = 61;
  scene.plane = test::upright_plane(test::grey_image(4, 4, 100), 1, {0, 0, 0});
  return scene;
}

Timestamp at(double seconds) { return Timestamp(from_seconds(seconds)); }

class ProgressiveTest : public ::testing::Test {
 protected:
  bool draw(double seconds) {
    auto image = progressive_.draw(scene_, at(seconds));
    EXPECT_TRUE(test::has_value(image));
    EXPECT_EQ(image->image.pixels.width(), scene_.width);
    EXPECT_EQ(image->image.pixels.height(), scene_.height);
    return image->refined;
  }
  void turn() { scene_.camera = orbited(scene_.camera); }
  static Camera orbited(Camera camera) {
    camera.eye_ct.mm.x() += 1;
    return camera;
  }
  SlowEngine engine_;
  ProgressiveRenderer progressive_{engine_};
  Scene scene_ = scene();
};

TEST_F(ProgressiveTest, DrawsCoarselyWhileTheViewMovesAndInFullAfterwards) {
  EXPECT_TRUE(draw(0));  // The cost is not known yet.
  turn();
  EXPECT_FALSE(draw(0.03));  // Fewer rays are perhaps enough.
  EXPECT_EQ(engine_.asked, std::make_pair(81, 61));
  EXPECT_EQ(engine_.asked_pixel_error, 0.1);
  EXPECT_TRUE(progressive_.wants_refinement());
  turn();
  EXPECT_FALSE(draw(0.06));  // Fewer rays were not enough.
  EXPECT_EQ(engine_.asked, std::make_pair(41, 31));
  EXPECT_FALSE(draw(0.15));  // The view has been still for only 90 ms.
  EXPECT_TRUE(draw(0.161));
  EXPECT_EQ(engine_.asked, std::make_pair(81, 61));
  EXPECT_EQ(engine_.asked_pixel_error, 0);
  EXPECT_FALSE(progressive_.wants_refinement());
  turn();
  EXPECT_FALSE(draw(0.2));  // Fewer rays would not be enough now. Half the pixels per side took 0.1
                            // s.
  EXPECT_EQ(engine_.asked, std::make_pair(21, 16));
}

TEST_F(ProgressiveTest, ReducesPixelsOnlyAsMuchAsTheBudgetRequires) {
  scene_.quality.pixel_error = 0.2;
  engine_.sparse_s = 0.12;
  EXPECT_TRUE(draw(0));
  const auto next = [&](double takes_s) {
    engine_.sparse_s = takes_s;
    turn();
    EXPECT_FALSE(draw(0.03));
    return engine_.asked;
  };
  const auto half = std::make_pair(41, 31), third = std::make_pair(27, 21);
  EXPECT_EQ(next(0.06), half);    // 0.12 s with all pixels is 0.03 s with half per side.
  EXPECT_EQ(next(0.027), third);  // 0.06 s with half per side is 0.027 s with a third.
  EXPECT_EQ(next(0.012), third);  // Half per side would take 0.06 s again.
  EXPECT_EQ(next(0.5), half);     // Half per side would take 0.027 s now.
  EXPECT_EQ(next(0.5), std::make_pair(11, 8));  // There is a minimum of an eighth per side.
}

TEST_F(ProgressiveTest, KeepsAllPixelsIfFewerRaysAreEnough) {
  engine_.sparse_s = 0.02;
  EXPECT_TRUE(draw(0));
  for (int i = 1; i < 4; ++i) {
    turn();
    EXPECT_FALSE(draw(0.03 * i));
    EXPECT_EQ(engine_.asked, std::make_pair(81, 61));
    EXPECT_EQ(engine_.asked_pixel_error, 0.1);
  }
}

TEST_F(ProgressiveTest, AnUnchangedImageDoesNotCountForFewerRays) {
  engine_.sparse_s = 0.03;
  EXPECT_TRUE(draw(0));
  turn();
  EXPECT_FALSE(draw(0.03));
  engine_.sparse_s = 0;
  EXPECT_FALSE(draw(0.05));  // There is no change.
  engine_.takes_s = 1;
  EXPECT_TRUE(draw(0.2));
  turn();
  EXPECT_FALSE(draw(0.25));  // Fewer rays would take 0.15 s now.
  EXPECT_EQ(engine_.asked, std::make_pair(41, 31));
}

TEST_F(ProgressiveTest, ReducesPixelsAtOnceIfRaysAreAlreadyFew) {
  scene_.quality.pixel_error = 0.2;
  engine_.sparse_s = 0.2;
  EXPECT_TRUE(draw(0));
  turn();
  EXPECT_FALSE(draw(0.03));
  EXPECT_EQ(engine_.asked, std::make_pair(27, 21));  // 0.2 s with all pixels.
  EXPECT_EQ(engine_.asked_pixel_error, 0.2);
}

TEST_F(ProgressiveTest, AFastEngineIsNeverCoarse) {
  engine_.takes_s = 0.01;
  for (int i = 0; i < 5; ++i) {
    EXPECT_TRUE(draw(0.03 * i));
    turn();
  }
}

TEST_F(ProgressiveTest, ProvisionalImagesAreNotReportedAsRefined) {
  engine_.takes_s = 0.001;
  EXPECT_TRUE(draw(0));
  engine_.sends = true;
  turn();
  EXPECT_FALSE(draw(0.03));
  EXPECT_TRUE(progressive_.wants_refinement());
  EXPECT_FALSE(draw(0.06));
  EXPECT_TRUE(draw(0.2));
  EXPECT_FALSE(progressive_.wants_refinement());
}

TEST_F(ProgressiveTest, NewUltrasoundPixelsNeitherCoarsenNorDelayRefinement) {
  EXPECT_TRUE(draw(0));
  scene_.plane->frame.pixels = test::grey_image(4, 4, 101);
  EXPECT_TRUE(draw(0.02));
  turn();
  EXPECT_FALSE(draw(0.04));
  scene_.plane->frame.pixels = test::grey_image(4, 4, 102);
  EXPECT_FALSE(draw(0.1));
  scene_.plane->frame.pixels = test::grey_image(4, 4, 103);
  EXPECT_TRUE(draw(0.145));
}

TEST_F(ProgressiveTest, AnImageInFullIsGivenUpForAnotherSceneAndACoarseOneIsShown) {
  ProgressiveRenderer at_once(engine_, {.budget_s = 0});
  const auto waits = [](SceneChange change) { return [change] { return change; }; };
  EXPECT_TRUE(test::has_value(at_once.draw(scene_, at(0), waits(SceneChange::kPixels))))
      << "only the pixels of the ultrasound image differ";
  EXPECT_TRUE(engine_.may_be_interrupted);
  turn();
  EXPECT_FALSE(at_once.draw(scene_, at(0.01), waits(SceneChange::kView)))
      << "nothing is known about an image with fewer rays";
  EXPECT_FALSE(at_once.draw(scene_, at(0.01), waits(SceneChange::kView))->refined);
  EXPECT_FALSE(engine_.may_be_interrupted) << "a coarse image";
  const auto full = at_once.draw(scene_, at(0.5), waits(SceneChange::kGeometry));
  ASSERT_FALSE(full);
  EXPECT_EQ(full.error().code, ErrorCode::kCancelled);
  for (int i = 0; i < 5; ++i) {
    turn();
    const auto coarse = at_once.draw(scene_, at(0.51 + 0.01 * i), waits(SceneChange::kView));
    ASSERT_TRUE(test::has_value(coarse));
    EXPECT_FALSE(coarse->refined);
  }
  EXPECT_TRUE(at_once.draw(scene_, at(1), waits(SceneChange::kNothing))->refined);
}

TEST_F(ProgressiveTest, CoarseImagesComeFromAnEngineOfTheirOwn) {
  SlowEngine second;
  CoarseEngine coarse{second};
  ProgressiveRenderer renderer(engine_, {}, &coarse);
  EXPECT_TRUE(renderer.draw(scene_, at(0))->refined);
  EXPECT_EQ(engine_.asked_ct, scene_.ct);
  EXPECT_EQ(second.images, 0);
  for (int i = 1; i < 4; ++i) {
    turn();
    const auto image = renderer.draw(scene_, at(0.03 * i));
    EXPECT_FALSE(image->refined);
    EXPECT_EQ(image->image.pixels.width(), scene_.width);
    EXPECT_EQ(second.images, i);
    EXPECT_NE(second.asked_ct, scene_.ct);
  }
  EXPECT_TRUE(renderer.draw(scene_, at(1))->refined);
  EXPECT_EQ(engine_.images, 2);
  scene_.predicates.emplace();
  turn();
  (void)renderer.draw(scene_, at(1.03));
  EXPECT_EQ(engine_.images, 3) << "predicates are always drawn of all voxels";
}

TEST_F(ProgressiveTest, AnImageWithinTheBudgetIsFinished) {
  ProgressiveRenderer patient(engine_, {.budget_s = 1000});
  EXPECT_TRUE(test::has_value(patient.draw(scene_, at(0), [] { return SceneChange::kView; })));
}

TEST_F(ProgressiveTest, EnlargingKeepsEachPositionOfTheView) {
  Scene small = scene_;
  for (const auto& [width, height] : {std::pair(27, 21), std::pair(41, 31), std::pair(40, 30)}) {
    small.width = width;
    small.height = height;
    const RenderedImage coarse = *engine_.render(small);
    const RenderedImage full = *engine_.render(scene_);
    const RenderedImage large = enlarged(coarse, scene_.width, scene_.height);
    // Exact inside the outermost coarse rays. Outside, the values stay constant.
    for (int y = 3; y < scene_.height - 3; ++y) {
      for (int x = 3; x < scene_.width - 3; ++x) {
        EXPECT_NEAR(large.pixels.at(x, y).r, full.pixels.at(x, y).r, 1e-5);
        EXPECT_NEAR(large.pixels.at(x, y).g, full.pixels.at(x, y).g, 1e-5);
      }
    }
  }
}

}  // namespace
}  // namespace nav::render
