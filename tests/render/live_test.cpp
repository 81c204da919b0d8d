// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Between two images, only the changed parts are drawn again, and no pixel shows a difference.
#include <algorithm>
#include <gtest/gtest.h>
#include <random>

#include "render/spec/ray_spec_cutaway.hpp"
#include "tests/render/scene_support.hpp"

namespace nav::render {
namespace {

constexpr int kWidth = 97;
constexpr int kHeight = 71;

/// Blobs in air, so that there are empty bricks, and rays pass through faint and dense tissue.
std::shared_ptr<const StoredVolume> blobs() {
  return test::make_volume(
      test::centred_grid({40, 36, 33}, {1.0, 1.2, 1.5}), [](int i, int j, int k) {
        return 300 * std::sin(0.35 * i) * std::cos(0.3 * j) * std::sin(0.4 * k + 1) - 50;
      });
}

TransferFunction materials() {
  return *TransferFunction::blend(
      "materials",
      {{"faint",
        {{-200, {0.9, 0.7, 0.5}, 0, 0.1},
         {0, {0.9, 0.7, 0.5}, 0.05, 0.1},
         {120, {0.9, 0.7, 0.5}, 0, 0.1}},
        {}},
       {"vessel",
        {{60, {0.2, 0.2, 1}, 0, 0.8}, {130, {0.2, 0.2, 1}, 0.3, 0.8}, {160, {0.2, 0.2, 1}, 0, 0.8}},
        {}},
       {"dense", {{120, {1, 0.2, 0.1}, 0, 1}, {200, {1, 0.2, 0.1}, 0.6, 1}}, {}}});
}

Image2d<std::uint8_t> noise(unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::uint8_t> pixels(64 * 48);
  for (auto& p : pixels) p = static_cast<std::uint8_t>(random() & 255U);
  return {64, 48, pixels};
}

Scene live_scene(bool orthographic) {
  Scene scene = test::plain_scene(blobs(), materials(), test::frontal(120, 60, orthographic));
  scene.quality.opaque_at = 0.99;
  scene.width = kWidth;
  scene.height = kHeight;
  scene.background_rgb = {0.1, 0.2, 0.3};
  scene.plane = test::upright_plane(noise(1), 0.5, {0, 0, 12});
  scene.cutaway.emplace();
  scene.cutaway->overlay_mm = 4;
  return scene;
}

bool same_pixels(const RenderedImage& a, const RenderedImage& b) {
  return std::equal(a.pixels.pixels().begin(), a.pixels.pixels().end(), b.pixels.pixels().begin(),
                    b.pixels.pixels().end(), [](const RgbaF& x, const RgbaF& y) {
                      return x.r == y.r && x.g == y.g && x.b == y.b && x.a == y.a;
                    });
}

class LiveTest : public ::testing::TestWithParam<CpuLanes> {
 protected:
  /// Returns the image of the engine after all earlier images. Expects that a new engine draws the
  /// same image.
  RenderedImage draw() {
    const RenderedImage image = test::draw(*engine_, scene_);
    EXPECT_TRUE(same_pixels(image, test::draw(*make_cpu_engine({0, GetParam()}), scene_)));
    return image;
  }
  std::unique_ptr<Engine> engine_ = make_cpu_engine({0, GetParam()});
  Scene scene_ = live_scene(false);
};

TEST_P(LiveTest, ANewUltrasoundImageCastsNoRay) {
  for (const bool orthographic : {false, true}) {
    for (const double opacity : {1.0, 0.4}) {
      for (const bool sector : {false, true}) {
        scene_ = live_scene(orthographic);
        scene_.plane->opacity = opacity;
        if (sector) scene_.plane->frame.outline = SectorOutline{{0, -5}, 6, 25, 0.5};
        draw();
        for (unsigned seed = 2; seed < 6; ++seed) {
          scene_.plane->frame.pixels = noise(seed);
          const RenderedImage image = draw();
          EXPECT_EQ(image.statistics.rays, 0U);
          EXPECT_EQ(image.statistics.volume_samples, 0U);
        }
      }
    }
  }
}

TEST_P(LiveTest, AnUnchangedSceneIsNotDrawnAgain) {
  const RenderedImage first = draw();
  EXPECT_EQ(first.statistics.rays, static_cast<std::uint64_t>(kWidth * kHeight));
  const RenderedImage second = draw();
  EXPECT_EQ(second.pixels.pixels().data(), first.pixels.pixels().data());
  EXPECT_EQ(second.statistics.rays, 0U);
  EXPECT_EQ(second.statistics.volume_samples, 0U);
}

TEST_P(LiveTest, AMovedPlaneCastsOnlyTheRaysItCanAffect) {
  scene_.cutaway->theta1_rad = 0.2;
  scene_.cutaway->theta2_rad = 0.3;
  scene_.camera = test::frontal(120, 120, false);
  draw();
  std::mt19937 random(3);
  std::normal_distribution<double> jitter(0, 0.4);
  std::uint64_t cast = 0;
  constexpr int kMoves = 20;
  for (int i = 0; i < kMoves; ++i) {
    const Eigen::Vector3d shift(jitter(random), jitter(random), jitter(random));
    const Eigen::Quaterniond turn(
        Eigen::AngleAxisd(0.03 * jitter(random), Eigen::Vector3d::UnitZ()));
    scene_.plane->ct_from_image = {turn * scene_.plane->ct_from_image.rotation(),
                                   scene_.plane->ct_from_image.translation_mm() + shift};
    cast += draw().statistics.rays;
  }
  EXPECT_GT(cast, 0U);
  EXPECT_LT(cast, static_cast<std::uint64_t>(kMoves * kWidth * kHeight * 3 / 4));
}

TEST_P(LiveTest, EveryChangeOfStateAndGeometryIsDrawn) {
  draw();
  const std::vector<std::function<void(Scene&)>> edits{
      [](Scene& s) {
        s.plane->safety = {SafetyState::kStale, "old"};
      },
      [](Scene& s) { s.plane->frame.pixels = noise(9); },  // Not visible while stale.
      [](Scene& s) {
        s.plane->safety = {SafetyState::kLost, "gone"};
      },
      [](Scene& s) {
        s.plane->safety = {SafetyState::kDegraded, "doubt"};
      },
      [](Scene& s) {
        s.plane->safety = {SafetyState::kValid, ""};
      },
      [](Scene& s) {
        s.needle = test::needle({0, -5, 0}, {20, -25, 20});
      },
      [](Scene& s) { s.needle->tip_ct.mm.x() += 1; },
      [](Scene& s) { s.needle->rgb.x() = 0.3; },
      [](Scene& s) { s.needle->rgb.y() = 0.3; },
      [](Scene& s) { s.needle->rgb.z() = 0.3; },
      [](Scene& s) {
        s.needle->safety = {SafetyState::kStale, "old"};
      },
      [](Scene& s) {
        s.spheres.push_back({{{3, -10, 2}}, 4, {1, 1, 0}, 0.4});
      },
      [](Scene& s) {
        s.lines.push_back({{{3, -10, 2}}, {{9, -20, 12}}});
      },
      [](Scene& s) { s.cutaway->around_spheres = true; },
      [](Scene& s) { s.cutaway->overlay_mm = 9; },
      [](Scene& s) { s.cutaway->theta2_rad = 1.2; },
      [](Scene& s) { s.cutaway->around_plane = false; },
      [](Scene& s) { s.cutaway.reset(); },
      [](Scene& s) { s.plane.reset(); },
      [](Scene& s) {
        s.plane = test::upright_plane(noise(4), 0.7, {5, 3, 9});
      },
      [](Scene& s) { s.transfer = test::fog(0.05); },
      [](Scene& s) { s.camera.eye_ct.mm.x() += 10; },
      [](Scene& s) { s.projection = Projection::kMaximum; },
      [](Scene& s) { s.plane->frame.pixels = noise(11); },
      [](Scene& s) { s.width = 50; },
  };
  for (std::size_t i = 0; i < edits.size(); ++i) {
    SCOPED_TRACE(i);
    edits[i](scene_);
    draw();
  }
}

TEST_P(LiveTest, ReturnedImagesNeverChange) {
  std::vector<RenderedImage> kept;
  std::vector<std::vector<RgbaF>> copies;
  for (unsigned seed = 1; seed < 9; ++seed) {
    scene_.plane->frame.pixels = noise(seed);
    RenderedImage image = draw();
    copies.emplace_back(image.pixels.pixels().begin(), image.pixels.pixels().end());
    kept.push_back(std::move(image));
    if (seed == 5) kept[1] = {};  // Its buffer may be reused.
  }
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (kept[i].pixels.empty()) continue;
    for (std::size_t p = 0; p < copies[i].size(); ++p) {
      ASSERT_EQ(kept[i].pixels.pixels()[p].r, copies[i][p].r);
    }
  }
}

TEST_P(LiveTest, ARejectedSceneLeavesTheEngineUsable) {
  draw();
  Scene bad = scene_;
  bad.cutaway->theta1_rad = 1.3;
  EXPECT_FALSE(engine_->render(bad));
  scene_.plane->frame.pixels = noise(3);
  EXPECT_EQ(draw().statistics.rays, 0U);
}

TEST_P(LiveTest, ALargeMeshCutsLikeTheReference) {
  auto mesh = std::make_shared<MeshObject>();
  constexpr int kRound = 12;
  for (int i = 0; i <= kRound; ++i) {
    for (int j = 0; j < kRound; ++j) {
      const double a = M_PI * i / kRound;
      const double b = 2 * M_PI * j / kRound;
      mesh->vertices_ct.push_back(
          {{9 * std::sin(a) * std::cos(b), 7 + 5 * std::cos(a), 9 * std::sin(a) * std::sin(b)}});
      if (i == kRound) continue;
      const int here = i * kRound + j;
      const int next = i * kRound + (j + 1) % kRound;
      mesh->triangles.push_back({here, next, here + kRound});
      mesh->triangles.push_back({next, next + kRound, here + kRound});
    }
  }
  ASSERT_GT(mesh->triangles.size(), spec::kExactTriangles);
  scene_.cutaway->meshes = {mesh};
  scene_.quality.opaque_at = 1;
  const RenderedImage image = draw();
  EXPECT_GT(image.statistics.cutaway_rays, 0U);
  EXPECT_LT(test::max_difference(image, test::draw(*make_reference_engine(), scene_)), 2.0 / 255);
}

INSTANTIATE_TEST_SUITE_P(Instructions, LiveTest, test::every_lanes(), test::lanes_name);

}  // namespace
}  // namespace nav::render
