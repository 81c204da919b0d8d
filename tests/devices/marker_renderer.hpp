// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <opencv2/aruco.hpp>
#include <random>
#include <string>
#include <vector>

#include "devices/camera/marker_tool.hpp"
#include "nav/image.hpp"

namespace nav::test {

/// A camera of the tests: pinhole with two radial coefficients, pixel centres at whole numbers.
struct TestCamera {
  int width = 1280, height = 1024;
  double focal_px = 1400;
  double centre_x = 640.3, centre_y = 508.7;
  double k1 = 0, k2 = 0;

  /// Direction (x/z, y/z) of a pixel, by fixed point.
  [[nodiscard]] Eigen::Vector2d direction(double x, double y) const {
    const Eigen::Vector2d bent((x - centre_x) / focal_px, (y - centre_y) / focal_px);
    Eigen::Vector2d straight = bent;
    for (int i = 0; i < 12 && (k1 != 0 || k2 != 0); ++i) {
      const double r2 = straight.squaredNorm();
      const Eigen::Vector2d better = bent / (1 + k1 * r2 + k2 * r2 * r2);
      const bool done = (better - straight).squaredNorm() < 1e-20;
      straight = better;
      if (done) break;
    }
    return straight;
  }
  [[nodiscard]] Eigen::Vector2d pixel(const Eigen::Vector3d& point) const {
    const Eigen::Vector2d straight = point.head<2>() / point.z();
    const double r2 = straight.squaredNorm();
    const Eigen::Vector2d bent = straight * (1 + k1 * r2 + k2 * r2 * r2);
    return {centre_x + focal_px * bent.x(), centre_y + focal_px * bent.y()};
  }
  /// Writes the calibration as OpenCV does.
  void write(const std::string& file) const {
    std::ofstream(file) << "%YAML:1.0\n---\nimage_width: " << width << "\nimage_height: " << height
                        << "\ncamera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
                           "   data: [ "
                        << focal_px << ", 0., " << centre_x << ", 0., " << focal_px << ", "
                        << centre_y
                        << ", 0., 0., 1. ]\ndistortion_coefficients: !!opencv-matrix\n   rows: 5\n"
                           "   cols: 1\n   dt: d\n   data: [ "
                        << k1 << ", " << k2 << ", 0., 0., 0. ]\n";
  }
};

/// Draws a pattern as a camera sees it, by rays through 5 x 5 points of each pixel, the blur of a
/// lens (a Gaussian of 0.7 px) and noise of 2 grey levels. Of the detector it uses nothing but the
/// bits of its dictionaries.
class MarkerRenderer {
 public:
  MarkerRenderer(const TestCamera& camera, int dictionary, unsigned seed)
      : camera_(camera),
        dictionary_(cv::aruco::getPredefinedDictionary(dictionary)),
        random_(seed),
        grey_(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height),
              kGround) {}

  /// Adds a tool at a pose in front of the camera.
  void add(const devices::MarkerTool& tool, const Eigen::Matrix4d& camera_from_tool) {
    constexpr int kPoints = 5;
    const Eigen::Matrix3d rotation = camera_from_tool.topLeftCorner<3, 3>();
    const Eigen::Vector3d origin = camera_from_tool.topRightCorner<3, 1>();
    const Eigen::Vector2d half = half_size(tool);
    Eigen::Vector2d low(1e9, 1e9), high(-1e9, -1e9);
    for (const double x : {-half.x(), half.x()}) {
      for (const double y : {-half.y(), half.y()}) {
        const Eigen::Vector2d at = camera_.pixel(rotation * Eigen::Vector3d(x, y, 0) + origin);
        low = low.cwiseMin(at);
        high = high.cwiseMax(at);
      }
    }
    const auto inside = [](double value, int size) {
      return static_cast<int>(std::clamp(value, 0.0, size - 1.0));
    };
    for (int row = inside(low.y() - 3, camera_.height); row <= inside(high.y() + 3, camera_.height);
         ++row) {
      for (int column = inside(low.x() - 3, camera_.width);
           column <= inside(high.x() + 3, camera_.width); ++column) {
        double sum = 0;
        const double ground = grey_[index(column, row)];
        for (int k = 0; k < kPoints * kPoints; ++k) {
          const double x = column + (k % kPoints + 0.5) / kPoints - 0.5;
          const double y = row + (k / kPoints + 0.5) / kPoints - 0.5;
          const Eigen::Vector2d d = camera_.direction(x, y);
          const Eigen::Vector3d ray(d.x(), d.y(), 1);
          // The ray meets the plane z = 0 of the tool at this depth.
          const double depth = rotation.col(2).dot(origin) / rotation.col(2).dot(ray);
          const Eigen::Vector3d at = rotation.transpose() * (depth * ray - origin);
          const bool on_paper =
              std::abs(at.x()) <= half.x() && std::abs(at.y()) <= half.y() && depth > 0;
          sum += on_paper ? (is_white(tool, at.x(), at.y()) ? kWhite : kBlack) : ground;
        }
        grey_[index(column, row)] = sum / (kPoints * kPoints);
      }
    }
  }

