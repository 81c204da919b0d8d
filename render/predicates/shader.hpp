// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "render/predicates/set.hpp"

namespace nav::render {

/// The conditions that number the classes of samples, so that their appearance is a table of 2^n
/// entries.
enum class PredicateClasses {
  kLeaves,   ///< The true leaves: at most kMostTabulated leaves.
  kEntries,  ///< The true entries: at most kMostTabulated entries.
  kNone,  ///< No table, because there are more of both: Eqs. 6 to 8 are evaluated for every sample.
};
PredicateClasses classes_of(const PredicateSet& set);

/// Position of a feature in the device's textures.
struct PredicateTexel {
  int texture;    ///< Index into texels of predicate_leaves().
  int component;  ///< 0 to 3.
};

/// The GLSL 4.1 building blocks of a set (§5.1), combined to
///   uint predicate_leaves(vec4 texels[N], float volume, uint undefined, uint labels, vec3
///   position)
/// with a bit for each true leaf, and
///   uint predicate_class(uint leaves)
/// which returns the leaves themselves if classes_of() is kLeaves, or otherwise a bit for each true
/// entry. \p texels: one for each channel except the first, which is the volume. N: number of
/// textures, at least 1. volume and texels are in codes. undefined: bits of undefined channels,
/// compared with the uniforms leaf<i>_undefined. position: grid mm. The text depends on the kinds
/// of leaves, on the positions of their features and, without kLeaves, on their combinations. It
/// depends on no parameter.
std::string predicate_shader(const PredicateSet& set, const std::vector<PredicateTexel>& texels);
/// Makes the same functions, except that texel i holds only channel i + 1, and predicate_class() is
/// replaced by
///   uint predicate_entries(uint leaves)
/// with a bit for each true entry.
std::string plain_predicate_shader(const PredicateSet& set);

/// Values to set before drawing: numbers and masks, each by the name of its uniform.
struct PredicateUniforms {
  std::vector<PredicateGlsl::Uniform> values;
  std::vector<std::pair<std::string, std::uint32_t>> masks;
};
/// Values of the uniforms. Ranges are widened by half a quantum, as everywhere, converted to codes,
/// and widened a little more for the rounding of single precision.
PredicateUniforms predicate_uniforms(const PredicateSet& set);

}  // namespace nav::render
