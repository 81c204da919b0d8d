// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/error_curve.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace nav::bench {

ErrorCurve::ErrorCurve(std::vector<CurvePoint> points) {
  std::erase_if(points, [](const CurvePoint& p) { return !(p.rms > 0 && p.time_s > 0); });
  std::sort(points.begin(), points.end(), [](const CurvePoint& a, const CurvePoint& b) {
    return a.time_s != b.time_s ? a.time_s < b.time_s : a.rms < b.rms;
  });
  for (const CurvePoint& point : points) {
    if (front_.empty() || point.rms < front_.back().rms) front_.push_back(point);
  }
}

double ErrorCurve::time_at(double rms) const {
  if (front_.empty() || rms < front_.back().rms) return std::numeric_limits<double>::quiet_NaN();
  if (rms >= front_.front().rms) return front_.front().time_s;
  std::size_t i = 1;
  while (front_[i].rms > rms) ++i;
  const CurvePoint& a = front_[i - 1];
  const CurvePoint& b = front_[i];
  const double w = std::log(a.rms / rms) / std::log(a.rms / b.rms);
  return a.time_s * std::pow(b.time_s / a.time_s, w);
}

bool ErrorCurve::spans(double rms) const {
  return !front_.empty() && rms <= front_.front().rms && rms >= front_.back().rms;
}

std::vector<ErrorLevelRatio> equal_error_ratios(const ErrorCurve& ours, const ErrorCurve& theirs,
                                                const std::vector<double>& levels) {
  std::vector<ErrorLevelRatio> ratios;
  for (const CurvePoint& point : theirs.front()) {
    ratios.push_back({point.rms, point.time_s / ours.time_at(point.rms)});
  }
  for (const double level : levels) {
    if (!theirs.spans(level)) continue;
    ratios.push_back({level, theirs.time_at(level) / ours.time_at(level)});
  }
  return ratios;
}

double worst(const std::vector<ErrorLevelRatio>& ratios, const ErrorRange& range) {
  const auto within = [&](const ErrorLevelRatio& one) {
    return one.rms >= range.finest && one.rms <= range.coarsest;
  };
  const bool some = std::any_of(ratios.begin(), ratios.end(), within);
  double least = std::numeric_limits<double>::quiet_NaN();
  for (const ErrorLevelRatio& one : ratios) {
    if (some && !within(one)) continue;
    const double ratio = std::isnan(one.ratio) ? 0 : one.ratio;
    if (!(least <= ratio)) least = ratio;
  }
  return least;
}

}  // namespace nav::bench
