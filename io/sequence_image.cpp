// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstring>

#include "io/sequence.hpp"

namespace nav::io {

namespace {

struct Flips {
  bool columns = false;
  bool rows = false;
};

/// Letter 1: direction of increasing columns (Marked, Unmarked). Letter 2: rows (Far, Near).
/// Optional letter 3: slices (Ascending, Descending), which has no meaning for a single slice.
std::optional<Flips> flips_to_mf(std::string_view orientation) {
  const bool third_ok =
      orientation.size() == 2 ||
      (orientation.size() == 3 && (orientation[2] == 'A' || orientation[2] == 'D'));
  if (!third_ok) return {};
  const char x = orientation[0];
  const char y = orientation[1];
  if ((x != 'M' && x != 'U') || (y != 'F' && y != 'N')) return {};
  return Flips{x == 'U', y == 'N'};
}

bool is_rf_orientation(std::string_view o) {
  return o.size() >= 2 && (o[0] == 'F' || o[0] == 'N') && (o[1] == 'M' || o[1] == 'U');
}

Result<Flips> judge(const SequenceHeader& header, const SequenceFrame& frame) {
  const std::string where = header.path.string() + ": frame " + std::to_string(frame.index) + ": ";
  const auto reject = [&](const std::string& reason) {
    return Error{ErrorCode::kUnsupportedData, where + reason};
  };
  if (header.width == 0 || header.height == 0) {
    return reject("expected an image, found 0 x 0 pixels");
  }
  const bool rgb = header.image_type == "RGB_COLOR";
  // PLUS also writes colours as BRIGHTNESS of 3 components.
  if (header.components != 3 && (rgb || header.components != 1)) {
    return reject("expected 1 component, or 3 of RGB, found " + std::to_string(header.components) +
                  (header.image_type.empty() ? "" : " of " + header.image_type));
  }
  if (header.image_type.starts_with("RF_")) {
    return reject("expected brightness, found radio-frequency data (" + header.image_type + ")");
  }
  if (header.pixel_type != PixelType::kUint8 && header.pixel_type != PixelType::kUint16 &&
      header.pixel_type != PixelType::kInt16) {
    return reject(std::string("expected samples of 8 or 16 bits (uint8, uint16, int16), found ") +
                  to_string(header.pixel_type));
  }
  if (header.depth != 1) {
    return reject("expected one slice per frame, found " + std::to_string(header.depth));
  }
  if (is_rf_orientation(header.orientation)) {
    return reject(
        "expected a scan-converted image (MF, MN, UF or UN), found the beam-wise orientation " +
        header.orientation);
  }
  const auto flips = flips_to_mf(header.orientation);
  if (!flips) {
    return reject(
        "expected the orientation MF, MN, UF or UN, found " +
        (header.orientation.empty() ? std::string("none") : "'" + header.orientation + "'"));
  }
  if (!header.image_type.empty() && header.image_type != "BRIGHTNESS" && !rgb) {
    return reject("expected the image type BRIGHTNESS or RGB_COLOR, found '" + header.image_type +
                  "'");
  }
  if (!frame.image_valid) return reject("expected a valid image, found one declared invalid");
  if (frame.pixels.size() != header.frame_bytes()) {
    return Error{ErrorCode::kUsage, where + "expected " + std::to_string(header.frame_bytes()) +
                                        " bytes of pixels, found " +
                                        std::to_string(frame.pixels.size())};
  }
  return *flips;
}

template <class Sample>
Sample sample_at(const SequenceFrame& frame, std::size_t index) {
  Sample value{};
  std::memcpy(&value, frame.pixels.data() + index * sizeof(Sample), sizeof(Sample));
  return value;
}

/// Samples of 16 bits as 8 bits, in the order of the file.
template <class Sample>
Result<std::vector<std::uint8_t>> narrowed(const SequenceHeader& header, const SequenceFrame& frame,
                                           GreyScale& scale) {
  const std::size_t count = frame.pixels.size() / sizeof(Sample);
  std::int32_t least = 0;
  std::int32_t largest = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const std::int32_t value = sample_at<Sample>(frame, i);
    least = std::min(least, value);
    largest = std::max(largest, value);
  }
  if (least < 0) {
    return Error{ErrorCode::kUnsupportedData,
                 header.path.string() + ": frame " + std::to_string(frame.index) +
                     ": expected brightness from 0, found " + std::to_string(least)};
  }
  scale.largest = std::max(scale.largest, static_cast<std::uint32_t>(largest));
  if (scale.white == 0) {
    scale.white = 255;
    while (scale.white < static_cast<std::uint32_t>(largest)) scale.white = 2 * scale.white + 1;
  }
  std::vector<std::uint8_t> grey(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto value = static_cast<std::uint32_t>(sample_at<Sample>(frame, i));
    grey[i] = static_cast<std::uint8_t>(
        std::min<std::uint32_t>(255, (value * 255 + scale.white / 2) / scale.white));
  }
  return grey;
}

Result<std::vector<std::uint8_t>> samples_of(const SequenceHeader& header,
                                             const SequenceFrame& frame, GreyScale& scale) {
  if (header.pixel_type == PixelType::kUint16) {
    return narrowed<std::uint16_t>(header, frame, scale);
  }
  if (header.pixel_type == PixelType::kInt16) return narrowed<std::int16_t>(header, frame, scale);
  std::vector<std::uint8_t> samples(frame.pixels.size());
  std::memcpy(samples.data(), frame.pixels.data(), samples.size());
  return samples;
}

/// Luma of interleaved RGB (ITU-R BT.601).
void to_luma(std::vector<std::uint8_t>& samples, GreyScale& scale) {
  for (std::size_t i = 0; i < samples.size() / 3; ++i) {
    const std::uint32_t r = samples[3 * i];
    const std::uint32_t g = samples[3 * i + 1];
    const std::uint32_t b = samples[3 * i + 2];
    scale.colour |= r != g || g != b;
    samples[i] = static_cast<std::uint8_t>((299 * r + 587 * g + 114 * b + 500) / 1000);
  }
  samples.resize(samples.size() / 3);
}

}  // namespace

Result<Image2d<std::uint8_t>> brightness_image(const SequenceHeader& header,
                                               const SequenceFrame& frame, GreyScale& scale) {
  const auto flips = judge(header, frame);
  if (!flips) return flips.error();
  auto samples = samples_of(header, frame, scale);
  if (!samples) return samples.error();
  if (header.components == 3) to_luma(*samples, scale);
  const auto width = static_cast<std::size_t>(header.width);
  const auto height = static_cast<std::size_t>(header.height);
  std::vector<std::uint8_t> pixels(width * height);
  for (std::size_t row = 0; row < height; ++row) {
    const std::size_t source = (flips->rows ? height - 1 - row : row) * width;
    std::uint8_t* out = pixels.data() + row * width;
    std::copy_n(samples->data() + source, width, out);
    if (flips->columns) std::reverse(out, out + width);
  }
  return Image2d<std::uint8_t>(header.width, header.height, std::move(pixels));
}

Result<Image2d<std::uint8_t>> brightness_image(const SequenceHeader& header,
                                               const SequenceFrame& frame) {
  GreyScale scale;
  return brightness_image(header, frame, scale);
}

}  // namespace nav::io
