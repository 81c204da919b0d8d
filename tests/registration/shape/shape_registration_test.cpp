// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <numbers>
#include <random>

#include "registration/shape/shape_acceptance.hpp"
#include "tests/registration/synthetic.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/trials.hpp"

namespace nav::registration {
namespace {

using Pose = Transform<frames::Ct, frames::Reference>;
constexpr double kPi = std::numbers::pi;

class Random {
 public:
  explicit Random(unsigned seed) : random_(seed) {}
  double uniform() { return (static_cast<double>(random_()) + 0.5) / 4294967296.0; }
  double normal() {
    const double radius = std::sqrt(-2 * std::log(uniform()));
    return radius * std::cos(2 * kPi * uniform());
  }

 private:
  std::mt19937 random_;
};

/// Returns a surface r(u, v) with u and v in [0, 1] as triangles.
TriangleMesh mesh_of(const std::function<Eigen::Vector3d(double, double)>& surface, int nu,
                     int nv) {
  TriangleMesh mesh{{}, {}, "test surface"};
  for (int j = 0; j <= nv; ++j) {
    for (int i = 0; i <= nu; ++i) {
      mesh.points_mm.push_back(surface(static_cast<double>(i) / nu, static_cast<double>(j) / nv));
    }
  }
  for (int j = 0; j < nv; ++j) {
    for (int i = 0; i < nu; ++i) {
      const int a = j * (nu + 1) + i;
      mesh.triangles.push_back({a, a + 1, a + nu + 1});
      mesh.triangles.push_back({a + 1, a + nu + 2, a + nu + 1});
    }
  }
  return mesh;
}

/// A surface with bumps like a bone, without symmetry.
Eigen::Vector3d landscape(double u, double v) {
  const double x = 140 * (u - 0.5);
  const double y = 110 * (v - 0.5);
  const double z = 14 * std::sin(x / 17 + 0.3) * std::cos(y / 23) + 9 * std::sin((x - 2 * y) / 31) +
                   0.004 * x * x - 12 * std::exp(-((x - 30) * (x - 30) + y * y) / 300);
  return {x, y, z};
}

Eigen::Vector3d cylinder(double u, double v) {
  return {30 * std::cos(2 * kPi * u), 30 * std::sin(2 * kPi * u), 160 * (v - 0.5)};
}
Eigen::Vector3d sphere(double u, double v) {
  const double a = 2 * kPi * u;
  const double b = kPi * (v - 0.5);
  return {40 * std::cos(b) * std::cos(a) + 10, 40 * std::cos(b) * std::sin(a), 40 * std::sin(b)};
}
Eigen::Vector3d plane(double u, double v) { return {150 * (u - 0.5), 150 * (v - 0.5), 20}; }

ShapeField field_of(const TriangleMesh& mesh, double spacing_mm = 2) {
  const auto shape = surface_shape(mesh, 3);
  EXPECT_TRUE(test::has_value(shape));
  auto field = ShapeField::create(*shape, {.spacing_mm = spacing_mm, .margin_mm = 30});
  EXPECT_TRUE(test::has_value(field));
  return *field;
}

std::vector<Point<frames::Reference>> touched(
    const std::function<Eigen::Vector3d(double, double)>& surface, int count, double noise_mm,
    unsigned seed, double inner = 0.1) {
  Random random(seed);
  const auto reference_from_ct = test::true_pose().inverse();
  std::vector<Point<frames::Reference>> points;
  for (int i = 0; i < count; ++i) {
    const double u = inner + (1 - 2 * inner) * random.uniform();
    const double v = inner + (1 - 2 * inner) * random.uniform();
    const Eigen::Vector3d noise(random.normal(), random.normal(), random.normal());
    points.push_back(reference_from_ct * Point<frames::Ct>{surface(u, v) + noise_mm * noise});
  }
  return points;
}

const ShapeField& landscape_field() {
  static const ShapeField field = field_of(mesh_of(landscape, 140, 110));
  return field;
}

TEST(ShapeFieldTest, APlaneIsExactForEverySpacing) {
  const ShapeField field = field_of(mesh_of(plane, 30, 30), 7);
  for (const double height : {-9.0, -0.1, 0.0, 0.7, 12.0}) {
    const Eigen::Vector3d p(11.3, -20.7, 20 + height);
    const ShapeSample sample = field.at(p);
    EXPECT_NEAR(sample.offset_mm.z(), height, 1e-9);
    // The surface element of a node 7 mm away does not reach the point.
    EXPECT_NEAR(sample.distance_mm, std::abs(height), 2.0);
    EXPECT_GE(sample.distance_mm, std::abs(height));
    EXPECT_EQ(field.distance_mm(p), sample.distance_mm);
    EXPECT_LT((sample.by_point - Eigen::Vector3d::UnitZ() * Eigen::RowVector3d::UnitZ()).norm(),
              1e-9);
  }
  // Beyond its rim, the plane continues for the offset but not for the distance.
  EXPECT_NEAR(field.at({95, 0, 20}).offset_mm.norm(), 0, 1e-9);
  EXPECT_NEAR(field.distance_mm({95, 0, 20}), 20, 4);
}

TEST(ShapeFieldTest, DerivativeIsThatOfTheOffset) {
  Random random(3);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Vector3d p =
        landscape(random.uniform(), random.uniform()) +
        6 * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
    const ShapeSample sample = landscape_field().at(p);
    constexpr double kStep = 1e-6;  // The step meets a kink between two cells once in 10⁶.
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const Eigen::Vector3d e = kStep * Eigen::Vector3d::Unit(axis);
      const Eigen::Vector3d slope =
          (landscape_field().at(p + e).offset_mm - landscape_field().at(p - e).offset_mm) /
          (2 * kStep);
      EXPECT_LT((slope - sample.by_point.col(axis)).norm(), 1e-5);
    }
  }
}

