// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/gradient.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <tbb/enumerable_thread_specific.h>

#include "nav/index.hpp"
#include "render/features/filled_field.hpp"
#include "render/features/gaussian_taps.hpp"
#include "render/features/kernels.hpp"
#include "render/parallel.hpp"

namespace nav::render::features {
namespace {

/// Difference over the known values among before, here and after; here must be known.
template <class Real>
Real difference(Real before, Real here, Real after) {
  const bool has_before = before == before;
  const bool has_after = after == after;
  if (has_before && has_after) return (after - before) * Real(0.5);
  if (has_after) return after - here;
  return here - before;  // NaN if both neighbours are unknown.
}

/// Per-index differences of one row, computed from the five rows around it.
class RowDifferences {
 public:
  RowDifferences(const ScalarVolume& volume) : volume_(volume), size_(volume.grid().size) {
    for (auto& row : rows_) row.resize(as_size(size_[0]));
  }
  void load(int j, int k) {
    const int around[5][2] = {{j, k}, {j - 1, k}, {j + 1, k}, {j, k - 1}, {j, k + 1}};
    for (std::size_t r = 0; r < 5; ++r) {
      const auto [y, z] = around[r];
      if (y < 0 || y >= size_[1] || z < 0 || z >= size_[2]) {
        std::fill(rows_[r].begin(), rows_[r].end(), kUnknown);
      } else {
        volume_.read_row(y, z, rows_[r].data());
      }
    }
  }
  [[nodiscard]] Eigen::Vector3f at(int i) const {
    const auto n = as_size(i);
    const float here = rows_[0][n];
    if (!(here == here)) return Eigen::Vector3f::Constant(kUnknown);
    const float before = i > 0 ? rows_[0][n - 1] : kUnknown;
    const float after = i + 1 < size_[0] ? rows_[0][n + 1] : kUnknown;
    return {size_[0] > 1 ? difference(before, here, after) : 0.0F,
            size_[1] > 1 ? difference(rows_[1][n], here, rows_[2][n]) : 0.0F,
            size_[2] > 1 ? difference(rows_[3][n], here, rows_[4][n]) : 0.0F};
  }

 private:
  const ScalarVolume& volume_;
  std::array<int, 3> size_;
  std::array<std::vector<float>, 5> rows_;
};

/// Converts per-index differences to a part of the gradient. One object serves all rows;
/// thread-safe.
class Writer {
 public:
  Writer(const VoxelGrid& grid, GradientPart part, const ScanLines* lines, double least,
         std::vector<float>& values)
      : grid_(grid),
        part_(part),
        lines_(lines),
        least_(least),
        per_mm_(grid.spacing_mm.cwiseInverse().cast<float>()),
        values_(values) {
    if (lines != nullptr && lines->common()) {
      common_ = grid.directions.transpose() * *lines->common();
    }
  }
  void write(int i, int j, int k, const Eigen::Vector3f& per_index) const {
    const Eigen::Vector3f g = per_index.cwiseProduct(per_mm_);
    float& to = values_[offset_of(grid_, i, j, k)];
    if (part_ == GradientPart::kMagnitude) {
      to = g.norm();
      return;
    }
    const Eigen::Vector3d away =
        common_ ? *common_
                : Eigen::Vector3d(grid_.directions.transpose() * lines_->away(grid_, i, j, k));
    to = static_cast<float>(of_direction(g.cast<double>(), away));
  }

 private:
  [[nodiscard]] double of_direction(const Eigen::Vector3d& g, const Eigen::Vector3d& away) const {
    if (part_ == GradientPart::kAngle) return gradient_angle(g, away, least_);
    if (part_ == GradientPart::kAlong) return g.dot(away);
    return g.cross(away).norm();
  }

