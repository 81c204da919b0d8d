// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/shader.hpp"

namespace nav::render {
namespace {

using Op = PredicateProgram::Op;

std::string prefix_of(std::size_t leaf) { return "leaf" + std::to_string(leaf); }

PredicateGlsl block_of(const PredicateSet& set, std::size_t i) {
  const PredicateSet::Leaf& leaf = set.leaves()[i];
  return leaf.kind->glsl(prefix_of(i), set.place(), leaf.values);
}

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
}

/// The closed expression with what its words stand for; false where a channel is undefined.
std::string expression_of(const PredicateSet& set, std::size_t i) {
  std::string text = block_of(set, i).expression;
  std::string defined;
  const auto& channels = set.leaves()[i].channels;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const std::string index = '[' + std::to_string(channels[c]) + ']';
    replace_all(text, "VALUE" + std::to_string(c), "values" + index);
    defined += "defined" + index + " && ";
  }
  replace_all(text, "LABELS", "labels");
  replace_all(text, "POSITION", "position");
  return defined + text;
}

std::string formula_of(const PredicateProgram& program) {
  std::vector<std::string> stack;
  for (const PredicateProgram::Token token : program.tokens) {
    if (token.op == Op::kLeaf) {
      stack.push_back(prefix_of(token.index));
    } else if (token.op == Op::kEntry) {
      stack.push_back("entry" + std::to_string(token.index));
    } else if (token.op == Op::kNot) {
      stack.back() = "!" + stack.back();
    } else {
      const std::string right = std::move(stack.back());
      stack.pop_back();
      const std::string op = token.op == Op::kAnd ? " && " : " || ";
      stack.back() = '(' + stack.back() + op + right + ')';
    }
  }
  return stack.front();
}

/// A range over codes covers half a quantum more on either side.
void widen(const PredicateSet& set, const PredicateSet::Leaf& leaf,
           PredicateGlsl::Uniform& uniform) {
  if (leaf.channels.size() != 1 || uniform.value.size() != 2) return;
  const double slack = 0.5 * set.channels()[static_cast<std::size_t>(leaf.channels[0])].quantum;
  uniform.value[0] -= slack;
  uniform.value[1] += slack;
}

}  // namespace

std::string predicate_shader(const PredicateSet& set) {
  std::string text = "#define PREDICATE_CHANNELS " + std::to_string(set.channels().size()) + '\n';
  for (std::size_t i = 0; i < set.leaves().size(); ++i) text += block_of(set, i).header;
  text +=
      "uint predicate_mask(float values[PREDICATE_CHANNELS], bool defined[PREDICATE_CHANNELS], "
      "uint labels,\n                    vec3 position) {\n";
  for (std::size_t i = 0; i < set.leaves().size(); ++i) {
    text += "  bool " + prefix_of(i) + " = " + expression_of(set, i) + ";\n";
  }
  for (const PredicateProgram& program : set.programs()) {
    text += "  bool entry" + std::to_string(program.entry) + " = " + formula_of(program) + ";\n";
  }
  text += "  uint mask = 0u;\n";
  for (std::size_t j = 0; j < set.size(); ++j) {
    text += "  if (entry" + std::to_string(j) + ") mask |= " + std::to_string(1U << j) + "u;\n";
  }
  return text + "  return mask;\n}\n";
}

PredicateUniforms predicate_uniforms(const PredicateSet& set) {
  PredicateUniforms out;
  for (std::size_t i = 0; i < set.leaves().size(); ++i) {
    PredicateGlsl block = block_of(set, i);
    for (PredicateGlsl::Uniform& uniform : block.uniforms) {
      widen(set, set.leaves()[i], uniform);
      out.values.push_back(std::move(uniform));
    }
    if (block.mask != 0) out.masks.emplace_back(prefix_of(i) + "_mask", block.mask);
  }
  return out;
}

}  // namespace nav::render
