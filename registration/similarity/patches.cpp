// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/similarity/patches.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>

#include "nav/check.hpp"
#include "nav/index.hpp"
#include "registration/similarity/coarse_images.hpp"
#include "registration/similarity/lc2_kernel.hpp"

namespace nav::registration {
namespace {

// Least standard deviation in grey levels. A flatter patch is quantisation noise.
constexpr double kMinDeviation = 1.0;
constexpr int kDepthBands = 3;

/// Position between two pixels of one axis: low and the next one, if there is one.
struct Between {
  int low;
  float w;  ///< Weight of the next pixel.
};

/// An ultrasound image smoothed to a level on coarser pixels, without the pixels outside the mask.
struct SmoothImage {
  cv::Mat grey;         ///< CV_32F.
  double per_x, per_y;  ///< Pixels of grey per pixel of the image.

  static Between between(double pixel, double per_pixel, int count) {
    const double at = std::clamp((pixel + 0.5) * per_pixel - 0.5, 0.0, count - 1.0);
    const int low = std::min(static_cast<int>(at), std::max(count - 2, 0));
    return {low, static_cast<float>(at - low)};
  }
  [[nodiscard]] Between along_x(double pixel) const { return between(pixel, per_x, grey.cols); }
  [[nodiscard]] Between along_y(double pixel) const { return between(pixel, per_y, grey.rows); }

