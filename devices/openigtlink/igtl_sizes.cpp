// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/openigtlink/igtl_sizes.hpp"

#include <array>

#include "devices/openigtlink/igtl_image.hpp"
#include "devices/openigtlink/igtl_messages.hpp"
#include "devices/openigtlink/igtl_poses.hpp"

namespace nav::devices {
namespace {

/// Longest content of a status, a query or a list that is believed before its CRC is known.
constexpr std::uint64_t kLongestUsual = 4096;

IgtlFit fit_if(bool fits) { return fits ? IgtlFit::kFits : IgtlFit::kWrong; }

IgtlFit fit_usual(std::uint64_t size) {
  return size <= kLongestUsual ? IgtlFit::kFits : IgtlFit::kUnknownType;
}

IgtlFit fit_list(std::uint64_t size, std::size_t width) {
  return size % width == 0 ? fit_usual(size) : IgtlFit::kWrong;
}

/// Size that the content's own header tells: \p size_of, given that header.
template <class SizeOf>
IgtlFit fit_by_header(std::uint64_t size, std::span<const std::byte> start, std::size_t header,
                      SizeOf size_of) {
  if (size < header) return IgtlFit::kWrong;
  if (start.size() < header) return IgtlFit::kMore;
  return size_of(start.first(header));
}

IgtlFit fit_image(std::uint64_t size, std::span<const std::byte> start) {
  if (size == 0) return IgtlFit::kFits;
  return fit_by_header(size, start, IgtlImage::kHeaderBytes, [&](auto header) {
    const auto pixels = igtl_pixel_bytes(header);
    if (!pixels) return IgtlFit::kUnknownType;
    return fit_if(size == IgtlImage::kHeaderBytes + *pixels);
  });
}

IgtlFit fit_string(std::uint64_t size, std::span<const std::byte> start) {
  return fit_by_header(size, start, 4, [&](auto header) {
    IgtlReader reader(header.subspan(2));
    return fit_if(size == 4u + reader.template number<std::uint16_t>());
  });
}

IgtlFit fit_command(std::uint64_t size, std::span<const std::byte> start) {
  return fit_by_header(size, start, IgtlCommand::kHeaderBytes, [&](auto header) {
    IgtlReader reader(header.last(4));
    return fit_if(size == std::uint64_t{IgtlCommand::kHeaderBytes} +
                              reader.template number<std::uint32_t>());
  });
}

IgtlFit fit_sensor(std::uint64_t size, std::span<const std::byte> start) {
  return fit_by_header(size, start, 1, [&](auto header) {
    IgtlReader reader(header);
    return fit_if(size == IgtlSensor::kHeaderBytes + 8u * reader.template number<std::uint8_t>());
  });
}

IgtlFit fit_position(std::uint64_t size) {
  constexpr std::uint64_t kWithoutOrientation = 12;
  return fit_if(size == IgtlPosition::kWidth || size == IgtlPosition::kShortWidth ||
                size == kWithoutOrientation);
}

}  // namespace

IgtlFit igtl_fit(std::string_view type, std::uint64_t size, std::span<const std::byte> start) {
  if (type == "TRANSFORM") return fit_if(size == IgtlTransform::kWidth);
  if (type == "IMAGE") return fit_image(size, start);
  if (type == "TDATA") return fit_list(size, IgtlTrackingElement::kWidth);
  if (type == "QTDATA") return fit_list(size, IgtlQuaternionElement::kWidth);
  if (type == "POSITION" || type == "QTRANS") return fit_position(size);
  if (type == "STATUS") {
    return size >= IgtlStatus::kLeastBytes ? fit_usual(size) : IgtlFit::kWrong;
  }
  if (type == "STRING") return fit_string(size, start);
  if (type == "COMMAND") return fit_command(size, start);
  if (type == "CAPABILITY") return fit_list(size, IgtlTypeName::kWidth);
  if (type == "SENSOR") return fit_sensor(size, start);
  if (type == "POINT") return fit_list(size, IgtlPoint::kWidth);
  if (igtl_query(type)) return fit_usual(size);
  return IgtlFit::kUnknownType;
}

}  // namespace nav::devices
