// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <mutex>
#include <thread>
#include <utility>

#include "devices/camera/frame_grabber_source.hpp"
#include "devices/camera/marker_source.hpp"

namespace nav::devices {

/// A camera without a driver: gives an image every few milliseconds, each different from the last.
class FakeCamera {
 public:
  VideoOpener opener() {
    return [this]() -> Result<std::unique_ptr<VideoInput>> {
      if (!there_) return Error{ErrorCode::kNotFound, "the camera is not there"};
      return std::unique_ptr<VideoInput>(std::make_unique<Input>(*this));
    };
  }
  void plug() { there_ = talks_ = true; }
  void unplug() { there_ = talks_ = false; }
  void hush() { talks_ = false; }

  std::atomic<int> width{8}, height{6};
  std::atomic<bool> repeats{false};   ///< Gives the same image again and again.
  std::atomic<Duration::rep> age{0};  ///< Age of each image.

 private:
  class Input final : public VideoInput {
   public:
    explicit Input(FakeCamera& camera) : camera_(camera) {}
    Result<std::optional<VideoImage>> next(Duration longest) override {
      std::this_thread::sleep_for(std::min<Duration>(longest, std::chrono::milliseconds(3)));
      if (!camera_.there_) return Error{ErrorCode::kUnavailable, "the camera is gone"};
      if (!camera_.talks_) return std::optional<VideoImage>();
      if (!camera_.repeats) ++count_;
      const int columns = camera_.width, rows = camera_.height;
      std::vector<std::uint8_t> pixels(
          static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), count_);
      return std::optional(
          VideoImage{.pixels = {columns, rows, std::move(pixels)}, .age = Duration(camera_.age)});
    }
    [[nodiscard]] Duration period() const override { return Duration(0); }
    [[nodiscard]] std::string description() const override { return "8 x 6 pixels"; }

   private:
    FakeCamera& camera_;
    std::uint8_t count_ = 0;
  };
  std::atomic<bool> there_{true}, talks_{true};
};

/// Finds what the test says, in every image of 8 x 6 pixels.
class FixedFinder final : public MarkerFinder {
 public:
  explicit FixedFinder(std::size_t tools) : readings(tools) {
    for (MarkerReading& one : readings) {
      one = {.markers = 1,
             .points = 4,
             .camera_from_tool = Eigen::Matrix4d::Identity(),
             .residual_px = 0.1,
             .error_mm = 0.2};
    }
  }
  Result<std::vector<MarkerReading>> find(const Image2d<std::uint8_t>& image) override {
    if (image.width() == 8 && image.height() == 6) return readings;
    return Error{ErrorCode::kUsage, "camera.yml: expected images of 8 x 6 pixels, found others"};
  }
  std::vector<MarkerReading> readings;
};

}  // namespace nav::devices
