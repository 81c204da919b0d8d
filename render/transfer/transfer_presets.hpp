// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "nav/volume.hpp"
#include "render/scene.hpp"
#include "render/transfer/transfer_function.hpp"

namespace nav::render {

/// The names of the built-in functions, in the order in which a list shows them.
std::vector<std::string> preset_names();

/// The range of the values of an image without a calibrated scale (MR), by its own percentiles:
/// from the background to the brightest value, without outliers. Gain and offset of a scanner do
/// not matter.
struct ValueRange {
  double low;   ///< First percentile of all values.
  double high;  ///< Above 99.5 % of the values above Otsu's threshold; > low.
};
ValueRange value_range(const StoredVolume& volume);
/// The value range for which the default gradients of Shading, and "mr-default" without a volume,
/// are made.
inline constexpr ValueRange kNominalRange{0, 1000};

/// A built-in function for a volume. CT presets are absolute, in HU; "mr-default" is mapped to the
/// volume's value_range(). kNotFound lists the names.
Result<TransferFunction> preset_for(const std::string& name, const StoredVolume& volume);

/// Moves an appearance to other values: maps `from` linearly to `to`. Gradient windows scale by the
/// same factor. Rejects nodes that coincide or exceed the range of a double. Precondition:
/// from.high > from.low and to.high > to.low; otherwise a Bug.
Result<TransferFunction> rescaled(const TransferFunction& function, const ValueRange& from,
                                  const ValueRange& to);
/// Moves a shading to other values: its gradients scale by the same factor. Same precondition.
Shading rescaled(Shading shading, const ValueRange& from, const ValueRange& to);

/// Sets the importance of a range of values, for one component or for all.
struct ImportanceRule {
  double low_hu;
  double high_hu;              ///< >= low_hu; both may be infinite.
  double importance;           ///< [0, 1].
  std::string component = "";  ///< Empty: every component.
};

/// A function with importances that rules set, in their order; where no rule applies, the
/// importance stays. Colour and extinction do not change: nodes are added 0.5 HU apart at the ends
/// of a range. Rejects NaN, high < low, importance outside [0, 1] and unknown components; the
/// message names the rule.
Result<TransferFunction> with_importance(const TransferFunction& function,
                                         const std::vector<ImportanceRule>& rules);

}  // namespace nav::render
