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

/// Limits a component by gradient magnitude, HU/mm: its extinction is multiplied by a trapezoid
/// that rises over [zero_below, full_from] and falls over [full_to, zero_above].
struct GradientWindow {
  double zero_below;
  double full_from;
  double full_to;  ///< May be infinite; then zero_above is infinite too.
  double zero_above;
};

/// One material of a transfer function.
struct TransferComponent {
  std::string name;
  std::vector<TransferNode> nodes;         ///< The end values hold outside the nodes.
  std::optional<GradientWindow> gradient;  ///< Absent: any gradient.
};

/// The appearance of a voxel value.
struct TransferSample {
  Eigen::Vector3d rgb;
  double tau_per_mm;  ///< Extinction, -ln(1 - opacity of 1 mm), >= 0.
  double importance;
};

/// Importances from this value on count as 1, so that rounding cannot make the most important
/// material vanish in the clear region, where I = 1 is visible and I < 1 is not.
inline constexpr double kFullImportance = 1 - 1.0 / 4096;

/// Importance-augmented transfer function: any number of overlapping components (Burns et al. 2007
/// §3.1). Within a component, colour, extinction and importance are linear in HU between nodes.
/// Components are blended by importance:
///   rgb = sum c a I / sum a I,  extinction = max,  importance = max over components with a > 0.
/// Degenerate cases: if all I = 0 but some a > 0, the weights are a alone (the limit of equal I ->
/// 0). If all a = 0, the colour is that of the component whose visible range is nearest, and the
/// importance is 0. Immutable.
class TransferFunction {
 public:
  /// Creates a function of one component over all nodes. Rejects fewer than two nodes, nodes that
  /// are not strictly increasing in HU, NaN, colour or importance outside [0, 1], and opacity
  /// outside [0, 1). The message names the node.
  static Result<TransferFunction> create(std::string name, std::vector<TransferNode> nodes);
  /// Creates a function of one or more components. Rejects each component as create() does, with
  /// the names of component and node, and gradient windows that are not
  /// 0 <= zero_below <= full_from <= full_to <= zero_above.
  static Result<TransferFunction> blend(std::string name,
                                        std::vector<TransferComponent> components);

  /// The classification of a value in HU. gradient_hu_per_mm, >= 0, matters only if
  /// uses_gradient().
  [[nodiscard]] TransferSample at(double hu, double gradient_hu_per_mm = 0) const;
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::vector<TransferComponent>& components() const { return components_; }
  /// True if some component has a gradient window.
  [[nodiscard]] bool uses_gradient() const;
  /// The HU values of all nodes, ascending, each once.
  [[nodiscard]] const std::vector<double>& values() const { return values_; }

 private:
  TransferFunction(std::string name, std::vector<TransferComponent> components);
  [[nodiscard]] Eigen::Vector3d invisible_colour(double hu) const;

  std::string name_;
  std::vector<TransferComponent> components_;
  std::vector<double> values_;
  std::vector<std::vector<double>> taus_per_mm_;  ///< Extinction of the nodes of each component.
};

/// Compare how two functions classify; their names may differ.
bool operator==(const TransferNode& a, const TransferNode& b);
bool same_classification(const TransferFunction& a, const TransferFunction& b);

/// A built-in function, for example "ct-bone" or "cta-vessels". kNotFound lists the names.
Result<TransferFunction> preset_transfer_function(const std::string& name);

}  // namespace nav::render
