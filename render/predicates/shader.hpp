// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "render/predicates/set.hpp"

namespace nav::render {

/// The building blocks of a set in GLSL 4.1 (§5.1), put together to one function
///   uint predicate_mask(float values[N], bool defined[N], uint labels, vec3 position)
/// with a bit for each true entry. N: PREDICATE_CHANNELS, in the order of the set's channels(),
/// values as these define them; position in grid mm. Pure text, no context is needed.
std::string predicate_shader(const PredicateSet& set);

/// What to set before drawing: numbers by the names of uniforms, and masks by theirs.
struct PredicateUniforms {
  std::vector<PredicateGlsl::Uniform> values;
  std::vector<std::pair<std::string, std::uint32_t>> masks;
};
/// Ranges are widened by half a quantum, as everywhere.
PredicateUniforms predicate_uniforms(const PredicateSet& set);

}  // namespace nav::render
