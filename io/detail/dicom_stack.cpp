// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/detail/dicom_stack.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "io/detail/text.hpp"

namespace nav::io::detail {

namespace {

/// Scanners write positions with one or two decimals: half a tenth of a millimetre is rounding.
constexpr double kPositionToleranceMm = 0.06;
/// Direction cosines have few digits too; the resulting drift grows with the stack.
constexpr double kDriftPerMm = 2e-4;
constexpr double kSamePositionMm = 0.01;
constexpr double kDirectionTolerance = 1e-3;
constexpr double kSpacingTolerance = 1e-3;  // Relative tolerance.

Error reject(const std::string& name, const std::string& what) {
  return {ErrorCode::kMalformedData, name + ": " + what};
}

/// Converts a number to a count. A count that is too large is rejected later, with the grid.
int to_count(double number) { return static_cast<int>(std::min(number, 1e9)); }

std::string vector_text(const Eigen::Vector3d& v) {
  return to_text(v.x()) + " " + to_text(v.y()) + " " + to_text(v.z());
}

Result<void> check_alike(const DicomSlice& first, const DicomSlice& other,
                         const std::string& name) {
  if (first.columns != other.columns || first.rows != other.rows) {
    return reject(name, "expected slices of one size, found " + std::to_string(first.columns) +
                            " x " + std::to_string(first.rows) + " in " + first.name() + " and " +
                            std::to_string(other.columns) + " x " + std::to_string(other.rows) +
                            " in " + other.name());
  }
  if (!((first.spacing_mm - other.spacing_mm).cwiseAbs().maxCoeff() <=
        kSpacingTolerance * first.spacing_mm.minCoeff())) {
    return reject(name, "expected one pixel spacing, found " + to_text(first.spacing_mm.x()) +
                            " mm in " + first.name() + " and " + to_text(other.spacing_mm.x()) +
                            " mm in " + other.name());
  }
  const double turned =
      std::max((first.row_direction - other.row_direction).cwiseAbs().maxCoeff(),
               (first.column_direction - other.column_direction).cwiseAbs().maxCoeff());
  if (!(turned <= kDirectionTolerance)) {
    const auto directions = [](const DicomSlice& slice) {
      return vector_text(slice.row_direction) + " " + vector_text(slice.column_direction) + " in " +
             slice.name();
    };
    return reject(name, "expected slices of one orientation, found " + directions(first) + " and " +
                            directions(other));
  }
  return {};
}

Result<Eigen::Matrix3d> slice_axes(const DicomSlice& slice, const std::string& name) {
  const Eigen::Vector3d& x = slice.row_direction;
  const Eigen::Vector3d& y = slice.column_direction;
  const bool good =
      x.allFinite() && y.allFinite() && std::abs(x.norm() - 1) <= kDirectionTolerance &&
      std::abs(y.norm() - 1) <= kDirectionTolerance && std::abs(x.dot(y)) <= kDirectionTolerance;
  if (!good) {
    return reject(name, slice.name() +
                            ": ImageOrientationPatient: expected two orthogonal unit "
                            "vectors, found " +
                            vector_text(x) + " and " + vector_text(y));
  }
  Eigen::Matrix3d axes;
  axes.col(0) = x.normalized();
  axes.col(1) = (y - axes.col(0).dot(y) * axes.col(0)).normalized();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  return axes;
}

Result<void> measure_gaps(DicomStack& stack, const std::string& name) {
  stack.min_gap_mm = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < stack.slices.size(); ++i) {
    const double gap = stack.at_mm[i].z() - stack.at_mm[i - 1].z();
    if (gap < kSamePositionMm) {
      return reject(name, "expected one slice per position, found " + stack.slices[i - 1].name() +
                              " and " + stack.slices[i].name() + " within " + to_text(gap) +
                              " mm of each other");
    }
    stack.min_gap_mm = std::min(stack.min_gap_mm, gap);
    constexpr double kRoundingMm = 1e-6;  // Among equal gaps the first is named.
    if (gap > stack.max_gap_mm + kRoundingMm) {
      stack.max_gap_mm = gap;
      stack.max_gap_at = i;
    }
  }
  return {};
}

void judge_regularity(DicomStack& stack) {
  const Eigen::Vector3d& last = stack.at_mm.back();
  const auto steps = static_cast<double>(stack.at_mm.size() - 1);
  const double drift_tolerance = kPositionToleranceMm + kDriftPerMm * last.z();
  stack.regular = true;
  double drift = 0;
  for (std::size_t i = 0; i < stack.at_mm.size(); ++i) {
    const Eigen::Vector3d& at = stack.at_mm[i];
    const double expected = last.z() * static_cast<double>(i) / steps;
    if (std::abs(at.z() - expected) > kPositionToleranceMm) stack.regular = false;
    drift = std::max(drift, at.head<2>().norm());
  }
  if (drift > drift_tolerance) stack.regular = false;
  stack.tilt_rad = std::atan2(last.head<2>().norm(), last.z());
}

}  // namespace

