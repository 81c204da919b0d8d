// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

namespace nav::registration {

/// Gain of images by a finer model that was not fitted to them: paired differences of their costs.
struct PairedGain {
  double sum = 0, squares = 0;
  int count = 0;

  void add(double gain) {
    sum += gain;
    squares += gain * gain;
    ++count;
  }
  /// Mean over its standard error; needs two or more.
  [[nodiscard]] double sigmas() const {
    const double n = count;
    const double variance = std::max(squares / n - sum * sum / (n * n), 1e-24) * n / (n - 1);
    return sum / n / std::sqrt(variance / n);
  }
};

}  // namespace nav::registration
