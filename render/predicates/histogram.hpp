// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "nav/result.hpp"

namespace nav::render {

/// Predicates of a histogram, at most.
inline constexpr std::size_t kMostPredicates = 32;

/// The bars of a predicate histogram (Schulte zu Berge et al. 2014 §3.3): importances that sum to 1
/// (Eq. 2) under any sequence of edits, and colour modulations. A plain value; driven by whatever
/// edits it, a window among others.
class PredicateHistogram {
 public:
  /// The sum of the importances is 1 within this.
  static constexpr double kSumTolerance = 1e-12;

  struct Bar {
    double importance;  ///< kappa, [0, 1].
    double hue_deg;     ///< [0, 360).
    double saturation;  ///< [0, 1].
  };

  PredicateHistogram() = default;
  /// Scales the importances to sum 1; all 0: equal ones. Refuses more than kMostPredicates bars,
  /// NaN, negative importances, saturations outside [0, 1]; takes hues modulo 360.
  static Result<PredicateHistogram> create(std::vector<Bar> bars);

  [[nodiscard]] const std::vector<Bar>& bars() const { return bars_; }
  [[nodiscard]] std::size_t size() const { return bars_.size(); }

  /// Drags a bar to a height, clamped to [0, 1]: the others keep their proportions, or share alike
  /// when all of them are 0. A single bar stays at 1. Precondition: bar < size().
  void drag(std::size_t bar, double importance);
  /// Preconditions: bar < size(); a finite hue.
  void set_colour(std::size_t bar, double hue_deg, double saturation);
  /// A new last bar of the mean height. Precondition: size() < kMostPredicates.
  void add(double hue_deg, double saturation);
  /// The others keep their proportions. Precondition: bar < size().
  void remove(std::size_t bar);
  /// Scribbles (§4.1): how many samples of those painted "show" and of those painted "hide" each
  /// predicate is true for. Eq. 9 corrected: m_i = q (N+_i - N-_i) / sum |N+ - N-|, less the mean,
  /// added; what falls below 0 is taken from the others. Nothing changes when every N+ equals its
  /// N-. Preconditions: counts of size(); 0 <= share <= 1.
  void scribble(std::span<const std::uint64_t> shown, std::span<const std::uint64_t> hidden,
                double share = 0.25);

 private:
  void normalise();
  std::vector<Bar> bars_;
};

bool operator==(const PredicateHistogram::Bar& a, const PredicateHistogram::Bar& b);

}  // namespace nav::render
