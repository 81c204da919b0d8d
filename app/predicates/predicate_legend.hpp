// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "nav/image.hpp"
#include "render/predicates/histogram.hpp"
#include "render/predicates/model.hpp"
#include "render/transfer/transfer_function.hpp"

namespace nav::app {

/// Colour of a bar of the histogram: its hue and saturation at half the luminance.
Rgba8 bar_colour(const render::PredicateHistogram::Bar& bar);

/// Meaning of a colour in an image by predicates.
struct LegendEntry {
  Rgba8 colour;
  std::string name;
  double importance = 0;
  [[nodiscard]] std::string importance_words() const;  ///< Importance with three decimals.
};
/// Legend of a model: one entry for each predicate, in the model's order.
std::vector<LegendEntry> legend_of(const render::PredicateModel& model);
/// Legend of a transfer function: one entry for each named component, in its order, with the colour
/// and importance of its most opaque node.
std::vector<LegendEntry> legend_of(const render::TransferFunction& transfer);

}  // namespace nav::app
