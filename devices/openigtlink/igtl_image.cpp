// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/openigtlink/igtl_image.hpp"

#include <bit>
#include <cmath>
#include <sstream>
#include <string>
#include <type_traits>

namespace nav::devices {
namespace {

constexpr std::array<const char*, 3> kImageAxisNames = {"columns", "rows", "slices"};

IgtlImage read_image_header(std::span<const std::byte> bytes) {
  IgtlReader reader(bytes);
  IgtlImage image;
  image.format = reader.number<std::uint16_t>();
  image.components = reader.number<std::uint8_t>();
  image.scalar = static_cast<IgtlScalar>(reader.number<std::uint8_t>());
  image.endian = static_cast<IgtlEndian>(reader.number<std::uint8_t>());
  image.axes = static_cast<IgtlAxes>(reader.number<std::uint8_t>());
  for (auto& n : image.size) n = reader.number<std::uint16_t>();
  for (auto& step : image.steps_mm) reader.floats(step);
  reader.floats(image.centre_mm);
  for (auto& n : image.part_offset) n = reader.number<std::uint16_t>();
  for (auto& n : image.part_size) n = reader.number<std::uint16_t>();
  return image;
}

/// At most 2^48 * 255 * 8 < 2^59: it fits.
std::uint64_t pixel_bytes_of(const IgtlImage& image) {
  return std::uint64_t{image.part_size[0]} * image.part_size[1] * image.part_size[2] *
         image.components * igtl_scalar_bytes(image.scalar);
}

template <class Unsigned>
Unsigned load_scalar(const std::byte* at, IgtlEndian endian) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(Unsigned); ++i) {
    const std::size_t from = endian == IgtlEndian::kBig ? i : sizeof(Unsigned) - 1 - i;
    value = value << 8 | std::to_integer<std::uint64_t>(at[from]);
  }
  return static_cast<Unsigned>(value);
}

template <class T>
double scalar_as(const std::byte* at, IgtlEndian endian) {
  using Bits = std::conditional_t<
      sizeof(T) == 1, std::uint8_t,
      std::conditional_t<sizeof(T) == 2, std::uint16_t,
                         std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>>>;
  return static_cast<double>(std::bit_cast<T>(load_scalar<Bits>(at, endian)));
}

Error bad_image(const std::string& what) {
  return {ErrorCode::kMalformedData, "IMAGE: expected " + what};
}

Result<void> check_codes(const IgtlImage& image) {
  const auto code = [](auto value) { return std::to_string(static_cast<int>(value)); };
  if (image.components == 0) return bad_image("at least 1 component, found 0");
  if (igtl_scalar_bytes(image.scalar) == 0) {
    return bad_image("a scalar type of 2 to 7, 10 or 11, found " + code(image.scalar));
  }
  if (image.endian != IgtlEndian::kBig && image.endian != IgtlEndian::kLittle) {
    return bad_image("an endian of 1 or 2, found " + code(image.endian));
  }
  if (image.axes != IgtlAxes::kRas && image.axes != IgtlAxes::kLps) {
    return bad_image("coordinates of 1 (RAS) or 2 (LPS), found " + code(image.axes));
  }
  return {};
}

Result<void> check_extent(const IgtlImage& image) {
  const Eigen::Vector3d spacing = image.spacing_mm();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string name = kImageAxisNames[axis];
    if (image.part_size[axis] == 0) return bad_image("at least 1 of " + name + ", found 0");
    if (image.part_offset[axis] + image.part_size[axis] > image.size[axis]) {
      return bad_image("a part within the " + std::to_string(image.size[axis]) + " " + name +
                       ", found " + std::to_string(image.part_size[axis]) + " from " +
                       std::to_string(image.part_offset[axis]));
    }
    if (axis == 2 && image.size[axis] == 1) continue;
    const double along = spacing[static_cast<Eigen::Index>(axis)];
    if (std::isfinite(along) && along > 0) continue;
    std::ostringstream text;
    text << "a spacing of " << name << " above 0 mm, found " << along;
    return bad_image(text.str());
  }
  return {};
}

}  // namespace

std::size_t igtl_scalar_bytes(IgtlScalar scalar) {
  switch (scalar) {
    case IgtlScalar::kInt8:
    case IgtlScalar::kUint8:
      return 1;
    case IgtlScalar::kInt16:
    case IgtlScalar::kUint16:
      return 2;
    case IgtlScalar::kInt32:
    case IgtlScalar::kUint32:
    case IgtlScalar::kFloat32:
      return 4;
    case IgtlScalar::kFloat64:
      return 8;
  }
  return 0;
}

