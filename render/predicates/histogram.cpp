// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/histogram.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>

#include "nav/check.hpp"

namespace nav::render {
namespace {

double hue_in_turn(double hue_deg) {
  const double h = std::fmod(hue_deg, 360);
  const double positive = h < 0 ? h + 360 : h;
  return positive < 360 ? positive : 0;  // -1e-20 + 360 rounds to 360.
}

Error rejected_bar(std::size_t bar, const std::string& expected, double found) {
  std::ostringstream text;
  text << "predicate " << bar << ": expected " << expected << ", found " << found;
  return {ErrorCode::kMalformedData, text.str()};
}

double sum_of(const std::vector<PredicateHistogram::Bar>& bars) {
  double sum = 0;
  for (const auto& bar : bars) sum += bar.importance;
  return sum;
}

}  // namespace

bool operator==(const PredicateHistogram::Bar& a, const PredicateHistogram::Bar& b) {
  return std::tie(a.importance, a.hue_deg, a.saturation) ==
         std::tie(b.importance, b.hue_deg, b.saturation);
}

Result<PredicateHistogram> PredicateHistogram::create(std::vector<Bar> bars) {
  if (bars.size() > kMostPredicates) {
    return Error{ErrorCode::kMalformedData, "predicates: expected at most " +
                                                std::to_string(kMostPredicates) + ", found " +
                                                std::to_string(bars.size())};
  }
  for (std::size_t i = 0; i < bars.size(); ++i) {
    constexpr double kMost = 1e100;
    if (!(bars[i].importance >= 0 && bars[i].importance <= kMost)) {
      return rejected_bar(i, "an importance >= 0, at most 1e100", bars[i].importance);
    }
    if (!std::isfinite(bars[i].hue_deg))
      return rejected_bar(i, "a hue in degrees", bars[i].hue_deg);
    if (!(bars[i].saturation >= 0 && bars[i].saturation <= 1)) {
      return rejected_bar(i, "a saturation in [0, 1]", bars[i].saturation);
    }
    bars[i].hue_deg = hue_in_turn(bars[i].hue_deg);
  }
  if (!bars.empty() && !(sum_of(bars) > 0)) {
    return Error{ErrorCode::kMalformedData,
                 "predicates: expected an importance above 0, found 0 for every predicate"};
  }
  PredicateHistogram out;
  out.bars_ = std::move(bars);
  // Importances that already sum to 1 stay unchanged, so that files return what was written.
  const double sum = sum_of(out.bars_);
  if (!(sum <= 1 && sum > 1 - 0.1 * kSumTolerance)) out.normalise();
  return out;
}

void PredicateHistogram::drag(std::size_t bar, double importance) {
  NAV_CHECK(bar < size(), bar, size());
  if (size() == 1 || std::isnan(importance)) return;
  const double to = std::clamp(importance, 0.0, 1.0);
  bars_[bar].importance = 0;
  const double others = sum_of(bars_);
  const double share = (1 - to) / static_cast<double>(size() - 1);
  for (std::size_t i = 0; i < size(); ++i) {
    // Divides first, because `others` may be as small as the least number.
    if (i != bar) {
      bars_[i].importance = others > 0 ? bars_[i].importance / others * (1 - to) : share;
    }
  }
  bars_[bar].importance = to;
  normalise();
}

void PredicateHistogram::set_colour(std::size_t bar, double hue_deg, double saturation) {
  NAV_CHECK(bar < size() && std::isfinite(hue_deg), bar, size(), hue_deg);
  bars_[bar].hue_deg = hue_in_turn(hue_deg);
  bars_[bar].saturation = std::clamp(saturation, 0.0, 1.0);
}

void PredicateHistogram::add(double hue_deg, double saturation) {
  NAV_CHECK(size() < kMostPredicates, size());
  const double mean = bars_.empty() ? 1 : 1 / static_cast<double>(size());
  bars_.push_back({mean, 0, 0});
  set_colour(size() - 1, hue_deg, saturation);
  normalise();
}

void PredicateHistogram::remove(std::size_t bar) {
  NAV_CHECK(bar < size(), bar, size());
  bars_.erase(bars_.begin() + static_cast<std::ptrdiff_t>(bar));
  normalise();
}

void PredicateHistogram::scribble(std::span<const std::uint64_t> shown,
                                  std::span<const std::uint64_t> hidden, double share) {
  NAV_CHECK(shown.size() == size() && hidden.size() == size(), shown.size(), hidden.size());
  NAV_CHECK(share >= 0 && share <= 1, share);
  std::vector<double> change(size());
  double sum = 0;
  double sum_of_sizes = 0;
  for (std::size_t i = 0; i < size(); ++i) {
    change[i] = static_cast<double>(shown[i]) - static_cast<double>(hidden[i]);
    sum += change[i];
    sum_of_sizes += std::abs(change[i]);
  }
  if (!(sum_of_sizes > 0)) return;
  const double mean = sum / static_cast<double>(size());
  for (std::size_t i = 0; i < size(); ++i) {
    bars_[i].importance += share * (change[i] - mean) / sum_of_sizes;
  }
  // Subtracts the missing amount below 0 in equal parts from all positive bars. Each round sets at
  // least one bar to 0.
  for (std::size_t round = 0; round < size(); ++round) {
    double missing = 0;
    std::size_t positive = 0;
    for (Bar& bar : bars_) {
      if (bar.importance < 0) missing -= std::exchange(bar.importance, 0.0);
      if (bar.importance > 0) ++positive;
    }
    if (!(missing > 0) || positive == 0) break;
    for (Bar& bar : bars_) {
      if (bar.importance > 0) bar.importance -= missing / static_cast<double>(positive);
    }
  }
  for (Bar& bar : bars_) bar.importance = std::max(bar.importance, 0.0);
  normalise();
}

void PredicateHistogram::normalise() {
  if (bars_.empty()) return;
  double most = 0;
  for (const Bar& bar : bars_) most = std::max(most, bar.importance);
  // Divides by the greatest first, so that no sum overflows and no quotient vanishes.
  for (Bar& bar : bars_) bar.importance = most > 0 ? bar.importance / most : 1;
  const double sum = sum_of(bars_);
  for (Bar& bar : bars_) bar.importance /= sum;
  NAV_CHECK(std::abs(sum_of(bars_) - 1) < kSumTolerance, sum_of(bars_));
}

}  // namespace nav::render