  /// Bilinear, at full-resolution pixel coordinates.
  [[nodiscard]] float at(double pixel_x, double pixel_y) const {
    return at(along_x(pixel_x), along_y(pixel_y));
  }
  [[nodiscard]] float at(const Between& x, const Between& y) const {
    const int right = grey.cols > 1 ? 1 : 0;
    const float* above = grey.ptr<float>(y.low) + x.low;
    const float* below = grey.rows > 1 ? grey.ptr<float>(y.low + 1) + x.low : above;
    const float top = above[0] + x.w * (above[right] - above[0]);
    const float bottom = below[0] + x.w * (below[right] - below[0]);
    return top + y.w * (bottom - top);
  }
};

/// Working memory of the smoothing, shared by all images.
struct SmoothBuffers {
  cv::Mat sums;                  ///< CV_32FC2: sum of the pixels' greys, and number of pixels.
  std::vector<int> grey, count;  ///< Value of each column, over the rows of a block.
};

/// Adds a row of pixels; pixels outside the mask are not counted.
void add_row(std::span<const std::uint8_t> grey, std::span<const std::uint8_t> usable,
             SmoothBuffers& sums) {
  int* grey_sum = sums.grey.data();
  int* count = sums.count.data();
  for (std::size_t column = 0; column < grey.size(); ++column) {
    grey_sum[column] += grey[column] * usable[column];
    count[column] += usable[column];
  }
}

/// Sums of greys and pixel counts over blocks.
void add_blocks(const UltrasoundImage& frame, const Image2d<std::uint8_t>& mask, int fx, int fy,
                SmoothBuffers& out) {
  const int columns = frame.pixels.width() / fx;
  const int rows = frame.pixels.height() / fy;
  const auto width = static_cast<std::size_t>(frame.pixels.width());
  out.sums.create(rows, columns, CV_32FC2);
  if (fx == 1 && fy == 1) {  // The most frequent case on the finest level.
    const auto grey = frame.pixels.pixels();
    const auto usable = mask.pixels();
    auto* sum = out.sums.ptr<float>();
    for (std::size_t i = 0; i < grey.size(); ++i) {
      sum[2 * i] = static_cast<float>(grey[i] * usable[i]);
      sum[2 * i + 1] = static_cast<float>(usable[i]);
    }
    return;
  }
  for (int row = 0; row < rows; ++row) {
    out.grey.assign(width, 0);
    out.count.assign(width, 0);
    for (int y = row * fy; y < (row + 1) * fy; ++y) {
      const std::size_t first = static_cast<std::size_t>(y) * width;
      add_row(frame.pixels.pixels().subspan(first, width), mask.pixels().subspan(first, width),
              out);
    }
    auto* sum = out.sums.ptr<float>(row);
    for (int column = 0; column < columns; ++column) {
      const auto from = static_cast<std::ptrdiff_t>(column) * fx;
      *sum++ = static_cast<float>(
          std::accumulate(out.grey.begin() + from, out.grey.begin() + from + fx, 0));
      *sum++ = static_cast<float>(
          std::accumulate(out.count.begin() + from, out.count.begin() + from + fx, 0));
    }
  }
}

SmoothImage smooth(const UltrasoundImage& frame, const Image2d<std::uint8_t>& mask, double sigma_mm,
                   SmoothBuffers& buffers) {
  const int width = frame.pixels.width();
  const int height = frame.pixels.height();
  const double px = frame.grid.mm_per_pixel.col(0).norm();
  const double py = frame.grid.mm_per_pixel.col(1).norm();
  const int fx = std::clamp(static_cast<int>(kBlockPerSigma * sigma_mm / px), 1, width);
  const int fy = std::clamp(static_cast<int>(kBlockPerSigma * sigma_mm / py), 1, height);
  add_blocks(frame, mask, fx, fy, buffers);
  // A mean of b pixels already has the variance (b² − 1)/12.
  const auto left = [&](double pixel_mm, int block) {
    const double all = sigma_mm * sigma_mm / (pixel_mm * pixel_mm);
    return std::max(std::sqrt(std::max(all - (block * block - 1) / 12.0, 0.0)) / block, 1e-3);
  };
  const double sx = left(px, fx);
  const double sy = left(py, fy);
  const cv::Size kernel(2 * static_cast<int>(std::ceil(3 * sx)) + 1,
                        2 * static_cast<int>(std::ceil(3 * sy)) + 1);
  cv::GaussianBlur(buffers.sums, buffers.sums, kernel, sx, sy, cv::BORDER_REPLICATE);
  SmoothImage out{cv::Mat(buffers.sums.size(), CV_32F), 1.0 / fx, 1.0 / fy};
  constexpr float kNoWeight = 1e-6f;
  const auto* sum = buffers.sums.ptr<float>();
  auto* grey = out.grey.ptr<float>();
  const std::size_t count = out.grey.total();
  for (std::size_t i = 0; i < count; ++i) {
    grey[i] = sum[2 * i] / std::max(sum[2 * i + 1], kNoWeight);
  }
  return out;
}

/// A patch before the selection.
struct PatchCandidate {
  Eigen::Vector2d centre;  ///< Image, mm.
  std::size_t order;       ///< Index of its image among the thinned ones.
  int bucket;
  double contrast;  ///< Standard deviation of a few of its samples, grey levels.
};

/// Corners of an ultrasound image, Image frame, mm.
std::array<Point<frames::Image>, 4> corners(const UltrasoundImage& frame) {
  const double right = frame.pixels.width() - 1;
  const double below = frame.pixels.height() - 1;
  return {frame.grid.at(0, 0), frame.grid.at(right, 0), frame.grid.at(0, below),
          frame.grid.at(right, below)};
}

/// One thinned ultrasound image, smoothed to the level.
struct LevelImage {
  int index;  ///< Index in the sweep.
  const TrackedImage& tracked;
  const Image2d<std::uint8_t>& mask;
  SmoothImage smooth;
  Eigen::Matrix2d pixel_per_mm = tracked.frame.grid.mm_per_pixel.inverse();
  int width = mask.width();
  int height = mask.height();
  const std::uint8_t* usable = mask.pixels().data();

