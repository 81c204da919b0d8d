// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace nav::bench {

/// One picture: how wrong and how dear.
struct CurvePoint {
  double rms;     ///< > 0.
  double time_s;  ///< > 0.
};

/// Run time against error of one renderer in one scene: its pictures that no other of its own beats
/// in both, joined by straight lines in the logarithms.
class ErrorCurve {
 public:
  explicit ErrorCurve(std::vector<CurvePoint> points);

  /// Points that no other beats, from the coarsest (largest rms) to the finest.
  [[nodiscard]] const std::vector<CurvePoint>& front() const { return front_; }
  /// Time at which an error of rms is reached. Never extrapolates: an error above the coarsest
  /// point's costs what that point costs; below the finest point's it is NaN, not reached.
  [[nodiscard]] double time_at(double rms) const;
  /// rms lies between the finest point and the coarsest.
  [[nodiscard]] bool spans(double rms) const;

 private:
  std::vector<CurvePoint> front_;
};

/// Ours against theirs at one error.
struct ErrorLevelRatio {
  double rms;
  double ratio;  ///< Their time over ours; NaN: we do not reach the error.
};

/// At the error of each point of their front, and at each level that their curve spans.
std::vector<ErrorLevelRatio> equal_error_ratios(const ErrorCurve& ours, const ErrorCurve& theirs,
                                                const std::vector<double>& levels);

/// Errors that a physician may see and a benchmark asks for, rms.
struct ErrorRange {
  double finest = 2e-3;
  double coarsest = 2e-2;
};

/// The least within a range, of all when none lies there; 0 stands for an error that we do not
/// reach; NaN for none.
double worst(const std::vector<ErrorLevelRatio>& ratios, const ErrorRange& range = {});

}  // namespace nav::bench
