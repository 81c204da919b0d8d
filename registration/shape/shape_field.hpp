// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "nav/volume.hpp"
#include "registration/shape/shape.hpp"

namespace nav::registration {

struct ShapeFieldOptions {
  double spacing_mm = 4.0;  ///< Spacing of the grid's nodes, 0.25 to 20.
  double margin_mm = 40;    ///< Margin of the grid around the shape, 0 to 200.
};

/// Value of the field at a point of the CT.
struct ShapeSample {
  /// Offset from the shape, without the directions that the shape leaves free.
  Eigen::Vector3d offset_mm;
  Eigen::Matrix3d by_point;  ///< Derivative of the offset by the point.
  double distance_mm;        ///< Distance from the nearest piece with its full extent, >= 0.
  /// Mean normal (or tangent) of the pieces around; its sign is that of the mesh's windings.
  Eigen::Vector3d axis;
};

/// The nearest piece of a shape for every node of a grid, computed once. A look-up replaces the
/// search for correspondences in every iteration of ICP (like the distance map of Fitzgibbon 2003).
/// Between the nodes the offsets to the eight planes (or lines) are interpolated, so that a plane
/// is exact at any spacing and the field has no kink at distance zero. Outside the grid the piece
/// of the nearest node is used. Copies share the data; thread-safe to read.
class ShapeField {
 public:
  /// Rejects options out of range, a shape without pieces, and grids of more than 2^28 nodes.
  static Result<ShapeField> create(const Shape& shape, const ShapeFieldOptions& options = {});

  [[nodiscard]] ShapeSample at(const Eigen::Vector3d& p_ct_mm) const;
  /// The distance_mm of at() alone.
  [[nodiscard]] double distance_mm(const Eigen::Vector3d& p_ct_mm) const;
  [[nodiscard]] ShapeKind kind() const { return data_->shape.kind; }
  [[nodiscard]] const std::string& name() const { return data_->shape.name; }
  [[nodiscard]] const Shape& shape() const { return data_->shape; }
  [[nodiscard]] std::size_t node_count() const { return data_->nearest.size(); }

 private:
  struct Data {
    Shape shape;
    VoxelGrid grid;
    std::vector<std::int32_t> nearest;  ///< Piece nearest to each node; i fastest.
  };
  explicit ShapeField(std::shared_ptr<const Data> data) : data_(std::move(data)) {}
  [[nodiscard]] double distance_from(const ShapeElement& e, const Eigen::Vector3d& p) const;

  std::shared_ptr<const Data> data_;
};

}  // namespace nav::registration
