// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "io/plus_config.hpp"
#include "nav/diagnostics.hpp"

namespace nav::io {

/// Contradictions of a configuration, before a recording is read with it: transforms that
/// contradict each other, that are not rigid or in another unit, and a calibration of the probe
/// that is a placeholder, cannot be used, or has pixels of another size than ScanConversion. Empty:
/// nothing.
std::vector<Finding> findings_of(const PlusConfig& config);

}  // namespace nav::io
