// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "render/spec/ray_spec_cutaway.hpp"
#include "tests/render/cutaway_support.hpp"
#include "tests/render/scene_support.hpp"

namespace nav::render::spec {
namespace {

Scene scene_with_everything() {
  const auto ct =
      test::make_volume(test::centred_grid({4, 4, 4}, {1, 1, 1}), [](int, int, int) { return 0; });
  Scene scene = test::plain_scene(ct, test::fog(0.1), test::frontal(100, 20, false));
  scene.plane = test::upright_plane(test::grey_image(80, 60, 100), 1, {0, 0, 3});
  scene.needle = test::needle({0, 0, 0}, {0, 0, 50});
  scene.spheres.push_back({{{5, 6, 7}}, 3});
  scene.cutaway.emplace();
  return scene;
}

TEST(MakeCutawayTest, ContainsTheRequestedVisibleObjects) {
  Scene scene = scene_with_everything();
  const auto counts = [&] {
    const auto objects = make_cutaway(scene, true);
    return std::pair(objects.polygons.size(), objects.balls.size());
  };
  EXPECT_EQ(counts(), std::pair(1UL, 0UL)) << "the plane alone by default";
  scene.cutaway->around_needle = true;
  scene.cutaway->around_spheres = true;
  EXPECT_EQ(counts(), std::pair(2UL, 1UL));
  scene.plane->safety.state = SafetyState::kStale;
  EXPECT_EQ(counts(), std::pair(2UL, 1UL)) << "a stale plane still shows its border";
  scene.plane->safety.state = SafetyState::kLost;
  EXPECT_EQ(counts(), std::pair(1UL, 1UL));
  scene.needle->safety.state = SafetyState::kLost;
  EXPECT_EQ(counts(), std::pair(0UL, 1UL));
  scene.projection = Projection::kMaximum;
  EXPECT_EQ(counts(), std::pair(0UL, 0UL)) << "projections are not cut";
  scene.cutaway.reset();
  EXPECT_TRUE(make_cutaway(scene, true).empty());
}

TEST(MakeCutawayTest, ABoxEqualsTheMaximumOverItsPoints) {
  Scene scene = scene_with_everything();
  scene.cutaway->around_plane = false;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int trial = 0; trial < 40; ++trial) {
    const Eigen::Matrix3d turn = Eigen::Quaterniond(u(random), u(random), u(random), u(random))
                                     .normalized()
                                     .toRotationMatrix();
    const Eigen::Matrix3d half = turn * Eigen::Vector3d(10, 20, 5).asDiagonal();
    scene.cutaway->boxes = {{{{3, 4, 5}}, half}};
    const auto objects = make_cutaway(scene, true);
    const Eigen::Vector3d direction = Eigen::Vector3d(u(random), u(random), u(random)).normalized();
    const Ray<double> ray{Eigen::Vector3d(20 * u(random), 5, 5) - 90 * direction, direction};
    const auto span = meet_cutaway(objects, ray);
    double corner = -1e300;
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector3d in(u(random), u(random), u(random));
      const Eigen::Vector3d q = Eigen::Vector3d(3, 4, 5) - scene.ct->grid().origin_mm + half * in;
      EXPECT_LE(test::cone_value(q, ray, objects.cot1), span.t1 + 1e-9);
      EXPECT_LE(test::cone_value(q, ray, objects.cot2), span.t2 + 1e-9);
      corner = std::max(corner, test::cone_value(q, ray, objects.cot2));
    }
    // The samples are about 2 mm apart, which is dense enough.
    EXPECT_LE(span.t2, corner + 6) << trial;
    EXPECT_GE(span.t2, span.t1);
  }
}

/// A point clears fog whose values, opacity and importance all increase through the volume.
Scene fading_scene(double importance_step) {
  const auto ct = test::make_volume(test::centred_grid({40, 40, 40}, {1, 1, 1}),
                                    [](int x, int y, int z) { return 2 * x + 2 * y + z; });
  const TransferFunction fog =
      *TransferFunction::create("fog", {{0, {1, 0.2, 0.1}, 0.02, 0.2},
                                        {99, {0.5, 0.6, 0.2}, 0.05, 0.5},
                                        {100, {0.5, 0.6, 0.2}, 0.05, 0.5 + importance_step},
                                        {200, {0.1, 0.3, 1}, 0.04, 0.6 + importance_step}});
  Scene scene = test::plain_scene(ct, fog, test::frontal(100, 40, true));
  scene.cutaway.emplace();
  scene.cutaway->around_plane = false;
  scene.cutaway->overlay_mm = 12;
  scene.cutaway->polygons.push_back({{{{-1, 0, 0}}, {{1, 0, 0}}}});
  scene.width = scene.height = 24;
  return scene;
}