  /// True if the nearest pixel is inside the mask.
  [[nodiscard]] bool inside(double pixel_x, double pixel_y) const {
    // Truncation rounds positive values down.
    const double x = pixel_x + 0.5;
    const double y = pixel_y + 0.5;
    if (!(x >= 0 && y >= 0 && x < width && y < height)) return false;
    return usable[static_cast<std::ptrdiff_t>(y) * width + static_cast<std::ptrdiff_t>(x)] != 0;
  }
};

/// sample_square() for a square whose sides are parallel to those of the pixels, one axis at a
/// time, with the same bits. Its corners must lie in the image.
bool sample_upright(const LevelImage& image, const Eigen::Vector2d& middle, double step_x,
                    double step_y, int half, int stride, std::vector<float>& values) {
  struct Column {
    std::ptrdiff_t pixel;
    Between between;
  };
  std::array<Column, kMaxPatchSide> columns;
  std::size_t count = 0;
  for (int i = -half; i <= half; i += stride) {
    const double x = middle.x() + i * step_x;
    columns[count++] = {static_cast<std::ptrdiff_t>(x + 0.5), image.smooth.along_x(x)};
  }
  for (int j = -half; j <= half; j += stride) {
    const double y = middle.y() + j * step_y;
    const std::uint8_t* usable = image.usable + static_cast<std::ptrdiff_t>(y + 0.5) * image.width;
    const Between row = image.smooth.along_y(y);
    for (std::size_t c = 0; c < count; ++c) {
      if (usable[columns[c].pixel] == 0) return false;
      values.push_back(image.smooth.at(columns[c].between, row));
    }
  }
  return true;
}

/// Samples (i, j) of a square about a centre, every stride-th from −half to half. Returns false if
/// one lies outside the mask. values: the samples.
bool sample_square(const LevelImage& image, const Eigen::Vector2d& centre, double step_mm, int half,
                   int stride, std::vector<float>& values) {
  const Eigen::Vector2d middle = image.pixel_per_mm * (centre - image.tracked.frame.grid.origin_mm);
  const Eigen::Vector2d a = image.pixel_per_mm.col(0) * step_mm;
  const Eigen::Vector2d b = image.pixel_per_mm.col(1) * step_mm;
  values.clear();
  // Most squares that do not lie inside have a corner outside.
  for (const int j : {-half, half}) {
    for (const int i : {-half, half}) {
      if (!image.inside(middle.x() + i * a.x() + j * b.x(), middle.y() + i * a.y() + j * b.y())) {
        return false;
      }
    }
  }
  if (a.y() == 0 && b.x() == 0) {
    return sample_upright(image, middle, a.x(), b.y(), half, stride, values);
  }
  for (int j = -half; j <= half; j += stride) {
    for (int i = -half; i <= half; i += stride) {
      const double x = middle.x() + i * a.x() + j * b.x();
      const double y = middle.y() + i * a.y() + j * b.y();
      if (!image.inside(x, y)) return false;
      values.push_back(image.smooth.at(x, y));
    }
  }
  return true;
}

/// Subtracts the mean; returns the standard deviation, and the mean if requested.
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

/// Squares at distances of half their width, row by row; they may lie outside the mask.
struct Squares {
  std::vector<Eigen::Vector2d> centres;
  std::size_t columns = 0;
};

Squares squares_of(const UltrasoundImage& frame, const LevelOptions& level) {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e300);
  Eigen::Vector2d high = -low;
  for (const auto& corner : corners(frame)) {
    low = low.cwiseMin(corner.mm.head<2>());
    high = high.cwiseMax(corner.mm.head<2>());
  }
  const double stride_mm = 0.5 * level.patch_side * level.sample_step_mm;
  Squares out;
  for (double y = low.y() + stride_mm; y < high.y(); y += stride_mm) {
    const std::size_t before = out.centres.size();
    for (double x = low.x() + stride_mm; x < high.x(); x += stride_mm) {
      out.centres.push_back({x, y});
    }
    out.columns = out.centres.size() - before;
  }
  return out;
}

/// All candidates of one image, judged by a few samples of each.
void find_candidates(const LevelImage& image, std::size_t order, const LevelOptions& level,
                     std::vector<PatchCandidate>& out) {
  const int half = level.patch_side / 2;
  // Five samples a side, including the corners if the side allows.
  const int stride = std::max(1, half / 2);
  const auto centres = squares_of(image.tracked.frame, level).centres;
  if (centres.empty()) return;
  const double top = centres.front().y();
  const double height = centres.back().y() - top + 0.5 * level.patch_side * level.sample_step_mm;
  std::vector<float> values;
  for (const Eigen::Vector2d& centre : centres) {
    if (!sample_square(image, centre, level.sample_step_mm, half, stride, values)) continue;
    const double contrast = centre_values(values);
    if (!(contrast >= kMinDeviation)) continue;
    const double depth = (centre.y() - top) / height;
    const int band = std::clamp(static_cast<int>(depth * kDepthBands), 0, kDepthBands - 1);
    out.push_back({centre, order, static_cast<int>(order) * kDepthBands + band, contrast});
  }
}

/// Adds one patch with all its samples; returns false if the mask or the contrast rejects it.
bool add_patch(const LevelImage& image, const Eigen::Vector2d& centre, const LevelOptions& level,
               std::vector<float>& values, PatchSet& out) {
  const double step = level.sample_step_mm;
  if (!sample_square(image, centre, step, level.patch_side / 2, 1, values)) return false;
  double mean = 0;
  const double deviation = centre_values(values, &mean);
  if (!(deviation >= kMinDeviation)) return false;
  const auto norm = static_cast<float>(deviation * std::sqrt(static_cast<double>(values.size())));
  for (const float value : values) out.samples.push_back(value / norm);
  const auto& outline = image.tracked.frame.outline;
  const Eigen::Vector2d beam =
      outline ? (centre - outline->apex_mm).normalized() : Eigen::Vector2d(0, 1);
  const double depth = outline ? (centre - outline->apex_mm).norm() - outline->radius_min_mm
                               : centre.y() - image.tracked.frame.grid.at(0, 0).mm.y();
  const auto& pose = image.tracked.reference_from_image;
  out.patches.push_back({.centre_mm = (pose * Point<frames::Image>{{centre.x(), centre.y(), 0}}).mm,
                         .step_a = pose.rotation() * Eigen::Vector3d(step, 0, 0),
                         .step_b = pose.rotation() * Eigen::Vector3d(0, step, 0),
                         .beam = pose.rotation() * Eigen::Vector3d(beam.x(), beam.y(), 0),
                         .weight = std::pow(deviation, kPatchWeightPower),
                         .frame = image.index,
                         .mean_grey = mean,
                         .norm_grey = norm,
                         .depth_mm = depth});
  return true;
}

}  // namespace

