// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

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
  if (header.components != 1 || header.image_type == "RGB_COLOR") {
    return reject("expected brightness, found colour with " + std::to_string(header.components) +
                  " components");
  }
  if (header.image_type.starts_with("RF_")) {
    return reject("expected brightness, found radio-frequency data (" + header.image_type + ")");
  }
  if (header.pixel_type != PixelType::kUint8) {
    return reject(std::string("expected 8-bit samples (uint8), found ") +
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
  if (!header.image_type.empty() && header.image_type != "BRIGHTNESS") {
    return reject("expected the image type BRIGHTNESS, found '" + header.image_type + "'");
  }
  if (!frame.image_valid) return reject("expected a valid image, found one declared invalid");
  if (frame.pixels.size() != header.frame_bytes()) {
    return Error{ErrorCode::kUsage, where + "expected " + std::to_string(header.frame_bytes()) +
                                        " bytes of pixels, found " +
                                        std::to_string(frame.pixels.size())};
  }
  return *flips;
}

}  // namespace

Result<Image2d<std::uint8_t>> brightness_image(const SequenceHeader& header,
                                               const SequenceFrame& frame) {
  const auto flips = judge(header, frame);
  if (!flips) return flips.error();
  const auto width = static_cast<std::size_t>(header.width);
  const auto height = static_cast<std::size_t>(header.height);
  std::vector<std::uint8_t> pixels(width * height);
  for (std::size_t row = 0; row < height; ++row) {
    const std::size_t source = (flips->rows ? height - 1 - row : row) * width;
    std::uint8_t* out = pixels.data() + row * width;
    for (std::size_t column = 0; column < width; ++column) {
      out[column] = static_cast<std::uint8_t>(frame.pixels[source + column]);
    }
    if (flips->columns) std::reverse(out, out + width);
  }
  return Image2d<std::uint8_t>(header.width, header.height, std::move(pixels));
}

}  // namespace nav::io
