// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/shape/shape_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace nav::registration {
namespace {

constexpr double kMaxNodes = 268435456;  // 2^28: 1 GiB of indices.
constexpr int kFieldRounds = 2;

VoxelGrid grid_around(const Shape& shape, const ShapeFieldOptions& options) {
  Eigen::Vector3d low = shape.elements.front().point_mm;
  Eigen::Vector3d high = low;
  for (const ShapeElement& e : shape.elements) {
    low = low.cwiseMin(e.point_mm);
    high = high.cwiseMax(e.point_mm);
  }
  VoxelGrid grid;
  grid.spacing_mm.setConstant(options.spacing_mm);
  grid.origin_mm = low.array() - options.margin_mm;
  const Eigen::Vector3d nodes =
      ((high - low).array() + 2 * options.margin_mm) / options.spacing_mm + 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // Values of 2^29 or more along one axis are rejected below, and 2^29 still fits an int.
    const double n = std::min(nodes[static_cast<Eigen::Index>(axis)], 536870912.0);
    grid.size[axis] = std::max(2, static_cast<int>(std::ceil(n)));
  }
  return grid;
}

/// Passes pieces from node to node, forwards and backwards (vector distance transform, Danielsson
/// 1980, with the true distances of the pieces).
class Propagation {
 public:
  Propagation(const Shape& shape, const VoxelGrid& grid)
      : shape_(shape), grid_(grid), nearest_(grid.voxel_count(), -1) {
    for (std::size_t i = 0; i < shape.elements.size(); ++i) plant(static_cast<std::int32_t>(i));
  }

  std::vector<std::int32_t> run() {
    for (int round = 0; round < kFieldRounds || !complete(); ++round) {
      pass(1);
      pass(-1);
    }
    return std::move(nearest_);
  }

 private:
  [[nodiscard]] bool complete() const {
    return std::none_of(nearest_.begin(), nearest_.end(), [](std::int32_t n) { return n < 0; });
  }
  [[nodiscard]] std::size_t offset(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * static_cast<std::size_t>(grid_.size[1]) +
            static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(grid_.size[0]) +
           static_cast<std::size_t>(i);
  }
  [[nodiscard]] Eigen::Vector3d node(int i, int j, int k) const {
    return grid_.origin_mm + grid_.spacing_mm.cwiseProduct(Eigen::Vector3d(i, j, k));
  }
  [[nodiscard]] double squared(std::int32_t piece, const Eigen::Vector3d& p) const {
    return (shape_.elements[static_cast<std::size_t>(piece)].point_mm - p).squaredNorm();
  }

  void plant(std::int32_t piece) {
    const Eigen::Vector3d index =
        (shape_.elements[static_cast<std::size_t>(piece)].point_mm - grid_.origin_mm)
            .cwiseQuotient(grid_.spacing_mm);
    std::array<int, 3> at{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto x = static_cast<int>(std::lround(index[static_cast<Eigen::Index>(axis)]));
      at[axis] = std::clamp(x, 0, grid_.size[axis] - 1);
    }
    std::int32_t& held = nearest_[offset(at[0], at[1], at[2])];
    const Eigen::Vector3d p = node(at[0], at[1], at[2]);
    if (held < 0 || squared(piece, p) < squared(held, p)) held = piece;
  }

  void pass(int step) {
    const auto range = [&](int n) { return step > 0 ? std::pair(0, n) : std::pair(n - 1, -1); };
    const auto [k0, k1] = range(grid_.size[2]);
    const auto [j0, j1] = range(grid_.size[1]);
    const auto [i0, i1] = range(grid_.size[0]);
    for (int k = k0; k != k1; k += step) {
      for (int j = j0; j != j1; j += step) {
        for (int i = i0; i != i1; i += step) relax(i, j, k, step);
      }
    }
  }

  /// Takes the best piece of the 13 neighbours that this pass has already visited.
  void relax(int i, int j, int k, int step) {
    std::int32_t& held = nearest_[offset(i, j, k)];
    const Eigen::Vector3d p = node(i, j, k);
    double least = held < 0 ? 1e300 : squared(held, p);
    for (int n = 0; n < 13; ++n) {
      // 0..8: the slice before; 9..11: the row before; 12: the node before.
      const int di = n < 12 ? n % 3 - 1 : -1;
      const int dj = n < 9 ? n / 3 - 1 : (n < 12 ? -1 : 0);
      const int dk = n < 9 ? -1 : 0;
      const int a = i + step * di;
      const int b = j + step * dj;
      const int c = k + step * dk;
      if (a < 0 || b < 0 || c < 0 || a >= grid_.size[0] || b >= grid_.size[1] ||
          c >= grid_.size[2]) {
        continue;
      }
      const std::int32_t other = nearest_[offset(a, b, c)];
      if (other < 0 || other == held) continue;
      const double d2 = squared(other, p);
      if (d2 >= least) continue;
      least = d2;
      held = other;
    }
  }

  const Shape& shape_;
  const VoxelGrid& grid_;
  std::vector<std::int32_t> nearest_;
};

/// Projection onto the part of an offset that a shape does not leave free.
Eigen::Matrix3d bound_part(ShapeKind kind, const Eigen::Vector3d& axis) {
  const Eigen::Matrix3d along = axis * axis.transpose();
  return kind == ShapeKind::kSurface ? along : Eigen::Matrix3d::Identity() - along;
}

/// Cell and fractions of a point, clamped to the grid.
struct FieldCell {
  std::array<int, 3> base{};
  std::array<double, 3> w{};
  std::array<double, 3> moves{};  ///< d w / d index: 0 if clamped.
};