  const VoxelGrid& grid_;
  GradientPart part_;
  const ScanLines* lines_;
  double least_;
  Eigen::Vector3f per_mm_;
  std::optional<Eigen::Vector3d> common_;  ///< In the axes of the grid.
  std::vector<float>& values_;
};

bool by_differences(const ScalarVolume& volume, const Writer& writer, const RunOptions& run) {
  const auto& size = volume.grid().size;
  Steps steps(run, as_size(size[2]));
  for_each_index(size[2], run.threads, [&](int k) {
    if (!steps.next()) return;
    RowDifferences differences(volume);
    for (int j = 0; j < size[1]; ++j) {
      differences.load(j, k);
      for (int i = 0; i < size[0]; ++i) writer.write(i, j, k, differences.at(i));
    }
  });
  return !steps.stopped();
}

/// Gaussian first derivatives of one plane; ScalePlane of vesselness.cpp computes second ones.
class SmoothPlane {
 public:
  SmoothPlane(const FilledField& field, const VoxelGrid& grid, const GradientOptions& options)
      : field_(field) {
    for (int axis = 0; axis < 3; ++axis) {
      const double sigma = options.smoothing_mm / grid.spacing_mm[axis];
      taps_.emplace_back(gaussian_taps(sigma, options.truncate), 1.0);
    }
  }
  template <class Write>
  void run(int k, const Write& write) const {
    std::vector<float> smooth(as_size(field_.stride) * as_size(field_.size[1]));
    std::vector<float> slope(smooth.size());
    for (int j = 0; j < field_.size[1]; ++j) {
      const std::size_t first = as_size(j) * as_size(field_.stride);
      filter(
          2, [&](int t) { return field_.row(j, clamped(k + t, 2)); }, &smooth[first],
          &slope[first]);
    }
    const int halo = taps_[0].radius();
    std::array<std::vector<float>, 3> rows;  // Smooth in j and k; slope in j; slope in k.
    for (auto& row : rows) row.resize(as_size(field_.stride + 2 * halo + kLanes));
    std::array<std::vector<float>, 3> out;
    for (auto& row : out) row.resize(as_size(field_.stride));
    for (int j = 0; j < field_.size[1]; ++j) {
      const auto of = [&](const std::vector<float>& plane) {
        return [&, this](int t) {
          return plane.data() + as_size(clamped(j + t, 1)) * as_size(field_.stride);
        };
      };
      filter(1, of(smooth), &rows[0][as_size(halo)], &rows[1][as_size(halo)]);
      filter(1, of(slope), &rows[2][as_size(halo)], nullptr);
      along_i(rows[0], nullptr, out[0].data());
      along_i(rows[1], out[1].data(), nullptr);
      along_i(rows[2], out[2].data(), nullptr);
      for (int i = 0; i < field_.size[0]; ++i) {
        write(i, j, Eigen::Vector3f(out[0][as_size(i)], out[1][as_size(i)], out[2][as_size(i)]));
      }
    }
  }

 private:
  [[nodiscard]] int clamped(int at, std::size_t axis) const {
    return std::clamp(at, 0, field_.size[axis] - 1);
  }
  template <class RowAt>
  void filter(std::size_t axis, const RowAt& row_at, float* smooth, float* slope) const {
    const int radius = taps_[axis].radius();
    std::vector<const float*> rows;
    for (int t = -radius; t <= radius; ++t) rows.push_back(row_at(t));
    float* const out[3] = {smooth, slope, nullptr};
    kernels().filter_rows(rows.data(), radius, taps_[axis].folded(), out, field_.stride);
  }
  void along_i(std::vector<float>& row, float* smooth, float* slope) const {
    const int halo = taps_[0].radius();
    float* middle = row.data() + halo;
    std::fill(row.data(), middle, middle[0]);
    std::fill(middle + field_.size[0], row.data() + row.size(), middle[field_.size[0] - 1]);
    filter(
        0, [&](int t) { return middle + t; }, smooth, slope);
  }