TEST(ShapeFieldTest, DistanceAgreesWithBruteForce) {
  const auto shape = surface_shape(mesh_of(landscape, 70, 55), 2);
  ASSERT_TRUE(test::has_value(shape));
  const auto field = ShapeField::create(*shape, {.spacing_mm = 2, .margin_mm = 20});
  ASSERT_TRUE(test::has_value(field));
  Random random(5);
  double worst = 0;
  for (int trial = 0; trial < 100; ++trial) {
    const Eigen::Vector3d p =
        landscape(random.uniform(), random.uniform()) +
        5 * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
    double least = 1e300;
    for (const auto& e : shape->elements) least = std::min(least, (e.point_mm - p).norm());
    worst = std::max(worst, std::abs(least - field->distance_mm(p)));
  }
  EXPECT_LT(worst, 1.5);  // The surface elements are points for brute force but 2 mm wide for the
                          // field.
}

TEST(ShapeRegistrationTest, FindsTheTruePoseFrom30MillimetresAnd20Degrees) {
  const auto points = touched(landscape, 600, 0.3, 1);
  for (unsigned seed = 1; seed <= test::trials(4U); ++seed) {
    const Pose start = test::off_by(test::true_pose(), 30, 20 * kPi / 180, seed);
    const auto result = register_points(points, landscape_field(), start);
    ASSERT_TRUE(test::has_value(result));
    EXPECT_LT(test::cube_error_mm(result->ct_from_reference, test::true_pose()), 0.3) << seed;
    EXPECT_TRUE(result->sliding.empty()) << result->sliding[0].description;
    EXPECT_LT(result->after.mean_mm, 0.5);
    EXPECT_GT(result->before.mean_mm, 5);
    const Decision decision = decide(*result, {}, {{0, 0, 0}});
    EXPECT_TRUE(decision.accepted) << (decision.reasons.empty() ? "" : decision.reasons[0]);
  }
}

TEST(ShapeRegistrationTest, TrimsPointsThatMissTheSurface) {
  auto points = touched(landscape, 600, 0.2, 2);
  for (std::size_t i = 0; i < points.size(); i += 5) {
    points[i].mm += Eigen::Vector3d(25 + static_cast<double>(i % 7), 15, -20);
  }
  ShapeRegistrationOptions options;
  options.keep_fraction = 0.75;
  const auto result = register_points(points, landscape_field(),
                                      test::off_by(test::true_pose(), 10, 0.15, 3), options);
  ASSERT_TRUE(test::has_value(result));
  EXPECT_LT(test::cube_error_mm(result->ct_from_reference, test::true_pose()), 0.3);
  EXPECT_EQ(result->trimmed, 150);
}

