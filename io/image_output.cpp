// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/image_output.hpp"

#include <algorithm>
#include <iterator>
#include <limits>
#include <memory>
#include <png.h>
#include <webp/encode.h>
#include <webp/mux.h>
#include <zlib.h>

#include "io/atomic_file.hpp"
#include "io/own_mark.hpp"

namespace nav::io {

namespace {

constexpr std::uint64_t kMaxPngBytes = 1ULL << 30;
constexpr std::uint64_t kMaxPixels = 1ULL << 28;

Error reject(const std::filesystem::path& path, const std::string& what) {
  return {ErrorCode::kUsage, path.string() + ": " + what};
}

std::span<const std::byte> bytes_of(const Image2d<Rgba8>& image) {
  return std::as_bytes(image.pixels());
}

/// Text chunk of a PNG that names the software (PNG specification, 11.3.4.3).
std::vector<std::byte> software_chunk() {
  const std::string content = "Software" + std::string(1, '\0') + std::string(kSoftwareMark);
  const std::string body = "tEXt" + content;
  const auto check = static_cast<std::uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size())));
  std::vector<std::byte> chunk;
  const auto add_number = [&](std::uint32_t number) {
    for (const int shift : {24, 16, 8, 0}) {
      chunk.push_back(static_cast<std::byte>((number >> shift) & 0xffU));
    }
  };
  add_number(static_cast<std::uint32_t>(content.size()));
  std::ranges::transform(body, std::back_inserter(chunk),
                         [](char c) { return static_cast<std::byte>(c); });
  add_number(check);
  return chunk;
}

/// Metadata of a WebP that name the software.
std::string software_xmp() {
  return "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\"><rdf:RDF "
         "xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\"><rdf:Description "
         "xmlns:xmp=\"http://ns.adobe.com/xap/1.0/\"><xmp:CreatorTool>" +
         std::string(kSoftwareMark) + "</xmp:CreatorTool></rdf:Description></rdf:RDF></x:xmpmeta>";
}

}  // namespace

Result<void> write_png(const Image2d<Rgba8>& image, const std::filesystem::path& path) {
  if (image.empty()) return reject(path, "expected an image with pixels, found none");
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width());
  png.height = static_cast<png_uint_32>(image.height());
  png.format = PNG_FORMAT_RGBA;
  const std::unique_ptr<png_image, void (*)(png_image*)> guard(&png, png_image_free);
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
  std::vector<std::byte> encoded(size);
  const int ok =
      png_image_write_to_memory(&png, encoded.data(), &size, 0, bytes_of(image).data(), 0, nullptr);
  if (ok == 0) return Error{ErrorCode::kIo, path.string() + ": cannot encode: " + png.message};
  encoded.resize(size);
  constexpr std::ptrdiff_t kAfterHeader = 33;  // Signature of 8 bytes, header of 25.
  const std::vector<std::byte> mark = software_chunk();
  encoded.insert(encoded.begin() + kAfterHeader, mark.begin(), mark.end());
  return write_file(path, std::span<const std::byte>(encoded));
}

Result<Image2d<Rgba8>> read_png(const std::filesystem::path& path) {
  const auto content = read_file(path, kMaxPngBytes);
  if (!content) return content.error();
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  const std::unique_ptr<png_image, void (*)(png_image*)> guard(&image, png_image_free);
  const auto fail = [&] {
    return Error{ErrorCode::kMalformedData,
                 path.string() + ": expected a PNG, found: " + image.message};
  };
  if (png_image_begin_read_from_memory(&image, content->data(), content->size()) == 0) {
    return fail();
  }
  if (static_cast<std::uint64_t>(image.width) * image.height > kMaxPixels) {
    return Error{ErrorCode::kUnsupportedData,
                 path.string() + ": expected at most 2^28 pixels, found " +
                     std::to_string(image.width) + " x " + std::to_string(image.height)};
  }
  image.format = PNG_FORMAT_RGBA;
  std::vector<Rgba8> pixels(static_cast<std::size_t>(image.width) * image.height);
  if (png_image_finish_read(&image, nullptr, pixels.data(), 0, nullptr) == 0) return fail();
  return Image2d<Rgba8>(static_cast<int>(image.width), static_cast<int>(image.height),
                        std::move(pixels));
}

