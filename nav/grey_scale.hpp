// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>

namespace nav {

/// Rule by which the 16-bit samples of one recording or stream become 8 bits. It is decided once
/// and kept, so that grey values do not jump from image to image.
struct GreyScale {
  /// Value of 16-bit samples that becomes 255: the smallest 2^n - 1, n >= 8, that is not below the
  /// declared maximum (above 0) or, without it, the largest sample of the first image that is not
  /// black. 0: not decided yet, or 8-bit samples.
  std::uint32_t white = 0;
  std::uint32_t largest = 0;  ///< Largest 16-bit sample so far; those above white become 255.
  bool of_header = false;     ///< White is that of the header.

  /// Takes the largest sample of the next image. \p declared: maximum that a header declares; 0:
  /// none.
  constexpr void see(std::uint32_t sample, std::uint32_t declared = 0) {
    largest = std::max(largest, sample);
    if (white != 0) return;
    of_header = declared > 0;
    if (largest == 0) return;  // A black image decides nothing.
    white = 255;
    while (white < (of_header ? declared : largest)) white = 2 * white + 1;
  }
  /// A sample in 8 bits, rounded; 0 until white is decided.
  [[nodiscard]] constexpr std::uint8_t grey(std::uint32_t sample) const {
    if (white == 0) return 0;
    return static_cast<std::uint8_t>(
        std::min<std::uint64_t>(255, (std::uint64_t{sample} * 255 + white / 2) / white));
  }
};

}  // namespace nav
