// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/camera/frame_grabber_source.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace nav::devices {
namespace {

bool holds(const Image2d<std::uint8_t>& image, const PixelArea& area) {
  return area.left <= image.width() - area.width && area.top <= image.height() - area.height;
}

template <class Pixel>
Image2d<Pixel> part_of(const Image2d<Pixel>& image, const PixelArea& area) {
  std::vector<Pixel> pixels;
  pixels.reserve(static_cast<std::size_t>(area.width) * static_cast<std::size_t>(area.height));
  const auto all = image.pixels();
  for (int row = area.top; row < area.top + area.height; ++row) {
    const std::size_t begin =
        static_cast<std::size_t>(row) * static_cast<std::size_t>(image.width()) +
        static_cast<std::size_t>(area.left);
    const auto line = all.subspan(begin, static_cast<std::size_t>(area.width));
    pixels.insert(pixels.end(), line.begin(), line.end());
  }
  return {area.width, area.height, std::move(pixels)};
}

}  // namespace

Result<void> validate(const FrameGrabberOptions& options) {
  const auto reject = [](const std::string& what) {
    return Error{ErrorCode::kUsage, "frame grabber: expected " + what};
  };
  if (options.image.empty()) return reject("a name of the images, found none");
  if (options.crop) {
    const PixelArea& c = *options.crop;
    if (c.left < 0 || c.top < 0 || c.width < 1 || c.height < 1) {
      return reject("a crop [left, top, width, height] inside the image, found [" +
                    std::to_string(c.left) + ", " + std::to_string(c.top) + ", " +
                    std::to_string(c.width) + ", " + std::to_string(c.height) + "]");
    }
  }
  return validate(options.times);
}

Result<std::unique_ptr<FrameGrabberSource>> FrameGrabberSource::create(FrameGrabberOptions options,
                                                                       std::string name,
                                                                       VideoOpener open,
                                                                       const Clock& clock,
                                                                       Diagnostics& diagnostics) {
  if (const auto ok = validate(options); !ok) return ok.error();
  return std::unique_ptr<FrameGrabberSource>(new FrameGrabberSource(
      std::move(options), std::move(name), std::move(open), clock, diagnostics));
}

FrameGrabberSource::FrameGrabberSource(FrameGrabberOptions options, std::string name,
                                       VideoOpener open, const Clock& clock,
                                       Diagnostics& diagnostics)
    : CameraImageSource(std::move(name), options.times, std::move(open), clock, diagnostics,
                        "devices.frame_grabber"),
      options_(std::move(options)) {
  add_stream({options_.image, StreamKind::kImages});
}

void FrameGrabberSource::take(VideoImage video, Timestamp acquired, Timestamp received) {
  Sample sample{.sequence = sequence_, .received = received};
  if (options_.crop && !holds(video.pixels, *options_.crop)) {
    const PixelArea& c = *options_.crop;
    const std::string message =
        "expected an image that holds the crop of " + std::to_string(c.width) + " x " +
        std::to_string(c.height) + " pixels at " + std::to_string(c.left) + ", " +
        std::to_string(c.top) + ", found " + std::to_string(video.pixels.width()) + " x " +
        std::to_string(video.pixels.height());
    count("crop");
    report_once(Severity::kError, "crop", message);
    sample.what = MissingImage{"crop", message};
  } else {
    UltrasoundImage image;
    image.acquired = acquired;
    image.received = received;
    image.sequence = sequence_;
    image.pixels = options_.crop ? part_of(video.pixels, *options_.crop) : video.pixels;
    if (!video.colours.empty()) {
      auto part = options_.crop ? part_of(video.colours, *options_.crop) : video.colours;
      if (has_colours(part)) image.colours = std::move(part);
    }
    image.grid = PixelGrid::centred(image.pixels.width(), 1, 1);
    sample.what = std::move(image);
  }
  ++sequence_;
  deliver(std::move(sample));
}

}  // namespace nav::devices
