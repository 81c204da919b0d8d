// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "nav/result.hpp"

namespace nav::render {

/// One node of a piecewise-linear transfer function.
struct TransferNode {
  double hu;            ///< Value, HU.
  Eigen::Vector3d rgb;  ///< Colour in [0, 1], not premultiplied.
  double opacity;       ///< Opacity of 1 mm of the material, in [0, 1).
  double importance;    ///< Burns et al. 2007 §3.1, in [0, 1]; 1: visible everywhere.
};

/// What a voxel value looks like.
struct TransferSample {
  Eigen::Vector3d rgb;
  double tau_per_mm;  ///< Extinction, -ln(1 - opacity of 1 mm), >= 0.
  double importance;
};

/// 1D transfer function with importance over HU. Between nodes colour, extinction and importance
/// are linear in HU; outside the nodes the end values hold. Immutable.
class TransferFunction {
 public:
  /// Refuses fewer than two nodes, nodes not strictly increasing in HU, NaN, colour or importance
  /// outside [0, 1], opacity outside [0, 1). The message names the node.
  static Result<TransferFunction> create(std::string name, std::vector<TransferNode> nodes);

  [[nodiscard]] TransferSample at(double hu) const;
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::vector<TransferNode>& nodes() const { return nodes_; }

 private:
  TransferFunction(std::string name, std::vector<TransferNode> nodes)
      : name_(std::move(name)), nodes_(std::move(nodes)) {}
  std::string name_;
  std::vector<TransferNode> nodes_;
};

/// Built-in functions: "ct-bone", "ct-soft-tissue", "cta-vessels". kNotFound lists them.
Result<TransferFunction> preset_transfer_function(const std::string& name);

}  // namespace nav::render