  [[nodiscard]] Image2d<std::uint8_t> image() {
    blur();
    std::normal_distribution<double> noise(0, 2);
    std::vector<std::uint8_t> pixels;
    for (const double value : grey_) {
      pixels.push_back(
          static_cast<std::uint8_t>(std::clamp(std::round(value + noise(random_)), 0.0, 255.0)));
    }
    return {camera_.width, camera_.height, std::move(pixels)};
  }

 private:
  static constexpr double kWhite = 215, kBlack = 35, kGround = 120;

  [[nodiscard]] std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(camera_.width) +
           static_cast<std::size_t>(column);
  }
  /// Half the size of the paper: a margin of a third of a marker around the pattern.
  static Eigen::Vector2d half_size(const devices::MarkerTool& tool) {
    const bool board = tool.kind == devices::MarkerTool::Kind::kCharuco;
    const double step = board ? tool.square_mm : tool.marker_mm + tool.gap_mm;
    const double margin = tool.marker_mm / 3 - (board ? 0 : 0.5 * tool.gap_mm);
    return {0.5 * tool.columns * step + margin, 0.5 * tool.rows * step + margin};
  }
  /// Colour of a marker at u to the right and v down from its top left corner, in its sides.
  [[nodiscard]] bool marker_white(int id, double u, double v) const {
    const int cells = dictionary_->markerSize + 2;
    const int column = static_cast<int>(u * cells), row = static_cast<int>(v * cells);
    if (column < 1 || row < 1 || column > cells - 2 || row > cells - 2) return false;
    const cv::Mat bits = cv::aruco::Dictionary::getBitsFromByteList(
        dictionary_->bytesList.rowRange(id, id + 1), dictionary_->markerSize);
    return bits.at<std::uint8_t>(row - 1, column - 1) != 0;
  }
  [[nodiscard]] bool is_white(const devices::MarkerTool& tool, double x, double y) const {
    const bool board = tool.kind == devices::MarkerTool::Kind::kCharuco;
    const double step = board ? tool.square_mm : tool.marker_mm + tool.gap_mm;
    // From the top left corner of the first cell, in cells.
    const double right = x / step + 0.5 * tool.columns, down = 0.5 * tool.rows - y / step;
    if (right < 0 || down < 0 || right >= tool.columns || down >= tool.rows) return true;
    const int column = static_cast<int>(right), row = static_cast<int>(down);
    if (board && (column + row) % 2 == 0) return false;
    const double side = tool.marker_mm / step, border = 0.5 * (1 - side);
    const double u = (right - column - border) / side, v = (down - row - border) / side;
    if (u < 0 || v < 0 || u >= 1 || v >= 1) return true;
    int id = tool.first_id + row * tool.columns + column;
    if (board) {
      id = tool.first_id;  // Markers stand in every second square.
      for (int k = 0; k < row * tool.columns + column; ++k) {
        id += (k % tool.columns + k / tool.columns) % 2;
      }
    }
    return marker_white(id, u, v);
  }
  void blur() {
    constexpr double kSigma = 0.7;
    std::array<double, 7> weights{};
    double sum = 0;
    for (int i = 0; i < 7; ++i) {
      sum += weights[static_cast<std::size_t>(i)] =
          std::exp(-0.5 * (i - 3) * (i - 3) / (kSigma * kSigma));
    }
    for (const bool across : {true, false}) {
      std::vector<double> out(grey_.size());
      for (int row = 0; row < camera_.height; ++row) {
        for (int column = 0; column < camera_.width; ++column) {
          double value = 0;
          for (int i = -3; i <= 3; ++i) {
            const int x = std::clamp(column + (across ? i : 0), 0, camera_.width - 1);
            const int y = std::clamp(row + (across ? 0 : i), 0, camera_.height - 1);
            value += weights[static_cast<std::size_t>(i + 3)] / sum * grey_[index(x, y)];
          }
          out[index(column, row)] = value;
        }
      }
      grey_ = std::move(out);
    }
  }

  TestCamera camera_;
  cv::Ptr<cv::aruco::Dictionary> dictionary_;
  std::mt19937 random_;
  std::vector<double> grey_;
};

/// Pose of a pattern that faces the camera, tilted by an angle about an axis in its plane.
inline Eigen::Matrix4d pattern_pose(double distance_mm, double tilt_rad, double axis_rad,
                                    double roll_rad = 0, double x_mm = 0, double y_mm = 0) {
  Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
  const Eigen::Vector3d axis(std::cos(axis_rad), std::sin(axis_rad), 0);
  pose.topLeftCorner<3, 3>() =
      (Eigen::AngleAxisd(tilt_rad, axis) * Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitZ()))
          .toRotationMatrix() *
      Eigen::Vector3d(1, -1, -1).asDiagonal();
  pose.topRightCorner<3, 1>() << x_mm, y_mm, distance_mm;
  return pose;
}

}  // namespace nav::test
