// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/labels.hpp"

#include <algorithm>
#include <cmath>

#include "nav/index.hpp"
#include "render/parallel.hpp"

namespace nav::render::features {
namespace {

/// Weights of the four control points around the position t in [0, 1] of a knot interval.
std::array<double, 4> cubic_weights(double t) {
  const double s = 1 - t;
  return {s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6, (3 * s * s * s - 6 * s * s + 4) / 6,
          t * t * t / 6};
}

/// Position of a voxel index among the control points: the first of four, and the position between
/// them.
struct Knot {
  int first;
  double t;
};
Knot knot_of(double voxel, int voxels, int control) {
  const double last = std::max(voxels - 1, 1);
  const double at = std::clamp(voxel / last, 0.0, 1.0) * (control - 3);
  const int first = std::min(static_cast<int>(at), control - 4);
  return {first, at - first};
}

std::array<std::size_t, 2> across(int axis) {
  return {axis == 0 ? std::size_t{1} : std::size_t{0}, axis == 2 ? std::size_t{1} : std::size_t{2}};
}

Error refused(const std::string& expected, const std::string& found) {
  return {ErrorCode::kMalformedData, "layer surface: expected " + expected + ", found " + found};
}

}  // namespace

Result<LabelVolume> LabelVolume::create(const VoxelGrid& grid, std::vector<std::uint32_t> masks,
                                        const std::string& name) {
  if (const auto ok = validate(grid, name); !ok) return ok.error();
  if (masks.size() != grid.voxel_count()) {
    return Error{ErrorCode::kMalformedData,
                 name + ": expected " + std::to_string(grid.voxel_count()) +
                     " label masks, found " + std::to_string(masks.size())};
  }
  LabelVolume labels;
  labels.grid_ = grid;
  labels.masks_ = std::make_shared<const std::vector<std::uint32_t>>(std::move(masks));
  return labels;
}

std::uint32_t LabelVolume::nearest(const Eigen::Vector3d& voxel) const {
  std::array<int, 3> at{};
  for (int a = 0; a < 3; ++a) {
    const double rounded = std::round(voxel[a]);
    if (!(rounded >= 0 && rounded < grid_.size[as_size(a)])) return 0;
    at[as_size(a)] = static_cast<int>(rounded);
  }
  return this->at(at[0], at[1], at[2]);
}

Result<LayerSurface> LayerSurface::create(int axis, const std::array<int, 3>& grid_size,
                                          const std::array<int, 2>& control,
                                          std::vector<double> heights) {
  if (axis < 0 || axis > 2) return refused("an axis 0, 1 or 2", std::to_string(axis));
  if (*std::min_element(grid_size.begin(), grid_size.end()) < 1) {
    return refused("a grid of at least one voxel along every axis", "fewer");
  }
  if (control[0] < 4 || control[1] < 4 || control[0] > 4096 || control[1] > 4096) {
    return refused("4 to 4096 control points along each side",
                   std::to_string(control[0]) + " x " + std::to_string(control[1]));
  }
  if (heights.size() != as_size(control[0]) * as_size(control[1])) {
    return refused(std::to_string(as_size(control[0]) * as_size(control[1])) + " heights",
                   std::to_string(heights.size()));
  }
  for (const double h : heights) {
    if (!std::isfinite(h)) return refused("finite heights", std::to_string(h));
  }
  LayerSurface surface;
  surface.axis_ = axis;
  surface.size_ = grid_size;
  surface.control_ = control;
  surface.heights_ = std::move(heights);
  return surface;
}

double LayerSurface::height(double u, double v) const {
  const auto [a, b] = across(axis_);
  const Knot ku = knot_of(u, size_[a], control_[0]);
  const Knot kv = knot_of(v, size_[b], control_[1]);
  const auto wu = cubic_weights(ku.t);
  const auto wv = cubic_weights(kv.t);
  double sum = 0;
  for (std::size_t y = 0; y < 4; ++y) {
    const double* row =
        &heights_[(as_size(kv.first) + y) * as_size(control_[0]) + as_size(ku.first)];
    for (std::size_t x = 0; x < 4; ++x) sum += wv[y] * wu[x] * row[x];
  }
  return sum;
}

Eigen::Vector2d LayerSurface::steepest() const {
  // The derivative of a B-spline is a B-spline of the differences and never exceeds them.
  const auto [a, b] = across(axis_);
  Eigen::Vector2d most = Eigen::Vector2d::Zero();
  for (int v = 0; v < control_[1]; ++v) {
    for (int u = 0; u < control_[0]; ++u) {
      const std::size_t at = as_size(v) * as_size(control_[0]) + as_size(u);
      if (u > 0) most.x() = std::max(most.x(), std::abs(heights_[at] - heights_[at - 1]));
      if (v > 0) {
        most.y() = std::max(most.y(), std::abs(heights_[at] - heights_[at - as_size(control_[0])]));
      }
    }
  }
  const auto knots_per_voxel = [](int control, int voxels) {
    return (control - 3.0) / std::max(voxels - 1, 1);
  };
  return {most.x() * knots_per_voxel(control_[0], size_[a]),
          most.y() * knots_per_voxel(control_[1], size_[b])};
}

Result<LayerModel> LayerModel::create(std::vector<LayerSurface> surfaces) {
  if (surfaces.empty() || surfaces.size() > 31) {
    return refused("1 to 31 surfaces", std::to_string(surfaces.size()));
  }
  for (const LayerSurface& s : surfaces) {
    if (s.axis() == surfaces.front().axis() && s.grid_size() == surfaces.front().grid_size()) {
      continue;
    }
    return refused("surfaces over the same axis of the same grid",
                   "axes " + std::to_string(surfaces.front().axis()) + " and " +
                       std::to_string(s.axis()) + ", or grids of different size");
  }
  LayerModel model;
  model.surfaces_ = std::move(surfaces);
  return model;
}

int LayerModel::layer_at(const Eigen::Vector3d& voxel) const {
  const int axis = surfaces_.front().axis();
  const auto [a, b] = across(axis);
  const double u = voxel[static_cast<int>(a)];
  const double v = voxel[static_cast<int>(b)];
  return static_cast<int>(
      std::count_if(surfaces_.begin(), surfaces_.end(),
                    [&](const LayerSurface& s) { return s.height(u, v) <= voxel[axis]; }));
}

Result<LabelVolume> LayerModel::rasterise(const VoxelGrid& grid, const RunOptions& run) const {
  const std::string name = "layer labels";
  if (grid.size != surfaces_.front().grid_size()) {
    return Error{ErrorCode::kUsage,
                 name + ": expected a grid of the size of the surfaces' grid, found another size"};
  }
  if (auto ok = check_memory(name, grid.voxel_count(), 4, run.memory_limit); !ok) return ok.error();
  const int axis = surfaces_.front().axis();
  const auto [a, b] = across(axis);
  std::vector<std::uint32_t> masks(grid.voxel_count());
  // Tolerance in voxels: a surface through voxel centres lies below all of them or none, despite
  // rounding.
  constexpr double kSameVoxels = 1e-6;
  Steps steps(run, as_size(grid.size[b]));
  for_each_index(grid.size[b], run.threads, [&, a = a, b = b](int v) {
    if (!steps.next()) return;
    std::vector<double> heights(surfaces_.size());
    for (int u = 0; u < grid.size[a]; ++u) {
      std::transform(surfaces_.begin(), surfaces_.end(), heights.begin(),
                     [&](const LayerSurface& s) { return s.height(u, v); });
      std::sort(heights.begin(), heights.end());
      std::size_t layer = 0;
      std::array<int, 3> at{};
      at[a] = u;
      at[b] = v;
      for (int h = 0; h < grid.size[as_size(axis)]; ++h) {
        while (layer < heights.size() && heights[layer] <= h + kSameVoxels) ++layer;
        at[as_size(axis)] = h;
        masks[offset_of(grid, at[0], at[1], at[2])] = std::uint32_t{1} << layer;
      }
    }
  });
  if (steps.stopped()) return cancelled(name);
  return LabelVolume::create(grid, std::move(masks), name);
}

double LayerModel::raster_error_voxels() const {
  double worst = 0;
  for (const LayerSurface& s : surfaces_) worst = std::max(worst, 0.5 * (1 + s.steepest().sum()));
  return worst;
}

}  // namespace nav::render::features