std::string DicomSlice::name() const {
  const std::string base = file.filename().string();
  return frame == 0 ? base : base + " frame " + std::to_string(frame);
}

VoxelGrid DicomStack::grid() const {
  VoxelGrid grid;
  grid.size = {slices[0].columns, slices[0].rows, static_cast<int>(slices.size())};
  const auto steps = static_cast<double>(slices.size() - 1);
  grid.spacing_mm << slices[0].spacing_mm, at_mm.back().z() / steps;
  grid.origin_mm = slices[0].position_mm;
  grid.directions = directions;
  return grid;
}

Result<DicomStack> stack_slices(std::vector<DicomSlice> slices, const std::string& name) {
  if (slices.size() < 2) {
    return reject(name, "expected at least 2 slices, found " + std::to_string(slices.size()));
  }
  DicomStack stack;
  const auto axes = slice_axes(slices[0], name);
  if (!axes) return axes.error();
  stack.directions = *axes;
  for (const DicomSlice& slice : slices) {
    if (!slice.position_mm.allFinite() || !(slice.spacing_mm.minCoeff() > 0) ||
        !slice.spacing_mm.allFinite()) {
      return reject(name, slice.name() + ": expected a finite position and positive pixel spacing");
    }
    if (const auto ok = check_alike(slices[0], slice, name); !ok) return ok.error();
  }
  const Eigen::Vector3d normal = stack.directions.col(2);
  std::stable_sort(slices.begin(), slices.end(), [&](const DicomSlice& a, const DicomSlice& b) {
    return normal.dot(a.position_mm) < normal.dot(b.position_mm);
  });
  for (const DicomSlice& slice : slices) {
    stack.at_mm.push_back(stack.directions.transpose() *
                          (slice.position_mm - slices[0].position_mm));
  }
  stack.slices = std::move(slices);
  if (const auto ok = measure_gaps(stack, name); !ok) return ok.error();
  judge_regularity(stack);
  return stack;
}

VoxelGrid regular_grid(const DicomStack& stack) {
  VoxelGrid grid = stack.grid();
  Eigen::Vector2d low = Eigen::Vector2d::Zero();
  Eigen::Vector2d high = Eigen::Vector2d::Zero();
  for (const Eigen::Vector3d& at : stack.at_mm) {
    low = low.cwiseMin(at.head<2>());
    high = high.cwiseMax(at.head<2>());
  }
  for (int axis = 0; axis < 2; ++axis) {
    const double extra = (high[axis] - low[axis]) / grid.spacing_mm[axis];
    // A drift within rounding adds no column.
    if (extra > kPositionToleranceMm) {
      grid.size[static_cast<std::size_t>(axis)] += to_count(std::ceil(extra));
      grid.origin_mm += stack.directions.col(axis) * low[axis];
    }
  }
  const double length = stack.at_mm.back().z();
  const double thinnest = std::max(stack.min_gap_mm, stack.slices[0].spacing_mm.minCoeff());
  const auto steps = std::max(1.0, std::round(length / thinnest));
  grid.size[2] = to_count(steps) + 1;
  grid.spacing_mm[2] = length / steps;
  return grid;
}