TEST(ShapeRegistrationTest, PredictsItsErrorWithinAFactorOfTwo) {
  const Pose start = test::off_by(test::true_pose(), 3, 0.03, 1);
  ShapeRegistrationOptions options;
  options.starts = 0;
  double found2 = 0;
  double predicted2 = 0;
  for (unsigned seed = 10; seed < 30; ++seed) {
    const auto result =
        register_points(touched(landscape, 400, 0.5, seed), landscape_field(), start, options);
    ASSERT_TRUE(test::has_value(result));
    const Point<frames::Reference> target =
        test::true_pose().inverse() * Point<frames::Ct>{{20, 10, -40}};
    found2 +=
        ((result->ct_from_reference * target).mm - Eigen::Vector3d(20, 10, -40)).squaredNorm();
    predicted2 += std::pow(result->tre_rms_mm({{20, 10, -40}}), 2);
  }
  EXPECT_GT(predicted2 / found2, 0.25);
  EXPECT_LT(predicted2 / found2, 4.0);
}

TEST(ShapeRegistrationTest, ADeformedSurfaceIncreasesThePredictedError) {
  // A known discrepancy that no pose can compensate: waves of 60 mm with 1.2 mm RMS.
  constexpr double kRms = 1.2;
  const auto bent = [](double u, double v) {
    Eigen::Vector3d p = landscape(u, v);
    p.z() += std::sqrt(2.0) * kRms * std::sin(2 * kPi * (p.x() + 0.6 * p.y()) / 60);
    return p;
  };
  ShapeRegistrationOptions options;
  options.starts = 0;
  const Pose start = test::off_by(test::true_pose(), 2, 0.02, 1);
  const auto plain =
      register_points(touched(landscape, 800, 0.5, 3), landscape_field(), start, options);
  const auto result =
      register_points(touched(bent, 800, 0.5, 3), landscape_field(), start, options);
  ASSERT_TRUE(test::has_value(plain));
  ASSERT_TRUE(test::has_value(result));
  EXPECT_EQ(plain->discrepancy_mm, 0);
  EXPECT_GT(result->discrepancy_mm, 0.5 * kRms);  // The discrepancy is measured along the normals,
                                                  // which are oblique.
  EXPECT_LT(result->discrepancy_mm, 1.2 * kRms);
  // A point of the true surface has the error of the pose plus the wave.
  EXPECT_GT(result->tre_rms_mm({{20, 10, -40}}), kRms);
}

TEST(ShapeRegistrationTest, APlaneSlidesInThreeDirections) {
  const Pose start = test::off_by(test::true_pose(), 5, 0.1, 1);
  const auto result =
      register_points(touched(plane, 300, 0.2, 3), field_of(mesh_of(plane, 30, 30)), start);
  ASSERT_TRUE(test::has_value(result));
  ASSERT_EQ(result->sliding.size(), 3u);
  EXPECT_EQ(result->sliding[0].description.rfind("translation along Ct", 0), 0u);
  EXPECT_EQ(result->sliding[1].description.rfind("translation along Ct", 0), 0u);
  EXPECT_EQ(result->sliding[2].description.rfind("rotation about Ct (0.00, 0.00, 1.00)", 0), 0u)
      << result->sliding[2].description;
  // The determined directions are found to 0.2 mm of noise over the root of 300 points.
  for (const double x : {-40.0, 40.0}) {
    const auto p = test::true_pose().inverse() * Point<frames::Ct>{{x, -x, 20}};
    EXPECT_NEAR((result->ct_from_reference * p).mm.z(), 20, 0.1);
  }
  EXPECT_TRUE(std::isinf(result->tre_rms_mm({{0, 0, 20}})));
  EXPECT_FALSE(decide(*result, {}, {{0, 0, 20}}).accepted);
}

TEST(ShapeRegistrationTest, ACylinderSlidesAlongAndAboutItsAxis) {
  const Pose start = test::off_by(test::true_pose(), 5, 0.1, 2);
  const auto result =
      register_points(touched(cylinder, 400, 0.1, 4), field_of(mesh_of(cylinder, 90, 60)), start);
  ASSERT_TRUE(test::has_value(result));
  ASSERT_EQ(result->sliding.size(), 2u);
  EXPECT_EQ(result->sliding[0].description, "translation along Ct (0.00, 0.00, 1.00)");
  EXPECT_EQ(result->sliding[1].description.rfind("rotation about Ct (0.00, 0.00, 1.00)", 0), 0u)
      << result->sliding[1].description;
  // Undetermined directions keep the value of the start pose: its shift along the axis remains.
  const auto p = test::true_pose().inverse() * Point<frames::Ct>{{0, 0, 0}};
  EXPECT_NEAR((result->ct_from_reference * p).mm.z(), (start * p).mm.z(), 1.5);
}

