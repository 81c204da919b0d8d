// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "registration/twist.hpp"

namespace nav::registration {

/// Twists [rotation rad | translation mm] that fill the box [−range, range]⁶ evenly: Halton points
/// (bases 2, 3, 5, 7, 11, 13) shifted by the seed modulo 1 (Cranley and Patterson 1976). The same
/// seed gives the same bits on every machine.
std::vector<Vector6d> spread_twists(int count, double range_rad, double range_mm,
                                    std::uint64_t seed);

}  // namespace nav::registration
