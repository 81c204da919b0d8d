// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/sweep_points.hpp"

#include <algorithm>
#include <cmath>

namespace nav::registration {

SweepPoints sweep_points(const Sweep& sweep, const std::vector<Image2d<std::uint8_t>>& masks) {
  constexpr double kStepMm = 4;
  SweepPoints out;
  out.centroid.mm.setZero();
  for (const int index : thin_frames(sweep, kStepMm)) {
    const auto i = static_cast<std::size_t>(index);
    const TrackedFrame& tracked = sweep.frames()[i];
    const PixelGrid& grid = tracked.frame.grid;
    const auto stride = [&](int axis) {
      return std::max(1,
                      static_cast<int>(std::lround(kStepMm / grid.mm_per_pixel.col(axis).norm())));
    };
    for (int row = stride(1) / 2; row < masks[i].height(); row += stride(1)) {
      for (int column = stride(0) / 2; column < masks[i].width(); column += stride(0)) {
        if (masks[i].at(column, row) == 0) continue;
        out.points.push_back(tracked.reference_from_image * grid.at(column, row));
        out.centroid.mm += out.points.back().mm;
      }
    }
  }
  if (out.points.empty()) return out;
  out.centroid.mm /= static_cast<double>(out.points.size());
  for (const auto& p : out.points) {
    const Eigen::Vector3d r = (p - out.centroid).v;
    out.radius_mm = std::max(out.radius_mm, r.norm());
    out.spread_mm2 += r * r.transpose() / static_cast<double>(out.points.size());
  }
  return out;
}

double overlap(const VoxelGrid& grid, const SweepPoints& sweep, const Pose& pose) {
  if (sweep.points.empty()) return 0;
  std::size_t inside = 0;
  const Eigen::Array3d last =
      Eigen::Array3d(grid.size[0], grid.size[1], grid.size[2]) - Eigen::Array3d::Ones();
  const Eigen::Array3d middle = grid.index_of(pose * sweep.centroid).array();
  const Eigen::Matrix3d turn = grid.spacing_mm.cwiseInverse().asDiagonal() *
                               grid.directions.transpose() * pose.rotation().toRotationMatrix();
  for (const auto& p : sweep.points) {
    const Eigen::Array3d index = middle + (turn * (p - sweep.centroid).v).array();
    if ((index >= 0).all() && (index <= last).all()) ++inside;
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
  for (const TrackedFrame& tracked : sweep.frames()) {
    const auto& pixels = tracked.frame.pixels;
    const Point<frames::Reference> p =
        tracked.reference_from_image *
        tracked.frame.grid.at(0.5 * (pixels.width() - 1), 0.5 * (pixels.height() - 1));
    sum += ((a * p) - (b * p)).v.squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(sweep.frames().size()));
}

}  // namespace nav::registration
