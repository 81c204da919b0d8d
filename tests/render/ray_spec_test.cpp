// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/ray_spec.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "tests/render/scene_support.hpp"

namespace nav::render::spec {
namespace {

using V = Vec3<double>;

V random_vector(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> u(-size, size);
  return {u(random), u(random), u(random)};
}

double distance_to_segment(const V& p, const V& a, const V& b) {
  const V u = b - a;
  const double square = u.squaredNorm();
  const double t = square > 0 ? std::clamp((p - a).dot(u) / square, 0.0, 1.0) : 0.0;
  return (p - a - t * u).norm();
}

TEST(EnterCapsuleTest, AgreesWithSphereTracing) {
  constexpr double kTolerance = 1e-6;
  std::mt19937 random(5);
  int hits = 0;
  for (int i = 0; i < 5000; ++i) {
    CapsuleSurface<double> c{random_vector(random, 5), random_vector(random, 5), 1.5, V::Zero(), 1};
    if (i % 10 == 0) c.b = c.a;
    Ray<double> ray{random_vector(random, 20), random_vector(random, 1).normalized()};
    if (i % 7 == 0) ray.direction = (c.b - c.a).normalized();  // Along the axis, or undefined.
    if (!ray.direction.allFinite() || ray.direction.norm() < 0.5) continue;
    if (i % 2 == 0) ray.origin = 0.5 * (c.a + c.b) + random_vector(random, 2) - 15 * ray.direction;
    if (distance_to_segment(ray.origin, c.a, c.b) <= c.radius) continue;
    double t = 0;
    double gap = 1;
    for (int step = 0; step < 20000 && t < 100 && gap > 1e-9; ++step) {
      gap = distance_to_segment(ray.origin + t * ray.direction, c.a, c.b) - c.radius;
      t += gap;
    }
    const double found = enter_capsule(c, ray);
    if (gap > 1e-9) {
      // A miss, or a graze that the tracer has not decided.
      const bool misses = !(found > 0 && std::isfinite(found));
      EXPECT_TRUE(misses || gap < 1e-3) << i;
      continue;
    }
    ++hits;
    // Near a graze the tracer stops early: the surface point itself must be right.
    EXPECT_NEAR(distance_to_segment(ray.origin + found * ray.direction, c.a, c.b), c.radius,
                kTolerance)
        << i;
    EXPECT_NEAR(found, t, 1e-3) << i;
  }
  EXPECT_GT(hits, 1000);
}

TEST(ClipToBoxTest, ContainsExactlyWhatIsInside) {
  std::mt19937 random(9);
  const std::array<int, 3> size{7, 1, 12};
  for (int i = 0; i < 2000; ++i) {
    Ray<double> ray{random_vector(random, 15), random_vector(random, 1)};
    if (i % 5 == 0) ray.direction.x() = 0;
    if (i % 3 == 0) ray.direction.z() = 0;
    const auto in = clip_to_box(ray, size);
    for (double t = 0.013; t < 60; t += 0.37) {
      const V p = ray.origin + t * ray.direction;
      const bool inside =
          p.x() > 0 && p.x() < 6 && std::abs(p.y()) < 0.5 && p.z() > 0 && p.z() < 11;
      EXPECT_EQ(inside, t > in.begin && t < in.end) << i << ' ' << t;
    }
  }
}

TEST(RayOfTest, CornersSpanTheFieldOfView) {
  VoxelGrid grid;
  Camera camera{{{1, 2, 3}}, {{1, 12, 3}}, {{0, 0, 2}}};
  camera.vertical_fov_rad = 0.8;
  const auto view = make_view<double>(camera, 400, 200, grid);
  // Middle of the top row: half a pixel below the upper edge.
  const V top = 0.5 * (ray_of(view, 199, 0).direction + ray_of(view, 200, 0).direction);
  EXPECT_NEAR(top.z() / top.y(), std::tan(0.4) * (1 - 1.0 / 200), 1e-5);
  const V right = 0.5 * (ray_of(view, 399, 99).direction + ray_of(view, 399, 100).direction);
  EXPECT_NEAR(right.x() / right.y(), 2 * std::tan(0.4) * (1 - 1.0 / 400), 1e-5);
  EXPECT_NEAR(ray_of(view, 7, 9).direction.norm(), 1.0, 1e-15);
}

TEST(ShadeSampleTest, FadesInWithTheGradientAndIsTwoSided) {
  const Shading shading{true, 0.2, 0.5, 0.0, 1};
  const V rgb(0.8, 0.4, 0.2);
  const V along(0, 1, 0);
  EXPECT_EQ(shade_sample<double>(rgb, V::Zero(), along, shading), rgb);
  const V full = shade_sample<double>(rgb, {0, 50, 0}, along, shading);
  EXPECT_NEAR(full.x(), 0.8 * 0.7, 1e-12);
  EXPECT_EQ(full, shade_sample<double>(rgb, {0, -50, 0}, along, shading));
  const V half = shade_sample<double>(rgb, {0, 5, 0}, along, shading);
  EXPECT_NEAR(half.x(), 0.5 * (0.8 + 0.8 * 0.7), 1e-12);
}

}  // namespace
}  // namespace nav::render::spec
