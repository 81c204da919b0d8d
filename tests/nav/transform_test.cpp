// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/transform.hpp"

#include <gtest/gtest.h>
#include <limits>
#include <type_traits>

#include "tests/support/matchers.hpp"

namespace nav {
namespace {

using frames::Ct;
using frames::Probe;
using frames::Reference;
using frames::Tracker;

template <class A, class B>
concept Composes = requires(A a, B b) {
  a* b;
};
template <class A, class B>
concept Subtracts = requires(A a, B b) {
  a - b;
};
template <class T>
concept HasIdentity = requires {
  T::identity();
};

// Transforms compose only if their frames match. Other compositions do not compile.
static_assert(Composes<Transform<Ct, Reference>, Transform<Reference, Tracker>>);
static_assert(!Composes<Transform<Ct, Reference>, Transform<Tracker, Probe>>);
static_assert(!Composes<Transform<Ct, Reference>, Transform<Ct, Reference>>);
static_assert(Composes<Transform<Ct, Reference>, Point<Reference>>);
static_assert(!Composes<Transform<Ct, Reference>, Point<Ct>>);
static_assert(!Composes<Transform<Ct, Reference>, Direction<Ct>>);
static_assert(!Composes<Transform<Ct, Reference>, Eigen::Vector3d>);
static_assert(Subtracts<Point<Ct>, Point<Ct>>);
static_assert(!Subtracts<Point<Ct>, Point<Reference>>);
static_assert(!std::is_assignable_v<Transform<Ct, Reference>&, Transform<Reference, Ct>>);
static_assert(!std::is_constructible_v<Transform<Ct, Reference>, Transform<Reference, Ct>>);
// A pose is measured, computed or absent. Therefore it has no default value, and there is no
// identity between different frames.
static_assert(!std::is_default_constructible_v<Transform<Ct, Reference>>);
static_assert(!HasIdentity<Transform<Ct, Reference>>);
static_assert(HasIdentity<Transform<Ct, Ct>>);

constexpr double kRoundingMm = 1e-12;
constexpr double kRoundingRad = 1e-7;  // acos near 1 loses half the digits.

Transform<Ct, Reference> ct_from_reference() {
  const Eigen::AngleAxisd turn(0.7, Eigen::Vector3d(1, 2, 3).normalized());
  return {Eigen::Quaterniond(turn), {10, -20, 30}};
}

TEST(TransformTest, ComposesLikeMatrices) {
  const Transform<Reference, Tracker> reference_from_tracker(
      Eigen::Quaterniond(Eigen::AngleAxisd(-1.1, Eigen::Vector3d::UnitY())), {1, 2, 3});
  const auto ct_from_tracker = ct_from_reference() * reference_from_tracker;
  const Eigen::Matrix4d expected = ct_from_reference().matrix() * reference_from_tracker.matrix();
  EXPECT_LT((ct_from_tracker.matrix() - expected).norm(), 1e-13);
  const Point<Tracker> p{{4, 5, 6}};
  const Eigen::Vector4d q = expected * p.mm.homogeneous();
  EXPECT_LT(((ct_from_tracker * p).mm - q.head<3>()).norm(), kRoundingMm * 100);
}

TEST(TransformTest, InverseTimesTransformIsIdentity) {
  const auto round = ct_from_reference() * ct_from_reference().inverse();
  EXPECT_TRUE(test::is_near(round, (Transform<Ct, Ct>::identity()), 1e-13, kRoundingRad));
}

TEST(TransformTest, DirectionsAreNotTranslated) {
  const Direction<Reference> d{{1, 0, 0}};
  EXPECT_NEAR((ct_from_reference() * d).v.norm(), 1.0, kRoundingMm);
}

TEST(TransformTest, StaysRigidOverAMillionCompositions) {
  const Transform<Ct, Ct> small(
      Eigen::Quaterniond(Eigen::AngleAxisd(1e-3, Eigen::Vector3d::UnitZ())),
      Eigen::Vector3d::Zero());
  auto product = Transform<Ct, Ct>::identity();
  for (int i = 0; i < 1000000; ++i) product = product * small;
  EXPECT_NEAR(product.rotation().norm(), 1.0, 1e-15);
  const Eigen::Matrix3d r = product.rotation().toRotationMatrix();
  EXPECT_LT((r.transpose() * r - Eigen::Matrix3d::Identity()).norm(), 1e-14);
}

TEST(TransformTest, NanAndUnnormalisedRotationsAreBugs) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((Transform<Ct, Reference>(Eigen::Quaterniond::Identity(), {nan, 0, 0})), Bug);
  EXPECT_THROW((Transform<Ct, Reference>(Eigen::Quaterniond(nan, 0, 0, 0), {0, 0, 0})), Bug);
  EXPECT_THROW((Transform<Ct, Reference>(Eigen::Quaterniond(1.01, 0, 0, 0), {0, 0, 0})), Bug);
}

TEST(RigidFromMatrixTest, AcceptsAMatrixOfSixDigitText) {
  Eigen::Matrix4d m;
  m << 0.231245, 0.951424, -0.203269, 172.641, -0.127436, -0.17751, -0.975833, -98.0022,  //
      -0.964513, 0.25156, 0.0801977, -22.0262, 0, 0, 0, 1;
  const auto pose = rigid_from_matrix<Tracker, Probe>(m);
  ASSERT_TRUE(test::has_value(pose));
  EXPECT_LT((pose->matrix() - m).cwiseAbs().maxCoeff(), 1e-5);
}

TEST(RigidFromMatrixTest, NamesEachDefect) {
  const auto defect = [](auto change) {
    Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
    change(m);
    return rigid_from_matrix<Tracker, Probe>(m);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  using Code = ErrorCode;
  EXPECT_TRUE(test::rejects(defect([&](auto& m) { m(1, 2) = nan; }), Code::kMalformedData,
                            {"ProbeToTracker", "nan", "row 2, column 3"}));
  EXPECT_TRUE(test::rejects(defect([&](auto& m) { m(0, 3) = inf; }), Code::kMalformedData,
                            {"ProbeToTracker", "inf"}));
  EXPECT_TRUE(test::rejects(defect([](auto& m) { m.template topLeftCorner<3, 3>() *= 2.0; }),
                            Code::kMalformedData, {"scaled"}));
  EXPECT_TRUE(
      test::rejects(defect([](auto& m) { m(0, 0) = -1; }), Code::kMalformedData, {"reflection"}));
  EXPECT_TRUE(
      test::rejects(defect([](auto& m) { m(3, 3) = 0; }), Code::kMalformedData, {"last row"}));
  EXPECT_TRUE(test::rejects(defect([](auto& m) {
                              m.setZero();
                              m(3, 3) = 1;
                            }),
                            Code::kMalformedData, {"column lengths 0 0 0"}));
}

TEST(InterpolateTest, TakesTheShorterArcAndNeverExtrapolates) {
  const Transform<Ct, Probe> a(Eigen::Quaterniond::Identity(), {0, 0, 0});
  const Eigen::Quaterniond quarter(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()));
  const Transform<Ct, Probe> b(Eigen::Quaterniond(-quarter.coeffs()), {10, 0, 0});
  const auto half = interpolate(a, b, 0.5);
  EXPECT_NEAR(rotation_distance_rad(a, half), M_PI / 4, 1e-12);
  EXPECT_NEAR(half.translation_mm().x(), 5.0, kRoundingMm);
  EXPECT_THROW(interpolate(a, b, 1.0 + 1e-9), Bug);
  EXPECT_THROW(interpolate(a, b, -1e-9), Bug);
}

}  // namespace
}  // namespace nav
