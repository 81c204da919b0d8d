// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace nav {

/// Median of the values: the mean of the middle two for an even number, NaN for none.
double median(std::vector<double> values);

}  // namespace nav
