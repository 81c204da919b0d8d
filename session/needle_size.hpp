// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace nav::session {

/// Of a straight needle, as it is drawn and as distances from its surface count.
struct NeedleSize {
  double length_mm = 150;    ///< Hub to tip, [1, 1000].
  double diameter_mm = 1.8;  ///< Of its shaft, [0.1, 20].
};

}  // namespace nav::session
