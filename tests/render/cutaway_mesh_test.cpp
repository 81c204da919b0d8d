// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cutaway_mesh.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

#include "tests/render/scene_support.hpp"

namespace nav::render {
namespace {

using V = Eigen::Vector3d;
constexpr double kMeetRoundingMm = 1e-10;  // Rounding, mm.

/// An irregular organ: a sphere whose radius changes with the direction, with rings × 2 rings
/// quads.
MeshObject organ(int rings, double radius_mm, const V& middle) {
  MeshObject mesh;
  const int around = 2 * rings;
  for (int i = 0; i <= rings; ++i) {
    for (int j = 0; j < around; ++j) {
      const double polar = std::numbers::pi * i / rings;
      const double turn = 2 * std::numbers::pi * j / around;
      const double lump =
          1 + 0.2 * std::sin(3 * turn) * std::sin(polar) + 0.1 * std::cos(5 * polar);
      mesh.vertices_ct.push_back(
          {middle + radius_mm * lump *
                        V(std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn),
                          std::cos(polar))});
    }
  }
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < around; ++j) {
      const int next = (j + 1) % around;
      const int a = i * around + j;
      const int b = i * around + next;
      mesh.triangles.push_back({a, b, a + around});
      mesh.triangles.push_back({b, b + around, a + around});
    }
  }
  return mesh;
}

/// Separate triangles of every size. Many are degenerate.
MeshObject soup(int count, std::mt19937& random) {
  std::uniform_real_distribution<double> u(-1, 1);
  MeshObject mesh;
  for (int i = 0; i < count; ++i) {
    const V at = 60 * V(u(random), u(random), u(random));
    const double size = std::pow(10, 1.5 * u(random));
    for (int k = 0; k < 3; ++k) {
      mesh.vertices_ct.push_back({at + size * V(u(random), u(random), u(random))});
    }
    const int v = 3 * i;
    mesh.triangles.push_back({v, i % 5 == 0 ? v : v + 1, i % 10 == 0 ? v : v + 2});
  }
  return mesh;
}

Scene scene_with(const MeshObject& mesh, bool orthographic) {
  const auto ct =
      test::make_volume(test::centred_grid({4, 4, 4}, {1, 1, 1}), [](int, int, int) { return 0; });
  Scene scene = test::plain_scene(ct, test::fog(0.1), test::frontal(300, 200, orthographic));
  scene.cutaway.emplace();
  scene.cutaway->around_plane = false;
  scene.cutaway->meshes.push_back(std::make_shared<const MeshObject>(mesh));
  return scene;
}

void expect_exact(const MeshObject& mesh, double theta1_deg, double theta2_deg) {
  for (const bool orthographic : {false, true}) {
    Scene scene = scene_with(mesh, orthographic);
    scene.cutaway->theta1_rad = theta1_deg * std::numbers::pi / 180;
    scene.cutaway->theta2_rad = theta2_deg * std::numbers::pi / 180;
    ASSERT_TRUE(test::has_value(validate(scene)));
    const auto exact = spec::make_cutaway(scene, true);
    const CutawayMesh tree(mesh, scene.ct->grid().origin_mm);
    const auto view = spec::make_view<double>(scene.camera, 33, 25, scene.ct->grid());
    CutawayMesh::Hint hint{-7, 1 << 30};
    for (int y = 0; y < 25; ++y) {
      for (int x = 0; x < 33; ++x) {
        const auto ray = spec::ray_of(view, x, y);
        const auto expected = spec::meet_cutaway(exact, ray);
        spec::CutawaySpan<double> found{-1e300, -1e300};
        tree.meet(ray, exact.cot1, exact.cot2, hint, found);
        EXPECT_NEAR(found.t1, expected.t1, kMeetRoundingMm * (1 + exact.cot1)) << x << ' ' << y;
        EXPECT_NEAR(found.t2, expected.t2, kMeetRoundingMm * (1 + exact.cot2)) << x << ' ' << y;
      }
    }
  }
}