double corners_moved_mm(const TrackedImage& from, const TrackedImage& to) {
  const auto before = corners(from.frame);
  const auto after = corners(to.frame);
  double moved_mm = 0;
  for (std::size_t c = 0; c < before.size(); ++c) {
    const auto a = from.reference_from_image * before[c];
    moved_mm = std::max(moved_mm, (to.reference_from_image * after[c] - a).v.norm());
  }
  return moved_mm;
}

std::vector<int> thin_frames(const Sweep& sweep, double step_mm) {
  // Sweeps with even steps must not be thinned because of rounding of their origin.
  constexpr double kAlmost = 1 - 1e-6;
  std::vector<int> kept;
  std::array<Eigen::Vector3d, 4> last;
  for (std::size_t i = 0; i < sweep.frames().size(); ++i) {
    const TrackedImage& tracked = sweep.frames()[i];
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

/// Chooses the patches of highest contrast, at most twice the fair share of each image and depth
/// third.
void choose_by_contrast(const std::vector<LevelImage>& images, const LevelOptions& level,
                        PatchSet& out) {
  std::vector<PatchCandidate> candidates;
  for (std::size_t i = 0; i < images.size(); ++i) {
    find_candidates(images[i], i, level, candidates);
  }
  std::stable_sort(
      candidates.begin(), candidates.end(),
      [](const PatchCandidate& a, const PatchCandidate& b) { return a.contrast > b.contrast; });
  const std::size_t budget = static_cast<std::size_t>(level.patches);
  const std::size_t quota = 2 * budget / (images.size() * kDepthBands) + 1;
  std::vector<std::size_t> taken(images.size() * kDepthBands, 0);
  std::vector<float> values;
  for (const PatchCandidate& candidate : candidates) {
    if (out.patches.size() == budget) break;
    std::size_t& of_bucket = taken[static_cast<std::size_t>(candidate.bucket)];
    if (of_bucket >= quota) continue;
    if (add_patch(images[candidate.order], candidate.centre, level, values, out)) ++of_bucket;
  }
}

/// Morton key (1966): the bits of the three cell indices are interleaved, so that points of one
/// cube are consecutive and neighbouring cubes are seldom far apart.
std::uint64_t place_key(const Eigen::Vector3d& cell) {
  constexpr double kMiddle = 1 << 20;
  constexpr int kBits = 21;
  std::uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double held = std::clamp(cell[axis] + kMiddle, 0.0, 2 * kMiddle - 1);
    const auto index = static_cast<std::uint64_t>(held);
    for (int bit = 0; bit < kBits; ++bit) key |= (index >> bit & 1) << (3 * bit + axis);
  }
  return key;
}

/// Sorts patches by position, so that the CT texels of consecutive patches are in the cache.
void order_by_place(PatchSet& set) {
  constexpr double kCellMm = 8;
  if (set.patches.empty()) return;
  const Eigen::Vector3d first = set.patches.front().centre_mm;
  std::vector<std::pair<std::uint64_t, std::size_t>> order;
  for (std::size_t i = 0; i < set.patches.size(); ++i) {
    const Eigen::Vector3d cell = ((set.patches[i].centre_mm - first) / kCellMm).array().floor();
    order.emplace_back(place_key(cell), i);
  }
  std::sort(order.begin(), order.end());
  PatchSet out{set.side, {}, {}, set.frames};
  out.patches.reserve(set.patches.size());
  out.samples.reserve(set.samples.size());
  for (const auto& [key, i] : order) {
    out.patches.push_back(set.patches[i]);
    const auto u = set.u(i);
    out.samples.insert(out.samples.end(), u.begin(), u.end());
  }
  set = std::move(out);
}

/// The squares of one image that may still be added to a set.
class SquaresLeft {
 public:
  SquaresLeft(const UltrasoundImage& frame, const LevelOptions& level)
      : squares_(squares_of(frame, level)), states_(squares_.centres.size(), State::kNew) {}

  [[nodiscard]] std::size_t count() const { return states_.size(); }
  /// Index of the square at a position between 0 and 1 along the columns and rows. Precondition:
  /// count() > 0.
  [[nodiscard]] std::size_t at(double x, double y) const {
    const auto part = [](double share, std::size_t of) {
      return std::min(static_cast<std::size_t>(share * static_cast<double>(of)), of - 1);
    };
    return part(y, count() / squares_.columns) * squares_.columns + part(x, squares_.columns);
  }
  /// Adds a square once. Before let_overlap(), squares that overlap half of an added one are put
  /// off.
  void take(std::size_t square, const LevelImage& image, const LevelOptions& level,
            std::vector<float>& values, PatchSet& out) {
    if (states_[square] != State::kNew) return;
    states_[square] = State::kSeen;
    if (!add_patch(image, squares_.centres[square], level, values, out)) return;
    if (overlap_) return;
    const std::size_t column = square % squares_.columns;
    if (column > 0) put_off(square - 1);
    if (column + 1 < squares_.columns) put_off(square + 1);
    if (square >= squares_.columns) put_off(square - squares_.columns);
    if (square + squares_.columns < count()) put_off(square + squares_.columns);
  }
  void let_overlap() {
    overlap_ = true;
    std::replace(states_.begin(), states_.end(), State::kPutOff, State::kNew);
  }

 private:
  enum class State : std::uint8_t { kNew, kPutOff, kSeen };
  void put_off(std::size_t square) {
    if (states_[square] == State::kNew) states_[square] = State::kPutOff;
  }
  Squares squares_;
  std::vector<State> states_;
  bool overlap_ = false;
};

/// Takes squares in an order that is spread evenly over images, columns and rows, however early it
/// ends: steps of the powers of 1/g, g⁴ = g + 1, along the three (the additive recurrence of
/// Roberts 2018). Equal steps through all squares would form chains of overlapping squares for some
/// counts of columns and rows. Squares that overlap half of a taken one come after all others.
/// Squares that are not needed are never evaluated.
void choose_evenly(const std::vector<LevelImage>& images, const LevelOptions& level,
                   PatchSet& out) {
  // After this many steps, new squares are rarely found; the remaining ones follow in order.
  constexpr std::size_t kStepsPerSquare = 4;
  constexpr double kRoot = 1.2207440846057596;
  const Eigen::Array3d step(1 / kRoot, 1 / (kRoot * kRoot), 1 / (kRoot * kRoot * kRoot));
  std::vector<SquaresLeft> left;
  std::size_t all = 0;
  for (const LevelImage& image : images) {
    left.emplace_back(image.tracked.frame, level);
    all += left.back().count();
  }
  std::vector<float> values;
  const auto enough = [&] { return out.patches.size() == as_size(level.patches); };
  for (int round = 0; round < 2; ++round) {
    Eigen::Array3d at = Eigen::Array3d::Constant(0.5);
    for (std::size_t k = 0; k < kStepsPerSquare * all && !enough(); ++k) {
      const double share = at[0] * static_cast<double>(images.size());
      const std::size_t i = std::min(static_cast<std::size_t>(share), images.size() - 1);
      if (left[i].count() > 0)
        left[i].take(left[i].at(at[1], at[2]), images[i], level, values, out);
      at += step;
      at -= at.floor();
    }
    for (std::size_t i = 0; i < images.size(); ++i) {
      for (std::size_t square = 0; square < left[i].count() && !enough(); ++square) {
        left[i].take(square, images[i], level, values, out);
      }
      left[i].let_overlap();
    }
  }
}

}  // namespace

