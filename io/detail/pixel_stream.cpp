// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/detail/pixel_stream.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <string_view>
#include <zlib.h>

namespace nav::io::detail {

struct PixelStream::Inflater {
  static constexpr std::size_t kBufferBytes = 64 << 10;
  // 15: largest window; + 32: zlib or gzip, detected from the first bytes.
  static constexpr int kWindowBits = 15 + 32;

  z_stream stream{};
  bool started = false;
  bool ended = false;
  std::int64_t encoded_offset = 0;
  std::int64_t decoded_offset = 0;
  std::array<std::byte, kBufferBytes> input{};

  ~Inflater() {
    if (started) inflateEnd(&stream);
  }
};

namespace {

/// Cause of damage by the words of zlib (inflate.c). \p decoded: bytes that were decoded before.
std::string damage_text(const char* zlib_words, std::int64_t decoded) {
  const std::string_view words = zlib_words != nullptr ? zlib_words : "";
  const auto says = [&](std::string_view part) { return words.find(part) != words.npos; };
  if (says("header")) {
    return decoded == 0 ? "expected the start of zlib or gzip data, found other bytes (are the "
                          "data not compressed?)"
                        : "expected another gzip member or the end, found other bytes";
  }
  if (says("data check")) return "expected data that agree with their checksum, found others";
  if (says("length check")) return "expected data of the length that follows them, found others";
  return "expected codes of the format, found others";
}

}  // namespace

PixelStream::PixelStream() = default;
PixelStream::PixelStream(PixelStream&&) noexcept = default;
PixelStream& PixelStream::operator=(PixelStream&&) noexcept = default;
PixelStream::~PixelStream() = default;

Result<PixelStream> PixelStream::open(const std::vector<DataPart>& parts, Encoding encoding,
                                      std::shared_ptr<const InputFile> pipe) {
  PixelStream out;
  for (const DataPart& part : parts) {
    if (pipe && part.path == pipe->path()) {
      out.parts_.push_back({pipe, part});
      continue;
    }
    auto file = InputFile::open(part.path);
    if (!file) return file.error();
    out.parts_.push_back({std::make_shared<const InputFile>(*std::move(file)), part});
  }
  if (encoding == Encoding::kDeflate) {
    out.inflater_ = std::make_unique<Inflater>();
    if (const auto ok = out.rewind(); !ok) return ok.error();
  }
  return out;
}

Result<void> PixelStream::rewind() {
  Inflater& z = *inflater_;
  const int code = z.started ? inflateReset2(&z.stream, Inflater::kWindowBits)
                             : inflateInit2(&z.stream, Inflater::kWindowBits);
  if (code != Z_OK) return Error{ErrorCode::kIo, "zlib cannot start"};
  z.started = true;
  z.ended = false;
  z.stream.avail_in = 0;
  z.encoded_offset = 0;
  z.decoded_offset = 0;
  return {};
}

Result<std::size_t> PixelStream::read_raw(std::int64_t offset, std::span<std::byte> out,
                                          bool some) const {
  std::size_t done = 0;
  for (const Part& part : parts_) {
    if (done == out.size()) break;
    if (offset >= part.place.size) {
      offset -= part.place.size;
      continue;
    }
    const auto here = static_cast<std::size_t>(std::min<std::int64_t>(
        part.place.size - offset, static_cast<std::int64_t>(out.size() - done)));
    const auto piece = out.subspan(done, here);
    const auto got = some ? part.file->read_some(part.place.offset + offset, piece)
                          : part.file->read_at(part.place.offset + offset, piece);
    if (!got) return got.error();
    if (const auto ok = part.file->check_unchanged(); !ok) return ok.error();
    done += *got;
    if (*got < here) break;
    offset = 0;
  }
  return done;
}

Result<std::size_t> PixelStream::inflate(std::span<std::byte> out) {
  Inflater& z = *inflater_;
  std::size_t done = 0;
  while (done < out.size()) {
    if (z.stream.avail_in == 0) {
      const auto got = read_raw(z.encoded_offset, z.input, true);
      if (!got) return got.error();
      z.encoded_offset += static_cast<std::int64_t>(*got);
      z.stream.next_in = reinterpret_cast<Bytef*>(z.input.data());
      z.stream.avail_in = static_cast<uInt>(*got);
      if (*got == 0) break;
    }
    if (z.ended) {  // gzip files may hold several members.
      if (z.stream.next_in[0] != 0x1f) break;
      inflateReset(&z.stream);
      z.ended = false;
    }
    const std::size_t room =
        std::min<std::size_t>(out.size() - done, std::numeric_limits<int>::max());
    z.stream.next_out = reinterpret_cast<Bytef*>(out.data() + done);
    z.stream.avail_out = static_cast<uInt>(room);
    const int code = ::inflate(&z.stream, Z_NO_FLUSH);
    const std::size_t made = room - z.stream.avail_out;
    done += made;
    z.decoded_offset += static_cast<std::int64_t>(made);  // Before a later read that may fail.
    z.ended = code == Z_STREAM_END;
    if (code != Z_OK && code != Z_STREAM_END && code != Z_BUF_ERROR) {
      return Error{ErrorCode::kMalformedData,
                   "compressed data are damaged after " + std::to_string(z.decoded_offset) +
                       " bytes: " + damage_text(z.stream.msg, z.decoded_offset)};
    }
  }
  return done;
}

Result<void> PixelStream::read(std::int64_t offset, std::span<std::byte> out) {
  const auto missing = [&](std::size_t found) {
    return Error{ErrorCode::kMalformedData, "pixel data cut short: expected " +
                                                std::to_string(out.size()) + " bytes at offset " +
                                                std::to_string(offset) + ", found " +
                                                std::to_string(found)};
  };
  if (!inflater_) {
    const auto got = read_raw(offset, out);
    if (!got) return got.error();
    if (*got < out.size()) return missing(*got);
    return {};
  }
  if (offset < inflater_->decoded_offset) {
    if (const auto ok = rewind(); !ok) return ok;
  }
  std::vector<std::byte> skipped;
  while (inflater_->decoded_offset < offset) {
    constexpr std::int64_t kSkipBytes = 1 << 20;
    skipped.resize(
        static_cast<std::size_t>(std::min(kSkipBytes, offset - inflater_->decoded_offset)));
    const auto got = inflate(skipped);
    if (!got) return got.error();
    if (*got < skipped.size()) return missing(0);
  }
  const auto got = inflate(out);
  if (!got) return got.error();
  if (*got < out.size()) return missing(*got);
  return {};
}

Result<void> PixelStream::expect_end() {
  if (!inflater_) return {};
  std::array<std::byte, 1> extra{};
  const auto got = inflate(extra);
  if (!got) return got.error();
  if (*got > 0) {
    return Error{ErrorCode::kMalformedData,
                 "expected the compressed data to end with the last sample, found more"};
  }
  return check_ended();
}

Result<std::int64_t> PixelStream::skip_to_end(std::int64_t offset) {
  if (!inflater_) {
    std::int64_t all = 0;
    for (const Part& part : parts_) all += part.place.size;
    return std::max<std::int64_t>(all - offset, 0);
  }
  std::vector<std::byte> skipped(Inflater::kBufferBytes);
  for (std::int64_t left = 0;;) {
    const auto got = inflate(skipped);
    if (!got) return got.error();
    left += static_cast<std::int64_t>(*got);
    if (*got == skipped.size()) continue;
    if (const auto ended = check_ended(); !ended) return ended.error();
    return left;
  }
}

Result<void> PixelStream::check_ended() const {
  if (inflater_->ended) return {};
  return Error{ErrorCode::kMalformedData, "compressed data cut short: their end is missing"};
}

Result<void> copy_voxels(PixelStream& stream, const StoredVoxels& voxels, std::int64_t stored_bytes,
                         VoxelSink& sink) {
  constexpr std::size_t kBlockVoxels = 1 << 18;
  // CT of a body, its padding included, is compressed to no less than a twentieth.
  constexpr std::size_t kUsualExpansion = 20;
  const std::size_t sample = size_of(voxels.type);
  std::size_t reserved =
      std::min(voxels.count, static_cast<std::size_t>(stored_bytes) * kUsualExpansion / sample);
  sink.reserve(reserved);
  std::vector<std::byte> block(std::min(voxels.count, kBlockVoxels) * sample);
  for (std::size_t done = 0; done < voxels.count;) {
    const std::size_t now = std::min(voxels.count - done, kBlockVoxels);
    const auto bytes = std::span(block).first(now * sample);
    const auto at = voxels.offset + static_cast<std::int64_t>(done * sample);
    if (const auto read = stream.read(at, bytes); !read) return read;
    if (voxels.swapped) swap_bytes(bytes, sample);
    if (done + now > reserved) {
      reserved = std::min(voxels.count, 2 * (done + now));
      sink.reserve(reserved);
    }
    sink.append(bytes, voxels.type, voxels.rescale);
    done += now;
  }
  return {};
}

void swap_bytes(std::span<std::byte> bytes, std::size_t sample_size) {
  if (sample_size < 2) return;
  for (std::size_t i = 0; i + sample_size <= bytes.size(); i += sample_size) {
    std::reverse(bytes.begin() + static_cast<std::ptrdiff_t>(i),
                 bytes.begin() + static_cast<std::ptrdiff_t>(i + sample_size));
  }
}

}  // namespace nav::io::detail
