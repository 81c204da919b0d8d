// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "render/gl/gl_feature_textures.hpp"
#include "render/predicates/set.hpp"

namespace nav::render {

/// A predicate set as a table for shaders/include/predicate_generic.glsl. Internal to render/.
struct GlPredicateRows {
  using Texel = std::array<std::uint32_t, 4>;
  std::vector<Texel> texels;  ///< Texels of the leaves, then of the tokens.
  int leaves = 0;
  int tokens = 0;  ///< 0: each class is a leaf.
};

/// Packs the kept bits of a word next to each other, lowest first.
std::uint32_t packed_bits(std::uint32_t word, std::uint32_t kept);

/// Builds the table. undefined: for each leaf the bits of the features that must be defined.
/// label_bits: the bits that the label texture keeps, see packed_bits(). Returns nothing if
/// expressions are nested deeper than the table can represent: 32 waiting operands.
std::optional<GlPredicateRows> predicate_rows(const PredicateSet& set,
                                              const GlFeatureTextures& features,
                                              const std::vector<std::uint32_t>& undefined,
                                              std::uint32_t label_bits);

}  // namespace nav::render
