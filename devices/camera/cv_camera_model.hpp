// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "nav/result.hpp"

namespace nav::devices {

/// A calibrated camera: pinhole with the distortion of OpenCV.
struct CvCameraModel {
  std::string file;
  cv::Size size;
  cv::Matx33d matrix;
  std::vector<double> distortion;

  /// Mean focal length, pixels.
  [[nodiscard]] double focal_px() const { return 0.5 * (matrix(0, 0) + matrix(1, 1)); }
  /// Directions of pixels: x/z and y/z, without distortion.
  [[nodiscard]] std::vector<cv::Point2d> directions(const std::vector<cv::Point2d>& pixels) const;
  /// Pixels of directions.
  [[nodiscard]] std::vector<cv::Point2d> pixels(const std::vector<cv::Point2d>& directions) const;
};

/// Reads image_width, image_height, camera_matrix (3 x 3) and distortion_coefficients (4, 5, 8, 12
/// or 14) from a YAML, XML or JSON file of OpenCV, at most 1 MiB. Errors name file and key.
Result<CvCameraModel> read_camera_model(const std::filesystem::path& file);

}  // namespace nav::devices
