// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/openigtlink/igtl_image.hpp"

#include <bit>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "tests/devices/igtl_wire.hpp"
#include "tests/support/matchers.hpp"

namespace nav::devices {
namespace {

using test::Bytes;
using test::GreyImage;

constexpr ErrorCode kMalformed = ErrorCode::kMalformedData;
constexpr double kSingleMm = 1e-4;  ///< Rounding of positions to single precision.

TEST(IgtlImageTest, TheMatrixPlacesTheCentreNotTheFirstPixel) {
  GreyImage grey(5, 3);  // Odd and not square.
  grey.image.centre_mm = {100, 200, 300};
  // Columns run along -y, rows along +z.
  grey.image.steps_mm = {{{0, -0.2F, 0}, {0, 0, 0.5F}, {1, 0, 0}}};
  const Bytes content = grey.content();
  const auto image = decode_igtl_image(content);
  ASSERT_TRUE(test::has_value(image));
  EXPECT_TRUE(image->position_mm(2, 1, 0).isApprox(Eigen::Vector3d(100, 200, 300)));
  EXPECT_LT((image->position_mm(0, 0, 0) - Eigen::Vector3d(100, 200.4, 299.5)).norm(), kSingleMm);
  EXPECT_LT((image->position_mm(4, 2, 0) - Eigen::Vector3d(100, 199.6, 300.5)).norm(), kSingleMm);
  EXPECT_LT((image->spacing_mm() - Eigen::Vector3d(0.2, 0.5, 1)).norm(), kSingleMm);
  EXPECT_EQ(image->value(0, 0, 0), std::to_integer<int>(grey.pixels.front()));
  EXPECT_EQ(image->value(4, 2, 0), std::to_integer<int>(grey.pixels.back()));
  EXPECT_EQ(image->value(4, 0, 0), std::to_integer<int>(grey.pixels[4]));
}

TEST(IgtlImageTest, AnEvenImageAtTheOriginBeginsHalfItsExtentBefore) {
  const GreyImage grey(64, 48);
  const Bytes content = grey.content();
  const auto image = decode_igtl_image(content);
  ASSERT_TRUE(test::has_value(image));
  const Eigen::Vector3d expected(-31.5 * 0.2, -23.5 * 0.3, 0);
  EXPECT_LT((image->position_mm(0, 0, 0) - expected).norm(), kSingleMm);
}

TEST(IgtlImageTest, TurnsRasToLps) {
  GreyImage grey(1, 1);
  grey.image.centre_mm = {1, 2, 3};
  Bytes content = grey.content();
  EXPECT_EQ(decode_igtl_image(content)->position_lps_mm(0, 0, 0), Eigen::Vector3d(-1, -2, 3));
  grey.image.axes = IgtlAxes::kLps;
  content = grey.content();
  EXPECT_EQ(decode_igtl_image(content)->position_lps_mm(0, 0, 0), Eigen::Vector3d(1, 2, 3));
}

/// Pixels of three scalars in both byte orders.
template <class T, class Bits>
void expect_scalars(IgtlScalar scalar, const std::array<T, 3>& values) {
  for (const IgtlEndian endian : {IgtlEndian::kBig, IgtlEndian::kLittle}) {
    GreyImage grey(3, 1);
    Bytes pixels;
    for (const T value : values) {
      const auto bits = static_cast<std::uint64_t>(std::bit_cast<Bits>(value));
      for (std::size_t i = 0; i < sizeof(T); ++i) {
        const std::size_t shift = endian == IgtlEndian::kBig ? sizeof(T) - 1 - i : i;
        pixels.push_back(static_cast<std::byte>(bits >> (8 * shift) & 255u));
      }
    }
    grey.image.scalar = scalar;
    grey.image.endian = endian;
    grey.image.pixels = pixels;
    const Bytes content = grey.content();
    const auto image = decode_igtl_image(content);
    ASSERT_TRUE(test::has_value(image));
    for (std::size_t i = 0; i < values.size(); ++i) {
      EXPECT_EQ(image->value(i, 0, 0), static_cast<double>(values[i]))
          << static_cast<int>(scalar) << ' ' << static_cast<int>(endian);
    }
  }
}

TEST(IgtlImageTest, ReadsEveryScalarTypeInBothByteOrders) {
  expect_scalars<std::int8_t, std::uint8_t>(IgtlScalar::kInt8, {-128, 0, 127});
  expect_scalars<std::uint8_t, std::uint8_t>(IgtlScalar::kUint8, {0, 128, 255});
  expect_scalars<std::int16_t, std::uint16_t>(IgtlScalar::kInt16, {-32768, -2, 258});
  expect_scalars<std::uint16_t, std::uint16_t>(IgtlScalar::kUint16, {1, 258, 65535});
  expect_scalars<std::int32_t, std::uint32_t>(IgtlScalar::kInt32, {-70000, 1, 70000});
  expect_scalars<std::uint32_t, std::uint32_t>(IgtlScalar::kUint32, {1, 70000, 4000000000u});
  expect_scalars<float, std::uint32_t>(IgtlScalar::kFloat32, {-1.5F, 0.F, 1e30F});
  expect_scalars<double, std::uint64_t>(IgtlScalar::kFloat64, {-1.5, 0., 1e300});
}

TEST(IgtlImageTest, ReadsComponentsAndSlicesInTheirOrder) {
  Bytes pixels(2 * 2 * 2 * 3);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::byte>(i);
  GreyImage grey(2, 2);
  grey.image.components = 3;
  grey.image.size = grey.image.part_size = {2, 2, 2};
  grey.image.pixels = pixels;
  const Bytes content = grey.content();
  const auto image = decode_igtl_image(content);
  ASSERT_TRUE(test::has_value(image));
  EXPECT_EQ(image->value(0, 0, 0, 2), 2);
  EXPECT_EQ(image->value(1, 0, 0, 0), 3);
  EXPECT_EQ(image->value(0, 1, 0, 0), 6);
  EXPECT_EQ(image->value(0, 0, 1, 0), 12);
}

TEST(IgtlImageTest, RejectsAPartBeyondTheImage) {
  GreyImage grey(4, 2);
  grey.image.part_size = {2, 2, 1};
  grey.image.pixels = std::span(grey.pixels).first(4);
  grey.image.part_offset = {2, 0, 0};
  Bytes content = grey.content();
  ASSERT_TRUE(test::has_value(decode_igtl_image(content)));
  EXPECT_FALSE(decode_igtl_image(content)->is_whole());
  grey.image.part_offset = {3, 0, 0};
  content = grey.content();
  EXPECT_TRUE(
      test::rejects(decode_igtl_image(content), kMalformed, {"part", "4 columns", "2 from 3"}));
  grey.image.part_offset = {65535, 0, 0};
  content = grey.content();
  EXPECT_TRUE(test::rejects(decode_igtl_image(content), kMalformed, {"part", "65535"}));
}

TEST(IgtlImageTest, RejectsASpacingOfZeroOrNaN) {
  GreyImage grey(2, 2);
  grey.image.steps_mm[0] = {0, 0, 0};
  Bytes content = grey.content();
  EXPECT_TRUE(
      test::rejects(decode_igtl_image(content), kMalformed, {"spacing of columns", "found 0"}));
  grey.image.steps_mm[0] = {1, 0, 0};
  grey.image.steps_mm[1] = {std::numeric_limits<float>::quiet_NaN(), 0, 0};
  content = grey.content();
  EXPECT_TRUE(test::rejects(decode_igtl_image(content), kMalformed, {"spacing of rows", "nan"}));
  grey.image.steps_mm[1] = {0, 1, 0};
  grey.image.steps_mm[2] = {0, 0, 0};
  content = grey.content();
  EXPECT_TRUE(test::has_value(decode_igtl_image(content))) << "one slice needs no step";
}

TEST(IgtlImageTest, RejectsCodesThatDoNotExistAndPixelsThatAreMissing) {
  const GreyImage grey(4, 3);
  const Bytes good = grey.content();
  const auto with = [&](std::size_t offset, int value) {
    Bytes content = good;
    content[offset] = static_cast<std::byte>(value);
    return content;
  };
  EXPECT_TRUE(test::rejects(decode_igtl_image(with(2, 0)), kMalformed, {"component", "0"}));
  EXPECT_TRUE(test::rejects(decode_igtl_image(with(3, 9)), kMalformed, {"scalar type", "9"}));
  EXPECT_TRUE(test::rejects(decode_igtl_image(with(4, 3)), kMalformed, {"endian", "3"}));
  EXPECT_TRUE(test::rejects(decode_igtl_image(with(5, 0)), kMalformed, {"RAS", "0"}));
  EXPECT_TRUE(test::rejects(decode_igtl_image(with(67, 0)), kMalformed, {"columns", "0"}));
  EXPECT_TRUE(test::rejects(decode_igtl_image(with(3, 5)), kMalformed, {"24 bytes", "12"}));
  for (std::size_t size = 0; size < good.size(); ++size) {
    EXPECT_FALSE(decode_igtl_image(std::span(good).first(size))) << size;
  }
}

}  // namespace
}  // namespace nav::devices