TEST(ShapeRegistrationTest, ASphereRotatesAboutItsCentre) {
  ShapeRegistrationOptions options;
  options.starts = 0;
  const auto result =
      register_points(touched(sphere, 400, 0.1, 5), field_of(mesh_of(sphere, 90, 60)),
                      test::off_by(test::true_pose(), 5, 0.1, 2), options);
  ASSERT_TRUE(test::has_value(result));
  ASSERT_EQ(result->sliding.size(), 3u);
  for (const auto& one : result->sliding) {
    EXPECT_EQ(one.description.rfind("rotation about", 0), 0u) << one.description;
  }
  const auto centre = test::true_pose().inverse() * Point<frames::Ct>{{10, 0, 0}};
  EXPECT_LT(((result->ct_from_reference * centre).mm - Eigen::Vector3d(10, 0, 0)).norm(), 0.1);
}

/// A vessel tree: a curved trunk and three branches.
template <class Frame>
std::vector<CentreLine<Frame>> tree(const Transform<Frame, frames::Ct>& pose, double from = 0) {
  std::vector<CentreLine<Frame>> lines(4);
  for (int i = 0; i <= 40; ++i) {
    const double s = std::max(i / 40.0, from);
    const std::vector<Eigen::Vector3d> at = {
        {12 * std::sin(3 * s), 8 * s * s, 90 * s - 45},
        {40 * s, 8 * s + 10 * s * s, 10 + 20 * std::sin(2 * s)},
        {-35 * s, 5 - 15 * std::sin(2.5 * s), 25 * s},
        {5 - 10 * s * s, 45 * s, -20 - 12 * s}};
    for (std::size_t branch = 0; branch < at.size(); ++branch) {
      lines[branch].push_back(pose * Point<frames::Ct>{at[branch]});
    }
  }
  return lines;
}

TEST(ShapeRegistrationTest, FindsThePoseFromVesselCentreLines) {
  const auto shape = curve_shape(tree(Transform<frames::Ct, frames::Ct>::identity()), 1, "vessels");
  ASSERT_TRUE(test::has_value(shape));
  const auto field = ShapeField::create(*shape);
  ASSERT_TRUE(test::has_value(field));
  // The ultrasound shows only the outer parts of the branches, with noise of 0.5 mm.
  auto points = points_along(tree(test::true_pose().inverse(), 0.3), 1.5);
  Random random(6);
  for (auto& p : points)
    p.mm += 0.5 * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
  for (unsigned seed = 1; seed <= test::trials(3U); ++seed) {
    const auto result =
        register_points(points, *field, test::off_by(test::true_pose(), 30, 0.35, seed));
    ASSERT_TRUE(test::has_value(result));
    EXPECT_LT(test::cube_error_mm(result->ct_from_reference, test::true_pose()), 1.0) << seed;
    EXPECT_TRUE(result->sliding.empty());
  }
}

TEST(ShapeRegistrationTest, AStraightVesselSlidesAlongItself) {
  CentreLine<frames::Ct> line;
  CentreLine<frames::Reference> seen;
  for (int i = 0; i <= 50; ++i) {
    line.push_back({{0, 3.0 * i - 75, 0}});
    if (i > 10 && i < 40) seen.push_back(test::true_pose().inverse() * line.back());
  }
  const auto field = ShapeField::create(*curve_shape({line}, 1, "straight vessel"));
  ASSERT_TRUE(test::has_value(field));
  const auto result =
      register_points(points_along({seen}, 2), *field, test::off_by(test::true_pose(), 3, 0.05, 1));
  ASSERT_TRUE(test::has_value(result));
  ASSERT_EQ(result->sliding.size(), 2u);
  EXPECT_EQ(result->sliding[0].description, "translation along Ct (0.00, 1.00, 0.00)");
  EXPECT_EQ(result->sliding[1].description.rfind("rotation about Ct (0.00, 1.00, 0.00)", 0), 0u);
}

bool says(const std::vector<std::string>& texts, const std::string& what) {
  return std::any_of(texts.begin(), texts.end(),
                     [&](const std::string& text) { return text.find(what) != std::string::npos; });
}

