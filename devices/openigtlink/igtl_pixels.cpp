// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/openigtlink/igtl_pixels.hpp"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace nav::devices {
namespace {

constexpr std::size_t kRgb = 3;
constexpr std::size_t kRgba = 4;

Error unsupported(const std::string& found) {
  return {ErrorCode::kUnsupportedData,
          "expected one whole slice of grey, RGB or RGBA values of 8 bits, or of 16 bits from 0, "
          "found " +
              found};
}

/// Samples of 16 bits as 8 bits, in their order.
Result<std::vector<std::uint8_t>> narrowed(const IgtlImage& image, GreyScale& scale) {
  const std::size_t count = image.pixels.size() / 2;
  const std::size_t low = image.endian == IgtlEndian::kBig ? 1 : 0;
  const auto sample = [&](std::size_t i) {
    return std::to_integer<std::uint32_t>(image.pixels[2 * i + low]) |
           std::to_integer<std::uint32_t>(image.pixels[2 * i + 1 - low]) << 8;
  };
  std::uint32_t largest = 0;
  for (std::size_t i = 0; i < count; ++i) largest = std::max(largest, sample(i));
  constexpr std::uint32_t kNegative = 0x8000;
  if (image.scalar == IgtlScalar::kInt16 && largest >= kNegative) {
    return unsupported("a negative sample");
  }
  scale.see(largest);
  std::vector<std::uint8_t> grey(count);
  for (std::size_t i = 0; i < count; ++i) grey[i] = scale.grey(sample(i));
  return grey;
}

}  // namespace

Result<void> set_pixels(UltrasoundImage& frame, const IgtlImage& image, GreyScale& scale) {
  const std::size_t components = image.components;
  if (components != 1 && components != kRgb && components != kRgba) {
    return unsupported(std::to_string(components) + " components");
  }
  if (image.size[2] != 1 || !image.is_whole()) return unsupported("a volume or a part");
  std::vector<std::uint8_t> samples;
  if (image.scalar == IgtlScalar::kUint16 || image.scalar == IgtlScalar::kInt16) {
    auto grey = narrowed(image, scale);
    if (!grey) return grey.error();
    samples = *std::move(grey);
  } else if (image.scalar == IgtlScalar::kUint8) {
    samples.resize(image.pixels.size());
    std::memcpy(samples.data(), image.pixels.data(), samples.size());
  } else {
    return unsupported("the scalar type " + std::to_string(static_cast<int>(image.scalar)));
  }
  const int width = image.size[0];
  const int height = image.size[1];
  if (components == 1) {
    frame.pixels = Image2d<std::uint8_t>(width, height, std::move(samples));
    return {};
  }
  std::vector<Rgb8> colours(samples.size() / components);
  for (std::size_t i = 0; i < colours.size(); ++i) {
    std::memcpy(&colours[i], samples.data() + i * components, sizeof(Rgb8));
  }
  set_colours(frame, {width, height, std::move(colours)});
  return {};
}

}  // namespace nav::devices
