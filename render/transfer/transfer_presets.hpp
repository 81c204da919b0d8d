// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "nav/volume.hpp"
#include "render/scene.hpp"
#include "render/transfer/transfer_function.hpp"

namespace nav::render {

/// Names of the built-in functions, in the order in which a list shows them.
std::vector<std::string> preset_names();

/// Values that an image without a calibrated scale (MR) is judged by: between the background and
/// the brightest, outliers left out.
struct ValueRange {
  double low;   ///< Border of the background, by Otsu's threshold.
  double high;  ///< 99.5 % of what is above low lies below; > low.
};
ValueRange value_range(const Volume& volume);
/// What shading's own gradients, and "mr-default" without a volume, are made for.
inline constexpr ValueRange kNominalRange{0, 1000};

/// A built-in function for a volume: CT presets are absolute, in HU; "mr-default" is laid over the
/// volume's value_range(). kNotFound lists the names.
Result<TransferFunction> preset_for(const std::string& name, const Volume& volume);

/// The same look on other values: from maps linearly to to. Gradient windows scale by the same
/// factor. Refuses nodes that fall together or leave the numbers that a double holds.
/// Precondition: from.high > from.low and to.high > to.low, otherwise a Bug.
Result<TransferFunction> rescaled(const TransferFunction& function, const ValueRange& from,
                                  const ValueRange& to);
/// The same shading on other values: its gradients scale by that factor. Precondition: as above.
Shading rescaled(Shading shading, const ValueRange& from, const ValueRange& to);

/// Importance for a range of values, of one component or of all.
struct ImportanceRule {
  double low_hu;
  double high_hu;              ///< >= low_hu; both may be infinite.
  double importance;           ///< [0, 1].
  std::string component = "";  ///< Empty: every component.
};

/// A function whose importance is set by rules, in their order; where none applies it stays.
/// Colour and extinction do not change: at the ends of a range nodes are added 0.5 HU apart.
/// Refuses, naming the rule: NaN, high < low, importance outside [0, 1], unknown components.
Result<TransferFunction> with_importance(const TransferFunction& function,
                                         const std::vector<ImportanceRule>& rules);

}  // namespace nav::render
