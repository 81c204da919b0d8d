// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/landmarks/anisotropic_landmarks.hpp"

#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "registration/landmarks/tre_map.hpp"
#include "registration/twist.hpp"
#include "tests/registration/normal.hpp"
#include "tests/registration/synthetic.hpp"
#include "tests/support/matchers.hpp"

namespace nav::registration {
namespace {

Eigen::Matrix3d shaped(double a, double b, double c, const Eigen::Vector3d& axis, double angle) {
  const Eigen::Matrix3d r = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
  return r * Eigen::Vector3d(a * a, b * b, c * c).asDiagonal() * r.transpose();
}

/// Exact pairs whose errors are elongated in different directions, like those of a tracker with
/// poor depth accuracy and a CT with thick slices. The errors differ between the points.
std::vector<AnisotropicLandmark> exact(const Eigen::Vector3d& offset = Eigen::Vector3d::Zero()) {
  const std::vector<Eigen::Vector3d> points{{-60, 20, 10}, {55, -5, 30},  {0, 70, -40},
                                            {20, 10, 90},  {-30, -50, 5}, {40, 35, -70}};
  const auto truth = test::true_pose(offset);
  std::vector<AnisotropicLandmark> out;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double x = static_cast<double>(i);
    const Point<frames::Reference> reference{points[i]};
    out.push_back({.name = "point " + std::to_string(i),
                   .reference = reference,
                   .ct = truth * reference,
                   .reference_covariance_mm2 = shaped(0.2, 0.3, 1.0 + 0.2 * x, {1, x, -1}, 0.3 * x),
                   .ct_covariance_mm2 = shaped(0.2, 0.2, 0.5 + 0.1 * x, {0, 1, x}, 0.2)});
  }
  return out;
}

std::vector<AnisotropicLandmark> noisy(test::Normal& normal) {
  auto list = exact();
  for (AnisotropicLandmark& one : list) {
    one.reference.mm += normal.vector(one.reference_covariance_mm2);
    one.ct.mm += normal.vector(one.ct_covariance_mm2);
  }
  return list;
}

double cost_of(const std::vector<AnisotropicLandmark>& list,
               const Transform<frames::Ct, frames::Reference>& pose) {
  const Eigen::Matrix3d r = pose.rotation().toRotationMatrix();
  double sum = 0;
  for (const auto& one : list) {
    const Eigen::Vector3d e = one.ct.mm - (pose * one.reference).mm;
    const Eigen::Matrix3d c =
        one.ct_covariance_mm2 + r * one.reference_covariance_mm2 * r.transpose();
    sum += e.dot(c.inverse() * e);
  }
  return sum;
}

TEST(AnisotropicLandmarksTest, FindsTheTrueTransformFarFromTheOrigin) {
  const Eigen::Vector3d offset(1e4, -1e4, 1e4);
  const auto result = register_anisotropic_landmarks(exact(offset));
  ASSERT_TRUE(test::has_value(result));
  constexpr double kRoundingMm = 1e-7;  // 1e4 mm with 16 digits, times the lever arm.
  EXPECT_LT(test::cube_error_mm(result->ct_from_reference, test::true_pose(offset), offset),
            kRoundingMm);
  EXPECT_LT(result->residuals[3].leave_one_out_mm, kRoundingMm);
}

TEST(AnisotropicLandmarksTest, EqualIsotropicErrorsGiveTheClosedForm) {
  test::Normal normal(4);
  auto list = noisy(normal);
  std::vector<LandmarkPair> pairs;
  for (AnisotropicLandmark& one : list) {
    one.reference_covariance_mm2 = 0.36 * Eigen::Matrix3d::Identity();
    one.ct_covariance_mm2 = 0.64 * Eigen::Matrix3d::Identity();
    pairs.push_back({one.name, one.reference, one.ct, 1.0});
  }
  const auto found = register_anisotropic_landmarks(list);
  const auto closed = register_landmarks(pairs);
  ASSERT_TRUE(test::has_value(found));
  ASSERT_TRUE(test::has_value(closed));
  EXPECT_TRUE(test::is_near(found->ct_from_reference, closed->ct_from_reference, 1e-5, 1e-6));
  EXPECT_NEAR(found->fre_rms_mm, closed->fre_rms_mm, 1e-9);
  EXPECT_NEAR(found->sigma_scale, closed->sigma_scale, 1e-9);
  const Point<frames::Ct> target{{30, -80, 60}};
  EXPECT_NEAR(found->tre_rms_mm(target), closed->tre_rms_mm(target), 1e-5);
}

TEST(AnisotropicLandmarksTest, NoNeighbouringPoseIsMoreLikely) {
  test::Normal normal(9);
  const auto list = noisy(normal);
  const auto found = register_anisotropic_landmarks(list);
  ASSERT_TRUE(test::has_value(found));
  const auto& pose = found->ct_from_reference;
  const double least = cost_of(list, pose);
  // The gradient of the definition, by central differences, is zero there, because the exact
  // Jacobian includes the rotation of the covariances.
  for (Eigen::Index axis = 0; axis < 6; ++axis) {
    const double h = axis < 3 ? 1e-5 : 1e-3;
    const Vector6d step = h * Vector6d::Unit(axis);
    const Eigen::Vector3d centre = found->uncertainty.centre_ct.mm;
    const double up = cost_of(list, moved(pose, centre, step));
    const double down = cost_of(list, moved(pose, centre, -step));
    EXPECT_GT(std::min(up, down), least) << axis;
    EXPECT_LT(std::abs(up - down), 2e-3 * (up + down - 2 * least)) << axis;
  }
}

TEST(AnisotropicLandmarksTest, PredictsTheTargetErrorAndBeatsTheClosedForm) {
  const auto truth = test::true_pose();
  const Point<frames::Reference> target{{30, -80, 60}};
  constexpr int kTrials = 3000;
  // The standard error of an RMS of 3000 draws is about 1 %.
  constexpr double kRelative = 0.03;
  test::Normal normal(3);
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  double closed2 = 0;
  double scale2 = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto list = noisy(normal);
    const auto found = register_anisotropic_landmarks(list);
    ASSERT_TRUE(test::has_value(found));
    const Eigen::Vector3d error = (found->ct_from_reference * target).mm - (truth * target).mm;
    scatter += error * error.transpose() / kTrials;
    scale2 += found->sigma_scale * found->sigma_scale / kTrials;
    if (trial % 10 != 0) continue;
    std::vector<LandmarkPair> pairs;
    for (const auto& one : list) pairs.push_back({one.name, one.reference, one.ct, 1.0});
    const auto closed = register_landmarks(pairs);
    closed2 += ((closed->ct_from_reference * target).mm - (truth * target).mm).squaredNorm() * 10 /
               kTrials;
  }
  const auto exact_fit = register_anisotropic_landmarks(exact());
  ASSERT_TRUE(test::has_value(exact_fit));
  const Point<frames::Ct> at = truth * target;
  EXPECT_NEAR(std::sqrt(scatter.trace()) / exact_fit->tre_rms_mm(at), 1.0, kRelative);
  const Eigen::Matrix3d predicted = exact_fit->tre_covariance(at);
  EXPECT_LT((scatter - predicted).norm() / predicted.norm(), 4 * kRelative);
  EXPECT_NEAR(std::sqrt(scale2), 1.0, kRelative);
  EXPECT_LT(scatter.trace(), 0.8 * closed2);
}

