// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/register/landmark_file.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <gtest/gtest.h>
#include <sstream>

#include "app/verbs/register/landmark_outcome.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::app {
namespace {

constexpr const char* kHeader =
    "name,reference_x_mm,reference_y_mm,reference_z_mm,ct_x_mm,ct_y_mm,ct_z_mm";

class LandmarkFileTest : public ::testing::Test {
 protected:
  auto read(const std::string& text) {
    const auto path = folder_ / "points.csv";
    std::ofstream(path) << text;
    return read_landmarks(path);
  }
  test::TemporaryFolder folder_;
};

TEST_F(LandmarkFileTest, ReadsTablesOfSpreadsheets) {
  const auto marked = read(std::string("\xEF\xBB\xBF") + kHeader + "\r\nTip,1,2,3,-4,5.5,10\r\n");
  ASSERT_TRUE(test::has_value(marked));
  EXPECT_EQ(marked->pairs[0].name, "Tip");
  std::string header = kHeader;
  std::ranges::replace(header, ',', ';');
  const auto separated = read(header + "\nTip;1;2;3;-4;5.5;10\n");
  ASSERT_TRUE(test::has_value(separated));
  EXPECT_EQ(separated->pairs[0].ct.mm, Eigen::Vector3d(-4, 5.5, 10));
}

TEST_F(LandmarkFileTest, ReadsCellsInQuotationMarks) {
  const auto list = read(std::string(kHeader) + "\n\"Tip, \"\"left\"\"\",1,\"2\",3,-4,5.5,10\n");
  ASSERT_TRUE(test::has_value(list));
  EXPECT_EQ(list->pairs[0].name, "Tip, \"left\"");
  EXPECT_EQ(list->pairs[0].reference.mm, Eigen::Vector3d(1, 2, 3));
}

TEST_F(LandmarkFileTest, ReadsTablesWithoutNamesOfTheColumns) {
  const auto list =
      read("\xEF\xBB\xBF# a comment; with a semicolon\nTip,1,2,3,-4,5.5,10\nB,0,0,0,0,0,0\n");
  ASSERT_TRUE(test::has_value(list));
  ASSERT_EQ(list->pairs.size(), 2u);
  EXPECT_EQ(list->pairs[0].name, "Tip");
  EXPECT_FALSE(list->sigmas_given);
  const auto with_sigma = read("Tip,1,2,3,-4,5.5,10,0.5\n");
  ASSERT_TRUE(test::has_value(with_sigma));
  EXPECT_EQ(with_sigma->pairs[0].sigma_mm, 0.5);
  EXPECT_TRUE(test::rejects(read("Tip,1,2,3,-4,5.5\n"), ErrorCode::kMalformedData,
                            {":1:", "column 1 to be name"}));
}

TEST_F(LandmarkFileTest, TakesACommaForADecimalPointWhereItCannotSeparate) {
  for (const std::string text : {"Tip;1,5;2;3;-4;5,5;10\n", "Tip,\"1,5\",2,3,-4,\"5,5\",10\n"}) {
    const auto list = read(text);
    ASSERT_TRUE(test::has_value(list)) << text;
    EXPECT_EQ(list->pairs[0].reference.mm, Eigen::Vector3d(1.5, 2, 3)) << text;
    EXPECT_EQ(list->pairs[0].ct.mm, Eigen::Vector3d(-4, 5.5, 10)) << text;
  }
  EXPECT_TRUE(test::rejects(read(std::string(kHeader) + "\nTip,\"1,234.5\",2,3,4,5,6\n"),
                            ErrorCode::kMalformedData, {":2:", "1,234.5"}));
}

TEST_F(LandmarkFileTest, ReadsPairsInOrder) {
  const auto pairs =
      read(std::string(kHeader) +
           ",sigma_mm\r\n# tip first\nTip , 1,2,3, -4,5.5,1e1,0.5\nBase,0,0,0,0,0,0,2\n");
  ASSERT_TRUE(test::has_value(pairs));
  ASSERT_EQ(pairs->pairs.size(), 2u);
  EXPECT_TRUE(pairs->sigmas_given);
  EXPECT_TRUE(pairs->shaped.empty());
  EXPECT_EQ(pairs->pairs[0].name, "Tip");
  EXPECT_EQ(pairs->pairs[0].reference.mm, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(pairs->pairs[0].ct.mm, Eigen::Vector3d(-4, 5.5, 10));
  EXPECT_EQ(pairs->pairs[1].sigma_mm, 2);
}

TEST_F(LandmarkFileTest, ReadsTheAxesOfTheErrorsInBothFrames) {
  const auto list = read(std::string(kHeader) +
                         ",reference_sigma_x_mm,reference_sigma_y_mm,reference_sigma_z_mm,"
                         "ct_sigma_x_mm,ct_sigma_y_mm,ct_sigma_z_mm\n"
                         "Tip,1,2,3,4,5,6,0.1,0.2,0.3,0,0,2\n");
  ASSERT_TRUE(test::has_value(list));
  ASSERT_EQ(list->shaped.size(), 1u);
  EXPECT_NEAR(list->shaped[0].reference_covariance_mm2(1, 1), 0.04, 1e-12);
  EXPECT_NEAR(list->shaped[0].ct_covariance_mm2(2, 2), 4, 1e-12);
  EXPECT_EQ(list->shaped[0].ct_covariance_mm2(0, 2), 0);
  EXPECT_NEAR(list->pairs[0].sigma_mm, std::sqrt((0.01 + 0.04 + 0.09 + 4) / 3), 1e-12);
  EXPECT_TRUE(test::rejects(read(std::string(kHeader) + ",sigma_mm,reference_sigma_x_mm\n"),
                            ErrorCode::kMalformedData, {"column 8", "reference_sigma_x_mm"}));
}

TEST_F(LandmarkFileTest, RejectsErrorsByLineAndColumn) {
  using Code = ErrorCode;
  const std::string header = std::string(kHeader) + "\n";
  EXPECT_TRUE(test::rejects(read("x,y,z\n1,2,3\n"), Code::kMalformedData, {":1:", "name", "x"}));
  EXPECT_TRUE(test::rejects(read(header + "Tip,1,2,3,4,5\n"), Code::kMalformedData,
                            {":2:", "7 values", "found 6"}));
  EXPECT_TRUE(test::rejects(read(header + "Tip,1,2,nan,4,5,6\n"), Code::kMalformedData,
                            {":2:", "reference_z_mm", "nan"}));
  EXPECT_TRUE(test::rejects(read(header + "Tip,1,2,3,4,5,6mm\n"), Code::kMalformedData,
                            {"ct_z_mm", "6mm"}));
  EXPECT_TRUE(test::rejects(read(header), Code::kMalformedData, {"found none"}));
  EXPECT_TRUE(
      test::rejects(read_landmarks(folder_ / "missing.csv"), Code::kNotFound, {"missing.csv"}));
}

/// Lines of a landmark file for pairs of points.
std::string lines_of(const std::vector<Eigen::Vector3d>& reference,
                     const std::vector<Eigen::Vector3d>& ct) {
  std::ostringstream text;
  text << kHeader << ",sigma_mm\n";
  for (std::size_t i = 0; i < reference.size(); ++i) {
    text << 'p' << i;
    for (const Eigen::Vector3d& p : {reference[i], ct[i]}) {
      for (const double x : p) text << ',' << x;
    }
    text << ",0.3\n";
  }
  return text.str();
}

TEST_F(LandmarkFileTest, WarnsOfPairsThatNoOtherPairChecks) {
  const Point<frames::Ct> target{{10, 10, 10}};
  CollectingDiagnostics diagnostics;
  const auto warnings_of = [&](const std::vector<Eigen::Vector3d>& reference,
                               const std::vector<Eigen::Vector3d>& ct) {
    const auto path = folder_ / "points.csv";
    std::ofstream(path) << lines_of(reference, ct);
    const auto outcome = register_landmark_file(path, "", nullptr, diagnostics);
    EXPECT_TRUE(test::has_value(outcome));
    const auto decision = decide(*outcome, target);
    EXPECT_TRUE(decision.accepted);
    return decision.warnings;
  };
  // A triangle with two equal sides: with two points swapped it fits as well.
  const std::vector<Eigen::Vector3d> equal{{0, 150, 0}, {-30, 0, 0}, {30, 0, 0}};
  for (const auto& warnings :
       {warnings_of(equal, equal), warnings_of(equal, {equal[0], equal[2], equal[1]})}) {
    ASSERT_EQ(warnings.size(), 2u) << warnings.back();
    EXPECT_NE(warnings[0].find("expected at least 4"), std::string::npos) << warnings[0];
    EXPECT_NE(warnings[1].find("'p1' and 'p2' may be swapped"), std::string::npos) << warnings[1];
    EXPECT_NE(warnings[1].find("180 degrees"), std::string::npos) << warnings[1];
  }
  const std::vector<Eigen::Vector3d> unlike{{0, 150, 0}, {-90, 0, 0}, {30, 0, 0}};
  EXPECT_EQ(warnings_of(unlike, unlike).size(), 1u);
  const std::vector<Eigen::Vector3d> four{{0, 150, 0}, {-90, 0, 0}, {30, 0, 0}, {0, 10, 90}};
  EXPECT_TRUE(warnings_of(four, four).empty());
  // Nearly in one plane: a mirrored list fits as well, so both lists get a warning.
  const std::vector<Eigen::Vector3d> flat{{0, 150, 0}, {-90, 0, 0}, {30, 0, 1}, {70, 90, 0}};
  std::vector<Eigen::Vector3d> mirrored = flat;
  for (Eigen::Vector3d& p : mirrored) p.x() = -p.x();
  for (const auto& ct : {flat, mirrored}) {
    const auto warnings = warnings_of(flat, ct);
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_NE(warnings[0].find("left from right"), std::string::npos);
  }
}

TEST(LandmarkUnitTest, RejectsPointsInMetresAndMicrometres) {
  const auto scaled = [](double by) {
    return std::vector<Eigen::Vector3d>{
        by * Eigen::Vector3d(0, 0, 0), by * Eigen::Vector3d(40, 0, 0),
        by * Eigen::Vector3d(0, 60, 0), by * Eigen::Vector3d(0, 0, 90)};
  };
  EXPECT_TRUE(test::has_value(check_unit(scaled(1), "Ct points")));
  EXPECT_TRUE(test::has_value(check_unit(scaled(0.1), "Ct points"))) << "a small bone";
  EXPECT_TRUE(test::rejects(check_unit(scaled(1e-3), "Ct points"), ErrorCode::kMalformedData,
                            {"Ct points: expected points in millimetres", "in metres?"}));
  EXPECT_TRUE(test::rejects(check_unit(scaled(1e3), "points"), ErrorCode::kMalformedData,
                            {"points: ", "in micrometres?"}));
}

}  // namespace
}  // namespace nav::app
