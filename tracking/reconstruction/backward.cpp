// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <atomic>
#include <cmath>

#include "nav/index.hpp"
#include "tracking/reconstruction/reconstruction_engine.hpp"

namespace nav::tracking {
namespace {

/// An image that voxels are sampled in.
class SampledImage {
 public:
  SampledImage(const TrackedImage& image, std::shared_ptr<const ImageArea> area,
               const Image2d<std::uint8_t>& confidence, const VoxelGridIn<frames::Reference>& grid,
               double reach_mm)
      : pixels_(image.frame.pixels),
        confidence_(confidence),
        area_(std::move(area)),
        reach_mm_(reach_mm) {
    const auto image_from_reference = image.reference_from_image.inverse();
    const Eigen::Matrix3d turn = image_from_reference.rotation().toRotationMatrix();
    const Eigen::Matrix2d pixel_per_mm = image.frame.grid.mm_per_pixel.inverse();
    // Rows of the map from voxel indices: column, row, distance from the plane in mm.
    const Eigen::Matrix3d per_index = turn * grid.directions * grid.spacing_mm.asDiagonal();
    const Eigen::Vector3d zero = (image_from_reference * grid.at(Eigen::Vector3d::Zero())).mm;
    per_index_.topRows<2>() = pixel_per_mm * per_index.topRows<2>();
    per_index_.row(2) = per_index.row(2);
    at_zero_ << pixel_per_mm * (zero.head<2>() - image.frame.grid.origin_mm), zero.z();
    mm_per_pixel_ = image.frame.grid.mm_per_pixel;
    origin_mm_ = image.frame.grid.origin_mm;
    // Directions of the image's axes along x, y, z of the Reference frame.
    axes_ = turn.transpose();
    low_ = Eigen::Vector3d(INFINITY, INFINITY, -reach_mm);
    high_ = Eigen::Vector3d(-INFINITY, -INFINITY, reach_mm);
    for (const Eigen::Vector2d& corner : area_->corners()) {
      low_.head<2>() = low_.head<2>().cwiseMin(corner);
      high_.head<2>() = high_.head<2>().cwiseMax(corner);
      for (const double side : {-reach_mm, reach_mm}) {
        const Eigen::Vector3d at =
            grid.index_of(image.reference_from_image *
                          Point<frames::Image>{image.frame.grid.at(corner.x(), corner.y()).mm +
                                               Eigen::Vector3d(0, 0, side)});
        least_ = least_.cwiseMin(at);
        most_ = most_.cwiseMax(at);
      }
    }
  }

  /// True when voxels of the row j (axis 1) or slice k (axis 2) may be within reach.
  [[nodiscard]] bool meets(int axis, int index) const {
    return index >= least_[axis] - 1e-6 && index <= most_[axis] + 1e-6;
  }
  /// Voxels [first, past) of a row within reach of the plane and between the corners of the area.
  [[nodiscard]] std::array<int, 2> span(int j, int k, int size) const {
    const Eigen::Vector3d start = at_zero_ + per_index_ * Eigen::Vector3d(0, j, k);
    double from = 0;
    double to = size - 1;
    for (int a = 0; a < 3; ++a) {
      const double step = per_index_(a, 0);
      if (std::abs(step) < 1e-12) {
        if (start[a] < low_[a] || start[a] > high_[a]) return {0, 0};
        continue;
      }
      const double one = (low_[a] - start[a]) / step;
      const double other = (high_[a] - start[a]) / step;
      from = std::max(from, std::min(one, other));
      to = std::min(to, std::max(one, other));
    }
    if (!(from <= to)) return {0, 0};
    return {static_cast<int>(std::ceil(from)), static_cast<int>(std::floor(to)) + 1};
  }