TEST(AnisotropicLandmarksTest, ThePoseIsDeterminedByTheAccurateAxes) {
  // Each point is accurate along one axis only. Errors along the inaccurate axes must not matter.
  auto list = exact();
  for (std::size_t i = 0; i < list.size(); ++i) {
    Eigen::Vector3d sigmas = Eigen::Vector3d::Constant(300.0);
    sigmas[static_cast<Eigen::Index>(i % 3)] = 0.1;
    list[i].ct_covariance_mm2 = sigmas.cwiseAbs2().asDiagonal();
    list[i].reference_covariance_mm2.setZero();
    Eigen::Vector3d blind = Eigen::Vector3d::Constant(2.0);
    blind[static_cast<Eigen::Index>(i % 3)] = 0;
    list[i].ct.mm += blind;
  }
  const auto result = register_anisotropic_landmarks(list);
  ASSERT_TRUE(test::has_value(result));
  // The weights are 1 : 9e6.
  EXPECT_LT(test::cube_error_mm(result->ct_from_reference, test::true_pose()), 0.01);
}

TEST(AnisotropicLandmarksTest, RejectsInvalidCovariancesByName) {
  const auto code = ErrorCode::kMalformedData;
  auto list = exact();
  list[1].ct_covariance_mm2(0, 1) += 1;
  EXPECT_TRUE(
      test::rejects(register_anisotropic_landmarks(list), code, {"point 1", "Ct", "symmetric"}));
  list = exact();
  list[2].reference_covariance_mm2(2, 2) = -4;
  EXPECT_TRUE(test::rejects(register_anisotropic_landmarks(list), code, {"point 2", "Reference"}));
  list = exact();
  list[0].reference_covariance_mm2(0, 0) = std::nan("");
  EXPECT_TRUE(test::rejects(register_anisotropic_landmarks(list), code, {"point 0", "finite"}));
  list = exact();
  list[4].reference_covariance_mm2.setZero();
  list[4].ct_covariance_mm2.setZero();
  EXPECT_TRUE(test::rejects(register_anisotropic_landmarks(list), code, {"point 4", "0.001"}));
  list.resize(2);
  EXPECT_TRUE(test::rejects(register_anisotropic_landmarks(list), code, {"at least 3"}));
}

