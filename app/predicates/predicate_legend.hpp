// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "nav/image.hpp"
#include "render/predicates/histogram.hpp"
#include "render/predicates/model.hpp"

namespace nav::app {

/// The colour of a bar of the histogram: its hue and saturation at half the luminance.
Rgba8 bar_colour(const render::PredicateHistogram::Bar& bar);

/// What a colour of a picture by predicates means.
struct LegendEntry {
  Rgba8 colour;
  std::string name;
  double importance = 0;
  [[nodiscard]] std::string importance_words() const;  ///< Three decimals.
};
/// Of every entry of a model, in its order.
std::vector<LegendEntry> legend_of(const render::PredicateModel& model);

}  // namespace nav::app
