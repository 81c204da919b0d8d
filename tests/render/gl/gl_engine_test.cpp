// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <functional>
#include <gtest/gtest.h>
#include <string>

#include "render/engine.hpp"
#include "tests/render/gl/gl_images.hpp"
#include "tests/render/gl/gl_scenes.hpp"
#include "tests/render/scene_support.hpp"
#include "tests/support/matchers.hpp"

namespace nav::render {
namespace {

struct AgreementCase {
  std::string name;
  std::function<Scene()> scene;
};
void PrintTo(const AgreementCase& c, std::ostream* out) { *out << c.name; }

Scene plain() { return test::ball_scene(test::cube_grid(48, 1.0)); }
Scene oblique() { return test::ball_scene(test::oblique_grid()); }

Scene with(Scene scene, const std::function<void(Scene&)>& change) {
  change(scene);
  return scene;
}

void add_everything(Scene& scene) {
  scene.plane = test::test_plane(scene.ct->grid(), SafetyState::kValid);
  scene.plane->opacity = 0.7;
  scene.needle = test::test_needle(scene.ct->grid(), SafetyState::kStale);
  scene.spheres = test::test_spheres(scene.ct->grid());
}

/// Every second voxel is bone. The smallest volumes are too small for a ball.
Scene blocks(const std::array<int, 3>& size) {
  VoxelGrid grid = test::cube_grid(2, 30.0 / std::max(size[0], 2));
  grid.size = size;
  std::vector<std::int16_t> hu;
  for (std::size_t i = 0; i < grid.voxel_count(); ++i) {
    hu.push_back(static_cast<std::int16_t>((i / 2 + i / 7) % 2 == 0 ? 300 : -200));
  }
  Scene scene = test::ball_scene(grid);
  scene.ct =
      std::make_shared<const StoredVolume>(*StoredVolume::create(grid, std::move(hu), "blocks"));
  return scene;
}

/// Part of the image that is not background. A blank image would agree with anything.
double drawn_part(const Scene& scene, const RenderedImage& image) {
  const auto pixels = image.pixels.pixels();
  const auto is_drawn = [&](const RgbaF& p) {
    const Eigen::Vector3d rgb(p.r, p.g, p.b);
    return (rgb - scene.background_rgb).cwiseAbs().maxCoeff() > 1e-3;
  };
  return static_cast<double>(std::count_if(pixels.begin(), pixels.end(), is_drawn)) /
         static_cast<double>(pixels.size());
}

class GlAgreementTest : public testing::TestWithParam<AgreementCase> {};

TEST_P(GlAgreementTest, AgreesWithTheReferenceAtTheSameStep) {
  CollectingDiagnostics diagnostics;
  auto gl = make_gl_engine(diagnostics);
  ASSERT_TRUE(test::has_value(gl));
  Scene scene = GetParam().scene();
  scene.quality.opaque_at = 1;  // The reference never terminates early.
  const auto actual = (*gl)->render(scene);
  const auto expected = make_reference_engine()->render(scene);
  ASSERT_TRUE(test::has_value(actual));
  ASSERT_TRUE(test::has_value(expected));
  test::keep_image(GetParam().name + "_gl", to_8bit(actual->pixels));
  test::keep_image(GetParam().name + "_reference", to_8bit(expected->pixels));
  EXPECT_GT(drawn_part(scene, *expected), 0.05);
  EXPECT_TRUE(test::agree(actual->pixels, expected->pixels, test::kAgreement255));
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, GlAgreementTest,
    testing::Values(
        AgreementCase{"Shaded", plain},
        AgreementCase{"Unshaded",
                      [] { return with(plain(), [](Scene& s) { s.shading.enabled = false; }); }},
        AgreementCase{"Orthographic",
                      [] { return with(plain(), [](Scene& s) { s.camera.orthographic = true; }); }},
        AgreementCase{"ObliqueLeftHanded", oblique},
        AgreementCase{"ObliqueWithEverything", [] { return with(oblique(), add_everything); }},
        AgreementCase{"Plane",
                      [] {
                        return with(plain(), [](Scene& s) {
                          s.plane = test::test_plane(s.ct->grid(), SafetyState::kDegraded);
                        });
                      }},
        AgreementCase{"StalePlaneInsideOutline",
                      [] {
                        return with(plain(), [](Scene& s) {
                          s.plane = test::test_plane(s.ct->grid(), SafetyState::kStale);
                          s.plane->frame.outline = SectorOutline{{0, -10}, 12, 45, 0.5};
                        });
                      }},
        AgreementCase{"Needle",
                      [] {
                        return with(plain(), [](Scene& s) {
                          s.needle = test::test_needle(s.ct->grid(), SafetyState::kValid);
                        });
                      }},
        AgreementCase{"Spheres",
                      [] {
                        return with(plain(),
                                    [](Scene& s) { s.spheres = test::test_spheres(s.ct->grid()); });
                      }},
        AgreementCase{"SpheresInOnePlace",
                      [] {
                        return with(plain(), [](Scene& s) {
                          const Point<frames::Ct> centre = s.ct->grid().centre();
                          s.spheres = {{centre, 30, {1, 0, 0}, 0.5}, {centre, 30, {0, 1, 0}, 0.5}};
                        });
                      }},
        AgreementCase{"FogBehindASphere",
                      [] {
                        return with(plain(), [](Scene& s) {
                          s.transfer =
                              *TransferFunction::create("fog", {{-2000, {0.2, 0.9, 0.4}, 0.02, 1},
                                                                {2000, {0.2, 0.9, 0.4}, 0.02, 1}});
                          // The front of the sphere lies in front of the volume.
                          s.spheres = {{s.ct->grid().centre(), 60, {1, 0, 0}, 0.5}};
                        });
                      }},
        AgreementCase{"CameraInside",
                      [] {
                        return with(plain(), [](Scene& s) {
                          s.camera.eye_ct.mm = s.ct->grid().centre().mm + Eigen::Vector3d(2, -3, 1);
                          s.camera.vertical_fov_rad = 1.5;
                        });
                      }},
        AgreementCase{"FarEye",
                      [] {
                        return with(plain(), [](Scene& s) {
                          const Eigen::Vector3d centre = s.ct->grid().centre().mm;
                          s.camera.eye_ct.mm = centre + Eigen::Vector3d(1e6, -2e6, 3e5);
                          s.camera.vertical_fov_rad = 60 / 2.26e6;
                        });
                      }},
        AgreementCase{"CoarseStep",
                      [] { return with(oblique(), [](Scene& s) { s.quality.step_voxels = 4; }); }},
        AgreementCase{"NodesBetweenWholeHu",
                      [] {
                        return with(plain(), [](Scene& s) {
                          s.transfer = *TransferFunction::create(
                              "fractions", {{-300.3, {0.8, 0.6, 0.5}, 0.0, 0.0},
                                            {49.7, {0.9, 0.5, 0.4}, 0.02, 0.3},
                                            {1500.5, {1.0, 1.0, 1.0}, 0.8, 1.0}});
                        });
                      }},
        AgreementCase{"SingleSlice",
                      [] {
                        return blocks({32, 32, 1});
                      }},
        AgreementCase{"TwoVoxelsAnEdge",
                      [] {
                        return blocks({2, 2, 2});
                      }},
        AgreementCase{"SingleVoxel",
                      [] {
                        return blocks({1, 1, 1});
                      }}),
    [](const auto& tested) { return tested.param.name; });

/// Renders a scene without and with skipping, expects equal bits, and returns the latter image.
RenderedImage expect_same_skipped(Engine& engine, Scene scene) {
  scene.quality.skip_empty_bricks = false;
  const RenderedImage all = test::draw(engine, scene);
  scene.quality.skip_empty_bricks = true;
  RenderedImage skipped = test::draw(engine, scene);
  EXPECT_TRUE(test::same_bytes(all, skipped));
  return skipped;
}

TEST(GlEngineTest, SkippingChangesNoBit) {
  CollectingDiagnostics diagnostics;
  auto gl = make_gl_engine(diagnostics);
  ASSERT_TRUE(test::has_value(gl));
  for (const Scene& scene : {plain(), with(oblique(), add_everything),
                             with(oblique(), [](Scene& s) { s.camera.orthographic = true; })}) {
    const RenderedImage skipped = expect_same_skipped(**gl, scene);
    EXPECT_GT(skipped.statistics.bricks, skipped.statistics.bricks_occupied);
  }
}

TEST(GlEngineTest, CellsLongerThanABrickMissNothingBetweenEmptyOnes) {
  CollectingDiagnostics diagnostics;
  auto gl = make_gl_engine(diagnostics);
  ASSERT_TRUE(test::has_value(gl));
  for (const double step : {6.0, 7.9, 8.0, 9.0, 12.0, 16.0}) {
    for (int shift = 0; shift < 32; ++shift) {  // Shifts the lattice of samples by half voxels.
      SCOPED_TRACE(std::to_string(step) + ", " + std::to_string(shift));
      Scene scene = test::sheet_scene(100 + 0.5 * shift, 8);
      scene.quality.step_voxels = step;
      EXPECT_GT(test::middle(expect_same_skipped(**gl, scene)).r, 0.1F);
    }
  }
}

TEST(GlEngineTest, EarlyTerminationStaysWithinItsBound) {
  CollectingDiagnostics diagnostics;
  auto gl = make_gl_engine(diagnostics);
  ASSERT_TRUE(test::has_value(gl));
  Scene scene = plain();
  scene.quality.opaque_at = 1;
  const auto full = (*gl)->render(scene);
  scene.quality.opaque_at = 0.99;
  const auto early = (*gl)->render(scene);
  ASSERT_TRUE(test::has_value(full));
  ASSERT_TRUE(test::has_value(early));
  // The part that stays unseen has a weight of at most 1 - 0.99.
  const auto found = test::difference(early->pixels, full->pixels, 255 * 0.01 + 1e-3);
  EXPECT_EQ(found.fraction_above, 0) << found.max;
}

TEST(GlEngineTest, ReportsItsDevice) {
  CollectingDiagnostics diagnostics;
  auto gl = make_gl_engine(diagnostics);
  ASSERT_TRUE(test::has_value(gl));
  EXPECT_EQ((*gl)->name(), "gl");
  ASSERT_EQ(diagnostics.entries().size(), 1U);
  EXPECT_NE(diagnostics.entries()[0].message.find((*gl)->device()), std::string::npos);
}

TEST(GlEngineTest, RejectsAnInvalidScene) {
  CollectingDiagnostics diagnostics;
  auto gl = make_gl_engine(diagnostics);
  ASSERT_TRUE(test::has_value(gl));
  Scene scene = plain();
  scene.ct = nullptr;
  EXPECT_FALSE((*gl)->render(scene).has_value());
}

TEST(GlEngineTest, DrawsAVolumeThatIsTooLargeAtReducedResolution) {
  CollectingDiagnostics diagnostics;
  auto gl = make_gl_engine(diagnostics);
  ASSERT_TRUE(test::has_value(gl));
  Scene scene = plain();
  VoxelGrid grid = test::cube_grid(2, 0.001);
  grid.size = {40000, 2, 2};  // No current device has 3D textures of this length.
  scene.ct = std::make_shared<const StoredVolume>(
      *StoredVolume::create(grid, std::vector<std::int16_t>(160000, 300), "long.nrrd"));
  const auto image = (*gl)->render(scene);
  ASSERT_TRUE(test::has_value(image));
  EXPECT_NE(image->statistics.note.find("long.nrrd: 40000 x 2 x 2"), std::string::npos)
      << image->statistics.note;
  EXPECT_NE(image->statistics.note.find("at most 0 HU"), std::string::npos);
  EXPECT_EQ((*gl)->render(plain())->statistics.note, "");
}

TEST(GlEngineTest, CutsAroundALargeMeshLikeTheReference) {
  CollectingDiagnostics diagnostics;
  auto gl = make_gl_engine(diagnostics);
  ASSERT_TRUE(test::has_value(gl));
  for (const bool orthographic : {false, true}) {
    Scene scene = oblique();
    scene.camera.orthographic = orthographic;
    scene.quality.opaque_at = 1;
    scene.cutaway.emplace();
    scene.cutaway->overlay_mm = 6;
    scene.cutaway->meshes = {test::ball_mesh(scene.ct->grid().centre().mm, 7)};
    ASSERT_GT(scene.cutaway->meshes[0]->triangles.size(), std::size_t{64});
    const auto actual = (*gl)->render(scene);
    const auto expected = make_reference_engine()->render(scene);
    ASSERT_TRUE(test::has_value(actual));
    ASSERT_TRUE(test::has_value(expected));
    EXPECT_TRUE(test::agree(actual->pixels, expected->pixels, test::kAgreement255));
    scene.cutaway.reset();
    EXPECT_FALSE(
        test::agree(*&(*gl)->render(scene)->pixels, expected->pixels, test::kAgreement255));
  }
}

/// A software rasteriser is asked between rows of pixels, a card before its rays.
TEST(GlInterruptTest, TheNextImageHasTheBitsOfAnEngineThatWasNeverInterrupted) {
  constexpr int kMostQuestions = 100;
  CollectingDiagnostics diagnostics;
  for (const double pixel_error : {0.0, 0.1}) {
    Scene first = test::ball_scene(test::cube_grid(48, 1.0), 160, 200);
    first.quality.pixel_error = pixel_error;
    first.plane = test::test_plane(first.ct->grid(), SafetyState::kValid);
    Scene moved = first;
    moved.plane->frame.grid.origin_mm.x() += 3;
    Scene turned = moved;
    turned.camera.eye_ct.mm.x() += 20;
    auto fresh = make_gl_engine(diagnostics);
    ASSERT_TRUE(test::has_value(fresh));
    const RenderedImage expected_moved = test::draw(**fresh, moved);
    const RenderedImage expected_turned = test::draw(**fresh, turned);
    auto engine = make_gl_engine(diagnostics);
    ASSERT_TRUE(test::has_value(engine));
    int at = 1;
    for (; at < kMostQuestions; ++at) {
      test::draw(**engine, first);
      int questions = 0;
      const auto given_up = (*engine)->render(moved, Interrupt([&] { return ++questions >= at; }));
      if (given_up) {
        EXPECT_TRUE(test::same_bytes(*given_up, expected_moved)) << "asked, and not interrupted";
        break;
      }
      EXPECT_EQ(given_up.error().code, ErrorCode::kCancelled);
      const bool same_view = at % 2 == 0;
      EXPECT_TRUE(test::same_bytes(test::draw(**engine, same_view ? moved : turned),
                                   same_view ? expected_moved : expected_turned))
          << at;
    }
    EXPECT_GT(at, 1);
    EXPECT_LT(at, kMostQuestions);
  }
}

}  // namespace
}  // namespace nav::render