  const FilledField& field_;
  std::vector<FloatTaps> taps_;
};

bool by_gaussian(const ScalarVolume& volume, const GradientOptions& options, const Writer& writer,
                 const RunOptions& run) {
  const VoxelGrid& grid = volume.grid();
  const double most_voxels = options.smoothing_mm / grid.spacing_mm.minCoeff();
  const int reach = gaussian_taps(most_voxels, options.truncate).radius;
  const FilledField field = filled_field(volume, reach, run.threads);
  const SmoothPlane plane(field, grid, options);
  Steps steps(run, as_size(grid.size[2]));
  for_each_index(grid.size[2], run.threads, [&](int k) {
    if (!steps.next()) return;
    plane.run(k, [&](int i, int j, const Eigen::Vector3f& d) {
      const float here = volume.at(i, j, k);
      writer.write(i, j, k, here == here ? d : Eigen::Vector3f::Constant(kUnknown));
    });
  });
  return !steps.stopped();
}

}  // namespace

Result<void> validate(const GradientOptions& options) {
  if (!(options.smoothing_mm >= 0 && options.smoothing_mm <= 20)) {
    return Error{ErrorCode::kUsage, "gradient: expected smoothing_mm in [0, 20], found " +
                                        std::to_string(options.smoothing_mm)};
  }
  if (!(options.truncate >= 2 && options.truncate <= 8)) {
    return Error{ErrorCode::kUsage, "gradient: expected truncate in [2, 8], found " +
                                        std::to_string(options.truncate)};
  }
  if (!(options.least_per_mm > 0 && std::isfinite(options.least_per_mm))) {
    return Error{ErrorCode::kUsage, "gradient: expected a finite least_per_mm above 0, found " +
                                        std::to_string(options.least_per_mm)};
  }
  return {};
}

Result<void> validate(const GradientOptions& options, const VoxelGrid& grid,
                      const std::string& name) {
  if (const auto ok = validate(options); !ok) return ok;
  const FilterReach widest{"smoothing_mm", options.smoothing_mm, options.smoothing_mm,
                           options.truncate};
  return check_reach(widest, grid, name + ": gradient");
}

Eigen::Vector3d gradient_at(const ScalarVolume& volume, int i, int j, int k) {
  const VoxelGrid& grid = volume.grid();
  const auto value = [&](int x, int y, int z) {
    const bool inside =
        x >= 0 && x < grid.size[0] && y >= 0 && y < grid.size[1] && z >= 0 && z < grid.size[2];
    return inside ? static_cast<double>(volume.at(x, y, z)) : std::nan("");
  };
  const double here = value(i, j, k);
  if (std::isnan(here)) return Eigen::Vector3d::Constant(here);
  Eigen::Vector3d g(difference(value(i - 1, j, k), here, value(i + 1, j, k)),
                    difference(value(i, j - 1, k), here, value(i, j + 1, k)),
                    difference(value(i, j, k - 1), here, value(i, j, k + 1)));
  for (int a = 0; a < 3; ++a) g[a] = grid.size[as_size(a)] > 1 ? g[a] / grid.spacing_mm[a] : 0;
  return grid.directions * g;
}

double gradient_angle(const Eigen::Vector3d& gradient, const Eigen::Vector3d& away, double least) {
  if (!(gradient.norm() >= least)) return std::nan("");
  return std::atan2(gradient.cross(away).norm(), gradient.dot(away));
}

Result<FeatureVolume> gradient_part(const ScalarVolume& volume, GradientPart part,
                                    const ScanLines* lines, const GradientOptions& options,
                                    const RunOptions& run) {
  const VoxelGrid& grid = volume.grid();
  if (const auto ok = validate(options, grid, volume.name()); !ok) return ok.error();
  const std::string name = volume.name() + ": gradient";
  if (part != GradientPart::kMagnitude) {
    if (lines == nullptr) {
      return Error{ErrorCode::kUsage, name + ": expected scan-line directions, found none"};
    }
    if (auto ok = lines->check(grid, name); !ok) return ok.error();
  }
  const double bytes = 4 + (options.smoothing_mm > 0 ? 10 : 0);
  if (auto ok = check_memory(name, grid.voxel_count(), bytes, run.memory_limit); !ok) {
    return ok.error();
  }
  std::vector<float> values(grid.voxel_count());
  const Writer writer(grid, part, lines, options.least_per_mm, values);
  const bool finished = options.smoothing_mm > 0 ? by_gaussian(volume, options, writer, run)
                                                 : by_differences(volume, writer, run);
  if (!finished) return cancelled(name);
  return FeatureVolume{grid, std::make_shared<const std::vector<float>>(std::move(values))};
}

}  // namespace nav::render::features
