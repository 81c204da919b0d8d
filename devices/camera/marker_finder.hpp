// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "devices/camera/marker_tool.hpp"
#include "nav/image.hpp"
#include "nav/result.hpp"

namespace nav::devices {

/// A tool as it was seen in an image.
struct MarkerReading {
  int markers = 0;  ///< Markers of the tool that were found.
  int points = 0;   ///< Corners that the pose was fitted to; 0: there is no pose.
  /// Pose of the tool in the frame of the camera: x to the right, y down, z along the view, mm.
  Eigen::Matrix4d camera_from_tool = Eigen::Matrix4d::Constant(std::nan(""));
  double residual_px = 0;  ///< Root mean square distance of the corners from where they belong.
  double error_mm = 0;     ///< Standard deviation of the tool's origin, by the residuals.
  /// A second pose, tilted the other way, fits the corners nearly as well: a flat pattern that is
  /// seen from the front or from far away.
  bool ambiguous = false;
  double other_residual_px = 0;  ///< Residual of that second pose; 0: there is none.
};

/// Finds tools in the images of a calibrated camera. Not thread-safe.
class MarkerFinder {
 public:
  virtual ~MarkerFinder() = default;
  /// Readings of all tools, in order. \p image: of the size of the calibration, otherwise kUsage
  /// with both sizes.
  virtual Result<std::vector<MarkerReading>> find(const Image2d<std::uint8_t>& image) = 0;
};

struct MarkerFinderOptions {
  std::vector<MarkerTool> tools{};
  std::string dictionary = "4x4_50";
  /// Calibration of the camera: a YAML, XML or JSON file of OpenCV with image_width, image_height,
  /// camera_matrix and distortion_coefficients.
  std::filesystem::path camera{};
};
/// Errors: kUsage as validate() for tools; kNotFound and kMalformedData for the calibration, by
/// file and key; kUnavailable in a build without cameras.
Result<std::unique_ptr<MarkerFinder>> make_marker_finder(const MarkerFinderOptions& options);

}  // namespace nav::devices
