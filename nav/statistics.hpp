// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace nav {

/// Median of the values: the mean of the middle two for an even number, NaN for none.
double median(std::vector<double> values);
/// Value below which a fraction q of the values lies (nearest rank); NaN for no values. q is
/// limited to [0, 1].
double quantile(std::vector<double> values, double q);

}  // namespace nav