  struct Seen {
    float weight = 0;  ///< 1 in the plane, 0 at its reach; 0: not seen.
    float value = 0;
    Eigen::Vector3f away;  ///< Reference frame.
    float depth_mm = 0;
  };
  [[nodiscard]] Seen see(int i, int j, int k) const {
    const Eigen::Vector3d at = at_zero_ + per_index_ * Eigen::Vector3d(i, j, k);
    auto weight = static_cast<float>(1 - std::abs(at.z()) / reach_mm_);
    if (!(weight > 0)) return {};
    const int last_column = pixels_.width() - 1;
    const int last_row = pixels_.height() - 1;
    if (!(at.x() >= 0 && at.y() >= 0 && at.x() <= last_column && at.y() <= last_row)) return {};
    const int column = std::min(static_cast<int>(at.x()), std::max(last_column - 1, 0));
    const int row = std::min(static_cast<int>(at.y()), std::max(last_row - 1, 0));
    const int right = std::min(column + 1, last_column);
    const int below = std::min(row + 1, last_row);
    if (!(area_->contains(column, row) && area_->contains(right, row) &&
          area_->contains(column, below) && area_->contains(right, below))) {
      return {};
    }
    const auto pixel = [&](int c, int r) {
      return static_cast<float>(
          pixels_.pixels()[as_size(r) * as_size(pixels_.width()) + as_size(c)]);
    };
    const auto x = static_cast<float>(at.x() - column);
    const auto y = static_cast<float>(at.y() - row);
    const float value = (1 - y) * ((1 - x) * pixel(column, row) + x * pixel(right, row)) +
                        y * ((1 - x) * pixel(column, below) + x * pixel(right, below));
    if (!confidence_.pixels().empty()) {
      constexpr float kConfidenceStep = 1.0F / 256;
      const int nearest_column = column + (x < 0.5F ? 0 : right - column);
      const int nearest_row = row + (y < 0.5F ? 0 : below - row);
      const std::uint8_t confidence =
          confidence_
              .pixels()[as_size(nearest_row) * as_size(pixels_.width()) + as_size(nearest_column)];
      weight *= kConfidenceStep * static_cast<float>(confidence + 1);
    }
    const Eigen::Vector2d mm = origin_mm_ + mm_per_pixel_ * at.head<2>();
    const auto& apex = area_->apex();
    if (!apex) return {weight, value, axes_.col(1).cast<float>(), static_cast<float>(mm.y())};
    const Eigen::Vector2d from = mm - apex->mm;
    const double distance = from.norm();
    if (!(distance > 1e-9)) return {};
    const Eigen::Vector3d away = axes_.leftCols<2>() * (from / distance);
    return {weight, value, away.cast<float>(), static_cast<float>(distance - apex->radius_mm)};
  }

 private:
  Image2d<std::uint8_t> pixels_;
  Image2d<std::uint8_t> confidence_;  ///< Empty: every pixel counts fully.
  std::shared_ptr<const ImageArea> area_;
  double reach_mm_;
  Eigen::Matrix3d per_index_;
  Eigen::Vector3d at_zero_;
  Eigen::Matrix2d mm_per_pixel_;
  Eigen::Vector2d origin_mm_;
  Eigen::Matrix3d axes_;
  Eigen::Vector3d low_, high_;
  Eigen::Vector3d least_ = Eigen::Vector3d::Constant(INFINITY);
  Eigen::Vector3d most_ = Eigen::Vector3d::Constant(-INFINITY);
};

using Seen = SampledImage::Seen;

struct CompoundedVoxel {
  std::int16_t value = kUnseenVoxel;
  ScanLineAtVoxel line{};
};

float compounded(std::vector<Seen>& samples, Compounding compounding) {
  switch (compounding) {
    case Compounding::kLatest:
      return samples.back().value;
    case Compounding::kMaximum:
      return std::ranges::max_element(samples, {}, &Seen::value)->value;
    case Compounding::kMean: {
      float sum = 0;
      float weight = 0;
      for (const Seen& sample : samples) {
        sum += sample.weight * sample.value;
        weight += sample.weight;
      }
      return sum / weight;
    }
    case Compounding::kMedian:
      break;
  }
  std::ranges::stable_sort(samples, {}, &Seen::value);
  float whole = 0;
  for (const Seen& sample : samples) whole += sample.weight;
  float below = 0;
  for (const Seen& sample : samples) {
    below += sample.weight;
    if (below >= whole / 2) return sample.value;
  }
  return samples.back().value;
}

/// The value of a voxel and its scan line. Images whose scan lines point away from the mean
/// direction count less: by the square of the cosine, and not at all from 90 degrees on.
CompoundedVoxel compound(std::vector<Seen>& samples, Compounding compounding) {
  CompoundedVoxel voxel;
  if (samples.empty()) return voxel;
  const auto mean_direction = [&](float& weight) {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    weight = 0;
    for (const Seen& sample : samples) {
      sum += sample.weight * sample.away;
      weight += sample.weight;
    }
    return sum;
  };
  constexpr float kCancelled = 1e-3F;  // Opposite directions give no scan line.
  float weight = 0;
  Eigen::Vector3f mean = mean_direction(weight);
  if (mean.norm() > kCancelled * weight) {
    mean.normalize();
    for (Seen& sample : samples) {
      const float along = std::max(sample.away.dot(mean), 0.0F);
      sample.weight *= along * along;
    }
    std::erase_if(samples, [](const Seen& sample) { return !(sample.weight > 0); });
    const Eigen::Vector3f direction = mean_direction(weight);
    float depth = 0;
    for (const Seen& sample : samples) depth += sample.weight * sample.depth_mm;
    voxel.line = ScanLineAtVoxel::pack(direction.cast<double>().normalized(),
                                       static_cast<double>(depth / weight));
  }
  voxel.value = static_cast<std::int16_t>(std::lround(compounded(samples, compounding)));
  return voxel;
}

class BackwardEngine final : public Reconstruction::Engine {
 public:
  BackwardEngine(const VoxelGridIn<frames::Reference>& grid, const ReconstructionOptions& options)
      : Engine(grid, options),
        values_(grid.voxel_count(), kUnseenVoxel),
        lines_(grid.voxel_count()),
        changed_(as_size(grid.size[2]), 0) {}

