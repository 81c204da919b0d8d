// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "devices/openigtlink/igtl_bytes.hpp"
#include "nav/result.hpp"

namespace nav::devices {

enum class IgtlScalar : std::uint8_t {
  kInt8 = 2,
  kUint8 = 3,
  kInt16 = 4,
  kUint16 = 5,
  kInt32 = 6,
  kUint32 = 7,
  kFloat32 = 10,
  kFloat64 = 11,
};
enum class IgtlEndian : std::uint8_t { kBig = 1, kLittle = 2 };
/// Patient axes of the matrix, as the sender names them: +x is right or left, +y anterior or
/// posterior, +z superior. Senders of tracked ultrasound write kRas whatever their frame is.
enum class IgtlAxes : std::uint8_t { kRas = 1, kLps = 2 };

/// Bytes of one scalar; 0 for a code that the format does not have.
std::size_t igtl_scalar_bytes(IgtlScalar scalar);

/// Content of IMAGE: a part (the whole, usually) of an image or a volume.
struct IgtlImage {
  static constexpr std::size_t kHeaderBytes = 72;

  std::uint16_t format = 1;     ///< Version of this content.
  std::uint8_t components = 1;  ///< Scalars of one pixel, >= 1.
  IgtlScalar scalar = IgtlScalar::kUint8;
  IgtlEndian endian = IgtlEndian::kLittle;
  IgtlAxes axes = IgtlAxes::kRas;
  std::array<std::uint16_t, 3> size{};  ///< Pixels of the whole image: columns, rows, slices.
  /// Step from a pixel to the next along columns, rows and slices, mm.
  std::array<std::array<float, 3>, 3> steps_mm{};
  /// Centre of the whole image, mm: the middle between its first and its last pixel's centre.
  std::array<float, 3> centre_mm{};
  std::array<std::uint16_t, 3> part_offset{};  ///< First pixel of the part.
  std::array<std::uint16_t, 3> part_size{};
  /// Scalars of the part, columns first; in the buffer that was decoded.
  std::span<const std::byte> pixels;

  /// Length of each step, mm.
  [[nodiscard]] Eigen::Vector3d spacing_mm() const;
  /// Position of a pixel's centre, mm, in the sender's axes. The indices count from the first pixel
  /// of the whole image.
  [[nodiscard]] Eigen::Vector3d position_mm(double column, double row, double slice) const;
  /// Position in LPS, mm; otherwise like position_mm().
  [[nodiscard]] Eigen::Vector3d position_lps_mm(double column, double row, double slice) const;
  /// A scalar of the part. Preconditions: within the part, otherwise a Bug.
  [[nodiscard]] double value(std::size_t column, std::size_t row, std::size_t slice,
                             std::size_t component = 0) const;
  [[nodiscard]] bool is_whole() const { return part_size == size; }
};

/// Size in bytes of the pixels that follow an image's first 72 bytes; absent if these contradict
/// the format. Precondition: 72 bytes, otherwise a Bug.
std::optional<std::uint64_t> igtl_pixel_bytes(std::span<const std::byte> header);

/// Decodes IMAGE without copying pixels. Rejects codes that the format does not have, an image
/// without pixels, a part beyond the image, a spacing that is 0 or not finite along an axis of more
/// than one pixel (columns and rows always), and another number of bytes than the size says. The
/// rest of the matrix is not judged.
Result<IgtlImage> decode_igtl_image(std::span<const std::byte> content);
/// Appends the content. Precondition: pixels of the size of the part, otherwise a Bug.
void append_igtl_image(std::vector<std::byte>& out, const IgtlImage& image);

}  // namespace nav::devices
