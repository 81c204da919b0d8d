// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/similarity/sweep_points.hpp"

#include <algorithm>
#include <cmath>

#include "nav/index.hpp"

namespace nav::registration {

SweepPoints sweep_points(const Sweep& sweep, const std::vector<Image2d<std::uint8_t>>& masks) {
  constexpr double kStepMm = 4;
  SweepPoints out;
  out.centroid.mm.setZero();
  for (const int index : thin_frames(sweep, kStepMm)) {
    const auto i = static_cast<std::size_t>(index);
    const TrackedImage& tracked = sweep.frames()[i];
    const PixelGrid& grid = tracked.frame.grid;
    const auto stride = [&](int axis) {
      return std::max(1,
                      static_cast<int>(std::lround(kStepMm / grid.mm_per_pixel.col(axis).norm())));
    };
    const Point<frames::Reference> first = tracked.reference_from_image * grid.at(0, 0);
    const Eigen::Matrix<double, 3, 2> per_pixel =
        tracked.reference_from_image.rotation().toRotationMatrix().leftCols<2>() *
        grid.mm_per_pixel;
    const int step_x = stride(0);
    const int step_y = stride(1);
    const auto usable = masks[i].pixels();
    for (int row = step_y / 2; row < masks[i].height(); row += step_y) {
      const std::size_t of_row = as_size(row) * as_size(masks[i].width());
      const Eigen::Vector3d start = first.mm + row * per_pixel.col(1);
      for (int column = step_x / 2; column < masks[i].width(); column += step_x) {
        if (usable[of_row + as_size(column)] == 0) continue;
        out.points.push_back({start + column * per_pixel.col(0)});
        out.centroid.mm += out.points.back().mm;
      }
    }
  }
  if (out.points.empty()) return out;
  out.centroid.mm /= static_cast<double>(out.points.size());
  double farthest_mm2 = 0;
  for (const auto& p : out.points) {
    const Eigen::Vector3d r = (p - out.centroid).v;
    farthest_mm2 = std::max(farthest_mm2, r.squaredNorm());
    out.spread_mm2 += r * r.transpose();
  }
  out.radius_mm = std::sqrt(farthest_mm2);
  out.spread_mm2 /= static_cast<double>(out.points.size());
  return out;
}

namespace {

/// True if the CT shows air at a point in Grid coordinates; false outside the texels.
bool in_air(const CtChannels& ct, const Eigen::Vector3d& p_grid) {
  // Smoothed soft tissue, fat included, is above −1.2 even beside air; values end at −1.5.
  constexpr float kAir = -1.45f;
  const Eigen::Array3d index = (p_grid.array() / ct.spacing_mm.array()).round();
  const Eigen::Array3d size(ct.size[0], ct.size[1], ct.size[2]);
  if (!(index >= 0).all() || !(index < size).all()) return false;
  const auto [nx, ny, nz] = ct.size;
  const auto at = [&](Eigen::Index axis) { return static_cast<std::size_t>(index[axis]); };
  const std::size_t texel = (at(2) * as_size(ny) + at(1)) * as_size(nx) + at(0);
  return ct.texels[texel][0] < kAir;
}

}  // namespace

double overlap(const VoxelGrid& grid, const SweepPoints& sweep, const Pose& pose,
               const CtChannels* ct) {
  if (sweep.points.empty()) return 0;
  std::size_t inside = 0;
  const Eigen::Array3d last =
      Eigen::Array3d(grid.size[0], grid.size[1], grid.size[2]) - Eigen::Array3d::Ones();
  const Eigen::Array3d middle = grid.index_of(pose * sweep.centroid).array();
  const Eigen::Matrix3d turn = grid.spacing_mm.cwiseInverse().asDiagonal() *
                               grid.directions.transpose() * pose.rotation().toRotationMatrix();
  for (const auto& p : sweep.points) {
    const Eigen::Array3d index = middle + (turn * (p - sweep.centroid).v).array();
    if ((index < 0).any() || (index > last).any()) continue;
    if (ct != nullptr && in_air(*ct, ct->grid_of((pose * p).mm))) continue;
    ++inside;
  }
  return static_cast<double>(inside) / static_cast<double>(sweep.points.size());
}

double spread_mm2(const SweepPoints& sweep, const Eigen::Matrix3d& m) {
  return std::max((m * sweep.spread_mm2 * m.transpose()).trace(), 0.0);
}

double distance_mm(const SweepPoints& sweep, const Pose& a, const Pose& b) {
  const Eigen::Vector3d shift = (a * sweep.centroid).mm - (b * sweep.centroid).mm;
  const Eigen::Matrix3d turn = a.rotation().toRotationMatrix() - b.rotation().toRotationMatrix();
  return std::sqrt(shift.squaredNorm() + spread_mm2(sweep, turn));
}

CtBox box_around(const SweepPoints& sweep, const std::vector<Pose>& poses, double margin_mm) {
  CtBox box{Eigen::Vector3d::Constant(1e300), Eigen::Vector3d::Constant(-1e300)};
  for (const Pose& pose : poses) {
    const Eigen::Matrix3d turn = pose.rotation().toRotationMatrix();
    const Eigen::Vector3d middle = (pose * sweep.centroid).mm;
    for (const auto& p : sweep.points) {
      const Eigen::Vector3d q = middle + turn * (p - sweep.centroid).v;
      box.low = box.low.cwiseMin(q);
      box.high = box.high.cwiseMax(q);
    }
  }
  box.low.array() -= margin_mm;
  box.high.array() += margin_mm;
  return box;
}

double apart_mm(const Sweep& sweep, const Transform<frames::Ct, frames::Reference>& a,
                const Transform<frames::Ct, frames::Reference>& b) {
  double sum = 0;
  for (const TrackedImage& tracked : sweep.frames()) {
    const auto& pixels = tracked.frame.pixels;
    const Point<frames::Reference> p =
        tracked.reference_from_image *
        tracked.frame.grid.at(0.5 * (pixels.width() - 1), 0.5 * (pixels.height() - 1));
    sum += ((a * p) - (b * p)).v.squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(sweep.frames().size()));
}

}  // namespace nav::registration