std::string all_of(const Decision& decision) {
  std::string text;
  for (const auto& one : decision.reasons) text += one + "; ";
  return text;
}

TEST(ShapeRegistrationTest, TheMirroredSurfaceIsRejectedAndNamed) {
  const auto mirrored = [](double u, double v) {
    const Eigen::Vector3d p = landscape(u, v);
    return Eigen::Vector3d(-p.x(), p.y(), p.z());
  };
  const auto result = register_points(touched(landscape, 400, 0.3, 21),
                                      field_of(mesh_of(mirrored, 140, 110)), test::true_pose());
  ASSERT_TRUE(test::has_value(result));
  const Decision decision = decide(*result, {}, {{0, 0, 0}});
  EXPECT_FALSE(decision.accepted);
  EXPECT_TRUE(says(decision.reasons, "mirrored surface better")) << all_of(decision);
  EXPECT_TRUE(says(decision.reasons, "check the side"));
}

/// A roof with ridge and gables: half a turn about the vertical leaves it as it is, and a mirror
/// too.
Eigen::Vector3d hip_roof(double u, double v) {
  const double x = 80 * (u - 0.5);
  const double y = 60 * (v - 0.5);
  return {x, y, std::min(30 - std::abs(y), 40 - std::abs(x))};
}

TEST(ShapeRegistrationTest, ASymmetricShapeNeedsAPoseThatTheUserVouchesFor) {
  const auto result =
      register_points(touched(hip_roof, 400, 0.3, 22, 0), field_of(mesh_of(hip_roof, 80, 60)),
                      test::off_by(test::true_pose(), 4, 0.05, 1));
  ASSERT_TRUE(test::has_value(result));
  ASSERT_TRUE(result->evidence.has_value());
  ASSERT_FALSE(result->evidence->rivals.turned.empty());
  EXPECT_NEAR(result->evidence->rivals.turned[0].turned_deg, 180, 3);
  const Decision alone = decide(*result, {}, {{0, 0, 0}});
  EXPECT_FALSE(alone.accepted);
  EXPECT_TRUE(says(alone.reasons, "as well when turned by")) << all_of(alone);
  const KnownPose known{
      .ct_from_reference = test::true_pose(), .within_mm = 6, .tells_sides = false};
  const Decision vouched = decide(*result, {}, {{0, 0, 0}}, kShapeWarnings, known);
  EXPECT_TRUE(vouched.accepted) << all_of(vouched);
  EXPECT_TRUE(says(vouched.warnings, "its own mirror image"));
  const KnownPose elsewhere{.ct_from_reference = test::off_by(test::true_pose(), 20, 0, 3),
                            .within_mm = 6,
                            .tells_sides = false};
  EXPECT_TRUE(says(decide(*result, {}, {{0, 0, 0}}, kShapeWarnings, elsewhere).reasons,
                   "where the landmarks or the start put them"));
}

TEST(ShapeRegistrationTest, AShapeOfAnotherSizeIsRejectedByItsSize) {
  for (const double factor : {0.95, 1.05}) {
    const auto scaled = [&](double u, double v) {
      return Eigen::Vector3d(factor * landscape(u, v));
    };
    const auto result = register_points(touched(landscape, 500, 0.3, 23),
                                        field_of(mesh_of(scaled, 140, 110)), test::true_pose());
    ASSERT_TRUE(test::has_value(result));
    const Decision decision = decide(*result, {}, {{0, 0, 0}});
    EXPECT_FALSE(decision.accepted);
    EXPECT_TRUE(says(decision.reasons, factor < 1 ? "% larger" : "% smaller")) << all_of(decision);
    EXPECT_NEAR(result->evidence->strain.scale, factor - 1, 0.015);
  }
}

TEST(ShapeRegistrationTest, GivenNoiseJudgesTheResiduals) {
  const auto result = register_points(touched(landscape, 500, 0.9, 24), landscape_field(),
                                      test::off_by(test::true_pose(), 4, 0.05, 1));
  ASSERT_TRUE(test::has_value(result));
  EXPECT_NEAR(*result->evidence->noise.rough_mm, 0.9, 0.25);
  const Decision usual = decide(*result, {}, {{0, 0, 0}});
  EXPECT_TRUE(usual.accepted) << all_of(usual);
  const Decision strict = decide(*result, {}, {{0, 0, 0}}, kShapeWarnings, {}, 0.3);
  EXPECT_TRUE(says(strict.reasons, "residuals of the points")) << all_of(strict);
}