FieldCell cell_of(const VoxelGrid& grid, const Eigen::Vector3d& p) {
  FieldCell cell;
  const Eigen::Vector3d index = (p - grid.origin_mm).cwiseQuotient(grid.spacing_mm);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double x = index[static_cast<Eigen::Index>(axis)];
    const double inside = std::clamp(x, 0.0, static_cast<double>(grid.size[axis] - 1));
    cell.base[axis] = std::min(static_cast<int>(inside), grid.size[axis] - 2);
    cell.w[axis] = inside - cell.base[axis];
    cell.moves[axis] = inside == x ? 1 : 0;
  }
  return cell;
}

}  // namespace

Result<ShapeField> ShapeField::create(const Shape& shape, const ShapeFieldOptions& options) {
  const auto reject = [&](ErrorCode code, const std::string& expected, double found) {
    return Error{code, shape.name + ": expected " + expected + ", found " + std::to_string(found)};
  };
  if (!(options.spacing_mm >= 0.25 && options.spacing_mm <= 20)) {
    return reject(ErrorCode::kUsage, "a field spacing of 0.25 to 20 mm", options.spacing_mm);
  }
  if (!(options.margin_mm >= 0 && options.margin_mm <= 200)) {
    return reject(ErrorCode::kUsage, "a field margin of 0 to 200 mm", options.margin_mm);
  }
  if (shape.elements.empty()) return reject(ErrorCode::kMalformedData, "pieces of a shape", 0);
  const VoxelGrid grid = grid_around(shape, options);
  const double nodes = static_cast<double>(grid.size[0]) * grid.size[1] * grid.size[2];
  if (!(nodes <= kMaxNodes)) {
    return reject(ErrorCode::kUnsupportedData, "at most 2^28 nodes of the field", nodes);
  }
  auto data = std::make_shared<Data>(Data{shape, grid, {}});
  data->nearest = Propagation(data->shape, grid).run();
  return ShapeField(std::move(data));
}

double ShapeField::distance_from(const ShapeElement& e, const Eigen::Vector3d& p) const {
  const Eigen::Vector3d d = p - e.point_mm;
  const double along2 = std::pow(e.axis.dot(d), 2);
  const double across2 = std::max(d.squaredNorm() - along2, 0.0);
  const bool surface = data_->shape.kind == ShapeKind::kSurface;
  // A triangle reaches at most two thirds of its longest side from its centroid, and a piece of a
  // line half its length. Beyond that lies a neighbour or nothing.
  const double reach = (surface ? 2.0 / 3 : 0.5) * data_->shape.spacing_mm;
  const double slid = std::max(0.0, std::sqrt(surface ? across2 : along2) - reach);
  return std::sqrt((surface ? along2 : across2) + slid * slid);
}

double ShapeField::distance_mm(const Eigen::Vector3d& p) const {
  const VoxelGrid& grid = data_->grid;
  const FieldCell cell = cell_of(grid, p);
  double least = 1e300;
  std::int32_t last = -1;
  for (int corner = 0; corner < 8; ++corner) {
    const std::size_t i = static_cast<std::size_t>(cell.base[0] + (corner & 1));
    const std::size_t j = static_cast<std::size_t>(cell.base[1] + ((corner >> 1) & 1));
    const std::size_t k = static_cast<std::size_t>(cell.base[2] + (corner >> 2));
    const std::int32_t piece = data_->nearest[(k * static_cast<std::size_t>(grid.size[1]) + j) *
                                                  static_cast<std::size_t>(grid.size[0]) +
                                              i];
    if (piece == last) continue;
    last = piece;
    least =
        std::min(least, distance_from(data_->shape.elements[static_cast<std::size_t>(piece)], p));
  }
  return least;
}

ShapeSample ShapeField::at(const Eigen::Vector3d& p) const {
  const VoxelGrid& grid = data_->grid;
  const FieldCell cell = cell_of(grid, p);
  ShapeSample sample{Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero(), 1e300,
                     Eigen::Vector3d::Zero()};
  for (int corner = 0; corner < 8; ++corner) {
    const std::array<int, 3> bit{corner & 1, (corner >> 1) & 1, corner >> 2};
    std::size_t offset = 0;
    for (std::size_t axis = 3; axis-- > 0;) {
      offset = offset * static_cast<std::size_t>(grid.size[axis]) +
               static_cast<std::size_t>(cell.base[axis] + bit[axis]);
    }
    const ShapeElement& e = data_->shape.elements[static_cast<std::size_t>(data_->nearest[offset])];
    const auto weight = [&](std::size_t axis) {
      return bit[axis] == 1 ? cell.w[axis] : 1 - cell.w[axis];
    };
    const Eigen::Matrix3d bound = bound_part(data_->shape.kind, e.axis);
    const Eigen::Vector3d off = bound * (p - e.point_mm);
    const double w = weight(0) * weight(1) * weight(2);
    sample.offset_mm += w * off;
    sample.by_point += w * bound;
    sample.axis += w * e.axis;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double slope = (bit[axis] == 1 ? 1 : -1) * cell.moves[axis] * weight((axis + 1) % 3) *
                           weight((axis + 2) % 3);
      const auto column = static_cast<Eigen::Index>(axis);
      sample.by_point.col(column) += slope / grid.spacing_mm[column] * off;
    }
    sample.distance_mm = std::min(sample.distance_mm, distance_from(e, p));
  }
  return sample;
}

}  // namespace nav::registration
