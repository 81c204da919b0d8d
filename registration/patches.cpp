// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/patches.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <optional>

namespace nav::registration {
namespace {

// c.1: the gain-free weight of a patch is a mild power of its contrast; larger powers let a few
// bright interfaces rule.
constexpr double kWeightPower = 0.3;
// Grey levels. A flatter patch is quantisation noise.
constexpr double kMinDeviation = 1.0;
constexpr int kDepthBands = 3;

/// A picture smoothed to a level on coarser pixels, masked pixels not counted.
struct SmoothPicture {
  cv::Mat grey;  ///< CV_32F.
  double factor_x, factor_y;

  /// Bilinear, at full-resolution pixel coordinates.
  [[nodiscard]] float at(const Eigen::Vector2d& pixel) const {
    const double x = std::clamp((pixel.x() + 0.5) / factor_x - 0.5, 0.0, grey.cols - 1.0);
    const double y = std::clamp((pixel.y() + 0.5) / factor_y - 0.5, 0.0, grey.rows - 1.0);
    const int column = std::min(static_cast<int>(x), std::max(grey.cols - 2, 0));
    const int row = std::min(static_cast<int>(y), std::max(grey.rows - 2, 0));
    const int right = std::min(column + 1, grey.cols - 1);
    const int below = std::min(row + 1, grey.rows - 1);
    const auto wx = static_cast<float>(x - column);
    const auto wy = static_cast<float>(y - row);
    const float top = (1 - wx) * grey.at<float>(row, column) + wx * grey.at<float>(row, right);
    const float bottom =
        (1 - wx) * grey.at<float>(below, column) + wx * grey.at<float>(below, right);
    return (1 - wy) * top + wy * bottom;
  }
};

SmoothPicture smooth(const UltrasoundFrame& frame, const Image2d<std::uint8_t>& mask,
                     double sigma_mm) {
  const int width = frame.pixels.width();
  const int height = frame.pixels.height();
  // const_cast: cv::Mat has no read-only view; neither matrix is written.
  const cv::Mat grey(height, width, CV_8U,
                     const_cast<std::uint8_t*>(frame.pixels.pixels().data()));  // NOLINT
  const cv::Mat usable(height, width, CV_8U,
                       const_cast<std::uint8_t*>(mask.pixels().data()));  // NOLINT
  cv::Mat weight, value;
  usable.convertTo(weight, CV_32F);
  grey.convertTo(value, CV_32F);
  value = value.mul(weight);
  // Averaging three pixels per sigma first changes nothing that the Gaussian would keep.
  const double px = frame.grid.mm_per_pixel.col(0).norm();
  const double py = frame.grid.mm_per_pixel.col(1).norm();
  const int fx = std::clamp(static_cast<int>(0.35 * sigma_mm / px), 1, width);
  const int fy = std::clamp(static_cast<int>(0.35 * sigma_mm / py), 1, height);
  if (fx > 1 || fy > 1) {
    const cv::Rect whole(0, 0, width / fx * fx, height / fy * fy);
    const cv::Size size(width / fx, height / fy);
    cv::resize(value(whole), value, size, 0, 0, cv::INTER_AREA);
    cv::resize(weight(whole), weight, size, 0, 0, cv::INTER_AREA);
  }
  const double sx = std::max(sigma_mm / (px * fx), 1e-3);
  const double sy = std::max(sigma_mm / (py * fy), 1e-3);
  const cv::Size kernel(2 * static_cast<int>(std::ceil(3 * sx)) + 1,
                        2 * static_cast<int>(std::ceil(3 * sy)) + 1);
  cv::GaussianBlur(value, value, kernel, sx, sy, cv::BORDER_REPLICATE);
  cv::GaussianBlur(weight, weight, kernel, sx, sy, cv::BORDER_REPLICATE);
  constexpr double kNoWeight = 1e-6;
  return {value / cv::max(weight, kNoWeight), static_cast<double>(fx), static_cast<double>(fy)};
}

/// A patch before the selection.
struct Candidate {
  Patch patch;
  double deviation;  ///< Grey levels.
  int bucket;
  std::vector<float> u;
};

/// Corners of the picture, Image frame, mm.
std::array<Point<frames::Image>, 4> corners(const UltrasoundFrame& frame) {
  const double right = frame.pixels.width() - 1;
  const double below = frame.pixels.height() - 1;
  return {frame.grid.at(0, 0), frame.grid.at(right, 0), frame.grid.at(0, below),
          frame.grid.at(right, below)};
}

/// One candidate, or nothing where the mask or the contrast says no.
std::optional<Candidate> cut(const TrackedFrame& tracked, const Image2d<std::uint8_t>& mask,
                             const SmoothPicture& picture, const Eigen::Vector2d& centre,
                             const LevelOptions& level) {
  const UltrasoundFrame& frame = tracked.frame;
  const int half = level.patch_side / 2;
  const Eigen::Matrix2d pixel_per_mm = frame.grid.mm_per_pixel.inverse();
  const Eigen::Vector2d middle = pixel_per_mm * (centre - frame.grid.origin_mm);
  const Eigen::Vector2d a = pixel_per_mm.col(0) * level.sample_step_mm;
  const Eigen::Vector2d b = pixel_per_mm.col(1) * level.sample_step_mm;
  Candidate candidate;
  candidate.u.reserve(static_cast<std::size_t>(level.patch_side * level.patch_side));
  double sum = 0;
  for (int j = -half; j <= half; ++j) {
    for (int i = -half; i <= half; ++i) {
      const Eigen::Vector2d pixel = middle + i * a + j * b;
      const auto column = static_cast<int>(std::lround(pixel.x()));
      const auto row = static_cast<int>(std::lround(pixel.y()));
      if (column < 0 || row < 0 || column >= mask.width() || row >= mask.height() ||
          mask.at(column, row) == 0) {
        return {};
      }
      candidate.u.push_back(picture.at(pixel));
      sum += candidate.u.back();
    }
  }
  const auto count = static_cast<double>(candidate.u.size());
  double squares = 0;
  for (float& value : candidate.u) {
    value = static_cast<float>(value - sum / count);
    squares += static_cast<double>(value) * value;
  }
  candidate.deviation = std::sqrt(squares / count);
  if (!(candidate.deviation >= kMinDeviation)) return {};
  const auto norm = static_cast<float>(std::sqrt(squares));
  for (float& value : candidate.u) value /= norm;

  const auto& pose = tracked.reference_from_image;
  const double step = level.sample_step_mm;
  const Eigen::Vector2d beam =
      frame.outline ? (centre - frame.outline->apex_mm).normalized() : Eigen::Vector2d(0, 1);
  candidate.patch = {(pose * Point<frames::Image>{{centre.x(), centre.y(), 0}}).mm,
                     pose.rotation() * Eigen::Vector3d(step, 0, 0),
                     pose.rotation() * Eigen::Vector3d(0, step, 0),
                     pose.rotation() * Eigen::Vector3d(beam.x(), beam.y(), 0),
                     std::pow(candidate.deviation, kWeightPower),
                     0};
  return candidate;
}

/// All candidates of one picture.
void cut_frame(const Sweep& sweep, int index, int order, const Image2d<std::uint8_t>& mask,
               const LevelOptions& level, double sigma_mm, std::vector<Candidate>& out) {
  const TrackedFrame& tracked = sweep.frames()[static_cast<std::size_t>(index)];
  const SmoothPicture picture = smooth(tracked.frame, mask, sigma_mm);
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e300);
  Eigen::Vector2d high = -low;
  for (const auto& corner : corners(tracked.frame)) {
    low = low.cwiseMin(corner.mm.head<2>());
    high = high.cwiseMax(corner.mm.head<2>());
  }
  const double stride = 0.5 * level.patch_side * level.sample_step_mm;
  for (double y = low.y() + stride; y < high.y(); y += stride) {
    for (double x = low.x() + stride; x < high.x(); x += stride) {
      auto candidate = cut(tracked, mask, picture, {x, y}, level);
      if (!candidate) continue;
      candidate->patch.frame = index;
      const double depth = (y - low.y()) / (high.y() - low.y());
      candidate->bucket = order * kDepthBands +
                          std::clamp(static_cast<int>(depth * kDepthBands), 0, kDepthBands - 1);
      out.push_back(std::move(*candidate));
    }
  }
}

}  // namespace

