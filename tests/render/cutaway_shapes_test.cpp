// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <random>

#include "tests/render/cutaway_support.hpp"

namespace nav::render::spec {
namespace {

using test::best_of;
using test::cone_value;
using test::polygon_of;
using V = Vec3<double>;
using Rays = std::vector<Ray<double>>;

constexpr double kDeg = std::numbers::pi / 180;
/// Tolerance of the search for the truth, relative to the slope of the cone.
constexpr double kSearch = 1e-9;

double cot_of(double deg) { return 1 / std::tan(deg * kDeg); }

class CutawayShapesTest : public ::testing::Test {
 protected:
  V vector(double size) {
    std::uniform_real_distribution<double> u(-size, size);
    return {u(random_), u(random_), u(random_)};
  }
  double unit() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  Ray<double> ray(double distance) {
    const V direction = vector(1).normalized();
    return {vector(30) - distance * direction, direction};
  }
  /// A polygon around \p middle in a random plane. If \p jagged, it is not convex.
  std::vector<V> star(int count, const V& middle, double size, bool jagged) {
    const V u = vector(1).normalized();
    const V v = u.unitOrthogonal();
    std::vector<V> vertices;
    for (int i = 0; i < count; ++i) {
      const double angle = 2 * std::numbers::pi * (i + 0.3 * unit()) / count;
      const double radius = jagged ? size * (0.2 + 0.8 * unit()) : size;
      vertices.emplace_back(middle + radius * (std::cos(angle) * u + std::sin(angle) * v));
    }
    return vertices;
  }
  /// Compares the closed form with a search over the fan of triangles around \p middle.
  static void expect_attained(const std::vector<V>& vertices, const V& middle,
                              const Ray<double>& ray, double cot) {
    double best = -std::numeric_limits<double>::infinity();
    for (std::size_t i = 0, j = vertices.size() - 1; i < vertices.size(); j = i++) {
      best = std::max(best, best_of(middle, vertices[j], vertices[i], ray, cot));
    }
    const double found = cone_polygon(polygon_of(vertices), ray, cot);
    EXPECT_NEAR(found, best, kSearch * (1 + cot)) << vertices.size() << " vertices, cot " << cot;
  }
  std::mt19937 random_{23};
};

TEST_F(CutawayShapesTest, PolygonsOf3To32VerticesEqualTheBestOfTheirPoints) {
  for (int count = 3; count <= 32; ++count) {
    for (int trial = 0; trial < 4; ++trial) {
      const V middle = vector(20);
      const auto vertices = star(count, middle, 40, trial % 2 == 1);
      expect_attained(vertices, middle, ray(200), cot_of(5 + 80 * unit()));
    }
  }
}

TEST_F(CutawayShapesTest, NarrowAndWideConesEqualTheBestOfAllPoints) {
  for (const double deg : {0.1, 1.0, 10.0, 45.0, 80.0, 89.0, 89.9}) {
    for (int trial = 0; trial < 10; ++trial) {
      const V middle = vector(20);
      expect_attained(star(5, middle, 40, true), middle, ray(200), cot_of(deg));
    }
  }
}

TEST_F(CutawayShapesTest, DifficultPositionsEqualTheBestOfAllPoints) {
  for (int trial = 0; trial < 30; ++trial) {
    const V middle = vector(20);
    const auto vertices = star(6, middle, 40, trial % 2 == 0);
    const double cot = cot_of(20 + 50 * unit());
    const V edge = (vertices[1] - vertices[0]).normalized();
    expect_attained(vertices, middle, {vertices[0] - 100 * edge, edge}, cot);  // Along an edge.
    expect_attained(vertices, middle, {middle - 100 * edge, edge}, cot);  // In the plane of the
                                                                          // polygon.
    const V out = edge.cross(vertices[2] - vertices[0]).normalized();
    expect_attained(vertices, middle, {middle + 50 * out, out}, cot);  // The polygon is behind the
                                                                       // eye.
    expect_attained(vertices, middle, {middle, vector(1).normalized()}, cot);  // The polygon
                                                                               // contains the eye.
    expect_attained(vertices, middle, {vertices[2], vector(1).normalized()}, cot);
    expect_attained(vertices, middle, {middle + 5 * out, edge}, cot);  // Crosses the plane of the
                                                                       // eye.
    expect_attained(vertices, middle, {middle - 80 * out, out}, cot);  // Perpendicular to the
                                                                       // polygon.
  }
}

TEST_F(CutawayShapesTest, DegeneratePolygonsEqualTheBestOfTheirPoints) {
  for (int trial = 0; trial < 30; ++trial) {
    const V a = vector(30);
    const V b = vector(30);
    const Ray<double> r = ray(200);
    const double cot = cot_of(10 + 70 * unit());
    const V c = a + 0.3 * (b - a);
    expect_attained({a, c, b}, c, r, cot);        // Without area.
    expect_attained({a, b, c, b, a}, c, r, cot);  // Folded onto itself.
    expect_attained({a, a, a}, a, r, cot);        // A point.
    expect_attained({a, b}, c, r, cot);           // A segment.
    const V d = vector(30);
    expect_attained({a, c, b, d}, c, r, cot);        // Three of four vertices on a line.
    expect_attained({a, a, b, b, d, d}, c, r, cot);  // Each vertex twice.
  }
}

TEST(ConeSegmentTest, IsCorrectIfTheSlopeEqualsThatOfTheCone) {
  // The ray runs along +z with cot = 1. The edge rises by exactly its length across the ray.
  const Ray<double> ray{{0, 0, 0}, {0, 0, 1}};
  for (const double side : {0.0, 3.0}) {
    const V a(-5, side, 10);
    const V b(5, side, 20);
    EXPECT_NEAR(cone_segment(a, b, ray, 1.0), 20 - std::hypot(5, side), 1e-12);
    EXPECT_NEAR(cone_segment(b, a, ray, 1.0), 20 - std::hypot(5, side), 1e-12);
  }
  // The plane is exactly as steep as the cone, so the whole line of steepest descent is equally
  // good.
  const auto steep = polygon_of({{-5, -5, 5}, {5, -5, 15}, {5, 5, 15}, {-5, 5, 5}});
  EXPECT_NEAR(cone_polygon(steep, ray, 1.0), 10, 1e-12);
}

TEST_F(CutawayShapesTest, SegmentsEqualTheBestOfTheirPoints) {
  for (int trial = 0; trial < 300; ++trial) {
    const V a = vector(40);
    const V b = trial % 10 == 0 ? a : vector(40);
    Ray<double> r = ray(150);
    if (trial % 7 == 0 && trial % 10 != 0) r.direction = (b - a).normalized();
    const double cot = cot_of(0.5 + 89 * unit());
    EXPECT_NEAR(cone_segment(a, b, r, cot), best_of(a, b, a, r, cot), kSearch * (1 + cot)) << trial;
  }
}

TEST_F(CutawayShapesTest, BallsEqualTheBestOfTheirPoints) {
  for (int trial = 0; trial < 200; ++trial) {
    const CutawayBall<double> ball{vector(30), 1 + 20 * unit()};
    const Ray<double> r =
        trial % 4 == 0 ? Ray<double>{ball.centre + vector(5), vector(1).normalized()} : ray(100);
    const double cot = cot_of(0.5 + 89 * unit());
    const double found = cone_ball(ball, r, cot);
    // The best point lies on the circle in the half plane of the ray and the centre.
    const V m = ball.centre - r.origin;
    const V across = m - m.dot(r.direction) * r.direction;
    const V e = across.norm() > 0 ? V(across.normalized()) : r.direction.unitOrthogonal();
    double best = -1e300;
    constexpr int kCount = 20000;
    for (int i = 0; i < kCount; ++i) {
      const double angle = 2 * std::numbers::pi * i / kCount;
      best = std::max(best, cone_value(ball.centre + ball.radius * (std::cos(angle) * r.direction +
                                                                    std::sin(angle) * e),
                                       r, cot));
    }
    EXPECT_GE(found, best - 1e-9) << trial;
    EXPECT_LE(found, best + (1 + cot) * ball.radius * std::numbers::pi / kCount) << trial;
    for (int i = 0; i < 200; ++i) {
      const V q = ball.centre + ball.radius * std::cbrt(unit()) * vector(1).normalized();
      EXPECT_GE(found, cone_value(q, r, cot) - 1e-9) << trial;
    }
  }
}

TEST_F(CutawayShapesTest, WiderConesReachDeeper) {
  for (int trial = 0; trial < 200; ++trial) {
    const auto polygon = polygon_of(star(7, vector(20), 40, true));
    const CutawayBall<double> ball{vector(30), 10};
    const Ray<double> r = ray(100);
    double last_polygon = -1e300;
    double last_ball = -1e300;
    for (double deg = 1; deg < 90; deg += 4) {
      const double t_polygon = cone_polygon(polygon, r, cot_of(deg));
      const double t_ball = cone_ball(ball, r, cot_of(deg));
      EXPECT_GE(t_polygon, last_polygon - 1e-9) << deg;
      EXPECT_GE(t_ball, last_ball - 1e-9) << deg;
      last_polygon = t_polygon;
      last_ball = t_ball;
    }
  }
}

TEST_F(CutawayShapesTest, AnObjectNeverOccludesItselfAlongItsOwnRays) {
  for (int trial = 0; trial < 200; ++trial) {
    const V middle = vector(20);
    const auto vertices = star(9, middle, 40, false);
    const V eye = vector(300);
    const V q = middle + 0.3 * (vertices[static_cast<std::size_t>(trial % 9)] - middle);
    const Ray<double> r{eye, (q - eye).normalized()};
    EXPECT_GE(cone_polygon(polygon_of(vertices), r, cot_of(30)), (q - eye).norm() - 1e-9);
  }
}

TEST_F(CutawayShapesTest, PerspectiveConvergesToOrthographic) {
  for (int trial = 0; trial < 20; ++trial) {
    const auto polygon = polygon_of(star(6, vector(20), 40, true));
    const V axis = vector(1).normalized();
    const V through = vector(30);
    const double cot = cot_of(15 + 60 * unit());
    // Depth relative to the point through which all rays pass.
    const double parallel = cone_polygon(polygon, {through - 100 * axis, axis}, cot) - 100;
    for (const double distance : {1e3, 1e4, 1e5, 1e6}) {
      const V eye = through - through.dot(axis) * axis - distance * axis -
                    (through - through.dot(axis) * axis);
      const V to = through - eye;
      const double found = cone_polygon(polygon, {eye, to.normalized()}, cot) - to.norm();
      // The rays turn by at most 60 mm / distance, over points within 120 mm.
      EXPECT_NEAR(found, parallel, 60 / distance * 120 * (1 + cot) + 1e-9 * distance) << distance;
    }
  }
}

TEST_F(CutawayShapesTest, SinglePrecisionStaysWithinAHundredthOfAMillimetre) {
  double worst = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const auto vertices = star(3 + trial % 30, vector(20), 60, false);
    const double cot = cot_of(10 + 75 * unit());
    const Ray<double> r = ray(400);
    const auto polygon = polygon_of(vertices);
    CutawayPolygon<float> single{{},
                                 polygon.normal.cast<float>(),
                                 polygon.axis_u.cast<float>(),
                                 polygon.axis_v.cast<float>()};
    for (const V& v : vertices) single.vertices.push_back(v.cast<float>());
    const Ray<float> r32{r.origin.cast<float>(), r.direction.cast<float>()};
    const double error =
        cone_polygon(single, r32, static_cast<float>(cot)) - cone_polygon(polygon, r, cot);
    worst = std::max(worst, std::abs(error) / (1 + cot));
  }
  RecordProperty("worst_mm", std::to_string(worst));
  EXPECT_LT(worst, 0.01 / 6);
}

}  // namespace
}  // namespace nav::render::spec
