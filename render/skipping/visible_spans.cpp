// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/skipping/visible_spans.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/parallel.hpp"

namespace nav::render {
namespace {

constexpr float kFarthestDepth = std::numeric_limits<float>::infinity();
constexpr VisibleSpan kNothing{kFarthestDepth, -kFarthestDepth};

void widen(VisibleSpan& span, const VisibleSpan& by) {
  span.near = std::min(span.near, by.near);
  span.far = std::max(span.far, by.far);
}

/// First and last position along one axis of the image.
struct Reach {
  double low;
  double high;
};

/// The spans of an image while bricks are added.
class DepthCanvas {
 public:
  DepthCanvas(const Scene& scene, const spec::View<double>& view)
      : view_(view),
        across_((scene.width - 1) / VisibleSpans::kSide),
        down_((scene.height - 1) / VisibleSpans::kSide),
        half_width_(0.5 * scene.width),
        half_height_(0.5 * scene.height),
        pixels_per_unit_(half_height_ / view.half_height),
        spans_(static_cast<std::size_t>(across_ + 1) * static_cast<std::size_t>(down_ + 1),
               kNothing) {}

  /// Adds a ball, local mm.
  void add(const Eigen::Vector3d& centre, double radius) {
    const Eigen::Vector3d to = centre - view_.eye;
    const double depth = to.dot(view_.forward);
    if (depth < -radius) return;
    const double along = view_.orthographic ? depth : to.norm();
    const VisibleSpan span{static_cast<float>(std::max(along - radius, 0.0)),
                           static_cast<float>(along + radius)};
    if (!view_.orthographic && depth <= radius) {
      widen(everywhere_, span);
      return;
    }
    const Reach x = reach(to.dot(view_.right), depth, radius);
    const Reach y = reach(-to.dot(view_.up), depth, radius);
    fill(half_width_ + pixels_per_unit_ * x.low, half_width_ + pixels_per_unit_ * x.high,
         half_height_ + pixels_per_unit_ * y.low, half_height_ + pixels_per_unit_ * y.high, span);
  }

  void merge_into(std::vector<VisibleSpan>& spans) const {
    for (std::size_t i = 0; i < spans.size(); ++i) {
      widen(spans[i], spans_[i]);
      widen(spans[i], everywhere_);
    }
  }

 private:
  /// The extent of a ball on the image plane: at distance 1; in mm if orthographic. aside: distance
  /// of its centre from the view axis.
  [[nodiscard]] Reach reach(double aside, double depth, double radius) const {
    if (view_.orthographic) return {aside - radius, aside + radius};
    // The tangents through the eye.
    const double square = depth * depth - radius * radius;
    const double root = radius * std::sqrt(aside * aside + square);
    return {(aside * depth - root) / square, (aside * depth + root) / square};
  }

  void fill(double x0, double x1, double y0, double y1, const VisibleSpan& span) {
    const int left = square_of(x0, across_);
    const int right = square_of(x1, across_);
    const int top = square_of(y0, down_);
    const int bottom = square_of(y1, down_);
    if (x1 < 0 || y1 < 0 || x0 > 2 * half_width_ || y0 > 2 * half_height_) return;
    for (int y = top; y <= bottom; ++y) {
      VisibleSpan* row =
          spans_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(across_ + 1);
      for (int x = left; x <= right; ++x) widen(row[x], span);
    }
  }

  static int square_of(double pixel, int last) {
    return static_cast<int>(
        std::clamp(pixel / VisibleSpans::kSide, 0.0, static_cast<double>(last)));
  }

