// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/shader.hpp"

#include <algorithm>

namespace nav::render {
namespace {

using Op = PredicateProgram::Op;

std::string prefix_of(std::size_t leaf) { return "leaf" + std::to_string(leaf); }

PredicateGlsl block_of(const PredicateSet& set, std::size_t i) {
  const PredicateSet::Leaf& leaf = set.leaves()[i];
  return leaf.kind->glsl(prefix_of(i), set.place(), leaf.values);
}

/// Name of the variable that holds a copy of a uniform: shaders/include/taken_over.glsl.
std::string taken(const std::string& name) { return name + "_taken"; }

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
}

/// The closed expression with its placeholders replaced. A range of one channel is tested in codes,
/// everything else in values.
std::string expression_of(const PredicateSet& set, std::size_t i, bool takes_over) {
  const PredicateGlsl block = block_of(set, i);
  std::string text = block.expression;
  if (takes_over) {
    for (const auto& uniform : block.uniforms) replace_all(text, uniform.name, taken(uniform.name));
  }
  const auto& channels = set.leaves()[i].channels;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    const std::string word =
        (channels.size() == 1 ? "code" : "value") + std::to_string(channels[c]);
    replace_all(text, "VALUE" + std::to_string(c), word);
  }
  replace_all(text, "LABELS", "labels");
  replace_all(text, "POSITION", "position");
  return text;
}

/// Declarations of the channels, which the code that reads them follows.
struct ChannelText {
  std::string uniforms;
  std::string body;
};

ChannelText channels_of(const PredicateSet& set, const std::vector<PredicateTexel>& texels,
                        bool takes_over) {
  ChannelText out;
  for (std::size_t c = 0; c < set.channels().size(); ++c) {
    const std::string index = std::to_string(c);
    std::string code = "volume";
    if (c > 0) {
      const PredicateTexel& at = texels[c - 1];
      code = "texels[" + std::to_string(at.texture) + "]." + "xyzw"[at.component];
    }
    const std::string scale = "channel" + index + "_scale";
    out.uniforms += "uniform vec2 " + scale + ";\n";
    const std::string read = takes_over ? taken(scale) : scale;
    out.body += "  float code" + index + " = " + code + ";\n  float value" + index + " = " + read +
                ".x + " + read + ".y * code" + index + ";\n";
  }
  return out;
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

/// Sets the change that half a quantum causes in the forms of a wedge.
void set_slack(const PredicateSet& set, const PredicateSet::Leaf& leaf,
               PredicateGlsl::Uniform& uniform) {
  const PredicateForm form = leaf.kind->form(set.place(), leaf.values);
  double quantum[2] = {};
  for (std::size_t c = 0; c < leaf.channels.size(); ++c) {
    quantum[c] = set.channels()[static_cast<std::size_t>(leaf.channels[c])].quantum;
  }
  for (std::size_t i = 0; i < 3; ++i) uniform.value[i] = wedge_slack(form.wedge[i], quantum);
}

/// Widens a range of codes on either side by half a quantum and by the rounding of a device.
void widen(const PredicateSet& set, const PredicateSet::Leaf& leaf,
           PredicateGlsl::Uniform& uniform) {
  if (uniform.name.ends_with("_slack")) set_slack(set, leaf, uniform);
  if (leaf.channels.size() != 1 || uniform.value.size() != 2) return;
  const PredicateSet::Channel& channel = set.channels()[static_cast<std::size_t>(leaf.channels[0])];
  constexpr double kRounding = 1.0 / 128;  // Less than what bricks allow for.
  constexpr double kMost = 1e30;
  const double slack = 0.5 * channel.quantum;
  const auto code = [&](double value) {
    return std::clamp((value - channel.offset) / channel.scale, -kMost, kMost);
  };
  uniform.value = {code(uniform.value[0] - slack) - kRounding,
                   code(uniform.value[1] + slack) + kRounding};
}

/// A function that combines leaves to a bit for each entry.
std::string entries_text(const PredicateSet& set, const std::string& name) {
  std::string text = "uint " + name + "(uint leaves) {\n";
  for (std::size_t i = 0; i < set.leaves().size(); ++i) {
    text += "  bool " + prefix_of(i) + " = (leaves & " + std::to_string(1U << i) + "u) != 0u;\n";
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

/// Copies the uniforms that samples need, except masks, to variables.
std::string take_over_text(const PredicateSet& set) {
  std::string variables;
  std::string body;
  const auto add = [&](const std::string& name, std::size_t numbers) {
    const std::string type = numbers == 1 ? "float" : "vec" + std::to_string(numbers);
    variables += type + " " + taken(name) + ";\n";
    body += "  " + taken(name) + " = max(" + name + ", -3.0e38);\n";
  };
  for (std::size_t c = 0; c < set.channels().size(); ++c) {
    add("channel" + std::to_string(c) + "_scale", 2);
  }
  for (std::size_t i = 0; i < set.leaves().size(); ++i) {
    for (const auto& uniform : block_of(set, i).uniforms) add(uniform.name, uniform.value.size());
    const std::string undefined = prefix_of(i) + "_undefined";
    variables += "uint " + taken(undefined) + ";\n";
    body += "  " + taken(undefined) + " = uint(max(int(" + undefined + "), -1));\n";
  }
  return "#define TAKES_OVER_LEAVES\n" + variables + "void take_over_leaves() {\n" + body + "}\n";
}

std::string leaves_text(const PredicateSet& set, const std::vector<PredicateTexel>& texels,
                        bool takes_over) {
  const ChannelText channels = channels_of(set, texels, takes_over);
  int textures = 1;
  for (const PredicateTexel& at : texels) textures = std::max(textures, at.texture + 1);
  std::string text = channels.uniforms;
  for (std::size_t i = 0; i < set.leaves().size(); ++i) {
    text += block_of(set, i).header + "uniform uint " + prefix_of(i) + "_undefined;\n";
  }
  if (takes_over) text += take_over_text(set);
  text +=
      "uint predicate_leaves(vec4 texels[" + std::to_string(textures) +
      "], float volume, uint undefined, uint labels,\n                      vec3 position) {\n" +
      channels.body + "  uint leaves = 0u;\n";
  for (std::size_t i = 0; i < set.leaves().size(); ++i) {
    const std::string bits = prefix_of(i) + "_undefined";
    text += "  if ((undefined & " + (takes_over ? taken(bits) : bits) + ") == 0u && " +
            expression_of(set, i, takes_over) + ") leaves |= " + std::to_string(1U << i) + "u;\n";
  }
  return text + "  return leaves;\n}\n";
}

}  // namespace

PredicateClasses classes_of(const PredicateSet& set) {
  if (set.leaves().size() <= kMostTabulated) return PredicateClasses::kLeaves;
  return set.size() <= kMostTabulated ? PredicateClasses::kEntries : PredicateClasses::kNone;
}

std::string predicate_shader(const PredicateSet& set, const std::vector<PredicateTexel>& texels) {
  const bool by_leaves = classes_of(set) == PredicateClasses::kLeaves;
  return leaves_text(set, texels, true) +
         (by_leaves ? "uint predicate_class(uint leaves) { return leaves; }\n"
                    : entries_text(set, "predicate_class"));
}

std::string plain_predicate_shader(const PredicateSet& set) {
  std::vector<PredicateTexel> texels;
  for (std::size_t c = 1; c < set.channels().size(); ++c) {
    texels.push_back({static_cast<int>(c) - 1, 0});
  }
  return leaves_text(set, texels, false) + entries_text(set, "predicate_entries");
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
