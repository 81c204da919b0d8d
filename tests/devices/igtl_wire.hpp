// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "devices/openigtlink/igtl_header.hpp"
#include "devices/openigtlink/igtl_image.hpp"
#include "devices/openigtlink/igtl_poses.hpp"

/// OpenIGTLink messages for tests.
namespace nav::test {

using Bytes = std::vector<std::byte>;

inline Bytes from_hex(std::string_view hex) {
  Bytes bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    bytes.push_back(static_cast<std::byte>(std::stoi(std::string(hex.substr(i, 2)), nullptr, 16)));
  }
  return bytes;
}

inline Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

inline Bytes text_bytes(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

inline Bytes message(const devices::IgtlEnvelope& envelope, std::span<const std::byte> content) {
  Bytes bytes;
  devices::append_igtl_message(bytes, envelope, content);
  return bytes;
}

/// Content of any record that writes itself.
template <class Record>
Bytes content_of(const Record& record) {
  Bytes bytes;
  devices::IgtlWriter writer(bytes);
  record.write(writer);
  return bytes;
}

inline Eigen::Matrix4d translation(double x, double y, double z) {
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topRightCorner<3, 1>() << x, y, z;
  return matrix;
}

/// 1234567890.25 s.
constexpr std::uint64_t kStamp = std::uint64_t{1234567890} << 32 | std::uint64_t{1} << 30;

inline Bytes transform_message(std::string_view device, const Eigen::Matrix4d& matrix,
                               std::string_view status = "", std::uint64_t stamp = kStamp) {
  const devices::IgtlMetadataEntry entry{.key = "TransformStatus", .value = status};
  const auto metadata = std::span(&entry, status.empty() ? 0u : 1u);
  return message({.version = static_cast<std::uint16_t>(status.empty() ? 1 : 2),
                  .type = "TRANSFORM",
                  .device = device,
                  .stamp = stamp,
                  .metadata = metadata},
                 content_of(devices::IgtlTransform::from(matrix)));
}

/// Grey image of that size with spacing 0.2 x 0.3 mm, around a centre; its pixels are a ramp.
struct GreyImage {
  explicit GreyImage(int width, int height) : pixels(static_cast<std::size_t>(width * height)) {
    for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::byte>(i * 7 % 251);
    image.size = {static_cast<std::uint16_t>(width), static_cast<std::uint16_t>(height), 1};
    image.part_size = image.size;
    image.steps_mm = {{{0.2F, 0, 0}, {0, 0.3F, 0}, {0, 0, 1}}};
    image.pixels = pixels;
  }
  GreyImage(const GreyImage&) = delete;
  GreyImage& operator=(const GreyImage&) = delete;
  [[nodiscard]] Bytes content() const {
    Bytes bytes;
    devices::append_igtl_image(bytes, image);
    return bytes;
  }
  [[nodiscard]] Bytes as_message(std::string_view device, std::uint64_t stamp = kStamp) const {
    return message({.type = "IMAGE", .device = device, .stamp = stamp}, content());
  }
  Bytes pixels;
  devices::IgtlImage image;
};

/// Writes another big-endian number of 64 bits over a message.
inline void overwrite_64(Bytes& bytes, std::size_t offset, std::uint64_t value) {
  for (std::size_t i = 0; i < 8; ++i) {
    bytes[offset + 7 - i] = static_cast<std::byte>(value >> (8 * i) & 255u);
  }
}
constexpr std::size_t kBodySizeOffset = 42;
constexpr std::size_t kCrcOffset = 50;

}  // namespace nav::test