  const spec::View<double>& view_;
  int across_;  ///< Index of the last square.
  int down_;
  double half_width_;
  double half_height_;
  double pixels_per_unit_;
  std::vector<VisibleSpan> spans_;
  VisibleSpan everywhere_ = kNothing;  ///< The span of balls around the eye.
};

/// True if rays may begin within the volume, behind its shell. margin: mm.
bool begin_inside(const spec::View<double>& view, const VoxelGrid& grid, double margin) {
  const Eigen::Vector3d last(grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1);
  const Eigen::Matrix3d mm_per_index = grid.directions * grid.spacing_mm.asDiagonal();
  if (view.orthographic) {
    const Eigen::Vector3d depth_per_index = mm_per_index.transpose() * view.forward;
    const Eigen::Vector3d least = depth_per_index.cwiseProduct(last).cwiseMin(0);
    return least.sum() - view.eye.dot(view.forward) < margin;
  }
  const Eigen::Vector3d eye = mm_per_index.inverse() * view.eye;
  return (mm_per_index * (eye.cwiseMax(0).cwiseMin(last) - eye)).norm() < margin;
}

/// Finds the open bricks of a row. open: 1 for every occupied brick that touches a hidden brick or
/// the border of the volume, else 0. outer: the whole row lies at the border.
void find_open(const std::uint8_t* row, const Eigen::Vector3i& n, bool outer, std::uint8_t* open) {
  const int width = n.x();  // A copy, because written bytes might alias n.
  for (int i = 0; i < width; ++i) open[i] = static_cast<std::uint8_t>(row[i] == 0);
  if (outer) return;
  const std::uint8_t* above = row - width;
  const std::uint8_t* below = row + width;
  const std::uint8_t* before = row - n.x() * n.y();
  const std::uint8_t* behind = row + n.x() * n.y();
  for (int i = 1; i < width - 1; ++i) {
    const int around = row[i - 1] | row[i + 1] | above[i] | below[i] | before[i] | behind[i];
    open[i] = static_cast<std::uint8_t>((row[i] == 0) & (around != 0));
  }
}

}  // namespace

BrickShell brick_shell(const BrickGrid& bricks, const std::vector<std::uint8_t>& hidden,
                       int threads) {
  const Eigen::Vector3i n = bricks.count;
  const int width = n.x();
  BrickShell shell{n, {}};
  std::vector<std::vector<int>> slices(static_cast<std::size_t>(n.z()));
  for_each_index(n.z(), threads, [&](int k) {
    std::vector<std::uint8_t> open(static_cast<std::size_t>(n.x()));
    std::vector<int> found(static_cast<std::size_t>(n.x() * n.y()));
    std::size_t count = 0;
    for (int j = 0; j < n.y(); ++j) {
      const int first = (k * n.y() + j) * n.x();
      const bool outer = k == 0 || k == n.z() - 1 || j == 0 || j == n.y() - 1;
      find_open(hidden.data() + first, n, outer, open.data());
      for (int i = 0; i < width; ++i) {  // Without a branch, because it would often be
                                         // mispredicted.
        found[count] = first + i;
        count += open[static_cast<std::size_t>(i)];
      }
    }
    found.resize(count);
    slices[static_cast<std::size_t>(k)] = std::move(found);
  });
  for (const std::vector<int>& slice : slices) {
    shell.bricks.insert(shell.bricks.end(), slice.begin(), slice.end());
  }
  return shell;
}

VisibleSpans::VisibleSpans(const Scene& scene, const BrickShell& shell, int threads)
    : across_((scene.width - 1) / kSide + 1),
      down_((scene.height - 1) / kSide + 1),
      spans_(static_cast<std::size_t>(across_) * static_cast<std::size_t>(down_), kNothing) {
  const VoxelGrid& grid = scene.ct->grid();
  const spec::View<double> view =
      spec::make_view<double>(scene.camera, scene.width, scene.height, grid);
  // A brick, the cell that runs into it, the cell that runs out of it, and one voxel more.
  const double step = spec::step_mm(scene.quality, grid);
  const double radius = (0.5 * kBrickVoxels + 1) * grid.spacing_mm.norm() + step;
  if (shell.bricks.empty()) return;
  if (begin_inside(view, grid, radius)) {
    std::fill(spans_.begin(), spans_.end(), VisibleSpan{});
    return;
  }
  const Eigen::Matrix3d mm_per_index = grid.directions * grid.spacing_mm.asDiagonal();
  constexpr int kChunks = 4;
  std::vector<DepthCanvas> parts(kChunks, DepthCanvas(scene, view));
  for_each_index(kChunks, threads, [&](int chunk) {
    const auto part = static_cast<std::size_t>(chunk);
    const std::size_t end = (part + 1) * shell.bricks.size() / kChunks;
    for (std::size_t i = part * shell.bricks.size() / kChunks; i < end; ++i) {
      const int brick = shell.bricks[i];
      const int row = brick / shell.count.x();
      const Eigen::Vector3d middle(brick % shell.count.x(), row % shell.count.y(),
                                   row / shell.count.y());
      const Eigen::Vector3d index = kBrickVoxels * (middle.array() + 0.5).matrix();
      parts[part].add(mm_per_index * index, radius);
    }
  });
  for (const DepthCanvas& part : parts) part.merge_into(spans_);
}

bool VisibleSpans::worth(const Scene& scene, const BrickShell& shell) {
  return 4 * shell.bricks.size() <
         static_cast<std::size_t>(scene.width) * static_cast<std::size_t>(scene.height);
}

}  // namespace nav::render
