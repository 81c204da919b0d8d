// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/gl/gl_predicate_rows.hpp"

#include <algorithm>
#include <bit>

#include "nav/check.hpp"
#include "render/predicates/shader.hpp"

namespace nav::render {
namespace {

using Texel = GlPredicateRows::Texel;
using Kind = PredicateForm::Kind;
using Op = PredicateProgram::Op;

// These numbers are used in predicate_generic.glsl.
static_assert(int(Kind::kRange) == 0 && int(Kind::kWedge) == 1 && int(Kind::kBits) == 2 &&
              int(Kind::kSegment) == 3 && int(Kind::kSlab) == 4);
static_assert(int(Op::kLeaf) == 0 && int(Op::kEntry) == 1 && int(Op::kNot) == 2 &&
              int(Op::kAnd) == 3 && int(Op::kOr) == 4);
constexpr std::uint32_t kResult = 5;

std::uint32_t bits_of(double number) {
  return std::bit_cast<std::uint32_t>(static_cast<float>(number));
}

Texel numbers(const std::vector<double>& values) {
  Texel texel{};
  for (std::size_t i = 0; i < values.size(); ++i) texel[i] = bits_of(values[i]);
  return texel;
}

/// The uniforms that the shader text of the set would have for a leaf.
class LeafUniforms {
 public:
  explicit LeafUniforms(const PredicateSet& set) : all_(predicate_uniforms(set)) {}
  [[nodiscard]] const std::vector<double>& of(std::size_t leaf, const char* name) const {
    const std::string wanted = "leaf" + std::to_string(leaf) + "_" + name;
    const auto found = std::find_if(all_.values.begin(), all_.values.end(),
                                    [&](const auto& uniform) { return uniform.name == wanted; });
    NAV_CHECK(found != all_.values.end(), wanted);
    return found->value;
  }

 private:
  PredicateUniforms all_;
};

/// Appends the texels after the first.
void append_numbers(const PredicateForm& form, std::size_t leaf, const LeafUniforms& uniforms,
                    const Texel& scales, std::vector<Texel>& texels) {
  Texel limits{form.mask, 0, 0, 0};
  std::array<Texel, 3> rest{};
  const bool ranged =
      form.kind == Kind::kRange || form.kind == Kind::kSegment || form.kind == Kind::kSlab;
  if (ranged) {
    const auto& range = uniforms.of(leaf, "range");
    limits[2] = bits_of(range[0]);
    limits[3] = bits_of(range[1]);
  }
  if (form.kind == Kind::kWedge) {
    std::vector<double> limits_of_forms = uniforms.of(leaf, "slack");
    limits_of_forms.push_back(uniforms.of(leaf, "least").front());
    rest = {numbers(uniforms.of(leaf, "wedge")), numbers(limits_of_forms),
            numbers(uniforms.of(leaf, "side"))};
  } else if (form.kind == Kind::kSegment) {
    rest = {numbers(uniforms.of(leaf, "a")), numbers(uniforms.of(leaf, "axis")),
            numbers(uniforms.of(leaf, "foot"))};
  } else if (form.kind == Kind::kSlab) {
    rest[1] = numbers(uniforms.of(leaf, "normal"));
  }
  texels.push_back(limits);
  texels.insert(texels.end(), rest.begin(), rest.end());
  texels.push_back(scales);
}

void append_leaf(const PredicateSet& set, std::size_t i, const GlFeatureTextures& features,
                 std::uint32_t undefined, std::uint32_t label_bits, const LeafUniforms& uniforms,
                 std::vector<Texel>& texels) {
  const PredicateSet::Leaf& leaf = set.leaves()[i];
  PredicateForm form = leaf.kind->form(set.place(), leaf.values);
  form.mask = packed_bits(form.mask, label_bits);
  Texel head{static_cast<std::uint32_t>(form.kind), 0, 0, undefined};
  Texel scales{};
  for (std::size_t c = 0; c < leaf.channels.size(); ++c) {
    const auto channel = static_cast<std::size_t>(leaf.channels[c]);
    if (channel > 0) {
      const auto slot = features.slot(channel);
      head[1 + c] = static_cast<std::uint32_t>(1 + GlFeatureTextures::kChannels * slot.texture +
                                               static_cast<std::size_t>(slot.component));
    }
    scales[2 * c] = bits_of(set.channels()[channel].offset);
    scales[2 * c + 1] = bits_of(set.channels()[channel].scale);
  }
  texels.push_back(head);
  append_numbers(form, i, uniforms, scales, texels);
}

/// Returns false if the expression is deeper than the bits of the stack.
bool append_tokens(const PredicateSet& set, GlPredicateRows& rows) {
  for (const PredicateProgram& program : set.programs()) {
    int depth = 0;
    for (const PredicateProgram::Token token : program.tokens) {
      if (token.op == Op::kLeaf || token.op == Op::kEntry) ++depth;
      if (token.op == Op::kAnd || token.op == Op::kOr) --depth;
      if (depth > 32) return false;
      rows.texels.push_back({static_cast<std::uint32_t>(token.op), token.index, 0, 0});
    }
    rows.texels.push_back({kResult, static_cast<std::uint32_t>(program.entry), 0, 0});
    rows.tokens += static_cast<int>(program.tokens.size()) + 1;
  }
  return true;
}

}  // namespace

std::uint32_t packed_bits(std::uint32_t word, std::uint32_t kept) {
  std::uint32_t packed = 0;
  for (std::uint32_t to = 1; kept != 0; kept &= kept - 1, to <<= 1U) {
    if ((word & kept & (~kept + 1)) != 0) packed |= to;
  }
  return packed;
}

std::optional<GlPredicateRows> predicate_rows(const PredicateSet& set,
                                              const GlFeatureTextures& features,
                                              const std::vector<std::uint32_t>& undefined,
                                              std::uint32_t label_bits) {
  GlPredicateRows rows;
  rows.leaves = static_cast<int>(set.leaves().size());
  const LeafUniforms uniforms(set);
  for (std::size_t i = 0; i < set.leaves().size(); ++i) {
    append_leaf(set, i, features, undefined[i], label_bits, uniforms, rows.texels);
  }
  if (classes_of(set) == PredicateClasses::kLeaves) return rows;
  if (!append_tokens(set, rows)) return std::nullopt;
  return rows;
}

}  // namespace nav::render
