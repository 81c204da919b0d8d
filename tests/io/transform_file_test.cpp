// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/transform_file.hpp"

#include <Eigen/Geometry>
#include <fstream>
#include <gtest/gtest.h>
#include <iterator>
#include <numbers>

#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::io {
namespace {

constexpr double kRoundingMm = 1e-9;

class TransformFileTest : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& body) {
    const auto path = folder_ / "a.tfm";
    std::ofstream(path) << "#Insight Transform File V1.0\n" << body;
    return path;
  }
  static std::string transform(const std::string& type, const std::string& parameters,
                               const std::string& fixed) {
    return "#Transform 0\nTransform: " + type + "\nParameters: " + parameters +
           "\nFixedParameters: " + fixed + "\n";
  }
  /// Position in the CT, LPS, of a point of the patient's frame.
  Eigen::Vector3d in_ct(const std::string& body, const Eigen::Vector3d& reference) {
    const auto read = read_ct_from_reference(write(body));
    EXPECT_TRUE(test::has_value(read));
    if (!read) return Eigen::Vector3d::Zero();
    return (*read * reference.homogeneous()).head<3>();
  }
  Error error_of(const std::string& body) {
    const auto read = read_ct_from_reference(write(body));
    EXPECT_FALSE(read);
    return read ? Error{ErrorCode::kCancelled, "none"} : read.error();
  }
  test::TemporaryFolder folder_;
};

// In 3D Slicer, the node ReferenceToRas maps (x, y, z) of the tracked body to RAS
// (10 - y, 20 + x, 30 + z). Its inverse in LPS, which ITK stores, maps (a, b, c) of the CT to
// (b + 20, -a - 10, c - 30).
constexpr const char* kMatrix = "0 1 0 -1 0 0 0 0 1 ";

TEST_F(TransformFileTest, HasTheDirectionAndTheAxesOf3dSlicer) {
  const std::string file =
      transform("AffineTransform_double_3_3", std::string(kMatrix) + "20 -10 -30", "0 0 0");
  // RAS (8, 21, 33).
  EXPECT_TRUE(in_ct(file, {1, 2, 3}).isApprox(Eigen::Vector3d(-8, -21, 33), kRoundingMm));
}

TEST_F(TransformFileTest, EveryRigidKindOfItkIsReadWithItsCentre) {
  // About the centre (5, 6, 7) the same map has the translation (21, -21, -30).
  const std::string angle = std::to_string(-std::numbers::pi / 2);
  const std::string half = std::to_string(-std::numbers::sqrt2 / 2);
  for (const auto& [type, parameters] :
       {std::pair<std::string, std::string>{"AffineTransform_float_3_3", kMatrix},
        {"MatrixOffsetTransformBase_double_3_3", kMatrix},
        {"Euler3DTransform_double_3_3", "0 0 " + angle + " "},
        {"VersorRigid3DTransform_double_3_3", "0 0 " + half + " "}}) {
    const Eigen::Vector3d found =
        in_ct(transform(type, parameters + "21 -21 -30", "5 6 7"), {1, 2, 3});
    // The texts above have six digits.
    EXPECT_LT((found - Eigen::Vector3d(-8, -21, 33)).norm(), 1e-3) << type << found.transpose();
  }
  EXPECT_TRUE(in_ct(transform("TranslationTransform_double_3_3", "1 2 3", ""), {0, 0, 0})
                  .isApprox(Eigen::Vector3d(-1, -2, -3), kRoundingMm));
  EXPECT_TRUE(in_ct(transform("IdentityTransform_double_3_3", "", ""), {4, 5, 6})
                  .isApprox(Eigen::Vector3d(-4, -5, 6), kRoundingMm));
}

TEST_F(TransformFileTest, TheAnglesOfEulerHaveTheOrderOfItk) {
  // Angles of 90 degrees about x and y. Z X Y, the usual order: (1, 0, 0) of the CT becomes
  // (0, 1, 0) in LPS, (0, -1, 0) in RAS. Z Y X: (0, 0, -1).
  const std::string angles = "1.5707963267948966 1.5707963267948966 0 0 0 0";
  const std::string type = "Euler3DTransform_double_3_3";
  EXPECT_LT((in_ct(transform(type, angles, "0 0 0"), {0, -1, 0}) - Eigen::Vector3d::UnitX()).norm(),
            kRoundingMm);
  EXPECT_LT(
      (in_ct(transform(type, angles, "0 0 0 0"), {0, -1, 0}) - Eigen::Vector3d::UnitX()).norm(),
      kRoundingMm);
  EXPECT_LT(
      (in_ct(transform(type, angles, "0 0 0 1"), {0, 0, -1}) - Eigen::Vector3d::UnitX()).norm(),
      kRoundingMm);
}

