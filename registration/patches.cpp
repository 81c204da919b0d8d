// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/patches.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>

namespace nav::registration {
namespace {

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
  Eigen::Vector2d centre;  ///< Image, mm.
  std::size_t order;       ///< Of its picture among the thinned ones.
  int bucket;
  double contrast;  ///< Standard deviation of a few of its samples, grey levels.
};

/// Corners of the picture, Image frame, mm.
std::array<Point<frames::Image>, 4> corners(const UltrasoundFrame& frame) {
  const double right = frame.pixels.width() - 1;
  const double below = frame.pixels.height() - 1;
  return {frame.grid.at(0, 0), frame.grid.at(right, 0), frame.grid.at(0, below),
          frame.grid.at(right, below)};
}

/// One thinned picture, smoothed to the level.
struct LevelPicture {
  int index;  ///< In the sweep.
  const TrackedFrame& tracked;
  const Image2d<std::uint8_t>& mask;
  SmoothPicture smooth;
};

/// Samples (i, j) of a square about a centre, each stride-th from −half to half; false: one lies
/// outside the mask. values: all samples.
bool sample_square(const LevelPicture& picture, const Eigen::Vector2d& centre, double step_mm,
                   int half, int stride, std::vector<float>& values) {
  const PixelGrid& grid = picture.tracked.frame.grid;
  const Eigen::Matrix2d pixel_per_mm = grid.mm_per_pixel.inverse();
  const Eigen::Vector2d middle = pixel_per_mm * (centre - grid.origin_mm);
  const Eigen::Vector2d a = pixel_per_mm.col(0) * step_mm;
  const Eigen::Vector2d b = pixel_per_mm.col(1) * step_mm;
  values.clear();
  for (int j = -half; j <= half; j += stride) {
    for (int i = -half; i <= half; i += stride) {
      const Eigen::Vector2d pixel = middle + i * a + j * b;
      const auto column = static_cast<int>(std::lround(pixel.x()));
      const auto row = static_cast<int>(std::lround(pixel.y()));
      if (column < 0 || row < 0 || column >= picture.mask.width() || row >= picture.mask.height() ||
          picture.mask.at(column, row) == 0) {
        return false;
      }
      values.push_back(picture.smooth.at(pixel));
    }
  }
  return true;
}

/// Takes the mean out; the standard deviation, and the mean where asked.
double centre_values(std::vector<float>& values, double* mean = nullptr) {
  const auto count = static_cast<double>(values.size());
  double sum = 0;
  for (const float value : values) sum += value;
  if (mean != nullptr) *mean = sum / count;
  double squares = 0;
  for (float& value : values) {
    value = static_cast<float>(value - sum / count);
    squares += static_cast<double>(value) * value;
  }
  return std::sqrt(squares / count);
}

/// Squares of half their width apart, wherever they lie.
std::vector<Eigen::Vector2d> square_centres(const UltrasoundFrame& frame,
                                            const LevelOptions& level) {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e300);
  Eigen::Vector2d high = -low;
  for (const auto& corner : corners(frame)) {
    low = low.cwiseMin(corner.mm.head<2>());
    high = high.cwiseMax(corner.mm.head<2>());
  }
  const double stride_mm = 0.5 * level.patch_side * level.sample_step_mm;
  std::vector<Eigen::Vector2d> centres;
  for (double y = low.y() + stride_mm; y < high.y(); y += stride_mm) {
    for (double x = low.x() + stride_mm; x < high.x(); x += stride_mm) centres.push_back({x, y});
  }
  return centres;
}

/// All candidates of one picture, by a few samples of each.
void find_candidates(const LevelPicture& picture, std::size_t order, const LevelOptions& level,
                     std::vector<Candidate>& out) {
  const int half = level.patch_side / 2;
  // Five samples a side, the corners among them where the side allows.
  const int stride = std::max(1, half / 2);
  const auto centres = square_centres(picture.tracked.frame, level);
  if (centres.empty()) return;
  const double top = centres.front().y();
  const double height = centres.back().y() - top + 0.5 * level.patch_side * level.sample_step_mm;
  std::vector<float> values;
  for (const Eigen::Vector2d& centre : centres) {
    if (!sample_square(picture, centre, level.sample_step_mm, half, stride, values)) continue;
    const double contrast = centre_values(values);
    if (!(contrast >= kMinDeviation)) continue;
    const double depth = (centre.y() - top) / height;
    const int band = std::clamp(static_cast<int>(depth * kDepthBands), 0, kDepthBands - 1);
    out.push_back({centre, order, static_cast<int>(order) * kDepthBands + band, contrast});
  }
}

