// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace nav::session {

/// Size of a straight needle, for drawing it and for distances from its surface.
struct NeedleSize {
  double length_mm = 150;    ///< Hub to tip, [1, 1000].
  double diameter_mm = 1.8;  ///< Shaft, [0.1, 20].
};

}  // namespace nav::session
