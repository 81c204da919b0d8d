// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/openigtlink/igtl_pixels.hpp"

#include <algorithm>
#include <gtest/gtest.h>
#include <initializer_list>
#include <string>
#include <vector>

#include "tests/devices/igtl_wire.hpp"
#include "tests/support/matchers.hpp"

namespace nav::devices {
namespace {

using Grey = std::vector<std::uint8_t>;

test::Bytes bytes_of(std::initializer_list<int> values) {
  test::Bytes bytes;
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value));
  return bytes;
}

/// An image of 2 x 2 pixels.
struct Small {
  explicit Small(std::initializer_list<int> values) : bytes(bytes_of(values)) {
    image.size = image.part_size = {2, 2, 1};
    image.pixels = bytes;
  }
  test::Bytes bytes;
  IgtlImage image;
  UltrasoundImage frame;
  GreyScale scale;

  [[nodiscard]] Grey grey() const {
    return {frame.pixels.pixels().begin(), frame.pixels.pixels().end()};
  }
};

TEST(IgtlPixelsTest, SixteenBitsOfBothByteOrdersHaveOneScale) {
  // 0, 1023, 512, 4: up to 1023, so that 1023 is white.
  Small little({0, 0, 0xFF, 3, 0, 2, 4, 0});
  little.image.scalar = IgtlScalar::kUint16;
  ASSERT_TRUE(set_pixels(little.frame, little.image, little.scale));
  EXPECT_EQ(little.grey(), (Grey{0, 255, 128, 1}));
  EXPECT_EQ(little.scale.white, 1023U);

  Small big({0, 0, 3, 0xFF, 2, 0, 0, 4});
  big.image.scalar = IgtlScalar::kInt16;
  big.image.endian = IgtlEndian::kBig;
  ASSERT_TRUE(set_pixels(big.frame, big.image, big.scale));
  EXPECT_EQ(big.grey(), little.grey());

  // A brighter image keeps the scale: what is above white is white.
  Small brighter({0xFF, 0x7F, 0xFF, 3, 0, 2, 4, 0});
  brighter.image.scalar = IgtlScalar::kUint16;
  ASSERT_TRUE(set_pixels(brighter.frame, brighter.image, big.scale));
  EXPECT_EQ(brighter.grey(), (Grey{255, 255, 128, 1}));
  EXPECT_EQ(big.scale.largest, 0x7FFFU);
}

TEST(IgtlPixelsTest, ABlackImageDecidesNoScale) {
  Small black({0, 0, 0, 0, 0, 0, 0, 0});
  black.image.scalar = IgtlScalar::kUint16;
  ASSERT_TRUE(set_pixels(black.frame, black.image, black.scale));
  EXPECT_EQ(black.grey(), (Grey{0, 0, 0, 0}));
  EXPECT_EQ(black.scale.white, 0U);
}

TEST(IgtlPixelsTest, RgbaLosesItsOpacityOnly) {
  Small rgba({255, 0, 0, 9, 0, 255, 0, 9, 0, 0, 255, 9, 50, 50, 50, 9});
  rgba.image.components = 4;
  ASSERT_TRUE(set_pixels(rgba.frame, rgba.image, rgba.scale));
  const std::vector<Rgb8> expected{{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {50, 50, 50}};
  EXPECT_TRUE(std::ranges::equal(rgba.frame.colours.pixels(), expected));
  EXPECT_TRUE(std::ranges::equal(rgba.frame.pixels.pixels(), luma(rgba.frame.colours).pixels()));
}

TEST(IgtlPixelsTest, RejectsWhatIsNoImageOfBrightness) {
  const auto rejects = [](Small& small, const std::string& found) {
    return test::rejects(set_pixels(small.frame, small.image, small.scale),
                         ErrorCode::kUnsupportedData, {found});
  };
  Small negative({0, 0, 0xFF, 0xFF, 0, 2, 4, 0});
  negative.image.scalar = IgtlScalar::kInt16;
  EXPECT_TRUE(rejects(negative, "negative"));
  Small single({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
  single.image.scalar = IgtlScalar::kFloat32;
  EXPECT_TRUE(rejects(single, "scalar type 10"));
  Small two({0, 0, 0, 0, 0, 0, 0, 0});
  two.image.components = 2;
  EXPECT_TRUE(rejects(two, "2 components"));
  Small part({0, 0, 0, 0});
  part.image.size = {4, 2, 1};
  EXPECT_TRUE(rejects(part, "part"));
}

}  // namespace
}  // namespace nav::devices
