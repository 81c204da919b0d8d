// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "render/cpu/predicate_march.hpp"
#include "render/predicates/predicate_sampler.hpp"

namespace nav::render {

/// OpacityPieces for cells of a length > 0. No value if the cells are so long compared with the
/// opacity's length that polynomials would have an error above 1e-3. Then nearly all intensities
/// are opaque, and the opacity of the others rises too fast.
std::optional<OpacityPieces> opacity_pieces(const IntensityOpacity& extinction, double step_mm);

}  // namespace nav::render