/// Adds one patch with all its samples; false where the mask or the contrast says no.
bool add_patch(const LevelPicture& picture, const Eigen::Vector2d& centre,
               const LevelOptions& level, std::vector<float>& values, PatchSet& out) {
  const double step = level.sample_step_mm;
  if (!sample_square(picture, centre, step, level.patch_side / 2, 1, values)) return false;
  double mean = 0;
  const double deviation = centre_values(values, &mean);
  if (!(deviation >= kMinDeviation)) return false;
  const auto norm = static_cast<float>(deviation * std::sqrt(static_cast<double>(values.size())));
  for (const float value : values) out.samples.push_back(value / norm);
  const auto& outline = picture.tracked.frame.outline;
  const Eigen::Vector2d beam =
      outline ? (centre - outline->apex_mm).normalized() : Eigen::Vector2d(0, 1);
  const double depth = outline ? (centre - outline->apex_mm).norm() - outline->radius_min_mm
                               : centre.y() - picture.tracked.frame.grid.at(0, 0).mm.y();
  const auto& pose = picture.tracked.reference_from_image;
  out.patches.push_back({(pose * Point<frames::Image>{{centre.x(), centre.y(), 0}}).mm,
                         pose.rotation() * Eigen::Vector3d(step, 0, 0),
                         pose.rotation() * Eigen::Vector3d(0, step, 0),
                         pose.rotation() * Eigen::Vector3d(beam.x(), beam.y(), 0),
                         std::pow(deviation, kPatchWeightPower), picture.index, mean, norm, depth});
  return true;
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

namespace {

/// The best by contrast, at most twice the fair share of each picture and depth third.
void choose_by_contrast(const std::vector<LevelPicture>& pictures, const LevelOptions& level,
                        PatchSet& out) {
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    find_candidates(pictures[i], i, level, candidates);
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.contrast > b.contrast; });
  const std::size_t budget = static_cast<std::size_t>(level.patches);
  const std::size_t quota = 2 * budget / (pictures.size() * kDepthBands) + 1;
  std::vector<std::size_t> taken(pictures.size() * kDepthBands, 0);
  std::vector<float> values;
  for (const Candidate& candidate : candidates) {
    if (out.patches.size() == budget) break;
    std::size_t& of_bucket = taken[static_cast<std::size_t>(candidate.bucket)];
    if (of_bucket >= quota) continue;
    if (add_patch(pictures[candidate.order], candidate.centre, level, values, out)) ++of_bucket;
  }
}

/// Takes squares in an order that is spread evenly however soon it ends: steps of the golden ratio
/// through all squares of all pictures (Weyl's sequence). Squares that are not needed are not even
/// looked at.
void choose_evenly(const std::vector<LevelPicture>& pictures, const LevelOptions& level,
                   PatchSet& out) {
  std::vector<std::pair<std::size_t, Eigen::Vector2d>> squares;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    for (const auto& centre : square_centres(pictures[i].tracked.frame, level)) {
      squares.emplace_back(i, centre);
    }
  }
  const std::size_t n = squares.size();
  if (n == 0) return;
  constexpr double kGolden = 0.6180339887498949;
  const auto golden = std::lround(kGolden * static_cast<double>(n));
  auto step = std::max<std::size_t>(1, static_cast<std::size_t>(golden));
  while (std::gcd(step, n) != 1) ++step;
  std::vector<float> values;
  for (std::size_t k = 0, at = 0; k < n; ++k, at = (at + step) % n) {
    if (out.patches.size() == static_cast<std::size_t>(level.patches)) break;
    add_patch(pictures[squares[at].first], squares[at].second, level, values, out);
  }
}

}  // namespace

PatchSet make_patches(const Sweep& sweep, const std::vector<Image2d<std::uint8_t>>& masks,
                      const LevelOptions& level, double sigma_mm) {
  std::vector<LevelPicture> pictures;
  for (const int index : thin_frames(sweep, level.frame_step_mm)) {
    const auto i = static_cast<std::size_t>(index);
    const TrackedFrame& tracked = sweep.frames()[i];
    pictures.push_back({index, tracked, masks[i], smooth(tracked.frame, masks[i], sigma_mm)});
  }
  PatchSet out;
  out.side = level.patch_side;
  out.frames = static_cast<int>(pictures.size());
  if (level.choice == PatchChoice::kEven) {
    choose_evenly(pictures, level, out);
  } else {
    choose_by_contrast(pictures, level, out);
  }
  double total = 0;
  for (const Patch& patch : out.patches) total += patch.weight;
  for (Patch& patch : out.patches) patch.weight /= total;
  return out;
}

}  // namespace nav::registration