std::vector<int> thin_frames(const Sweep& sweep, double step_mm) {
  // Evenly stepped sweeps must not be thinned by the rounding of their origin.
  constexpr double kAlmost = 1 - 1e-6;
  std::vector<int> kept;
  std::array<Eigen::Vector3d, 4> last;
  for (std::size_t i = 0; i < sweep.frames().size(); ++i) {
    const TrackedFrame& tracked = sweep.frames()[i];
    std::array<Eigen::Vector3d, 4> now;
    double moved_mm = 0;
    const auto image_corners = corners(tracked.frame);
    for (std::size_t c = 0; c < now.size(); ++c) {
      now[c] = (tracked.reference_from_image * image_corners[c]).mm;
      if (!kept.empty()) moved_mm = std::max(moved_mm, (now[c] - last[c]).norm());
    }
    if (!kept.empty() && moved_mm < kAlmost * step_mm) continue;
    kept.push_back(static_cast<int>(i));
    last = now;
  }
  return kept;
}

PatchSet make_patches(const Sweep& sweep, const std::vector<Image2d<std::uint8_t>>& masks,
                      const LevelOptions& level, double sigma_mm) {
  const std::vector<int> kept = thin_frames(sweep, level.frame_step_mm);
  std::vector<Candidate> candidates;
  int order = 0;
  for (const int index : kept) {
    cut_frame(sweep, index, order++, masks[static_cast<std::size_t>(index)], level, sigma_mm,
              candidates);
  }
  std::vector<std::size_t> by_contrast(candidates.size());
  std::iota(by_contrast.begin(), by_contrast.end(), std::size_t{0});
  std::stable_sort(by_contrast.begin(), by_contrast.end(), [&](std::size_t a, std::size_t b) {
    return candidates[a].deviation > candidates[b].deviation;
  });
  const std::size_t budget = static_cast<std::size_t>(level.patches);
  const std::size_t quota = 2 * budget / (kept.size() * kDepthBands) + 1;
  std::map<int, std::size_t> taken;
  PatchSet out;
  out.side = level.patch_side;
  out.frames = static_cast<int>(kept.size());
  double total = 0;
  for (const std::size_t i : by_contrast) {
    if (out.patches.size() == budget) break;
    if (taken[candidates[i].bucket]++ >= quota) continue;
    out.patches.push_back(candidates[i].patch);
    out.samples.insert(out.samples.end(), candidates[i].u.begin(), candidates[i].u.end());
    total += candidates[i].patch.weight;
  }
  for (Patch& patch : out.patches) patch.weight /= total;
  return out;
}

}  // namespace nav::registration
