// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <linux/videodev2.h>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <sys/ioctl.h>
#include <time.h>
#include <utility>
#include <vector>

#include "devices/camera/video_input.hpp"
#include "devices/openigtlink/tcp_socket.hpp"

namespace nav::devices {
namespace {

/// Pixels of a matrix of their size.
template <class Pixel>
Image2d<Pixel> pixels_of(const cv::Mat& matrix) {
  const auto width = static_cast<std::size_t>(matrix.cols);
  std::vector<Pixel> pixels(width * static_cast<std::size_t>(matrix.rows));
  for (int row = 0; row < matrix.rows; ++row) {
    std::memcpy(pixels.data() + static_cast<std::size_t>(row) * width, matrix.ptr(row),
                width * sizeof(Pixel));
  }
  return {matrix.cols, matrix.rows, std::move(pixels)};
}

/// An image of one, three or four channels of 8 bits; \p colours: keep them. Absent: another kind.
std::optional<VideoImage> image_of(const cv::Mat& image, bool colours) {
  cv::Mat grey;
  if (image.empty() || image.depth() != CV_8U) return std::nullopt;
  if (colours && (image.channels() == 3 || image.channels() == 4)) {
    cv::Mat rgb;
    cv::cvtColor(image, rgb, image.channels() == 3 ? cv::COLOR_BGR2RGB : cv::COLOR_BGRA2RGB);
    auto all = pixels_of<Rgb8>(rgb);
    VideoImage made{.pixels = luma(all)};
    if (has_colours(all)) made.colours = std::move(all);
    return made;
  }
  if (image.channels() == 1) {
    grey = image;
  } else if (image.channels() == 3) {
    cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  } else if (image.channels() == 4) {
    cv::cvtColor(image, grey, cv::COLOR_BGRA2GRAY);
  } else {
    return std::nullopt;
  }
  return VideoImage{.pixels = pixels_of<std::uint8_t>(grey)};
}

/// Time since a stamp of the monotonic clock, ms; 0 where it is none.
Duration age_of_stamp(double stamp_ms) {
  constexpr Duration kLongest = std::chrono::seconds(1);
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  const double now_ms =
      1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
  const double age_ms = now_ms - stamp_ms;
  if (!(stamp_ms > 0 && age_ms >= 0 && age_ms < 1000)) return Duration(0);
  return std::min<Duration>(
      std::chrono::duration_cast<Duration>(std::chrono::duration<double, std::milli>(age_ms)),
      kLongest);
}

std::string four_letters(double code) {
  const auto number = static_cast<std::uint32_t>(static_cast<std::int64_t>(code));
  std::string text;
  for (int i = 0; i < 4; ++i) {
    const char letter = static_cast<char>(number >> (8 * i) & 0x7F);
    text += letter >= ' ' && letter < 0x7F ? letter : '?';
  }
  return text;
}

class CvVideoInput final : public VideoInput {
 public:
  CvVideoInput(const cv::VideoCapture& capture, const VideoOptions& options)
      : capture_(capture), options_(options) {
    const double rate_hz = options.rate_hz > 0 ? options.rate_hz : capture_.get(cv::CAP_PROP_FPS);
    constexpr double kUsualHz = 25;
    const bool known = std::isfinite(rate_hz) && rate_hz > 0 && rate_hz <= 1000;
    rate_hz_ = known ? rate_hz : kUsualHz;
    description_ = std::to_string(std::lround(capture_.get(cv::CAP_PROP_FRAME_WIDTH))) + " x " +
                   std::to_string(std::lround(capture_.get(cv::CAP_PROP_FRAME_HEIGHT))) +
                   " pixels, " + std::to_string(std::lround(rate_hz_)) + " images a second";
    if (options.is_device) description_ += ", " + four_letters(capture_.get(cv::CAP_PROP_FOURCC));
  }

  Result<std::optional<VideoImage>> next(Duration longest) override {
    try {
      return options_.is_device ? from_camera(longest) : from_film();
    } catch (const cv::Exception& error) {
      return gone("the driver failed: " + error.err);
    }
  }
  [[nodiscard]] Duration period() const override {
    if (options_.is_device) return Duration(0);
    return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(1 / rate_hz_));
  }
  [[nodiscard]] std::string description() const override { return description_; }

 private:
  [[nodiscard]] Error gone(const std::string& what) const {
    return {ErrorCode::kUnavailable, options_.path + ": " + what};
  }

  Result<std::optional<VideoImage>> from_camera(Duration longest) {
    std::vector<int> ready;
    const std::int64_t wait_ns = std::max<std::int64_t>(longest.count(), 1);
    if (!cv::VideoCapture::waitAny({capture_}, ready, wait_ns)) {
      return std::optional<VideoImage>();
    }
    cv::Mat image;
    if (!capture_.grab() || !capture_.retrieve(image)) {
      return gone("the camera gives no more images; plug it in again");
    }
    auto made = image_of(image, options_.colours);
    if (!made) return gone("expected images of 8 bits, found others");
    made->age = age_of_stamp(capture_.get(cv::CAP_PROP_POS_MSEC));
    return made;
  }

