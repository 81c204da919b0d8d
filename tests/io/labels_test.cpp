// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/labels.hpp"

#include <gtest/gtest.h>
#include <limits>

#include "tests/io/support.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

namespace nav::io {
namespace {

class LabelFileTest : public ::testing::Test {
 protected:
  template <class T>
  Result<LabelFile> read(const std::string& type, const std::vector<T>& values) {
    test::put(folder_ / "a.mha",
              "ObjectType = Image\nNDims = 3\nBinaryData = True\n"
              "TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 5 6 7\n"
              "ElementSpacing = 2 3 4\nDimSize = 2 1 2\nElementType = " +
                  type + "\nElementDataFile = LOCAL\n" + test::bytes_of(values));
    return read_labels(folder_ / "a.mha", diagnostics_);
  }
  test::TemporaryFolder folder_;
  CollectingDiagnostics diagnostics_;
};

TEST_F(LabelFileTest, ReadsEveryWholeNumberExactly) {
  const auto expect = [](const Result<LabelFile>& file, const std::vector<std::uint32_t>& values) {
    ASSERT_TRUE(test::has_value(file));
    EXPECT_EQ(file->values, values);
    EXPECT_EQ(file->grid.at({1, 0, 1}).mm, Eigen::Vector3d(7, 6, 11));
  };
  expect(read<std::uint16_t>("MET_USHORT", {0, 32767, 32768, 65535}), {0, 32767, 32768, 65535});
  expect(read<std::uint32_t>("MET_UINT", {1U << 31, 4294967295U, 4294967294U, 7}),
         {1U << 31, 4294967295U, 4294967294U, 7});
  expect(read<std::int32_t>("MET_INT", {2147483647, 0, 1 << 30, 65536}),
         {2147483647, 0, 1U << 30, 65536});
  expect(read<float>("MET_FLOAT", {0, 1, 16777216, 2147483648.0F}), {0, 1, 16777216, 1U << 31});
  EXPECT_TRUE(diagnostics_.entries().empty());
}

TEST_F(LabelFileTest, RejectsInvalidLabelsAndNamesTheirValueAndIndex) {
  constexpr auto kCode = ErrorCode::kMalformedData;
  EXPECT_TRUE(test::rejects(read<float>("MET_FLOAT", {0, 1.6F, 1, 2}), kCode,
                            {"a.mha", "whole numbers", "0 to 4294967295", "1.6", "(1, 0, 0)"}));
  EXPECT_TRUE(test::rejects(read<std::int16_t>("MET_SHORT", {0, 0, -3, 2}), kCode,
                            {"a.mha", "-3", "(0, 0, 1)"}));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(test::rejects(read<float>("MET_FLOAT", {0, 0, 0, nan}), kCode, {"nan", "(1, 0, 1)"}));
  EXPECT_TRUE(
      test::rejects(read<double>("MET_DOUBLE", {0, 4294967296.0, 0, 0}), kCode, {"4294967296"}));
}

TEST_F(LabelFileTest, AcceptsASingleSlice) {
  test::put(folder_ / "slice.mha",
            "ObjectType = Image\nNDims = 3\nBinaryData = True\n"
            "TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 0 0 0\nElementSpacing = 1 1 1\n"
            "DimSize = 2 1 1\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n" +
                test::bytes_of(std::vector<std::uint8_t>{3, 4}));
  const auto file = read_labels(folder_ / "slice.mha", diagnostics_);
  ASSERT_TRUE(test::has_value(file));
  EXPECT_EQ(file->values, (std::vector<std::uint32_t>{3, 4}));
}

TEST_F(LabelFileTest, RejectsOtherKindsOfFiles) {
  EXPECT_TRUE(test::rejects(read_labels(folder_ / "a.png", diagnostics_),
                            ErrorCode::kUnsupportedData, {"a.png", "expected labels as .nii"}));
}

}  // namespace
}  // namespace nav::io
