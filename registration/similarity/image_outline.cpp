// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/similarity/image_outline.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace nav::registration {
namespace {

constexpr double kRadPerDegree = std::numbers::pi / 180;
constexpr std::size_t kLeastPoints = 12;
// Sides with a smaller angle are those of a linear probe.
constexpr double kLeastHalfAngle = 6 * kRadPerDegree;
constexpr double kMostHalfAngle = 80 * kRadPerDegree;
constexpr double kMostLean = 4 * kRadPerDegree;
constexpr int kLeastPartPixels = 20;
constexpr double kEdgePixels = 1.5;
// Largest fraction of the lit pixels outside a fitted sector, and least fraction of the sector that
// is lit: the rest may be shadow or lost contact.
constexpr double kMostOutside = 0.02;
constexpr double kLeastLit = 0.4;

/// Lit pixels (1, CV_8U) in connected parts of at least kLeastPartPixels, or in the largest part
/// only: burned-in text is a separate part.
cv::Mat lit_parts(const Sweep& sweep, bool largest_only) {
  const Image2d<std::uint8_t>& first = sweep.frames().front().frame.pixels;
  std::vector<std::uint8_t> dark = never_lit(sweep);
  const cv::Mat lit = cv::Mat(first.height(), first.width(), CV_8U, dark.data()) == 0;
  cv::Mat parts, stats, centres;
  const int count = cv::connectedComponentsWithStats(lit, parts, stats, centres, 4);
  const auto area = [&](int part) { return stats.at<int>(part, cv::CC_STAT_AREA); };
  int largest = 0;
  for (int part = 1; part < count; ++part) {
    if (largest == 0 || area(part) > area(largest)) largest = part;
  }
  cv::Mat out = cv::Mat::zeros(lit.size(), CV_8U);
  for (int part = 1; part < count; ++part) {
    if (largest_only ? part == largest : area(part) >= kLeastPartPixels) {
      out.setTo(1, parts == part);
    }
  }
  return out;
}

/// x = at_zero + slope · y, mm.
struct Side {
  double at_zero, slope;
};

Side line_through(const std::vector<Eigen::Vector2d>& points) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const auto& p : points) mean += p / static_cast<double>(points.size());
  double yy = 0, xy = 0;
  for (const auto& p : points) {
    yy += (p.y() - mean.y()) * (p.y() - mean.y());
    xy += (p.y() - mean.y()) * (p.x() - mean.x());
  }
  const double slope = xy / std::max(yy, 1e-9);
  return {mean.x() - slope * mean.y(), slope};
}

/// Outermost lit pixel of each row, (column, row).
std::vector<cv::Point> row_ends(const cv::Mat& lit, bool right) {
  std::vector<cv::Point> ends;
  for (int row = 0; row < lit.rows; ++row) {
    for (int i = 0; i < lit.cols; ++i) {
      const int column = right ? lit.cols - 1 - i : i;
      if (lit.at<std::uint8_t>(row, column) == 0) continue;
      ends.emplace_back(column, row);
      break;
    }
  }
  return ends;
}

/// An edge of a hull, with its upper end first.
struct HullEdge {
  cv::Point top, low;
  [[nodiscard]] int height() const { return low.y - top.y; }
  [[nodiscard]] double column_at(double row) const {
    return top.x + static_cast<double>(low.x - top.x) * (row - top.y) / height();
  }
};

/// A side of the sector. Except for the face, a sector is convex: even if shadows hide much of it,
/// its sides are the longest hull edges on their side that lead downwards and outwards.
std::optional<HullEdge> longest_edge(const std::vector<cv::Point>& lit_ends, bool right) {
  std::vector<cv::Point> hull, corners;
  cv::convexHull(lit_ends, hull);
  cv::approxPolyDP(hull, corners, 1.0, true);
  double middle = 0;
  for (const cv::Point& p : corners) middle += 1.0 * p.x / static_cast<double>(corners.size());
  std::optional<HullEdge> longest;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    HullEdge edge{corners[i], corners[(i + 1) % corners.size()]};
    if (edge.top.y > edge.low.y) std::swap(edge.top, edge.low);
    const double x = 0.5 * (edge.top.x + edge.low.x);
    const bool outwards = right ? edge.low.x >= edge.top.x : edge.low.x <= edge.top.x;
    if (edge.height() < 1 || !outwards || (right ? x < middle : x > middle)) continue;
    if (!longest || edge.height() > longest->height()) longest = edge;
  }
  return longest;
}

/// Line fitted to the ends of rows that touch the longest edge.
std::optional<Side> side_of(const cv::Mat& lit, const PixelGrid& grid, bool right) {
  const std::vector<cv::Point> ends = row_ends(lit, right);
  std::vector<cv::Point> all = row_ends(lit, !right);
  all.insert(all.end(), ends.begin(), ends.end());
  if (ends.size() < kLeastPoints) return {};
  const auto edge = longest_edge(all, right);
  if (!edge) return {};
  std::vector<Eigen::Vector2d> points;
  for (const cv::Point& e : ends) {
    if (e.y < edge->top.y || e.y > edge->low.y) continue;
    if (std::abs(e.x - edge->column_at(e.y)) > kEdgePixels) continue;
    points.push_back(grid.at(e.x, e.y).mm.head<2>());
  }
  if (points.size() < kLeastPoints) return {};
  return line_through(points);
}

