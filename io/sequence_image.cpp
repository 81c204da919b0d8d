// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
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

Result<Flips> judge(const SequenceHeader& header, const SequenceImage& frame) {
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
        "UltrasoundImageOrientation: expected MF, MN, UF or UN, found " +
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
Sample sample_at(const SequenceImage& frame, std::size_t index) {
  Sample value{};
  std::memcpy(&value, frame.pixels.data() + index * sizeof(Sample), sizeof(Sample));
  return value;
}

/// ElementMax of a MetaImage (16 bits); 0: none, or no such number.
std::uint32_t largest_of_header(const SequenceHeader& header) {
  const auto field = header.fields.find("ElementMax");
  if (field == header.fields.end()) return 0;
  double value = 0;
  const char* end = field->second.data() + field->second.size();
  const auto [stop, failure] = std::from_chars(field->second.data(), end, value);
  if (failure != std::errc() || stop != end || !(value >= 1 && value <= 65535)) return 0;
  return static_cast<std::uint32_t>(value);
}

/// Samples of 16 bits as 8 bits, in the order of the file.
template <class Sample>
Result<std::vector<std::uint8_t>> narrowed(const SequenceHeader& header, const SequenceImage& frame,
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
  scale.see(static_cast<std::uint32_t>(largest), largest_of_header(header));
  std::vector<std::uint8_t> grey(count);
  for (std::size_t i = 0; i < count; ++i) {
    grey[i] = scale.grey(static_cast<std::uint32_t>(sample_at<Sample>(frame, i)));
  }
  return grey;
}

Result<std::vector<std::uint8_t>> samples_of(const SequenceHeader& header,
                                             const SequenceImage& frame, GreyScale& scale) {
  if (header.pixel_type == PixelType::kUint16) {
    return narrowed<std::uint16_t>(header, frame, scale);
  }
  if (header.pixel_type == PixelType::kInt16) return narrowed<std::int16_t>(header, frame, scale);
  std::vector<std::uint8_t> samples(frame.pixels.size());
  std::memcpy(samples.data(), frame.pixels.data(), samples.size());
  return samples;
}

/// Pixels of a whole image, in the order of the file, flipped.
template <class Pixel>
Image2d<Pixel> flipped(const SequenceHeader& header, const Flips& flips,
                       const std::vector<std::uint8_t>& samples) {
  const auto width = static_cast<std::size_t>(header.width);
  const auto height = static_cast<std::size_t>(header.height);
  std::vector<Pixel> pixels(width * height);
  for (std::size_t row = 0; row < height; ++row) {
    const std::size_t source = (flips.rows ? height - 1 - row : row) * width;
    Pixel* out = pixels.data() + row * width;
    std::memcpy(out, samples.data() + source * sizeof(Pixel), width * sizeof(Pixel));
    if (flips.columns) std::reverse(out, out + width);
  }
  return {header.width, header.height, std::move(pixels)};
}

}  // namespace

Result<DecodedImage> sequence_image(const SequenceHeader& header, const SequenceImage& frame,
                                    GreyScale& scale) {
  const auto flips = judge(header, frame);
  if (!flips) return flips.error();
  const auto samples = samples_of(header, frame, scale);
  if (!samples) return samples.error();
  if (header.components != 3) return DecodedImage{flipped<std::uint8_t>(header, *flips, *samples)};
  auto colours = flipped<Rgb8>(header, *flips, *samples);
  DecodedImage image{luma(colours)};
  if (has_colours(colours)) image.colours = std::move(colours);
  return image;
}

Result<Image2d<std::uint8_t>> brightness_image(const SequenceHeader& header,
                                               const SequenceImage& frame, GreyScale& scale) {
  auto image = sequence_image(header, frame, scale);
  if (!image) return image.error();
  return std::move(image->pixels);
}

Result<Image2d<std::uint8_t>> brightness_image(const SequenceHeader& header,
                                               const SequenceImage& frame) {
  GreyScale scale;
  return brightness_image(header, frame, scale);
}

}  // namespace nav::io
