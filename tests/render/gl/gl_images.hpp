// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <string>

#include "nav/image.hpp"

namespace nav::test {

/// Writes a PNG into the folder named by SONDE_PICTURES, if it is set, for a person to view.
void keep_image(const std::string& name, const Image2d<Rgba8>& pixels);

/// Limit for the renderer. Beyond it, a difference from the reference is visible.
inline constexpr double kAgreement255 = 2.0;

/// Difference of two images of equal size, in 1/255 of a channel.
struct ImageDifference {
  int max = 0;
  double fraction_above = 0;  ///< Share of the pixels with a channel above the limit.
};
ImageDifference difference(const Image2d<Rgba8>& a, const Image2d<Rgba8>& b, int limit);
/// The difference in single precision, before rounding to 8 bits.
ImageDifference difference(const Image2d<RgbaF>& a, const Image2d<RgbaF>& b, double limit_255);

/// Succeeds if at least 99.9 % of the pixels differ by at most limit/255 in every channel.
::testing::AssertionResult agree(const Image2d<RgbaF>& actual, const Image2d<RgbaF>& expected,
                                 double limit_255);

}  // namespace nav::test