namespace {

/// Values of one slice as a function of the position within the plane.
class SliceSampler {
 public:
  SliceSampler(const DicomStack& stack, const std::vector<std::int16_t>& hu, std::size_t k)
      : width_(stack.slices[0].columns),
        height_(stack.slices[0].rows),
        spacing_(stack.slices[0].spacing_mm),
        at_(stack.at_mm[k].head<2>()),
        hu_(hu.data() + k * static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_)) {}

  /// Bilinear value at a position in mm relative to the first pixel of the first slice; absent
  /// outside the pixel centres.
  [[nodiscard]] std::optional<double> operator()(const Eigen::Vector2d& p_mm) const {
    constexpr double kBorderPixels = 1e-6;  // Rounding must not move the border outside.
    const Eigen::Vector2d index = (p_mm - at_).cwiseQuotient(spacing_);
    if (!(index.x() >= -kBorderPixels && index.x() <= width_ - 1 + kBorderPixels &&
          index.y() >= -kBorderPixels && index.y() <= height_ - 1 + kBorderPixels)) {
      return {};
    }
    const double x = std::clamp(index.x(), 0.0, width_ - 1.0);
    const double y = std::clamp(index.y(), 0.0, height_ - 1.0);
    const int i = std::min(static_cast<int>(x), std::max(width_ - 2, 0));
    const int j = std::min(static_cast<int>(y), std::max(height_ - 2, 0));
    const double u = x - i;
    const double v = y - j;
    return (1 - v) * ((1 - u) * at(i, j) + u * at(i + 1, j)) +
           v * ((1 - u) * at(i, j + 1) + u * at(i + 1, j + 1));
  }

 private:
  [[nodiscard]] double at(int i, int j) const {
    return hu_[static_cast<std::size_t>(std::min(j, height_ - 1)) *
                   static_cast<std::size_t>(width_) +
               static_cast<std::size_t>(std::min(i, width_ - 1))];
  }
  int width_, height_;
  Eigen::Vector2d spacing_, at_;
  const std::int16_t* hu_;
};

}  // namespace

std::vector<std::int16_t> resample(const DicomStack& stack, const std::vector<std::int16_t>& hu,
                                   const VoxelGrid& grid) {
  std::vector<std::int16_t> out;
  out.reserve(grid.voxel_count());
  const Eigen::Vector2d corner =
      (stack.directions.transpose() * (grid.origin_mm - stack.slices[0].position_mm)).head<2>();
  std::size_t below = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    const double z = grid.spacing_mm.z() * k;
    while (below + 2 < stack.at_mm.size() && stack.at_mm[below + 1].z() <= z) ++below;
    const double z0 = stack.at_mm[below].z();
    const double weight = std::clamp((z - z0) / (stack.at_mm[below + 1].z() - z0), 0.0, 1.0);
    const SliceSampler lower(stack, hu, below);
    const SliceSampler upper(stack, hu, below + 1);
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const Eigen::Vector2d p =
            corner + Eigen::Vector2d(grid.spacing_mm.x() * i, grid.spacing_mm.y() * j);
        // A slice of weight 0 is not sampled, so that the first and the last slice stay complete.
        const auto a = weight < 1 ? lower(p) : std::optional<double>(0);
        const auto b = weight > 0 ? upper(p) : std::optional<double>(0);
        const double value = a && b ? (1 - weight) * *a + weight * *b : kAirHu;
        out.push_back(static_cast<std::int16_t>(std::nearbyint(value)));
      }
    }
  }
  return out;
}

}  // namespace nav::io::detail
