// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/similarity/noise_floor.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "nav/index.hpp"
#include "registration/similarity/grey_histogram.hpp"

namespace nav::registration {
namespace {

constexpr int kDeepHalf = 2;  // Cells are averaged over 5 depth bins
constexpr int kLineHalf = 1;  // and 3 lines.
constexpr double kDarkest = 0.02;
constexpr double kUsual = 0.75;
// Noise reaches this many standard deviations above its darkest cells, which lie two below its
// mean.
constexpr float kDeviations = 4.5f;
// Averaged cells share neighbours and beams, so that averaging reduces the spread less than by the
// root of their number, which is 3.9.
constexpr float kCalming = 2.5f;
constexpr float kLeastMargin = 6;
// Tissue is told from noise only where its usual grey lies this many margins above the darkest.
constexpr float kClearMargins = 2;
constexpr int kLinesApart = 5;
// Averaged cells share 15 cells each, so that as few of the pairs are independent.
constexpr double kPairsPerIndependent = 15;
constexpr double kLeastCorrelation = 0.2;

/// Sums of pairs of values, for their correlation.
struct PairSums {
  double n = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;
  void add(double a, double b) {
    n += 1;
    x += a;
    y += b;
    xx += a * a;
    yy += b * b;
    xy += a * b;
  }
  void add(const PairSums& other) {
    n += other.n;
    x += other.x;
    y += other.y;
    xx += other.xx;
    yy += other.yy;
    xy += other.xy;
  }
  /// True if the values vary and are uncorrelated beyond doubt.
  [[nodiscard]] bool unrelated() const {
    if (n < 1) return false;
    const double of_x = xx - x * x / n;
    const double of_y = yy - y * y / n;
    if (!(of_x > n && of_y > n)) return false;  // A deviation of 1 grey at least.
    const double correlation = (xy - x * y / n) / std::sqrt(of_x * of_y);
    return correlation + 2 / std::sqrt(n / kPairsPerIndependent) < kLeastCorrelation;
  }
};

/// Pairs of lines kLinesApart at one depth, less the mean of each cell over the images: a pattern
/// that all images share, as from an uneven gain, says nothing.
PairSums line_pairs(const std::vector<CellGreys>& greys, std::size_t first, std::size_t lines) {
  std::vector<float> means(lines, 0);
  for (std::size_t line = 0; line < lines; ++line) {
    for (const CellGreys& image : greys) means[line] += image[first + line];
    means[line] /= static_cast<float>(greys.size());
  }
  PairSums sums;
  for (const CellGreys& image : greys) {
    for (std::size_t line = 0; line + kLinesApart < lines; ++line) {
      const float one = image[first + line];
      const float other = image[first + line + kLinesApart];
      if (one >= 0 && other >= 0) sums.add(one - means[line], other - means[line + kLinesApart]);
    }
  }
  return sums;
}

}  // namespace

CellGreys calm(const CellGreys& greys, CellCount count) {
  const auto lines = as_size(count.lines);
  const auto depths = as_size(count.depths);
  CellGreys down(greys.size(), 0), cells(greys.size(), 0);
  for (std::size_t depth = 0; depth < depths; ++depth) {
    const std::size_t from = depth - std::min<std::size_t>(depth, kDeepHalf);
    const std::size_t to = std::min(depth + kDeepHalf, depths - 1);
    for (std::size_t near = from; near <= to; ++near) {
      for (std::size_t line = 0; line < lines; ++line) {
        const float grey = greys[near * lines + line];
        const bool any = grey >= 0;
        down[depth * lines + line] += any ? grey : 0;
        cells[depth * lines + line] += any ? 1.0f : 0.0f;
      }
    }
  }
  CellGreys out(greys.size(), -1);
  for (std::size_t depth = 0; depth < depths; ++depth) {
    for (std::size_t line = 0; line < lines; ++line) {
      const std::size_t cell = depth * lines + line;
      if (greys[cell] < 0) continue;
      float sum = 0;
      float number = 0;
      const std::size_t from = line - std::min<std::size_t>(line, kLineHalf);
      const std::size_t to = std::min(line + kLineHalf, lines - 1);
      for (std::size_t near = from; near <= to; ++near) {
        sum += down[depth * lines + near];
        number += cells[depth * lines + near];
      }
      out[cell] = sum / number;
    }
  }
  return out;
}

NoiseFloor noise_floor(const std::vector<CellGreys>& greys, const std::vector<CellGreys>& calmed,
                       CellCount count) {
  const auto lines = as_size(count.lines);
  const auto depths = as_size(count.depths);
  NoiseFloor floor{count.depths, std::vector<float>(depths, 0)};
  if (lines == 0 || depths == 0 || greys.empty()) return floor;

  // Noise alone, from the deepest rows upwards.
  std::vector<PairSums> pairs;
  for (std::size_t depth = 0; depth < depths; ++depth) {
    pairs.push_back(line_pairs(calmed, depth * lines, lines));
  }
  for (int depth = count.depths - 1; depth >= 0; --depth) {
    PairSums about;
    for (int near = std::max(depth - kDeepHalf, 0);
         near <= std::min(depth + kDeepHalf, count.depths - 1); ++near) {
      about.add(pairs[as_size(near)]);
    }
    if (!about.unrelated()) break;
    floor.noise_from = depth;
  }

  std::vector<float> darkest(depths, 255), usual(depths, 0);
  float least = 255;
  for (std::size_t depth = depths; depth-- > 0;) {
    const GreyHistogram histogram = greys_at(calmed, depth, lines);
    least = std::min(least, static_cast<float>(histogram.quantile(kDarkest).value_or(255)));
    darkest[depth] = least;
    usual[depth] = static_cast<float>(histogram.quantile(kUsual).value_or(0));
  }
  for (std::size_t depth = 0; depth < depths; ++depth) {
    // Spread of single cells about their surroundings, where these are as dark as noise.
    double squares = 0;
    double cells = 0;
    const float dark = darkest[depth] + kLeastMargin;
    for (std::size_t f = 0; f < greys.size(); ++f) {
      for (std::size_t cell = depth * lines; cell < (depth + 1) * lines; ++cell) {
        if (greys[f][cell] < 0 || calmed[f][cell] > dark) continue;
        squares += std::pow(greys[f][cell] - calmed[f][cell], 2);
        ++cells;
      }
    }
    const float spread = cells > 0 ? static_cast<float>(std::sqrt(squares / cells)) : 0;
    const float margin = std::max(kDeviations * spread / kCalming, kLeastMargin);
    if (usual[depth] >= darkest[depth] + kClearMargins * margin) {
      floor.least_echo[depth] = darkest[depth] + margin;
    }
  }
  return floor;
}

}  // namespace nav::registration