TEST(CutawayMeshTest, EqualsTheMaximumOverAllTriangles) {
  expect_exact(organ(16, 50, {5, 0, -10}), 30, 50);
  expect_exact(organ(16, 50, {5, 0, -10}), 1, 89);
  expect_exact(organ(8, 20, {0, -280, 0}), 20, 20);   // Near the eye.
  expect_exact(organ(8, 250, {0, -280, 0}), 40, 70);  // Around the eye.
}

TEST(CutawayMeshTest, EqualsTheMaximumOverSeparateTriangles) {
  std::mt19937 random(8);
  for (const int count : {1, 3, 4, 5, 9, 100, 700}) expect_exact(soup(count, random), 25, 60);
}

/// A flat closed disc: two fans of triangles with opposite normals on one rim, with centres at a
/// distance of \p apart_mm.
MeshObject disc(double apart_mm) {
  constexpr int kRim = 64;
  MeshObject mesh;
  mesh.vertices_ct = {{V(0.5 * apart_mm, 0, 0)}, {V(-0.5 * apart_mm, 0, 0)}};
  for (int i = 0; i < kRim; ++i) {
    const double turn = 2 * std::numbers::pi * i / kRim;
    mesh.vertices_ct.push_back({20 * V(std::cos(turn), std::sin(turn), 0)});
    const int here = 2 + i;
    const int next = 2 + (i + 1) % kRim;
    mesh.triangles.push_back({0, here, next});
    mesh.triangles.push_back({1, next, here});
  }
  return mesh;
}

TEST(CutawayMeshTest, EqualsTheMaximumOverAFlatDisc) {
  for (const double apart_mm : {0.0, 2.0}) {
    const MeshObject mesh = disc(apart_mm);
    const CutawayMesh tree(mesh, V::Zero());
    std::mt19937 random(1);
    std::uniform_real_distribution<double> u(-1, 1);
    for (int n = 0; n < 1000; ++n) {
      spec::Ray<double> ray{100 * V(u(random), u(random), u(random)).normalized(), V::Zero()};
      ray.direction = (30 * V(u(random), u(random), u(random)) - ray.origin).normalized();
      double greatest = -1e300;
      for (const auto& corners : mesh.triangles) {
        std::array<V, 3> at;
        for (std::size_t k = 0; k < 3; ++k) {
          at[k] = mesh.vertices_ct[static_cast<std::size_t>(corners[k])].mm;
        }
        const auto plane = spec::make_polygon({at[0], at[1], at[2]});
        const spec::CutawayTriangle<double> triangle{at, plane.normal, plane.axis_u, plane.axis_v};
        greatest = std::max(greatest, spec::cone_polygon<double>(triangle, ray, 1.5));
      }
      int hint = 0;
      EXPECT_NEAR(tree.greatest(ray, 1.5, -1e300, hint), greatest, 1e-6) << apart_mm << ' ' << n;
    }
  }
}

TEST(CutawayMeshTest, KeepsTheLargerValuesOfOtherObjects) {
  const CutawayMesh tree(organ(8, 50, V::Zero()), V::Zero());
  const spec::Ray<double> ray{{0, -300, 0}, {0, 1, 0}};
  CutawayMesh::Hint hint;
  spec::CutawaySpan<double> span{1000, 900};
  tree.meet(ray, 1.7, 1, hint, span);
  EXPECT_EQ(span.t2, 1000);
  EXPECT_EQ(span.t1, 900);
}

TEST(CutawayMeshTest, TestsFewOfManyTriangles) {
  Scene scene = scene_with(organ(64, 50, V::Zero()), false);
  const CutawayMesh tree(*scene.cutaway->meshes[0], scene.ct->grid().origin_mm);
  EXPECT_EQ(tree.triangles(), 64U * 128 * 2);
  const auto view = spec::make_view<double>(scene.camera, 40, 30, scene.ct->grid());
  double met = 0;
  int hint = 0;
  for (int i = 0; i < 1200; ++i) {
    int here = 0;
    (void)tree.greatest(spec::ray_of(view, i % 40, i / 40), 1.7, -1e300, hint, &here);
    met += here;
  }
  EXPECT_LT(met / 1200, 0.02 * static_cast<double>(tree.triangles()));
}