PatchSet make_patches(const Sweep& sweep, const std::vector<Image2d<std::uint8_t>>& masks,
                      const LevelOptions& level, double sigma_mm) {
  std::vector<LevelImage> images;
  SmoothBuffers buffers;
  for (const int index : thin_frames(sweep, level.frame_step_mm)) {
    const auto i = static_cast<std::size_t>(index);
    const TrackedImage& tracked = sweep.frames()[i];
    images.push_back(
        {index, tracked, masks[i], smooth(tracked.frame, masks[i], sigma_mm, buffers)});
  }
  PatchSet out;
  out.side = level.patch_side;
  out.frames = static_cast<int>(images.size());
  if (level.choice == PatchChoice::kEven) {
    choose_evenly(images, level, out);
  } else {
    choose_by_contrast(images, level, out);
  }
  order_by_place(out);
  double total = 0;
  for (const Patch& patch : out.patches) total += patch.weight;
  std::size_t index = 0;
  for (Patch& patch : out.patches) {
    patch.weight /= total;
    patch.index = index++;
  }
  return out;
}

PatchSet coarsened(const PatchSet& patches, int stride) {
  NAV_CHECK(stride >= 1 && 2 * stride < patches.side, stride, patches.side);
  // Relative to the norm of all samples: a smaller norm is rounding noise.
  constexpr double kFlat = 1e-3;
  const int middle = patches.side / 2;
  const int half = middle / stride;
  PatchSet out{2 * half + 1, {}, {}, patches.frames};
  std::vector<float> values;
  double total = 0;
  for (std::size_t i = 0; i < patches.patches.size(); ++i) {
    const auto u = patches.u(i);
    values.clear();
    for (int b = -half; b <= half; ++b) {
      for (int a = -half; a <= half; ++a) {
        const int sample = (middle + b * stride) * patches.side + middle + a * stride;
        values.push_back(u[static_cast<std::size_t>(sample)]);
      }
    }
    double mean = 0;
    const double norm =
        centre_values(values, &mean) * std::sqrt(static_cast<double>(values.size()));
    if (!(norm > kFlat)) continue;
    for (const float value : values) out.samples.push_back(value / static_cast<float>(norm));
    Patch patch = patches.patches[i];
    patch.step_a *= stride;
    patch.step_b *= stride;
    patch.mean_grey += patch.norm_grey * mean;
    patch.norm_grey *= norm;
    total += patch.weight;
    out.patches.push_back(patch);
  }
  for (Patch& patch : out.patches) patch.weight /= total;
  return out;
}

}  // namespace nav::registration