Eigen::Vector3d IgtlImage::spacing_mm() const {
  Eigen::Vector3d spacing;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto& step = steps_mm[axis];
    spacing[static_cast<Eigen::Index>(axis)] =
        std::hypot(double{step[0]}, double{step[1]}, double{step[2]});
  }
  return spacing;
}

Eigen::Vector3d IgtlImage::position_mm(double column, double row, double slice) const {
  const std::array<double, 3> index = {column, row, slice};
  Eigen::Vector3d p(centre_mm[0], centre_mm[1], centre_mm[2]);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto& step = steps_mm[axis];
    p += (index[axis] - 0.5 * (size[axis] - 1)) * Eigen::Vector3d(step[0], step[1], step[2]);
  }
  return p;
}

Eigen::Vector3d IgtlImage::position_lps_mm(double column, double row, double slice) const {
  Eigen::Vector3d p = position_mm(column, row, slice);
  if (axes == IgtlAxes::kRas) p.head<2>() *= -1;
  return p;
}

double IgtlImage::value(std::size_t column, std::size_t row, std::size_t slice,
                        std::size_t component) const {
  NAV_CHECK(column < part_size[0] && row < part_size[1] && slice < part_size[2], column, row,
            slice);
  NAV_CHECK(component < components, component);
  const std::size_t width = igtl_scalar_bytes(scalar);
  const std::size_t pixel = (slice * part_size[1] + row) * part_size[0] + column;
  const std::byte* at = pixels.subspan((pixel * components + component) * width, width).data();
  switch (scalar) {
    case IgtlScalar::kInt8:
      return scalar_as<std::int8_t>(at, endian);
    case IgtlScalar::kUint8:
      return scalar_as<std::uint8_t>(at, endian);
    case IgtlScalar::kInt16:
      return scalar_as<std::int16_t>(at, endian);
    case IgtlScalar::kUint16:
      return scalar_as<std::uint16_t>(at, endian);
    case IgtlScalar::kInt32:
      return scalar_as<std::int32_t>(at, endian);
    case IgtlScalar::kUint32:
      return scalar_as<std::uint32_t>(at, endian);
    case IgtlScalar::kFloat32:
      return scalar_as<float>(at, endian);
    case IgtlScalar::kFloat64:
      return scalar_as<double>(at, endian);
  }
  return std::nan("");
}

std::optional<std::uint64_t> igtl_pixel_bytes(std::span<const std::byte> header) {
  const IgtlImage image = read_image_header(header);
  if (!check_codes(image)) return std::nullopt;
  return pixel_bytes_of(image);
}

Result<IgtlImage> decode_igtl_image(std::span<const std::byte> content) {
  if (content.size() < IgtlImage::kHeaderBytes) {
    return bad_image("72 bytes before the pixels, found " + std::to_string(content.size()));
  }
  IgtlImage image = read_image_header(content);
  if (const auto ok = check_codes(image); !ok) return ok.error();
  if (const auto ok = check_extent(image); !ok) return ok.error();
  image.pixels = content.subspan(IgtlImage::kHeaderBytes);
  if (const std::uint64_t expected = pixel_bytes_of(image); image.pixels.size() != expected) {
    return bad_image(std::to_string(expected) + " bytes of pixels, found " +
                     std::to_string(image.pixels.size()));
  }
  return image;
}

void append_igtl_image(std::vector<std::byte>& out, const IgtlImage& image) {
  NAV_CHECK(image.pixels.size() == pixel_bytes_of(image), image.pixels.size());
  IgtlWriter writer(out);
  writer.number(image.format);
  writer.number(image.components);
  writer.number(static_cast<std::uint8_t>(image.scalar));
  writer.number(static_cast<std::uint8_t>(image.endian));
  writer.number(static_cast<std::uint8_t>(image.axes));
  for (const auto n : image.size) writer.number(n);
  for (const auto& step : image.steps_mm) writer.floats(step);
  writer.floats(image.centre_mm);
  for (const auto n : image.part_offset) writer.number(n);
  for (const auto n : image.part_size) writer.number(n);
  writer.bytes(image.pixels);
}

}  // namespace nav::devices
