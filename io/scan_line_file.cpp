// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/scan_line_file.hpp"

#include <bit>

#include "io/detail/image_file.hpp"
#include "io/detail/meta_writer.hpp"
#include "io/detail/pixel_stream.hpp"
#include "io/digest.hpp"

namespace nav::io {
namespace {

constexpr const char* kDigestKey = "SondeVolumeSha256";
constexpr int kWords = 4;
static_assert(sizeof(ScanLineAtVoxel) == kWords * sizeof(std::int16_t));

}  // namespace

std::filesystem::path scan_lines_beside(const std::filesystem::path& volume) {
  std::filesystem::path beside = volume;
  return beside.replace_extension(".scan-lines.mha");
}

std::string digest_of(const StoredVolume& volume) {
  return sha256_hex(std::as_bytes(volume.values()));
}

Result<void> write_scan_lines(const StoredVolume& volume, std::span<const ScanLineAtVoxel> lines,
                              const std::filesystem::path& path) {
  NAV_CHECK(lines.size() == volume.values().size(), lines.size(), volume.values().size());
  std::string field = kDigestKey;
  field.append(" = ").append(digest_of(volume)).append("\n");
  return detail::write_meta_image(volume.grid(), kWords, field, std::as_bytes(lines), true, path);
}

Result<ScanLineFile> read_scan_line_file(const std::filesystem::path& path) {
  auto file = detail::read_image_file(path);
  if (!file) return file.error();
  constexpr std::int64_t kMostBytes = std::int64_t{8} << 31;
  if (file->components != kWords || file->type != PixelType::kInt16 ||
      file->sample_bytes > kMostBytes || !file->has(kDigestKey)) {
    return Error{ErrorCode::kUnsupportedData,
                 path.string() + ": expected scan lines (four 16-bit channels and " + kDigestKey +
                     "), found another kind of image"};
  }
  auto stream = detail::PixelStream::open(file->data, file->encoding);
  if (!stream) return stream.error();
  ScanLineFile found;
  found.volume_digest = std::string(file->value(kDigestKey));
  found.lines.resize(static_cast<std::size_t>(file->sample_bytes) / sizeof(ScanLineAtVoxel));
  const auto bytes = std::as_writable_bytes(std::span(found.lines));
  const auto fail = [&](const Error& error) {
    return Error{error.code, path.string() + ": " + error.message};
  };
  if (auto ok = stream->read(0, bytes); !ok) return fail(ok.error());
  if (auto ok = stream->expect_end(); !ok) return fail(ok.error());
  if (file->big_endian != (std::endian::native == std::endian::big)) {
    detail::swap_bytes(bytes, sizeof(std::int16_t));
  }
  return found;
}

}  // namespace nav::io
