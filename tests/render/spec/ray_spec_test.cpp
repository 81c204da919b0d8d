// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/spec/ray_spec.hpp"

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

TEST(ValueAtTest, IsTrilinearBetweenVoxelsAndTheNearestVoxelOutside) {
  VoxelGrid grid;
  grid.size = {4, 3, 1};
  std::vector<std::int16_t> hu;
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 4; ++i)
      hu.push_back(static_cast<std::int16_t>(10 * i * i + 100 * j + i * j));
  }
  const StoredVolume ct = *StoredVolume::create(grid, std::move(hu), "bowed");
  EXPECT_DOUBLE_EQ(value_at(ct, V(3, 2, 0)), 296);
  EXPECT_DOUBLE_EQ(value_at(ct, V(1.25, 1.5, 0)), 17.5 + 150 + 1.25 * 1.5);
  EXPECT_DOUBLE_EQ(value_at(ct, V(2.5, 1, 0)), 65 + 100 + 2.5);
  EXPECT_DOUBLE_EQ(value_at(ct, V(-1, 0.5, 0.4)), 50);
  EXPECT_DOUBLE_EQ(value_at(ct, V(9, 9, -9)), 296);
}

TEST(EnterCapsuleTest, AgreesWithSphereTracing) {
  constexpr double kTolerance = 1e-6;
  std::mt19937 random(5);
  int hits = 0;
  for (int i = 0; i < 5000; ++i) {
    CapsuleSurface<double> c{.a = random_vector(random, 5),
                             .b = random_vector(random, 5),
                             .radius = 1.5,
                             .rgb = V::Zero(),
                             .alpha = 1};
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
      // A miss, or a ray that touches the surface only, which the tracer cannot decide.
      const bool misses = !(found > 0 && std::isfinite(found));
      EXPECT_TRUE(misses || gap < 1e-3) << i;
      continue;
    }
    ++hits;
    // The tracer stops early if the ray nearly touches. The surface point itself must be correct.
    EXPECT_NEAR(distance_to_segment(ray.origin + found * ray.direction, c.a, c.b), c.radius,
                kTolerance)
        << i;
    EXPECT_NEAR(found, t, 1e-3) << i;
  }
  EXPECT_GT(hits, 1000);
}

