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

/// A set of predicates as a table for shaders/include/predicate_generic.glsl. Internal to render/.
struct GlPredicateRows {
  using Texel = std::array<std::uint32_t, 4>;
  std::vector<Texel> texels;  ///< Of the leaves, then the tokens.
  int leaves = 0;
  int tokens = 0;  ///< 0: classes are leaves.
};

/// The bits of a word that are kept, next to each other, lowest first.
std::uint32_t packed_bits(std::uint32_t word, std::uint32_t kept);

/// label_bits: those that the label texture keeps, packed_bits().
/// undefined: for each leaf the bits of the features that it needs defined. Absent when expressions
/// are nested deeper than the table can say: 32 operands that wait.
std::optional<GlPredicateRows> predicate_rows(const PredicateSet& set,
                                              const GlFeatureTextures& features,
                                              const std::vector<std::uint32_t>& undefined,
                                              std::uint32_t label_bits);

}  // namespace nav::render
