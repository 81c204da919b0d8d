// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace nav::bench {

/// Error and time of one rendered image.
struct CurvePoint {
  double rms;     ///< > 0.
  double time_s;  ///< > 0.
};

/// Run time against error of one renderer in one scene: its images that none of its others beats in
/// both, joined by straight lines in the logarithms.
class ErrorCurve {
 public:
  explicit ErrorCurve(std::vector<CurvePoint> points);

  /// Points that no other point beats, from the coarsest (largest rms) to the finest.
  [[nodiscard]] const std::vector<CurvePoint>& front() const { return front_; }
  /// Time to reach an error of rms. Never extrapolates: an error above that of the coarsest point
  /// costs as much as that point; an error below that of the finest point is not reached, NaN.
  [[nodiscard]] double time_at(double rms) const;
  /// True if rms lies between the finest point and the coarsest.
  [[nodiscard]] bool spans(double rms) const;

 private:
  std::vector<CurvePoint> front_;
};

/// Ratio of our time to theirs at one error.
struct ErrorLevelRatio {
  double rms;
  double ratio;  ///< Their time over ours; NaN: we do not reach the error.
};

/// Ratios at the error of each point of their front, and at each level that their curve spans.
std::vector<ErrorLevelRatio> equal_error_ratios(const ErrorCurve& ours, const ErrorCurve& theirs,
                                                const std::vector<double>& levels);

/// Range of errors that is visible to a physician and that a benchmark requests, rms.
struct ErrorRange {
  double finest = 2e-3;
  double coarsest = 2e-2;
};

/// The smallest ratio within a range, or of all if none lies in it. 0 means that we do not reach an
/// error; NaN means that there are no ratios.
double worst(const std::vector<ErrorLevelRatio>& ratios, const ErrorRange& range = {});

}  // namespace nav::bench
