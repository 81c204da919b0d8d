// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "nav/result.hpp"

namespace nav::render {

/// One node of a piecewise-linear ramp.
struct TransferNode {
  double hu;            ///< Value, HU (MR: the stored value).
  Eigen::Vector3d rgb;  ///< Colour in [0, 1], not premultiplied.
  double opacity;       ///< Opacity of 1 mm of the material, in [0, 1).
  double importance;    ///< Burns et al. 2007 §3.1, in [0, 1]; 1: visible everywhere.
};

/// Where a component acts by gradient magnitude, HU/mm: its extinction is multiplied by a trapezoid
/// that rises over [zero_below, full_from] and falls over [full_to, zero_above].
struct GradientWindow {
  double zero_below;
  double full_from;
  double full_to;  ///< May be infinity, then zero_above is as well.
  double zero_above;
};

/// One material of a transfer function.
struct TransferComponent {
  std::string name;
  std::vector<TransferNode> nodes;         ///< Outside the nodes the end values hold.
  std::optional<GradientWindow> gradient;  ///< Absent: everywhere.
};

/// What a voxel value looks like.
struct TransferSample {
  Eigen::Vector3d rgb;
  double tau_per_mm;  ///< Extinction, -ln(1 - opacity of 1 mm), >= 0.
  double importance;
};

/// Importances from here on count as 1, so that rounding cannot make the most important material
/// vanish in the clear region, where I = 1 shows and I < 1 does not.
inline constexpr double kFullImportance = 1 - 1.0 / 4096;

/// Importance-augmented transfer function: any number of overlapping components (Burns et al. 2007
/// §3.1). Within a component colour, extinction and importance are linear in HU between nodes.
/// Components are blended by importance:
///   rgb = sum c a I / sum a I,  extinction = max,  importance = max over components with a > 0.
/// Degenerate cases: all I = 0 where some a > 0: weights a alone (the limit of equal I -> 0); all
/// a = 0: the colour of the component whose visible range is nearest, importance 0. Immutable.
class TransferFunction {
 public:
  /// One component over all nodes. Refuses fewer than two nodes, nodes not strictly increasing in
  /// HU, NaN, colour or importance outside [0, 1], opacity outside [0, 1). The message names the
  /// node.
  static Result<TransferFunction> create(std::string name, std::vector<TransferNode> nodes);
  /// Any number >= 1 of components. Refuses each as above, naming component and node, and gradient
  /// windows that are not 0 <= zero_below <= full_from <= full_to <= zero_above.
  static Result<TransferFunction> blend(std::string name,
                                        std::vector<TransferComponent> components);

  /// gradient_hu_per_mm >= 0 matters only when uses_gradient().
  [[nodiscard]] TransferSample at(double hu, double gradient_hu_per_mm = 0) const;
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::vector<TransferComponent>& components() const { return components_; }
  /// Some component has a gradient window.
  [[nodiscard]] bool uses_gradient() const;
  /// Every node's HU, ascending, each once.
  [[nodiscard]] const std::vector<double>& values() const { return values_; }

 private:
  TransferFunction(std::string name, std::vector<TransferComponent> components);
  [[nodiscard]] Eigen::Vector3d invisible_colour(double hu) const;

  std::string name_;
  std::vector<TransferComponent> components_;
  std::vector<double> values_;
  std::vector<std::vector<double>> taus_per_mm_;  ///< Extinction of the nodes of each component.
};

/// Whether two functions classify alike: names may differ.
bool operator==(const TransferNode& a, const TransferNode& b);
bool same_classification(const TransferFunction& a, const TransferFunction& b);

/// Built-in functions, e.g. "ct-bone", "cta-vessels"; kNotFound lists them.
Result<TransferFunction> preset_transfer_function(const std::string& name);

}  // namespace nav::render