  void add(const TrackedImage& image, const std::shared_ptr<const ImageArea>& area,
           const Image2d<std::uint8_t>& confidence) override {
    images_.emplace_back(image, area, confidence, grid_, options_.reach_mm);
    for (int k = 0; k < grid_.size[2]; ++k) {
      if (images_.back().meets(2, k)) changed_[as_size(k)] = 1;
    }
  }

  Result<std::vector<std::int16_t>> values(const ReconstructionRun& run) override {
    std::vector<int> slices;
    for (int k = 0; k < grid_.size[2]; ++k) {
      if (changed_[as_size(k)] != 0) slices.push_back(k);
    }
    std::atomic<std::size_t> done = 0;
    workers_.run(static_cast<int>(slices.size()), [&](int n) {
      if (run.stop.stop_requested()) return;
      const int k = slices[as_size(n)];
      compute(k);
      changed_[as_size(k)] = 0;
      if (run.progress) {
        run.progress(static_cast<double>(++done) / static_cast<double>(slices.size()));
      }
    });
    if (run.stop.stop_requested()) return reconstruction_cancelled();
    return values_;
  }
  [[nodiscard]] std::span<const ScanLineAtVoxel> scan_lines() const override { return lines_; }

 private:
  void compute(int k) {
    std::vector<const SampledImage*> near;
    for (const SampledImage& image : images_) {
      if (image.meets(2, k)) near.push_back(&image);
    }
    const auto row_size = as_size(grid_.size[0]);
    std::vector<std::vector<Seen>> row(row_size);
    for (int j = 0; j < grid_.size[1]; ++j) {
      for (auto& samples : row) samples.clear();
      for (const SampledImage* image : near) {
        if (!image->meets(1, j)) continue;
        const auto [first, past] = image->span(j, k, grid_.size[0]);
        for (int i = first; i < past; ++i) {
          if (const Seen seen = image->see(i, j, k); seen.weight > 0) {
            row[as_size(i)].push_back(seen);
          }
        }
      }
      const std::size_t start = (as_size(k) * as_size(grid_.size[1]) + as_size(j)) * row_size;
      for (std::size_t i = 0; i < row_size; ++i) {
        const CompoundedVoxel voxel = compound(row[i], options_.compounding);
        values_[start + i] = voxel.value;
        lines_[start + i] = voxel.line;
      }
    }
  }

  std::vector<SampledImage> images_;
  std::vector<std::int16_t> values_;
  std::vector<ScanLineAtVoxel> lines_;
  std::vector<std::uint8_t> changed_;  ///< Slices k that new images reach.
};

}  // namespace

std::unique_ptr<Reconstruction::Engine> make_backward_engine(
    const VoxelGridIn<frames::Reference>& grid, const ReconstructionOptions& options) {
  return std::make_unique<BackwardEngine>(grid, options);
}

}  // namespace nav::tracking