double fading_error(Scene scene, double step) {
  const auto engine = make_reference_engine();
  scene.quality.step_voxels = step;
  const RenderedImage found = test::draw(*engine, scene);
  scene.quality.step_voxels = 1.0 / 32;
  return rms_difference(found.pixels, test::draw(*engine, scene).pixels);
}

TEST(FadeTest, ContinuousImportanceGivesNearlySecondOrderConvergence) {
  const Scene scene = fading_scene(0);
  // Error ratio after two halvings of the step: 4 for first order and 16 for second order.
  // Importance depends on whole values, and its small jumps are of first order.
  constexpr double kBetter = 6.5;
  EXPECT_GT(fading_error(scene, 2), kBetter * fading_error(scene, 0.5));
  EXPECT_LT(fading_error(scene, 1), 1.2e-4);
}

TEST(FadeTest, FourMidpointsLocateAJumpOfImportance) {
  const Scene scene = fading_scene(0.4);  // Every ray crosses a boundary between materials.
  EXPECT_LT(fading_error(scene, 1), 1.8e-4);
  EXPECT_LT(fading_error(scene, 0.5), 9e-5);
}

TEST(OutlineOfTest, TheRectangleCoversThePixelsWithTheirEdges) {
  const auto plane = test::upright_plane(test::grey_image(80, 60, 100), 0.5, {0, 0, 0});
  const auto outline = outline_of(plane.frame);
  ASSERT_EQ(outline.size(), 4U);
  EXPECT_NEAR((outline[2] - outline[0] - Vec2<double>(40, 30)).norm(), 0, 1e-12);
}

TEST(OutlineOfTest, TheSectorIsItsArcWithinTheStatedDistance) {
  UltrasoundImage frame = test::upright_plane(test::grey_image(80, 60, 100), 1, {0, 0, 0}).frame;
  for (const double radius_min : {0.0, 15.0}) {
    frame.outline = SectorOutline{{0, -15}, radius_min, 120, 0.52};
    const double sagitta = 120 * (1 - std::cos(0.52 / kSectorChords));
    std::vector<Eigen::Vector3d> vertices;
    for (const auto& p : outline_of(frame)) {
      vertices.emplace_back(p.x(), p.y(), 0);
      const double radius = (p - frame.outline->apex_mm).norm();
      EXPECT_LE(radius, 120 + 1e-9);
      EXPECT_GE(radius, radius_min - 1e-9);
    }
    const auto polygon = test::polygon_of(vertices);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> u(-70, 70);
    int inside = 0;
    for (int i = 0; i < 4000; ++i) {
      const Eigen::Vector2d p(u(random), u(random) + 50);
      const double radius = (p - frame.outline->apex_mm).norm();
      const double edge = std::min(std::abs(radius - 120), std::abs(radius - radius_min));
      if (edge <= sagitta) continue;
      EXPECT_EQ(frame.outline->contains(p), inside_polygon<double>(polygon, {p.x(), p.y(), 0}))
          << p.transpose();
      inside += frame.outline->contains(p) ? 1 : 0;
    }
    EXPECT_GT(inside, 500);
  }
}

TEST(MakeCutawayTest, AMeshCutsLikeItsTriangles) {
  Scene scene = scene_with_everything();
  scene.cutaway->around_plane = false;
  MeshObject mesh;
  for (int i = 0; i < 100; ++i) {
    mesh.vertices_ct.push_back({{std::sin(i * 1.3) * 9, std::cos(i * 2.1) * 9, i * 0.1}});
  }
  for (int i = 0; i + 2 < 100; ++i) mesh.triangles.push_back({i, i + 1, i + 2});
  scene.cutaway->meshes = {std::make_shared<const MeshObject>(mesh)};
  const auto exact = make_cutaway(scene, true);
  EXPECT_EQ(exact.polygons.size(), 98U);
  EXPECT_TRUE(make_cutaway(scene, false).empty()) << "more than kExactTriangles: by another way";
  const Eigen::Vector3d origin = scene.ct->grid().origin_mm;
  const Ray<double> ray{{0.3, -50, 0.2}, {0, 1, 0}};
  double best = -1e300;
  for (const auto& t : mesh.triangles) {
    const auto at = [&](int k) -> Eigen::Vector3d {
      return mesh.vertices_ct[static_cast<std::size_t>(t[static_cast<std::size_t>(k)])].mm - origin;
    };
    best = std::max(best, test::best_of(at(0), at(1), at(2), ray, exact.cot1));
  }
  EXPECT_NEAR(meet_cutaway(exact, ray).t1, best, 1e-8);
}

}  // namespace
}  // namespace nav::render::spec
