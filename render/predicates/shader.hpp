// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "render/predicates/set.hpp"

namespace nav::render {

/// What classes of samples are numbered by, so that how they look is a table of 2^n entries.
enum class PredicateClasses {
  kLeaves,   ///< The leaves that are true: at most kMostTabulated.
  kEntries,  ///< The entries that are true: at most kMostTabulated.
  kNone,     ///< More of both: Eqs. 6 to 8 for every sample.
};
PredicateClasses classes_of(const PredicateSet& set);

/// Where a feature is on the device.
struct PredicateTexel {
  int texture;    ///< Of predicate_leaves().
  int component;  ///< 0 to 3.
};

/// The building blocks of a set in GLSL 4.1 (§5.1), put together to
///   uint predicate_leaves(vec4 texels[N], float volume, uint undefined, uint labels, vec3
///   position)
/// with a bit for each leaf that is true, and
///   uint predicate_class(uint leaves)
/// the leaves themselves or, unless classes_of() says kLeaves, a bit for each true entry.
/// texels: of the channels but the first, which is the volume; N: textures, at least 1. volume and
/// texels in codes. undefined: bits of undefined channels, compared with uniforms
/// leaf<i>_undefined. position in grid mm. The text depends on the kinds of leaves, on where their
/// features are and, without kLeaves, on how they combine: on no parameter.
std::string predicate_shader(const PredicateSet& set, const std::vector<PredicateTexel>& texels);
/// The same with texel i holding channel i + 1 alone, and instead of predicate_class()
///   uint predicate_entries(uint leaves)
/// with a bit for each true entry.
std::string plain_predicate_shader(const PredicateSet& set);

/// What to set before drawing: numbers by the names of uniforms, and masks by theirs.
struct PredicateUniforms {
  std::vector<PredicateGlsl::Uniform> values;
  std::vector<std::pair<std::string, std::uint32_t>> masks;
};
/// Ranges are widened by half a quantum, as everywhere, and given in codes with a little more for
/// the rounding of single precision.
PredicateUniforms predicate_uniforms(const PredicateSet& set);

}  // namespace nav::render
