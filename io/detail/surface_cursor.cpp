// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/detail/surface_cursor.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>

#include "io/detail/text.hpp"

namespace nav::io::detail {

namespace {

constexpr std::string_view kSpace = " \t\r\n\f\v";

template <class T>
double as_number(std::uint64_t bits) {
  if constexpr (sizeof(T) == 8) {
    return static_cast<double>(std::bit_cast<T>(bits));
  } else if constexpr (sizeof(T) == 4) {
    return static_cast<double>(std::bit_cast<T>(static_cast<std::uint32_t>(bits)));
  } else {
    return static_cast<double>(static_cast<T>(bits));
  }
}

double decode(std::uint64_t bits, const NumberKind& kind) {
  if (kind.real) return kind.bytes == 4 ? as_number<float>(bits) : as_number<double>(bits);
  switch (kind.bytes) {
    case 1:
      return kind.has_sign ? as_number<std::int8_t>(bits) : as_number<std::uint8_t>(bits);
    case 2:
      return kind.has_sign ? as_number<std::int16_t>(bits) : as_number<std::uint16_t>(bits);
    case 4:
      return kind.has_sign ? as_number<std::int32_t>(bits) : as_number<std::uint32_t>(bits);
    default:
      return kind.has_sign ? as_number<std::int64_t>(bits) : as_number<std::uint64_t>(bits);
  }
}

}  // namespace

std::optional<std::string_view> SurfaceCursor::line() {
  if (rest_.empty()) return {};
  const std::size_t end = std::min(rest_.find('\n'), rest_.size());
  const std::string_view found = rest_.substr(0, end);
  rest_.remove_prefix(std::min(end + 1, rest_.size()));
  return found;
}

std::optional<std::string_view> SurfaceCursor::filled_line() {
  for (auto found = line(); found; found = line()) {
    if (!trim(*found).empty()) return found;
  }
  return {};
}

std::optional<double> SurfaceCursor::number(const NumberKind& kind, NumberCoding coding) {
  if (coding == NumberCoding::kText) {
    rest_.remove_prefix(std::min(rest_.find_first_not_of(kSpace), rest_.size()));
    const std::string_view word =
        rest_.substr(0, std::min(rest_.find_first_of(kSpace), rest_.size()));
    rest_.remove_prefix(word.size());
    return parse_double(word);
  }
  if (rest_.size() < kind.bytes) return {};
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < kind.bytes; ++i) {
    const std::size_t at = coding == NumberCoding::kBigEndian ? i : kind.bytes - 1 - i;
    bits = bits << 8U | static_cast<unsigned char>(rest_[at]);
  }
  rest_.remove_prefix(kind.bytes);
  return decode(bits, kind);
}

bool SurfaceCursor::may_hold(std::uint64_t numbers, const NumberKind& kind,
                             NumberCoding coding) const {
  // In text, each number needs at least one character and, except for the last, a separator.
  if (coding == NumberCoding::kText) return numbers <= rest_.size() / 2 + 1;
  return numbers <= rest_.size() / kind.bytes;
}

void MeshBuilder::add(std::int64_t a, std::int64_t b, std::int64_t c) {
  least_ = std::min({least_, a, b, c});
  greatest_ = std::max({greatest_, a, b, c});
  mesh_.triangles.push_back({static_cast<int>(a), static_cast<int>(b), static_cast<int>(c)});
}

void MeshBuilder::add_polygon(std::span<const std::int64_t> corners) {
  for (std::size_t i = 2; i < corners.size(); ++i) add(corners[0], corners[i - 1], corners[i]);
}

void MeshBuilder::add_strip(std::span<const std::int64_t> corners) {
  for (std::size_t i = 2; i < corners.size(); ++i) {
    const std::size_t odd = i % 2;
    add(corners[i - 2 + odd], corners[i - 1 - odd], corners[i]);
  }
}

Result<TriangleMesh> MeshBuilder::take() && {
  const auto points = static_cast<std::int64_t>(mesh_.points_mm.size());
  if (mesh_.triangles.empty()) return malformed_surface(mesh_.name, "polygons", "none");
  for (std::size_t i = 0; i < mesh_.points_mm.size(); ++i) {
    if (mesh_.points_mm[i].allFinite()) continue;
    return malformed_surface(mesh_.name, "points of three finite numbers",
                             "none for point " + std::to_string(i));
  }
  if (least_ < 0 || greatest_ >= points || points > std::numeric_limits<int>::max()) {
    return malformed_surface(mesh_.name, "polygons of its " + std::to_string(points) + " points",
                             "other points");
  }
  return std::move(mesh_);
}

Error malformed_surface(const std::filesystem::path& path, const std::string& expected,
                        const std::string& found) {
  return {ErrorCode::kMalformedData, path.string() + ": expected " + expected + ", found " + found};
}

Error unexpected_line(const std::filesystem::path& path, const std::string& expected,
                      const std::optional<std::string_view>& found) {
  return malformed_surface(
      path, expected, found ? "'" + excerpt(*found) + "'" : std::string("the end of the file"));
}

}  // namespace nav::io::detail