TEST(CutawayFieldTest, EqualsTheSpecificationInEveryPixelInFront) {
  Scene scene = scene_with(organ(12, 40, {30, 0, 0}), false);
  scene.plane = test::upright_plane(test::grey_image(80, 60, 100), 1, {-30, 0, 30});
  scene.cutaway->around_plane = true;
  MeshObject small = organ(12, 15, {-60, -20, 0});
  small.triangles.resize(20);
  scene.cutaway->meshes.push_back(std::make_shared<const MeshObject>(small));
  EXPECT_TRUE(CutawayField::needed(scene));
  const CutawayField field(scene);
  const auto exact = spec::make_cutaway(scene, true);
  const auto view = spec::make_view<double>(scene.camera, 64, 48, scene.ct->grid());
  const auto spans = field.meet_all(view, 2);
  int touched = 0;
  for (int i = 0; i < 64 * 48; ++i) {
    const auto expected = spec::meet_cutaway(exact, spec::ray_of(view, i % 64, i / 64));
    const auto& found = spans[static_cast<std::size_t>(i)];
    if (!(expected.t2 > 0)) {
      EXPECT_EQ(found.t2, CutawayField::lowest());
      continue;
    }
    ++touched;
    EXPECT_FLOAT_EQ(found.t2, static_cast<float>(expected.t2)) << i;
    EXPECT_FLOAT_EQ(found.t1, static_cast<float>(expected.t1)) << i;
  }
  EXPECT_GT(touched, 1000);
}

TEST(CutawayFieldTest, InterpolatesWithinTheStatedTolerance) {
  constexpr double kTolerance = 0.25;  // Tolerance, mm.
  std::mt19937 random(12);
  for (const MeshObject& mesh : {organ(24, 40, {30, 0, 0}), soup(300, random)}) {
    const Scene scene = scene_with(mesh, false);
    const CutawayField field(scene);
    const auto view = spec::make_view<double>(scene.camera, 203, 150, scene.ct->grid());
    const auto exact = field.meet_all(view, 2);
    const auto fast = field.meet_all(view, 2, kTolerance);
    double worst = 0;
    int beyond = 0;
    for (std::size_t i = 0; i < exact.size(); ++i) {
      const bool here = exact[i].t2 > CutawayField::lowest();
      const bool there = fast[i].t2 > CutawayField::lowest();
      ASSERT_EQ(here, there) << i;
      if (!here) continue;
      EXPECT_GE(fast[i].t2, fast[i].t1 - 1e-3F);
      const double error =
          std::max(std::abs(exact[i].t1 - fast[i].t1), std::abs(exact[i].t2 - fast[i].t2));
      worst = std::max(worst, error);
      beyond += error > kTolerance ? 1 : 0;
    }
    RecordProperty("worst_mm", std::to_string(worst));
    RecordProperty("beyond", std::to_string(beyond));
    EXPECT_LT(worst, 10 * kTolerance);
    EXPECT_LT(beyond, 0.01 * static_cast<double>(exact.size()));
  }
}

TEST(CutawayFieldTest, IsNeededOnlyForLargeMeshesThatCut) {
  Scene scene = scene_with(organ(12, 40, V::Zero()), false);
  EXPECT_TRUE(CutawayField::needed(scene));
  scene.projection = Projection::kMaximum;
  EXPECT_FALSE(CutawayField::needed(scene));
  scene.projection = Projection::kComposite;
  scene.cutaway->meshes.clear();
  EXPECT_FALSE(CutawayField::needed(scene));
  scene.cutaway.reset();
  EXPECT_FALSE(CutawayField::needed(scene));
}

TEST(CutawayFieldTest, ReusesTheTreesOfThePreviousField) {
  Scene scene = scene_with(organ(12, 40, V::Zero()), false);
  const CutawayField first(scene);
  scene.cutaway->theta1_rad = 0.2;  // The trees do not depend on the angles.
  const CutawayField second(scene, &first);
  const CutawayField fresh(scene);
  const auto view = spec::make_view<double>(scene.camera, 16, 12, scene.ct->grid());
  const auto a = second.meet_all(view, 1);
  const auto b = fresh.meet_all(view, 1);
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].t1, b[i].t1);
    EXPECT_EQ(a[i].t2, b[i].t2);
  }
}

}  // namespace
}  // namespace nav::render
