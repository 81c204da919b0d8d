// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "nav/result.hpp"

namespace nav::render {

/// Greatest number of predicates in a histogram.
inline constexpr std::size_t kMostPredicates = 32;

/// The bars of a predicate histogram (Schulte zu Berge et al. 2014 §3.3): importances, whose sum
/// stays 1 (Eq. 2) under any sequence of edits, and colour modulations. A plain value. Any editor
/// can change it, for example a window.
class PredicateHistogram {
 public:
  /// Tolerance for the sum of the importances, which is 1.
  static constexpr double kSumTolerance = 1e-12;

  struct Bar {
    double importance;  ///< kappa, [0, 1].
    double hue_deg;     ///< [0, 360).
    double saturation;  ///< [0, 1].
  };

  PredicateHistogram() = default;
  /// Scales the importances to the sum 1; if all are 0, makes them equal. Rejects more than
  /// kMostPredicates bars, NaN, negative importances and saturations outside [0, 1]. Takes hues
  /// modulo 360.
  static Result<PredicateHistogram> create(std::vector<Bar> bars);

  [[nodiscard]] const std::vector<Bar>& bars() const { return bars_; }
  [[nodiscard]] std::size_t size() const { return bars_.size(); }

  /// Drags a bar to a height, clamped to [0, 1]. The others keep their proportions, or share
  /// equally when all of them are 0. A single bar stays at 1. Precondition: bar < size().
  void drag(std::size_t bar, double importance);
  /// Sets the colour of a bar. Preconditions: bar < size(); a finite hue.
  void set_colour(std::size_t bar, double hue_deg, double saturation);
  /// Adds a last bar of the mean height. Precondition: size() < kMostPredicates.
  void add(double hue_deg, double saturation);
  /// Removes a bar. The others keep their proportions. Precondition: bar < size().
  void remove(std::size_t bar);
  /// Applies scribbles (§4.1). \p shown and \p hidden hold, for each predicate, the number of
  /// samples painted "show" and "hide" for which it is true. Eq. 9, corrected: adds
  /// m_i = q (N+_i - N-_i) / sum |N+ - N-| minus the mean of m, with q = share. The amount below 0
  /// is taken from the others. Nothing changes when every N+ equals its N-. Preconditions: size()
  /// counts each; 0 <= share <= 1.
  void scribble(std::span<const std::uint64_t> shown, std::span<const std::uint64_t> hidden,
                double share = 0.25);

 private:
  void normalise();
  std::vector<Bar> bars_;
};

bool operator==(const PredicateHistogram::Bar& a, const PredicateHistogram::Bar& b);

}  // namespace nav::render