/// Quantile \p share of the distances from the apex of the first (or last) lit pixels of the
/// central columns.
std::optional<double> radius_of(const cv::Mat& lit, const PixelGrid& grid,
                                const SectorOutline& sector, bool lower, double share) {
  std::vector<double> radii;
  for (int column = 0; column < lit.cols; ++column) {
    for (int i = 0; i < lit.rows; ++i) {
      const int row = lower ? lit.rows - 1 - i : i;
      if (lit.at<std::uint8_t>(row, column) == 0) continue;
      const Eigen::Vector2d d = grid.at(column, row).mm.head<2>() - sector.apex_mm;
      if (std::abs(std::atan2(d.x(), d.y())) < 0.8 * sector.half_angle_rad) {
        radii.push_back(d.norm());
      }
      break;
    }
  }
  if (radii.size() < kLeastPoints) return {};
  std::sort(radii.begin(), radii.end());
  return radii[static_cast<std::size_t>(share * static_cast<double>(radii.size() - 1))];
}

/// True if nearly all lit pixels lie in the sector, and enough of it is lit.
bool fits(const cv::Mat& lit, const PixelGrid& grid, SectorOutline sector) {
  const double edge_mm = kEdgePixels * grid.mm_per_pixel.col(0).norm();
  sector.radius_min_mm = std::max(sector.radius_min_mm - edge_mm, 0.0);
  sector.radius_max_mm += edge_mm;
  sector.half_angle_rad += edge_mm / sector.radius_max_mm;
  int shown = 0, outside = 0, dark = 0;
  for (int row = 0; row < lit.rows; ++row) {
    for (int column = 0; column < lit.cols; ++column) {
      const bool inside = sector.contains(grid.at(column, row).mm.head<2>());
      const bool is_lit = lit.at<std::uint8_t>(row, column) != 0;
      shown += is_lit ? 1 : 0;
      outside += is_lit && !inside ? 1 : 0;
      dark += inside && !is_lit ? 1 : 0;
    }
  }
  const int lit_inside = shown - outside;
  return outside <= kMostOutside * shown && lit_inside >= kLeastLit * (lit_inside + dark);
}

std::optional<SectorOutline> sector_about(const cv::Mat& lit, const PixelGrid& grid) {
  const auto left = side_of(lit, grid, false);
  const auto right = side_of(lit, grid, true);
  if (!left || !right) return {};
  const double closing = left->slope - right->slope;  // Negative if the sides open downwards.
  const double angle_left = -std::atan(left->slope);
  const double angle_right = std::atan(right->slope);
  SectorOutline sector{};
  sector.half_angle_rad = 0.5 * (angle_left + angle_right);
  if (!(sector.half_angle_rad > kLeastHalfAngle && sector.half_angle_rad < kMostHalfAngle)) {
    return {};
  }
  if (std::abs(angle_left - angle_right) > 2 * kMostLean) return {};
  sector.apex_mm.y() = (right->at_zero - left->at_zero) / closing;
  sector.apex_mm.x() = left->at_zero + left->slope * sector.apex_mm.y();
  // Fraction of the columns: gaps at the face and shadows at the end.
  constexpr double kRim = 0.05;
  const auto upper = radius_of(lit, grid, sector, false, kRim);
  const auto lower = radius_of(lit, grid, sector, true, 1 - kRim);
  if (!upper || !lower || !(*lower > *upper)) return {};
  sector.radius_min_mm = *upper;
  sector.radius_max_mm = *lower;
  if (!fits(lit, grid, sector)) return {};
  return sector;
}

}  // namespace

std::vector<std::uint8_t> never_lit(const Sweep& sweep) {
  constexpr std::uint8_t kNothing = 2;  // Greys up to this are black after lossy compression.
  const Image2d<std::uint8_t>& first = sweep.frames().front().frame.pixels;
  cv::Mat dark(first.height(), first.width(), CV_8U, cv::Scalar(1));
  for (const auto& tracked : sweep.frames()) {
    const auto pixels = tracked.frame.pixels.pixels();
    std::uint8_t* still = dark.data;
    const std::uint8_t* grey = pixels.data();
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      still[i] = static_cast<std::uint8_t>(still[i] & (grey[i] <= kNothing ? 1 : 0));
    }
  }
  cv::Mat parts;
  const int count = cv::connectedComponents(dark, parts, 4, CV_32S);
  std::vector<bool> at_border(static_cast<std::size_t>(count), false);
  const auto mark = [&](int row, int column) {
    at_border[static_cast<std::size_t>(parts.at<int>(row, column))] = true;
  };
  for (int row = 0; row < dark.rows; ++row) mark(row, 0), mark(row, dark.cols - 1);
  for (int column = 0; column < dark.cols; ++column) mark(0, column), mark(dark.rows - 1, column);
  for (int row = 0; row < dark.rows; ++row) {
    for (int column = 0; column < dark.cols; ++column) {
      const auto part = static_cast<std::size_t>(parts.at<int>(row, column));
      if (!at_border[part]) dark.at<std::uint8_t>(row, column) = 0;
    }
  }
  return {dark.datastart, dark.dataend};
}

std::optional<SectorOutline> sector_of(const Sweep& sweep) {
  const PixelGrid& grid = sweep.frames().front().frame.grid;
  const auto sector = sector_about(lit_parts(sweep, true), grid);
  return sector ? sector : sector_about(lit_parts(sweep, false), grid);
}

Sweep with_outline(const Sweep& sweep) {
  if (sweep.frames().front().frame.outline) return sweep;
  const auto sector = sector_of(sweep);
  if (!sector) return sweep;
  std::vector<TrackedImage> frames = sweep.frames();
  for (TrackedImage& tracked : frames) tracked.frame.outline = sector;
  auto made = Sweep::create(std::move(frames), sweep.calibration_id());
  NAV_CHECK(made.has_value());
  return std::move(*made);
}

}  // namespace nav::registration
