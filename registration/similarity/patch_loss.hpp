// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace nav::registration {

/// Contribution of a patch's term s in [0, 1] (Black and Rangarajan 1996): a patch that the CT
/// explains badly pulls less than one that it explains well. All losses are 0 at 0 and 1 at 1.
enum class PatchLoss {
  kNone,  ///< s: every patch pulls equally.
  /// log(1 + s/c) / log(1 + 1/c): for small c the likelihood of noise that differs between patches.
  kCauchy,
  kGemanMcClure,  ///< s (1 + c) / (s + c).
};

/// Stable lower-case name: "none", "cauchy", "geman-mcclure".
const char* to_string(PatchLoss loss);

/// A loss with its scale c.
struct RobustLoss {
  PatchLoss kind = PatchLoss::kNone;
  double scale = 0.3;  ///< [0.001, 1000]; the smaller, the less badly explained patches pull.

  [[nodiscard]] double value(double s) const;       ///< [0, 1].
  [[nodiscard]] double derivative(double s) const;  ///< > 0, falling.
};

}  // namespace nav::registration