TEST_F(TransformFileTest, WhatIsWrittenIsReadToTheSameNumbers) {
  Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
  pose.topLeftCorner<3, 3>() =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  pose.topRightCorner<3, 1>() << 12.25, -1000.0 / 3, 77;
  const auto path = folder_ / "b.tfm";
  ASSERT_TRUE(test::has_value(write_ct_from_reference(pose, path)));
  const auto read = read_ct_from_reference(path);
  ASSERT_TRUE(test::has_value(read));
  EXPECT_LT((*read - pose).cwiseAbs().maxCoeff(), 1e-10);
  std::ifstream file(path);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_TRUE(
      text.starts_with("#Insight Transform File V1.0\n#Transform 0\n"
                       "Transform: AffineTransform_double_3_3\nParameters: "));
  EXPECT_TRUE(text.ends_with("\nFixedParameters: 0 0 0\n"));
}

TEST_F(TransformFileTest, NamesWhatIsWrong) {
  const std::string affine = "AffineTransform_double_3_3";
  const auto expect = [&](const std::string& body, ErrorCode code,
                          const std::vector<std::string>& pieces) {
    const Error error = error_of(body);
    EXPECT_EQ(error.code, code) << error.message;
    for (const std::string& piece : pieces) {
      EXPECT_NE(error.message.find(piece), std::string::npos) << piece << " in " << error.message;
    }
    EXPECT_NE(error.message.find("a.tfm"), std::string::npos) << error.message;
    EXPECT_LT(error.message.size(), 400U);
  };
  expect(transform(affine, "1 0 0", "0 0 0"), ErrorCode::kMalformedData,
         {"Parameters: expected 12 numbers of AffineTransform, found 3"});
  expect(transform(affine, "1 0 0 0 1 0 0 0 1 0 0 nan", "0 0 0"), ErrorCode::kMalformedData,
         {"Parameters: expected finite numbers"});
  expect(transform(affine, std::string(100000, 'x'), "0 0 0"), ErrorCode::kMalformedData,
         {"Parameters: expected finite numbers", "xxx..."});
  expect(transform(affine, "0 0 0 0 1 0 0 0 1 0 0 0", "0 0 0"), ErrorCode::kMalformedData,
         {"can be inverted"});
  expect(transform(affine, "1 0 0 0 1 0 0 0 1 0 0 0", "0 0"), ErrorCode::kMalformedData,
         {"FixedParameters: expected 3 numbers, the centre of rotation, found 2"});
  expect(transform("VersorRigid3DTransform_double_3_3", "1 1 0 0 0 0", "0 0 0"),
         ErrorCode::kMalformedData, {"versor of length 1"});
  expect(transform("BSplineTransform_double_3_3", "1", "0"), ErrorCode::kUnsupportedData,
         {"Transform: expected one of AffineTransform", "found BSplineTransform"});
  expect(transform("AffineTransform_double_2_2", "1 0 0 1 0 0", "0 0"), ErrorCode::kMalformedData,
         {"Transform: expected a transform of three dimensions"});
  const std::string one = transform(affine, "1 0 0 0 1 0 0 0 1 0 0 0", "0 0 0");
  expect(one + one, ErrorCode::kUnsupportedData, {"a.tfm:7", "expected one transform"});
  expect("Foo: 1\n", ErrorCode::kMalformedData, {"a.tfm:2", "found 'Foo: 1'"});
  expect("", ErrorCode::kMalformedData, {"Transform: expected"});
  const auto other = folder_ / "a.tfm";
  std::ofstream(other) << "\x1b[31m";
  const auto read = read_ct_from_reference(other);
  EXPECT_TRUE(test::rejects(read, ErrorCode::kMalformedData, {"a.tfm", "first line", "\\x1b[31m"}));
  EXPECT_TRUE(test::rejects(read_ct_from_reference(folder_ / "none.tfm"), ErrorCode::kNotFound,
                            {"none.tfm"}));
}

}  // namespace
}  // namespace nav::io