TEST(ShapeRegistrationTest, WarnsOfASharedDistanceOnlyWhereThePoseTakesItUp) {
  const auto warnings = [](const auto& surface, int nu, int nv, double inner) {
    const auto result =
        register_points(touched(surface, 500, 0.3, 25, inner), field_of(mesh_of(surface, nu, nv)),
                        test::off_by(test::true_pose(), 3, 0.03, 1));
    EXPECT_TRUE(test::has_value(result));
    ShapeLimits no_rivals;
    no_rivals.min_evidence = -1e9;
    const Decision decision = decide(*result, no_rivals, {{0, 0, 0}});
    EXPECT_TRUE(decision.accepted) << all_of(decision);
    return decision.warnings;
  };
  // The faces of the roof have one slope, so a shared distance is a shift; around a closed surface
  // it is not.
  EXPECT_TRUE(says(warnings(hip_roof, 80, 60, 0.0), "one side of the shape"));
  const auto potato = [](double u, double v) {
    Eigen::Vector3d p = sphere(u, v) - Eigen::Vector3d(10, 0, 0);
    p = p.cwiseProduct(Eigen::Vector3d(1.6, 1, 0.7));
    return Eigen::Vector3d(p * (1 + 0.12 * std::sin(p.x() / 11 + 1) + 0.1 * std::cos(p.y() / 9) +
                                0.1 * std::sin(p.z() / 8)));
  };
  EXPECT_FALSE(says(warnings(potato, 120, 80, 0.02), "one side of the shape"));
}

TEST(ShapeRegistrationTest, RejectsAnotherShape) {
  const auto result = register_points(touched(landscape, 400, 0.2, 7),
                                      field_of(mesh_of(sphere, 60, 40)), test::true_pose());
  ASSERT_TRUE(test::has_value(result));
  const Decision decision = decide(*result, {}, {{0, 0, 0}});
  EXPECT_FALSE(decision.accepted);
}

TEST(ShapeRegistrationTest, RejectsInvalidInput) {
  const auto code = ErrorCode::kMalformedData;
  auto points = touched(landscape, 50, 0, 1);
  const auto solve = [&] { return register_points(points, landscape_field(), test::true_pose()); };
  points[7].mm.x() = std::nan("");
  EXPECT_TRUE(test::rejects(solve(), code, {"point 7", "NaN"}));
  points[7].mm.x() = 1e300;  // The square of this coordinate is infinite.
  EXPECT_TRUE(test::rejects(solve(), code, {"point 7", "1e7 mm", "1e+300"}));
  points = touched(landscape, 19, 0, 1);
  EXPECT_TRUE(test::rejects(solve(), code, {"20 points", "19"}));
  points.assign(50, points[0]);
  EXPECT_TRUE(test::rejects(solve(), ErrorCode::kRefused, {"one position"}));
  EXPECT_TRUE(test::rejects(register_points(touched(landscape, 50, 0, 1), landscape_field(),
                                            test::true_pose(), {.keep_fraction = 0}),
                            ErrorCode::kUsage, {"keep_fraction"}));
  EXPECT_TRUE(test::rejects(register_points(touched(landscape, 50, 0, 1), landscape_field(),
                                            test::true_pose(), {}, [] { return false; }),
                            ErrorCode::kCancelled, {}));
  TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}, "thin.stl"};
  EXPECT_TRUE(test::rejects(surface_shape(mesh, 2), code, {"thin.stl", "area"}));
  mesh.triangles = {{0, 1, 3}};
  EXPECT_TRUE(test::rejects(surface_shape(mesh, 2), code, {"triangle 0", "0 to 2"}));
  mesh = {{{0, 0, 0}, {1, 0, 0}, {0, std::nan(""), 0}}, {{0, 1, 2}}, "thin.stl"};
  EXPECT_TRUE(test::rejects(surface_shape(mesh, 2), code, {"triangle 0", "finite"}));
  mesh.points_mm[2] = {0, 1e6, 0};
  EXPECT_TRUE(test::rejects(surface_shape(mesh, 1), code, {"2^24"}));
}

}  // namespace
}  // namespace nav::registration