namespace {

Result<void> check_animation(const std::vector<Image2d<Rgba8>>& frames, int frame_duration_ms,
                             const std::filesystem::path& path, const AnimationOptions& options) {
  constexpr int kMaxSide = WEBP_MAX_DIMENSION;
  constexpr int kMaxDurationMs = 60000;
  if (frames.empty() || frames[0].empty()) {
    return reject(path, "expected at least 1 image with pixels, found none");
  }
  if (frame_duration_ms < 1 || frame_duration_ms > kMaxDurationMs) {
    return reject(
        path, "expected a duration of 1 to 60000 ms, found " + std::to_string(frame_duration_ms));
  }
  const std::int64_t total_ms =
      static_cast<std::int64_t>(frames.size()) * static_cast<std::int64_t>(frame_duration_ms);
  if (total_ms > std::numeric_limits<int>::max()) {
    return reject(path, "expected less than 2^31 ms in all, found " + std::to_string(total_ms));
  }
  if (!(options.quality >= 0 && options.quality <= 100)) {
    return reject(path, "expected a quality of 0 to 100, found " + std::to_string(options.quality));
  }
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto& frame = frames[i];
    if (frame.width() != frames[0].width() || frame.height() != frames[0].height() ||
        frame.width() > kMaxSide || frame.height() > kMaxSide) {
      return reject(
          path, "image " + std::to_string(i) + ": expected " + std::to_string(frames[0].width()) +
                    " x " + std::to_string(frames[0].height()) +
                    " pixels, at most 16383 a side, found " + std::to_string(frame.width()) +
                    " x " + std::to_string(frame.height()));
    }
  }
  return {};
}

/// Adds one image to the encoder, which copies the pixels.
bool add_frame(WebPAnimEncoder* encoder, const Image2d<Rgba8>& frame, int time_ms,
               const WebPConfig& config) {
  WebPPicture image;
  if (WebPPictureInit(&image) == 0) return false;
  const std::unique_ptr<WebPPicture, void (*)(WebPPicture*)> guard(&image, WebPPictureFree);
  image.width = frame.width();
  image.height = frame.height();
  image.use_argb = 1;
  const auto* rgba = reinterpret_cast<const std::uint8_t*>(bytes_of(frame).data());
  return WebPPictureImportRGBA(&image, rgba, 4 * frame.width()) != 0 &&
         WebPAnimEncoderAdd(encoder, &image, time_ms, &config) != 0;
}

}  // namespace

Result<void> write_animation(const std::vector<Image2d<Rgba8>>& frames, int frame_duration_ms,
                             const std::filesystem::path& path, const AnimationOptions& options) {
  if (const auto ok = check_animation(frames, frame_duration_ms, path, options); !ok) return ok;
  WebPConfig config;
  WebPAnimEncoderOptions encoder_options;
  const auto fail = [&](const std::string& why) {
    return Error{ErrorCode::kIo, path.string() + ": cannot encode: " + why};
  };
  if (WebPConfigInit(&config) == 0 || WebPAnimEncoderOptionsInit(&encoder_options) == 0) {
    return fail("libwebp has an unexpected version");
  }
  config.quality = options.quality;
  config.lossless = options.lossless ? 1 : 0;
  config.exact = options.lossless ? 1 : 0;  // Keeps the colours of fully transparent pixels.
  const std::unique_ptr<WebPAnimEncoder, void (*)(WebPAnimEncoder*)> encoder(
      WebPAnimEncoderNew(frames[0].width(), frames[0].height(), &encoder_options),
      WebPAnimEncoderDelete);
  if (!encoder) return fail("no encoder");
  int time_ms = 0;
  for (const auto& frame : frames) {
    if (!add_frame(encoder.get(), frame, time_ms, config)) {
      return fail(WebPAnimEncoderGetError(encoder.get()));
    }
    time_ms += frame_duration_ms;
  }
  WebPData data;
  WebPDataInit(&data);
  const std::unique_ptr<WebPData, void (*)(WebPData*)> guard(&data, WebPDataClear);
  if (WebPAnimEncoderAdd(encoder.get(), nullptr, time_ms, nullptr) == 0 ||
      WebPAnimEncoderAssemble(encoder.get(), &data) == 0) {
    return fail(WebPAnimEncoderGetError(encoder.get()));
  }
  const std::unique_ptr<WebPMux, void (*)(WebPMux*)> mux(WebPMuxCreate(&data, 0), WebPMuxDelete);
  const std::string xmp = software_xmp();
  const WebPData metadata{reinterpret_cast<const std::uint8_t*>(xmp.data()), xmp.size()};
  WebPData marked;
  WebPDataInit(&marked);
  const std::unique_ptr<WebPData, void (*)(WebPData*)> marked_guard(&marked, WebPDataClear);
  if (!mux || WebPMuxSetChunk(mux.get(), "XMP ", &metadata, 0) != WEBP_MUX_OK ||
      WebPMuxAssemble(mux.get(), &marked) != WEBP_MUX_OK) {
    return fail("its metadata cannot be added");
  }
  return write_file(path, std::as_bytes(std::span(marked.bytes, marked.size)));
}

}  // namespace nav::io
