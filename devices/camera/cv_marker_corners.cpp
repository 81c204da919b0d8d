// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/camera/cv_marker_corners.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace nav::devices {
namespace {

constexpr double kLeastContrast = 15;  ///< Grey levels across an edge.
constexpr std::size_t kLeastEdgePoints = 5;

/// Brightness between pixel centres, which lie at whole numbers. Absent outside the image.
std::optional<double> brightness(const cv::Mat& image, double x, double y) {
  const double left = std::floor(x), top = std::floor(y);
  if (!(left >= 0 && top >= 0 && left + 1 < image.cols && top + 1 < image.rows)) {
    return std::nullopt;
  }
  const int i = static_cast<int>(left), j = static_cast<int>(top);
  const double u = x - left, v = y - top;
  const auto at = [&](int row, int column) {
    return static_cast<double>(image.at<std::uint8_t>(row, column));
  };
  return (1 - v) * ((1 - u) * at(j, i) + u * at(j, i + 1)) +
         v * ((1 - u) * at(j + 1, i) + u * at(j + 1, i + 1));
}

/// Place of an edge along a line through it, px from \p middle towards \p outward, where it is
/// bright. Absent: outside the image, or without contrast.
std::optional<double> edge_along(const cv::Mat& image, const cv::Point2d& middle,
                                 const cv::Point2d& outward, double reach_px) {
  constexpr double kStep = 0.25;
  const int half = std::max(4, static_cast<int>(std::lround(reach_px / kStep)));
  std::vector<double> profile;
  for (int i = -half; i <= half; ++i) {
    const cv::Point2d at = middle + (i * kStep) * outward;
    const auto value = brightness(image, at.x, at.y);
    if (!value) return std::nullopt;
    profile.push_back(*value);
  }
  // The plateaus are the mean of what lies near both ends.
  const int ends = std::max(2, half / 4);
  double dark = 0, bright = 0;
  for (int i = 0; i < ends; ++i) {
    dark += profile[static_cast<std::size_t>(i)] / ends;
    bright += profile[profile.size() - 1 - static_cast<std::size_t>(i)] / ends;
  }
  if (bright - dark < kLeastContrast) return std::nullopt;
  double area = 0;  // Trapezes.
  for (std::size_t i = 0; i < profile.size(); ++i) {
    const double weight = i == 0 || i + 1 == profile.size() ? 0.5 : 1;
    area += weight * kStep * (profile[i] - dark) / (bright - dark);
  }
  const double place = half * kStep - area;
  if (std::abs(place) > 0.8 * half * kStep) return std::nullopt;
  return place;
}

/// A line: points p with normal · p = offset.
struct EdgeLine {
  Eigen::Vector2d normal;
  double offset;
};

/// Line with the least squared distances from the points, without those that are far off.
std::optional<EdgeLine> line_through(std::vector<cv::Point2d> points) {
  for (int round = 0;; ++round) {
    if (points.size() < kLeastEdgePoints) return std::nullopt;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (const cv::Point2d& p : points) mean += Eigen::Vector2d(p.x, p.y);
    mean /= static_cast<double>(points.size());
    Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
    for (const cv::Point2d& p : points) {
      const Eigen::Vector2d d = Eigen::Vector2d(p.x, p.y) - mean;
      spread += d * d.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(spread);
    const EdgeLine line{solver.eigenvectors().col(0), solver.eigenvectors().col(0).dot(mean)};
    if (round == 2) return line;
    const double sigma =
        std::sqrt(std::max(solver.eigenvalues()[0], 0.0) / static_cast<double>(points.size()));
    constexpr double kFar = 2.5;
    std::erase_if(points, [&](const cv::Point2d& p) {
      return std::abs(line.normal.dot(Eigen::Vector2d(p.x, p.y)) - line.offset) > kFar * sigma;
    });
  }
}

std::optional<cv::Point2d> crossing(const EdgeLine& a, const EdgeLine& b) {
  Eigen::Matrix2d normals;
  normals << a.normal.transpose(), b.normal.transpose();
  if (std::abs(normals.determinant()) < 0.05) return std::nullopt;
  const Eigen::Vector2d p = normals.inverse() * Eigen::Vector2d(a.offset, b.offset);
  return cv::Point2d(p.x(), p.y());
}

/// Points of the edge from one corner to the next, pixels.
std::vector<cv::Point2d> edge_points(const cv::Mat& image, const cv::Point2d& from,
                                     const cv::Point2d& to, double reach_px) {
  const cv::Point2d along = to - from;
  const double length = std::hypot(along.x, along.y);
  std::vector<cv::Point2d> points;
  if (!(length > 4)) return points;
  const cv::Point2d step = along * (1 / length);
  // Corners are counted clockwise in the image, where y points down: outward is to the left.
  const cv::Point2d outward(step.y, -step.x);
  const double margin = std::max(0.12 * length, 2.0);
  for (double at = margin; at <= length - margin; at += 1) {
    const cv::Point2d middle = from + at * step;
    if (const auto place = edge_along(image, middle, outward, reach_px)) {
      points.push_back(middle + *place * outward);
    }
  }
  return points;
}

}  // namespace

std::optional<std::array<cv::Point2d, 4>> refine_square(const cv::Mat& image,
                                                        const CvCameraModel& camera,
                                                        std::array<cv::Point2d, 4> corners,
                                                        double cell_px) {
  std::array<cv::Point2d, 4> found;
  // The first pass starts from corners that are off by up to two pixels.
  for (const double reach_px :
       {std::clamp(0.45 * cell_px, 2.5, 6.0), std::clamp(0.4 * cell_px, 2.0, 4.0)}) {
    std::array<std::optional<EdgeLine>, 4> lines;
    for (std::size_t i = 0; i < 4; ++i) {
      const auto points = edge_points(image, corners[i], corners[(i + 1) % 4], reach_px);
      lines[i] = line_through(camera.directions(points));
      if (!lines[i]) return std::nullopt;
    }
    for (std::size_t i = 0; i < 4; ++i) {
      const auto corner = crossing(*lines[(i + 3) % 4], *lines[i]);
      if (!corner) return std::nullopt;
      found[i] = *corner;
    }
    const auto pixels = camera.pixels({found.begin(), found.end()});
    constexpr double kFarthestPx = 4;
    for (std::size_t i = 0; i < 4; ++i) {
      if (!(cv::norm(pixels[i] - corners[i]) < kFarthestPx)) return std::nullopt;
      corners[i] = pixels[i];
    }
  }
  return found;
}

std::optional<cv::Point2d> refine_saddle(const cv::Mat& image, cv::Point2d corner,
                                         double radius_px) {
  constexpr int kRounds = 12;
  constexpr double kSpacing = 0.5;
  const cv::Point2d begin = corner;
  const int half = std::max(4, static_cast<int>(radius_px / kSpacing));
  for (int round = 0; round < kRounds; ++round) {
    // Brightness a x² + b x y + c y² + d x + e y + f by least squares, within a circle.
    Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
    double low = 255, high = 0;
    for (int j = -half; j <= half; ++j) {
      for (int i = -half; i <= half; ++i) {
        if (i * i + j * j > half * half) continue;
        const double x = i * kSpacing, y = j * kSpacing;
        const auto value = brightness(image, corner.x + x, corner.y + y);
        if (!value) return std::nullopt;
        low = std::min(low, *value);
        high = std::max(high, *value);
        Eigen::Matrix<double, 6, 1> row;
        row << x * x, x * y, y * y, x, y, 1;
        normal.noalias() += row * row.transpose();
        right.noalias() += *value * row;
      }
    }
    if (high - low < kLeastContrast) return std::nullopt;
    const Eigen::Matrix<double, 6, 1> f = normal.ldlt().solve(right);
    Eigen::Matrix2d curvature;
    curvature << 2 * f[0], f[1], f[1], 2 * f[2];
    if (!(curvature.determinant() < 0)) return std::nullopt;  // A hill or a valley.
    const Eigen::Vector2d move = -curvature.inverse() * Eigen::Vector2d(f[3], f[4]);
    corner += cv::Point2d(move.x(), move.y());
    if (!(cv::norm(corner - begin) <= radius_px)) return std::nullopt;
    if (move.norm() < 1e-3) return corner;
  }
  return corner;
}

}  // namespace nav::devices
