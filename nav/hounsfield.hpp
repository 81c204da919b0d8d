// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/volume.hpp"

namespace nav {

/// Values below this are air or lung, whatever the scanner's noise. HU.
inline constexpr int kLeastTissueHu = -200;

/// True if the values seem to be Hounsfield units: at least 1 % of them are air or lung. CT has
/// air, lung or gas in every body; MR and ultrasound have no such values.
bool is_hounsfield(const StoredVolume& volume);

}  // namespace nav
