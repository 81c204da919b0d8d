// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <limits>
#include <vtkActor.h>
#include <vtkNew.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkSphereSource.h>

#include "render/gl/gl_device.hpp"
#include "render/gl/gl_volume_fit.hpp"
#include "render/vtk/vtk_convert.hpp"
#include "tests/render/gl/gl_images.hpp"
#include "tests/render/gl/gl_random_scenes.hpp"
#include "tests/render/gl/gl_scenes.hpp"
#include "tests/render/gl/gl_view.hpp"
#include "tests/render/scene_support.hpp"

namespace nav::render {
namespace {

/// Each call draws the scene of the phantom once.
class GlRaycasterTest : public test::GlViewTest {
 protected:
  void draw() { ASSERT_TRUE(test::has_value(try_to_draw(scene_))); }
  Image2d<Rgba8> image() {
    draw();
    return read_pixels(window_->window());
  }

  Scene scene_ = test::ball_scene(test::cube_grid(48, 1.0));
};

TEST_F(GlRaycasterTest, ParameterEditsNeverCompile) {
  scene_.plane = test::test_plane(scene_.ct->grid(), SafetyState::kValid);
  scene_.needle = test::test_needle(scene_.ct->grid(), SafetyState::kValid);
  scene_.shading.style = ShadingStyle::kGooch;
  scene_.shading.emphasis = 0.2;
  scene_.cutaway.emplace();
  draw();
  ASSERT_EQ(caster().compiled(), 1);
  scene_.transfer = *preset_transfer_function("ct-bone");
  scene_.shading.ambient = 0.1;
  scene_.shading.emphasis = 1;
  scene_.shading.silhouette = 0;
  scene_.shading.full_gradient_per_mm = 50;
  scene_.quality.step_voxels = 1;
  scene_.quality.opaque_at = 1;
  scene_.camera.orthographic = true;
  scene_.plane->opacity = 0.5;
  scene_.plane->safety = {SafetyState::kStale, "test"};
  scene_.needle->safety = {SafetyState::kStale, "test"};
  scene_.lines = {{{{0, 0, 0}}, {{20, 0, 0}}}};
  scene_.cutaway->theta1_rad = scene_.cutaway->theta2_rad = 0.3;
  scene_.cutaway->overlay_mm = std::numeric_limits<double>::infinity();
  scene_.cutaway->around_needle = scene_.cutaway->around_spheres = true;
  scene_.background_rgb.setConstant(0.5);
  draw();
  EXPECT_EQ(caster().compiled(), 1);
}

TEST_F(GlRaycasterTest, InterpolatedPixelsCompileOnce) {
  caster().set_compute(false);
  scene_ = test::ball_scene(test::cube_grid(24, 1.0), 160, 120);
  draw();
  ASSERT_EQ(caster().compiled(), 1);
  scene_.quality.pixel_error = 0.1;
  draw();
  EXPECT_GT(statistics().pixels_without_ray, 1000U);
  EXPECT_EQ(caster().compiled(), 3) << "one for fewer rays, one for the means";
  for (const double error : {0.2, 0.0, 0.05}) {
    scene_.quality.pixel_error = error;
    scene_.camera.eye_ct.mm.x() += 1;
    draw();
  }
  EXPECT_EQ(caster().compiled(), 3);
}

TEST_F(GlRaycasterTest, OmitsTheSameRaysAsTheCpuEngine) {
  caster().set_compute(false);
  constexpr double kRounding = 0.001;  // Share of the pixels: squares at the limit of being even.
  // The CPU engine casts the surroundings of a shape in blocks, OpenGL only the shape itself.
  constexpr double kAroundShape = 0.02;
  for (const bool plane : {false, true}) {
    scene_ = test::ball_scene(test::cube_grid(48, 1.0), 240, 180);
    const auto expect_same = [&](const std::string& where, double share) {
      const auto expected = test::draw(*make_cpu_engine(), scene_);
      const auto found = image();
      EXPECT_LT(test::difference(found, to_8bit(expected.pixels), 2).fraction_above, share)
          << where << (plane ? ", plane" : "");
      // The CPU engine counts the rays of blocks that meet nothing, OpenGL interpolates there.
      const auto background =
          static_cast<std::uint64_t>(std::ranges::count(found.pixels(), found.at(0, 0)));
      const std::uint64_t means = expected.statistics.pixels_without_ray;
      const auto rounding = static_cast<std::uint64_t>(kRounding * static_cast<double>(means));
      EXPECT_GE(statistics().pixels_without_ray + rounding, means) << where;
      return means + background + rounding;
    };
    if (plane) {
      scene_.plane = test::test_plane(scene_.ct->grid(), SafetyState::kValid);
      scene_.plane->opacity = 0.7;
    }
    for (const double error : {0.1, 0.3}) {
      scene_.quality.pixel_error = error;
      for (const bool pairs : {false, true}) {
        caster().set_voxel_pairs(pairs);
        const auto most = expect_same(pairs ? "pairs of voxels" : "texture", kRounding);
        EXPECT_LE(statistics().pixels_without_ray, most);
      }
    }
    if (plane) {
      scene_.plane->safety = {SafetyState::kStale, "test"};
      expect_same("a border alone", kRounding);
    }
    scene_.spheres = {{{{6, -12, 4}}, 4, {1, 0.8, 0.1}, 1}};
    expect_same("sphere", kAroundShape);
    scene_.background_rgb.setConstant(0.9);
    expect_same("another background", kAroundShape);
  }
}

TEST_F(GlRaycasterTest, RandomScenesWithInterpolatedPixelsAgreeWithTheCpuEngine) {
  caster().set_compute(false);
  // The CPU engine treats the surroundings of shapes in blocks. This share of an image has rays
  // only there.
  constexpr double kAroundShapes = 0.05;
  constexpr double kRounding = 0.001;
  for (unsigned seed = 0; seed < 12; ++seed) {
    scene_ = test::RandomScenes(seed).next();
    scene_.width = 157;
    scene_.height = 118;
    scene_.quality.jitter = false;
    scene_.quality.pixel_error = 0.05;
    for (const bool shapes : {true, false}) {
      if (!shapes) {
        scene_.needle.reset();
        scene_.spheres.clear();
        scene_.lines.clear();
      }
      const auto expected = to_8bit(test::draw(*make_cpu_engine(), scene_).pixels);
      caster().forget_image();  // Shapes that are out of sight change nothing.
      const auto found = test::difference(image(), expected, 2);
      EXPECT_EQ(statistics().rays + statistics().pixels_without_ray, 157U * 118U) << seed;
      EXPECT_LT(found.fraction_above, shapes ? kAroundShapes : kRounding) << seed;
    }
  }
}

TEST_F(GlRaycasterTest, UnimportantTissueNeedsNoGradient) {
  scene_.transfer = *TransferFunction::create(
      "unimportant",
      {{-300, {1, 0.5, 0.3}, 0.0, 0.0}, {50, {1, 0.5, 0.3}, 0.1, 0.0}, {900, {1, 1, 1}, 0.5, 0.0}});
  scene_.shading.emphasis = 1;
  scene_.quality.classification = Classification::kPostClassified;
  draw();
  EXPECT_GT(caster().statistics().volume_samples, 0U);
  EXPECT_EQ(caster().statistics().gradient_samples, 0U);
}

TEST_F(GlRaycasterTest, TheCutawayReducesTheSamples) {
  scene_.plane = test::test_plane(scene_.ct->grid(), SafetyState::kValid);
  scene_.shading.enabled = false;
  draw();
  const std::uint64_t without = caster().statistics().volume_samples;
  scene_.cutaway.emplace();
  scene_.cutaway->overlay_mm = 2;
  draw();
  EXPECT_LT(caster().statistics().volume_samples, without);
}

TEST_F(GlRaycasterTest, EachFeatureSetCompilesOnce) {
  draw();
  scene_.shading.enabled = false;
  draw();
  EXPECT_EQ(caster().compiled(), 2);
  scene_.spheres = test::test_spheres(scene_.ct->grid());
  draw();
  EXPECT_EQ(caster().compiled(), 3);
  scene_.spheres.pop_back();  // The number of spheres is not a feature.
  draw();
  EXPECT_EQ(caster().compiled(), 3);
  scene_.spheres.clear();
  scene_.plane = test::test_plane(scene_.ct->grid(), SafetyState::kLost);  // A lost plane needs no
                                                                           // program for planes.
  draw();
  scene_.shading.enabled = true;
  draw();
  EXPECT_EQ(caster().compiled(), 3);
}

TEST_F(GlRaycasterTest, UploadsOnlyWhatChanged) {
  scene_.plane = test::test_plane(scene_.ct->grid(), SafetyState::kValid);
  draw();
  scene_.camera.eye_ct.mm.x() += 20;
  scene_.shading.diffuse = 0.5;
  draw();
  EXPECT_EQ(caster().uploads().volumes, 1);
  EXPECT_EQ(caster().uploads().transfers, 1);
  EXPECT_EQ(caster().uploads().bricks, 1);
  EXPECT_EQ(caster().uploads().images, 1);
  scene_.transfer = *preset_transfer_function("ct-bone");
  draw();
  EXPECT_EQ(caster().uploads().volumes, 1);
  EXPECT_EQ(caster().uploads().transfers, 2);
  EXPECT_EQ(caster().uploads().bricks, 2);
  scene_.plane->frame.pixels = {40, 30, std::vector<std::uint8_t>(40 * 30, 99)};
  draw();
  EXPECT_EQ(caster().uploads().images, 2);
  scene_.ct = test::ball_phantom(test::cube_grid(40, 1.0));
  draw();
  EXPECT_EQ(caster().uploads().volumes, 2);
}

TEST_F(GlRaycasterTest, ProjectionsSkipWhatCannotChangeThem) {
  for (const bool flat : {false, true}) {
    for (const auto projection : {Projection::kMaximum, Projection::kMinimum, Projection::kMean}) {
      scene_ = test::ball_scene(flat ? test::cube_grid(48, 1.0) : test::oblique_grid());
      scene_.projection = projection;
      scene_.quality.skip_empty_bricks = false;
      const auto all = test::GlViewTest::draw(scene_);
      const std::uint64_t taken = caster().statistics().volume_samples;
      scene_.quality.skip_empty_bricks = true;
      EXPECT_TRUE(test::same_bits(test::GlViewTest::draw(scene_), all));
      EXPECT_LT(caster().statistics().volume_samples, taken * 9 / 10);
      EXPECT_EQ(caster().uploads().transfers, 0);
    }
  }
}

TEST_F(GlRaycasterTest, StoredGradientsAreCentralDifferences) {
  scene_ = test::ball_scene(test::oblique_grid());
  caster().set_voxel_pairs(false);
  draw();
  const Image2d<RgbaF> kept(96, 72, caster().read());
  const std::uint64_t taken = caster().statistics().gradient_samples;
  caster().set_gradient_texture(false);
  draw();
  EXPECT_EQ(caster().compiled(), 2);
  EXPECT_EQ(caster().statistics().gradient_samples, taken);
  EXPECT_TRUE(test::agree(kept, Image2d<RgbaF>(96, 72, caster().read()), 0.05));
}

TEST_F(GlRaycasterTest, AVolumeBeyondTheLargestEdgeIsDrawnFromMeans) {
  scene_.quality.opaque_at = 1;
  scene_.background_rgb.setZero();
  caster().set_largest_edge(24);  // The phantom has 48 voxels per edge.
  draw();
  EXPECT_NE(caster().statistics().note.find("means of 2 x 2 x 2 voxels"), std::string::npos)
      << caster().statistics().note;
  const Image2d<RgbaF> found(96, 72, caster().read());
  const ReducedVolume expected_ct = reduced(*scene_.ct, {2, 2, 2});
  EXPECT_GT(expected_ct.rms_error_hu, 0);
  scene_.ct = expected_ct.volume;
  const auto expected = make_reference_engine()->render(scene_);
  ASSERT_TRUE(test::has_value(expected));
  EXPECT_TRUE(test::agree(found, expected->pixels, test::kAgreement255));
}

TEST_F(GlRaycasterTest, AVolumeThatFillsTheMemoryIsHalvedUntilItFits) {
  scene_.quality.opaque_at = 1;
  scene_.background_rgb.setZero();
  caster().set_memory(48 * 48 * 48 / 6);
  draw();
  // The number of voxels is halved three times: once along each axis.
  EXPECT_NE(caster().statistics().note.find("means of 2 x 2 x 2 voxels"), std::string::npos)
      << caster().statistics().note;
  EXPECT_EQ(caster().uploads().volumes, 1);
  const Image2d<RgbaF> found(96, 72, caster().read());
  const std::shared_ptr<const StoredVolume> whole = scene_.ct;
  scene_.ct = reduced(*whole, {2, 2, 2}).volume;
  const auto expected = make_reference_engine()->render(scene_);
  ASSERT_TRUE(test::has_value(expected));
  EXPECT_TRUE(test::agree(found, expected->pixels, test::kAgreement255));
  // A volume that fits is drawn completely again, without a note.
  scene_.ct = test::ball_phantom(test::cube_grid(24, 1.0));
  draw();
  EXPECT_EQ(caster().statistics().note, "");
}

TEST_F(GlRaycasterTest, AVolumeThatNeverFitsIsRejectedByName) {
  caster().set_memory(0);
  EXPECT_TRUE(test::rejects(try_to_draw(scene_), ErrorCode::kUnsupportedData,
                            {"ball phantom", "free memory of this OpenGL device"}));
  caster().set_memory(1 << 30);
  scene_.ct = test::ball_phantom(test::cube_grid(20, 1.0));
  draw();
  EXPECT_GT(caster().statistics().volume_samples, 0U);
}

TEST_F(GlRaycasterTest, ACoarseImageAgreesWithTheFullOne) {
  scene_.plane = test::test_plane(scene_.ct->grid(), SafetyState::kValid);
  const Image2d<Rgba8> whole = image();
  ASSERT_TRUE(test::has_value(try_to_draw(scene_, 2)));
  EXPECT_EQ(caster().statistics().rays, 48U * 36U);
  const Image2d<Rgba8> coarse = read_pixels(window_->window());
  // Edges are blurred. An image that is shifted by one pixel would differ in most of the ball.
  constexpr int kBlur255 = 24;
  EXPECT_LT(test::difference(coarse, whole, kBlur255).fraction_above, 0.15);
  EXPECT_GT(test::difference(coarse, whole, 0).fraction_above, 0.1);
  EXPECT_EQ(test::difference(image(), whole, 0).max, 0);
}

TEST_F(GlRaycasterTest, LeapsOverPartsOfBricks) {
  // A wall across x in the first part of each brick of a row. The rays run along the wall.
  scene_ = test::plain_scene(
      test::make_volume(test::centred_grid({17, 33, 17}, {1, 1, 1}),
                        [](int i, int, int) { return i == 1 || i == 9 ? 1000 : -1000; }),
      test::solid({1, 1, 1}), test::frontal(100, 16, true));
  const auto samples = [&](double step) {
    scene_.quality.step_voxels = step;
    const auto leapt = test::GlViewTest::draw(scene_);
    const auto taken = static_cast<double>(caster().statistics().volume_samples);
    scene_.quality.skip_empty_bricks = false;
    EXPECT_TRUE(test::same_bits(leapt, test::GlViewTest::draw(scene_)));
    scene_.quality.skip_empty_bricks = true;
    return taken;
  };
  // Cells of 4 voxels leap only over whole bricks.
  EXPECT_LT(samples(2), 1.5 * samples(4));
  EXPECT_GT(samples(2), 0);
}

TEST_F(GlRaycasterTest, PairsOfVoxelsGiveTheSameImage) {
  for (const VoxelGrid& grid :
       {test::oblique_grid(), test::cube_grid(1, 8.0), test::cube_grid(2, 8.0)}) {
    scene_ = test::ball_scene(grid);
    caster().set_voxel_pairs(false);
    draw();
    const Image2d<RgbaF> by_texture(96, 72, caster().read());
    caster().set_voxel_pairs(true);
    draw();
    EXPECT_TRUE(test::agree(Image2d<RgbaF>(96, 72, caster().read()), by_texture, 0.5));
  }
  EXPECT_EQ(caster().uploads().volumes, 6);
}

TEST_F(GlRaycasterTest, GradientsFromPairsOfVoxelsEqualThoseFromSixFetches) {
  // The rays cross all edges, where neighbours are repeated, and axes of one to five voxels.
  for (const std::array<int, 3>& size :
       {std::array{1, 1, 1}, std::array{2, 1, 3}, std::array{1, 4, 2}, std::array{3, 2, 1},
        std::array{5, 4, 3}}) {
    const Eigen::Vector3d spacing = 60 / Eigen::Array3i::Map(size.data()).cast<double>();
    scene_ = test::plain_scene(
        test::make_volume(test::centred_grid(size, spacing),
                          [](int i, int j, int k) { return (i * 619 + j * 811 + k * 1097) % 907; }),
        test::fog(0.05, {0.9, 0.6, 0.3}), test::frontal(160, 90, false));
    scene_.shading.enabled = true;
    scene_.shading.full_gradient_per_mm = 5;
    caster().set_voxel_pairs(false);
    caster().set_gradient_texture(false);
    const auto drawn = [&] {
      return Image2d<RgbaF>(scene_.width, scene_.height, test::GlViewTest::draw(scene_));
    };
    const Image2d<RgbaF> six = drawn();
    EXPECT_GT(caster().statistics().gradient_samples, 0U);
    caster().set_voxel_pairs(true);
    caster().set_gradient_texture(true);
    EXPECT_TRUE(test::agree(drawn(), six, 0.05));
  }
}

TEST_F(GlRaycasterTest, PairsOfVoxelsAreUsedInSoftware) {
  draw();
  EXPECT_EQ(caster().voxel_pairs(), runs_in_software(window_->device()));
  EXPECT_TRUE(runs_in_software("llvmpipe (LLVM 15.0.6, 256 bits)"));
  EXPECT_FALSE(runs_in_software("NVIDIA GeForce RTX 4070/PCIe/SSE2"));
}

TEST_F(GlRaycasterTest, CostsDependOnTheElementsOfTheScene) {
  draw();
  const RenderStatistics shaded = caster().statistics();
  EXPECT_GT(shaded.gradient_samples, 0U);
  EXPECT_LT(shaded.gradient_samples, shaded.volume_samples);
  scene_.shading.enabled = false;
  draw();
  EXPECT_EQ(caster().statistics().gradient_samples, 0U);
  EXPECT_EQ(caster().statistics().volume_samples, shaded.volume_samples);
  scene_.quality.skip_empty_bricks = false;
  draw();
  EXPECT_GT(caster().statistics().volume_samples, shaded.volume_samples);
  EXPECT_EQ(caster().statistics().bricks, 0U);
  scene_.quality.skip_empty_bricks = true;
  scene_.quality.opaque_at = 1;
  draw();
  EXPECT_GT(caster().statistics().volume_samples, shaded.volume_samples);
  // A sphere that covers the whole image leaves nothing to sample.
  scene_.spheres = {{scene_.camera.eye_ct, 1, {1, 0, 0}, 1}};
  scene_.spheres[0].centre_ct.mm +=
      20 * (scene_.camera.look_at_ct.mm - scene_.camera.eye_ct.mm).normalized();
  scene_.spheres[0].radius_mm = 15;
  draw();
  EXPECT_EQ(caster().statistics().volume_samples, 0U);
}

/// A green VTK ball.
vtkNew<vtkActor> green_ball(const Eigen::Vector3d& centre_mm, double radius_mm) {
  vtkNew<vtkSphereSource> source;
  source->SetCenter(centre_mm.x(), centre_mm.y(), centre_mm.z());
  source->SetRadius(radius_mm);
  source->SetThetaResolution(64);
  source->SetPhiResolution(64);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(source->GetOutputPort());
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(0, 1, 0);
  actor->GetProperty()->LightingOff();
  return actor;
}

/// A homogeneous block with a known extinction, so that the light in front of a surface is known
/// too.
Scene block_scene(bool orthographic) {
  const VoxelGrid grid = test::cube_grid(41, 1.0);
  Scene scene = test::ball_scene(grid);
  scene.ct = std::make_shared<const StoredVolume>(
      *StoredVolume::create(grid, std::vector<std::int16_t>(grid.voxel_count(), 100), "block"));
  scene.transfer =
      *TransferFunction::create("red", {{0, {1, 0, 0}, 0.05, 0}, {200, {1, 0, 0}, 0.05, 0}});
  scene.shading.enabled = false;
  scene.quality.opaque_at = 1;
  scene.camera.eye_ct.mm = {0, -150, 0};
  scene.camera.look_at_ct.mm = {0, 0, 0};
  scene.camera.orthographic = orthographic;
  scene.camera.orthographic_height_mm = 60;
  scene.background_rgb.setZero();
  return scene;
}

TEST_F(GlRaycasterTest, RaysStopAtVtkGeometry) {
  for (const bool orthographic : {false, true}) {
    scene_ = block_scene(orthographic);
    constexpr double kRadiusMm = 10;
    const vtkNew<vtkActor> ball = green_ball({0, 0, 0}, kRadiusMm);
    view_->renderer().AddActor(ball);
    const Image2d<Rgba8> seen = image();
    view_->renderer().RemoveActor(ball);
    test::keep_image(orthographic ? "shared_depth_orthographic" : "shared_depth", seen);
    // The middle ray crosses the block from -20 to -10 mm with 5 % opacity per mm, and then meets
    // the ball.
    const double through = std::pow(0.95, 20 - kRadiusMm);
    const Rgba8 middle = seen.at(48, 36);
    // The ball is a polyhedron, seen half a pixel beside its pole: 0.1 mm, or 0.5 % of the light.
    constexpr double kTolerance255 = 2.5;
    EXPECT_NEAR(middle.r, 255 * (1 - through), kTolerance255) << orthographic;
    EXPECT_NEAR(middle.g, 255 * through, kTolerance255) << orthographic;
    // Beside the ball (14 pixels, 12 to 15 mm from the middle), the rays continue to the far side
    // of the block.
    EXPECT_NEAR(seen.at(48, 22).r, 255 * (1 - std::pow(0.95, 40)), kTolerance255) << orthographic;
    EXPECT_EQ(seen.at(48, 22).g, 0) << orthographic;
  }
}

TEST_F(GlRaycasterTest, ObliqueRaysStopAtVtkGeometry) {
  scene_ = block_scene(false);
  scene_.camera.eye_ct.mm = {0, -40, 0};
  scene_.camera.vertical_fov_rad = 1.2;
  const Eigen::Vector3d centre(14, 0, 0);
  constexpr double kRadiusMm = 2;
  const vtkNew<vtkActor> ball = green_ball(centre, kRadiusMm);
  view_->renderer().AddActor(ball);
  // The ray of pixel (66, 36) is 18.5 pixels to the right of the middle and half a pixel below it,
  // in the axes of the camera (x, depth, up). It meets the ball nearly in the middle.
  const double pixel = std::tan(0.6) / 36;
  const Eigen::Vector3d direction = Eigen::Vector3d(18.5 * pixel, 1, -0.5 * pixel).normalized();
  const Eigen::Vector3d to_centre = centre - scene_.camera.eye_ct.mm;
  const double along = to_centre.dot(direction);
  const double aside = (to_centre - along * direction).norm();
  const double ball_mm = along - std::sqrt(kRadiusMm * kRadiusMm - aside * aside);
  const double face_mm = 20 / direction.y();
  const double through = std::pow(0.95, ball_mm - face_mm);
  // Using the depth instead of the distance would cause an error of 2.3 mm, or 12/255.
  constexpr double kTolerance255 = 2.5;
  EXPECT_NEAR(image().at(66, 36).r, 255 * (1 - through), kTolerance255);
  EXPECT_NEAR(image().at(66, 36).g, 255 * through, kTolerance255);
}

TEST_F(GlRaycasterTest, PixelsOfVtkGeometryKeepTheirRays) {
  caster().set_compute(false);
  scene_ = block_scene(true);
  const vtkNew<vtkActor> ball = green_ball({0, 0, 0}, 10);
  view_->renderer().AddActor(ball);
  const Image2d<Rgba8> dense = image();
  scene_.quality.pixel_error = 0.05;
  const Image2d<Rgba8> sparse = image();
  EXPECT_GT(statistics().pixels_without_ray, 500U);
  for (int y = 0; y < dense.height(); ++y) {
    for (int x = 0; x < dense.width(); ++x) {
      EXPECT_NEAR(sparse.at(x, y).r, dense.at(x, y).r, 13) << x << ' ' << y;
      if (std::hypot(x - 47.5, y - 35.5) > 13) continue;  // The ball has a radius of 12 pixels.
      EXPECT_EQ(sparse.at(x, y), dense.at(x, y)) << x << ' ' << y;
    }
  }
}

TEST_F(GlRaycasterTest, VtkGeometryInFrontHidesSolids) {
  scene_ = block_scene(false);
  scene_.spheres = {{{{0, 30, 0}}, 6, {0, 0, 1}, 1}};
  const vtkNew<vtkActor> ball = green_ball({0, -40, 0}, 3);
  view_->renderer().AddActor(ball);
  EXPECT_EQ(image().at(48, 36), (Rgba8{0, 255, 0, 255}));
}

}  // namespace
}  // namespace nav::render