TEST(TreMapTest, EqualsTheFormulaAtItsNodes) {
  const auto fit = register_anisotropic_landmarks(exact());
  ASSERT_TRUE(test::has_value(fit));
  VoxelGrid ct = test::cubic_grid(80, 2.0);
  ct.size[2] = 1;
  const TreMap map = tre_map(fit->uncertainty, ct, 20);
  EXPECT_EQ(map.grid.size, (std::array<int, 3>{9, 9, 2}));
  const auto node = map.grid.at({3, 5, 1});
  EXPECT_NEAR(map.rms_mm[9 * 9 + 5 * 9 + 3], fit->tre_rms_mm(node), 1e-6);
  EXPECT_NEAR(map.grid.at({8, 8, 0}).mm.x(), 80, 1e-9);
  EXPECT_EQ(map.fraction_within(map.worst_mm()), 1.0);
  EXPECT_LT(map.fraction_within(fit->tre_rms_mm(fit->uncertainty.centre_ct)), 0.2);
}

TEST(TreMapTest, LimitsTheNumberOfNodesOfAHugeCt) {
  // A CT whose millimetres were read as metres. Nodes 20 mm apart would be 10^11.
  VoxelGrid ct;
  ct.size = {256, 256, 128};
  ct.spacing_mm.setConstant(700);
  PoseUncertainty uncertainty{{ct.centre()}, Matrix6d::Zero()};
  uncertainty.covariance.bottomRightCorner<3, 3>().diagonal().setConstant(3);
  const TreMap map = tre_map(uncertainty, ct, 20);
  EXPECT_LE(map.rms_mm.size(), std::size_t{1} << 22);
  EXPECT_EQ(map.rms_mm.size(), map.grid.voxel_count());
  EXPECT_GE(map.step_mm, 20);
  EXPECT_NEAR(map.worst_mm(), 3, 1e-6);
  const Eigen::Vector3d last(map.grid.size[0] - 1, map.grid.size[1] - 1, map.grid.size[2] - 1);
  EXPECT_LE((map.grid.at(last).mm - ct.at(Eigen::Vector3d(255, 255, 127)).mm).norm(), 1e-6);
}

}  // namespace
}  // namespace nav::registration
