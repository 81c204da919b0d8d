// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "render/cpu/predicate_march.hpp"
#include "render/predicates/predicate_sampler.hpp"

namespace nav::render {

/// Of cells of a length, > 0. Absent for cells so long beside the opacity's length that
/// polynomials would be off by more than 1e-3: nearly all brightness is opaque there, and what is
/// not rises too fast.
std::optional<OpacityPieces> opacity_pieces(const IntensityOpacity& extinction, double step_mm);

}  // namespace nav::render
