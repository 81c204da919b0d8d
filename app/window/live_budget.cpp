// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/live_budget.hpp"

#include <algorithm>

#include "nav/check.hpp"

namespace nav::app {
namespace {

constexpr double kOfNewest = 0.1;  ///< Share of the newest value in a mean.
/// Share of the interval that an image may take; the rest is for images that take longer.
constexpr double kShare = 0.9;
/// Longer intervals are pauses, s.
constexpr double kLongest = 1;

double mean(double before, double newest) { return before + kOfNewest * (newest - before); }

}  // namespace

void LiveBudget::ordered(std::uint64_t number, Timestamp published) {
  const std::optional<Seen> before = last_;
  if (before && number == before->number) return;
  last_ = Seen{number, published};
  // Another session counts anew.
  if (!before || number < before->number) return;
  const double interval_s =
      to_seconds(published - before->published) / static_cast<double>(number - before->number);
  if (interval_s <= 0 || interval_s > kLongest) return;
  interval_s_ = interval_s_ ? mean(*interval_s_, interval_s) : interval_s;
}

void LiveBudget::drawn(double rays_s, double whole_s) {
  NAV_CHECK(rays_s >= 0 && whole_s >= 0, rays_s, whole_s);
  besides_s_ = mean(besides_s_, std::max(0.0, whole_s - rays_s));
}

double LiveBudget::budget_s() const {
  if (!interval_s_) return kFirst;
  return std::clamp(kShare * *interval_s_ - besides_s_, kLeast, kMost);
}

}  // namespace nav::app