  Result<std::optional<VideoImage>> from_film() {
    cv::Mat image;
    if (!capture_.read(image)) {
      return Error{ErrorCode::kEndOfStream, options_.path + ": the film has ended"};
    }
    auto made = image_of(image, options_.colours);
    if (!made) return gone("expected images of 8 bits, found others");
    return made;
  }

  cv::VideoCapture capture_;
  VideoOptions options_;
  double rate_hz_ = 0;
  std::string description_;
};

/// Names what hinders a camera before OpenCV, which only says that it failed, is asked.
Result<void> check_camera(const std::string& path) {
  const FileDescriptor device(::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
  if (!device.is_open()) {
    switch (errno) {
      case ENOENT:
      case ENODEV:
      case ENXIO:
        return Error{
            ErrorCode::kNotFound,
            path + ": expected a camera, found none; plug it in (sonde devices lists them)"};
      case EACCES:
      case EPERM:
        return Error{ErrorCode::kUnavailable,
                     path +
                         ": expected to be readable, found permission denied: add the user to "
                         "the group video"};
      case EBUSY:
        return Error{ErrorCode::kUnavailable,
                     path + ": expected a camera for this program alone, found it in use"};
      default:
        return Error{ErrorCode::kUnavailable, path + ": cannot be opened: " + std::strerror(errno)};
    }
  }
  v4l2_capability capability{};
  const bool asked = ::ioctl(device.get(), VIDIOC_QUERYCAP, &capability) == 0;
  const std::uint32_t can = (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0
                                ? capability.device_caps
                                : capability.capabilities;
  if (asked && (can & V4L2_CAP_VIDEO_CAPTURE) != 0) return {};
  return Error{ErrorCode::kUnavailable,
               path + ": expected a camera (a video device that captures), found another device"};
}

int print_no_video_error(int, const char*, const char*, const char*, int, void*) { return 0; }

}  // namespace

Result<std::unique_ptr<VideoInput>> open_video(const VideoOptions& options) {
  // Errors come back as results: the library prints nothing.
  cv::redirectError(print_no_video_error);
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  const bool is_numbered = options.path.find('%') != std::string::npos;
  std::error_code status;
  if (options.is_device) {
    if (auto ok = check_camera(options.path); !ok) return ok.error();
  } else if (!is_numbered && !std::filesystem::is_regular_file(options.path, status)) {
    return Error{ErrorCode::kNotFound, options.path + ": expected a film, found no such file"};
  }
  cv::VideoCapture capture;
  // Readers of films, by name: any reader would include those that search for photo cameras on USB.
  std::vector<int> readers{cv::CAP_FFMPEG, cv::CAP_GSTREAMER, cv::CAP_OPENCV_MJPEG, cv::CAP_IMAGES};
  if (options.is_device) readers = {cv::CAP_V4L2};
  if (is_numbered && !options.is_device) readers = {cv::CAP_IMAGES};
  try {
    const bool opened = std::ranges::any_of(
        readers, [&](int reader) { return capture.open(options.path, reader); });
    if (!opened) {
      return Error{options.is_device ? ErrorCode::kUnavailable : ErrorCode::kNotFound,
                   options.path + (options.is_device
                                       ? ": the camera cannot be started; is it in use?"
                                       : ": expected a film or numbered images, found none that "
                                         "can be read")};
    }
    if (options.is_device) {
      if (options.width > 0) capture.set(cv::CAP_PROP_FRAME_WIDTH, options.width);
      if (options.height > 0) capture.set(cv::CAP_PROP_FRAME_HEIGHT, options.height);
      if (options.rate_hz > 0) capture.set(cv::CAP_PROP_FPS, options.rate_hz);
      const auto width = static_cast<int>(std::lround(capture.get(cv::CAP_PROP_FRAME_WIDTH)));
      const auto height = static_cast<int>(std::lround(capture.get(cv::CAP_PROP_FRAME_HEIGHT)));
      const bool granted = (options.width == 0 || options.width == width) &&
                           (options.height == 0 || options.height == height);
      if (!granted) {
        return Error{ErrorCode::kUnavailable,
                     options.path + ": expected images of " + std::to_string(options.width) +
                         " x " + std::to_string(options.height) + " pixels, the camera gives " +
                         std::to_string(width) + " x " + std::to_string(height) +
                         " (v4l2-ctl --list-formats-ext lists what it can)"};
      }
    }
  } catch (const cv::Exception& error) {
    return Error{ErrorCode::kUnavailable, options.path + ": cannot be opened: " + error.err};
  }
  return std::unique_ptr<VideoInput>(std::make_unique<CvVideoInput>(capture, options));
}

}  // namespace nav::devices