TEST(ClipToBoxTest, ContainsExactlyThePointsInside) {
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

TEST(RayOfTest, RaysOfTheCornersSpanTheFieldOfView) {
  VoxelGrid grid;
  Camera camera{{{1, 2, 3}}, {{1, 12, 3}}, {{0, 0, 2}}};
  camera.vertical_fov_rad = 0.8;
  const auto view = make_view<double>(camera, 400, 200, grid);
  // The middle of the top row is half a pixel below the upper edge.
  const V top = 0.5 * (ray_of(view, 199, 0).direction + ray_of(view, 200, 0).direction);
  EXPECT_NEAR(top.z() / top.y(), std::tan(0.4) * (1 - 1.0 / 200), 1e-5);
  const V right = 0.5 * (ray_of(view, 399, 99).direction + ray_of(view, 399, 100).direction);
  EXPECT_NEAR(right.x() / right.y(), 2 * std::tan(0.4) * (1 - 1.0 / 400), 1e-5);
  EXPECT_NEAR(ray_of(view, 7, 9).direction.norm(), 1.0, 1e-15);
}

Shading matte(ShadingStyle style) {
  Shading shading;
  shading.style = style;
  shading.ambient = 0.2;
  shading.diffuse = 0.5;
  shading.specular = 0;
  return shading;
}

TEST(ShadeSampleTest, FadesInWithTheGradientAndIsTwoSided) {
  const Shading shading = matte(ShadingStyle::kPhong);
  const V rgb(0.8, 0.4, 0.2);
  const V along(0, 1, 0);
  const V light = V(-1, 0, 1).normalized();
  const auto shade = [&](const V& gradient, double share) {
    return shade_sample<double>(rgb, gradient, along, light, share, shading);
  };
  EXPECT_EQ(shade(V::Zero(), 1), rgb);
  EXPECT_NEAR(shade({0, 50, 0}, 1).x(), 0.8 * 0.7, 1e-12);
  EXPECT_EQ(shade({0, 50, 0}, 1), shade({0, -50, 0}, 1));
  EXPECT_NEAR(shade({0, 5, 0}, 1).x(), 0.5 * (0.8 + 0.8 * 0.7), 1e-12);
  EXPECT_EQ(shade({0, 50, 0}, 0), rgb);
  EXPECT_NEAR(shade({0, 50, 0}, 0.25).x(), 0.8 + 0.25 * (0.8 * 0.7 - 0.8), 1e-12);
  EXPECT_EQ(shade({1e-320, 0, 0}, 1).allFinite(), true) << "denormal gradients";
}

TEST(ShadedShareTest, BlendsShadedAndPlainColourAsInThePaper) {
  Shading shading;
  for (const double importance : {0.0, 0.3, 1.0}) {
    shading.emphasis = 0;
    EXPECT_EQ(shaded_share(importance, shading), 1) << "no emphasis: all is shaded";
    shading.emphasis = 1;
    EXPECT_NEAR(shaded_share(importance, shading), importance, 1e-15);
    shading.emphasis = 0.5;
    EXPECT_NEAR(shaded_share(importance, shading), 1 - 0.5 * (1 - importance), 1e-15);
  }
  EXPECT_EQ(shaded_share(1.0F, shading), 1.0F);
}

TEST(GoochTest, RunsFromCoolToWarmAndDarkensEdges) {
  Shading shading;
  shading.silhouette = 0;
  const V rgb(0.8, 0.2, 0.2);
  const V cool = gooch<double>(rgb, 1, -1, shading);
  const V warm = gooch<double>(rgb, 1, 1, shading);
  EXPECT_NEAR((cool - V(0.25 * 0.8, 0.25 * 0.2, 0.25 * 0.2 + 0.4)).norm(), 0, 1e-12);
  EXPECT_NEAR((warm - V(0.6 * 0.8 + 0.4, 0.6 * 0.2 + 0.4, 0.6 * 0.2)).norm(), 0, 1e-12);
  EXPECT_NEAR((gooch<double>(rgb, 1, 0, shading) - 0.5 * (cool + warm)).norm(), 0, 1e-12);
  shading.silhouette = 0.7;
  EXPECT_NEAR((gooch<double>(rgb, 0, 1, shading) - 0.3 * warm).norm(), 0, 1e-12) << "edge-on";
  EXPECT_EQ(gooch<double>(rgb, 1, 1, shading), warm) << "facing: as without";
  EXPECT_EQ(gooch<double>(rgb, -1.0001, 2, shading), warm) << "rounded cosines are clamped";
}

TEST(GoochTest, IsTwoSidedAndLitFromTheUpperLeft) {
  const Shading shading = matte(ShadingStyle::kGooch);
  VoxelGrid grid;
  const auto view = make_view<double>({{{0, -10, 0}}, {{0, 0, 0}}, {{0, 0, 1}}}, 10, 10, grid);
  const V light = gooch_light(view);
  EXPECT_NEAR((light - V(-1, 0, 1).normalized()).norm(), 0, 1e-12) << "x is right, z up";
  const V along = view.forward;
  const V rgb(0.5, 0.5, 0.5);
  const auto shade = [&](const V& gradient) {
    return shade_sample<double>(rgb, gradient, along, light, 1, shading);
  };
  const V lit = shade({-40, -40, 40});
  EXPECT_EQ(lit, shade({40, 40, -40})) << "the normal is turned to the eye";
  EXPECT_GT(lit.x(), shade({40, -40, -40}).x()) << "warm towards the light";
}

TEST(JitterTest, IsUniformWithoutCorrelationAlongRows) {
  double sum = 0;
  double product = 0;
  constexpr int kSize = 200;
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      const double u = jitter_of(x, y);
      ASSERT_TRUE(u >= 0 && u < 1);
      sum += u;
      product += (u - 0.5) * (jitter_of(x + 1, y) - 0.5);
    }
  }
  // Three standard deviations of 40 000 uniform numbers.
  EXPECT_NEAR(sum / (kSize * kSize), 0.5, 3 * std::sqrt(1.0 / 12) / kSize);
  EXPECT_NEAR(product / (kSize * kSize), 0, 3.0 / 12 / kSize);
}

TEST(ShadesTest, GrowWithWeightAndLengthWithinBounds) {
  EXPECT_EQ(spec::shades_of(0, 0.5), 1);
  EXPECT_EQ(spec::shades_of(1, 1e-9), 1);
  EXPECT_EQ(spec::shades_of(1, 1), spec::kMostShades);
  EXPECT_EQ(spec::shades_of(1, 1e6), spec::kMostShades);
  EXPECT_EQ(spec::shades_of(0.02, 0.5), 1);
  EXPECT_EQ(spec::shades_of(0.05, 0.5), 2);
  EXPECT_EQ(spec::shades_of(0.05, 2), 3);
  int before = 1;
  for (double weight = 0; weight <= 1; weight += 1.0 / 64) {
    const int now = spec::shades_of(weight, 0.25);
    EXPECT_GE(now, before);
    before = now;
  }
}

}  // namespace
}  // namespace nav::render::spec
