// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Tests the GLSL that the program assembles from its building blocks.
#include <cstdlib>
#include <fstream>

#include "render/predicates/shader.hpp"
#include "tests/render/predicates/predicate_scenes.hpp"
#include "tests/support/test_data.hpp"

namespace nav::render {
namespace {

using E = PredicateExpression;

PredicateSet set_of(const Scene& scene) {
  return *PredicateSet::create(*scene.predicates, scene.ct, position_of(scene));
}

/// Puts the channels into two textures: the last channel into the second one, the others into the
/// first.
std::vector<PredicateTexel> texels_of(const PredicateSet& set) {
  const int count = static_cast<int>(set.channels().size());
  std::vector<PredicateTexel> texels;
  for (int c = 1; c < count; ++c) texels.push_back({c / 4, c % 4});
  if (!texels.empty()) texels.back().texture = 1;
  return texels;
}

std::string text_of(const Scene& scene) {
  const PredicateSet set = set_of(scene);
  return predicate_shader(set, texels_of(set));
}

Scene some_scene(unsigned seed) {
  std::mt19937 random(seed);
  const auto ct = test::small_ultrasound(test::centred_grid({9, 9, 9}, {1, 1, 1}), seed);
  return test::random_predicate_scene(random, ct, test::random_features(ct, seed));
}

TEST(PredicateShaderTest, IsValidGlslForEachKindAndCombination) {
  if (std::system("command -v glslangValidator > /dev/null") != 0) {
    GTEST_SKIP() << "glslangValidator not found (Debian: glslang-tools)";
  }
  const test::TemporaryFolder folder;
  std::string files;
  for (unsigned seed = 0; seed < 40; ++seed) {
    const std::string name = "predicates" + std::to_string(seed) + ".frag";
    const PredicateSet set = set_of(some_scene(seed));
    std::ofstream(folder / name)
        << "#version 410 core\nlayout(location = 0) out vec4 colour;\n"
        << predicate_shader(set, texels_of(set))
        << (set.channels().size() > 1
                ? "void main() {\n  vec4 t[2] = vec4[2](gl_FragCoord, gl_FragCoord.yxwz);\n"
                : "void main() {\n  vec4 t[1] = vec4[1](gl_FragCoord);\n")
        << "  uint leaves = predicate_leaves(t, gl_FragCoord.x, 5u, 3u, gl_FragCoord.xyz);\n"
           "  colour = vec4(float(predicate_class(leaves)));\n}\n";
    files += ' ' + (folder / name).string();
  }
  const std::string log = (folder / "log").string();
  const int result = std::system(("glslangValidator" + files + " > " + log + " 2>&1").c_str());
  std::ifstream said(log);
  EXPECT_EQ(result, 0) << std::string(std::istreambuf_iterator<char>(said), {});
}

TEST(PredicateShaderTest, ChangesWithTheSetOnly) {
  Scene scene = some_scene(3);
  scene.predicates->model =
      test::model_of({{E::kind("snr", {0.1, 0.5}), 1}, {E::negation(E::kind("label", {1})), 2}});
  const std::string before = text_of(scene);
  const double low = predicate_uniforms(set_of(scene)).values[0].value[0];
  scene.predicates->model.entries[0].expression.values = {0.2, 0.9};
  scene.predicates->model.entries[1].expression.operands[0].values = {2};
  scene.predicates->model.histogram.drag(0, 0.9);
  scene.predicates->model.histogram.set_colour(1, 120, 1);
  EXPECT_EQ(text_of(scene), before) << "parameters are uniforms";
  const double scale = set_of(scene).channels()[1].scale;
  EXPECT_NEAR((predicate_uniforms(set_of(scene)).values[0].value[0] - low) * scale, 0.1, 1e-12);
  EXPECT_EQ(predicate_uniforms(set_of(scene)).masks[0].second, 2U);
  scene.predicates->model.entries[1].expression = E::kind("label", {1});
  EXPECT_EQ(text_of(scene), before) << "combinations are tables";
  scene.predicates->model.entries[1].expression = E::kind("confidence", {0, 1});
  EXPECT_NE(text_of(scene), before) << "another predicate";
}

/// Adds entries of one range each, to exceed the number of leaves that a table holds.
void add_ranges(int count, PredicateModel& model) {
  std::vector<PredicateHistogram::Bar> bars = model.histogram.bars();
  for (int i = 0; i < count; ++i) {
    model.entries.push_back({"range " + std::to_string(i), E::kind("intensity", {0.01 * i, 0.9})});
    bars.push_back({1, 0, 0});
  }
  model.histogram = *PredicateHistogram::create(std::move(bars));
}

TEST(PredicateShaderTest, ContainsTheCombinationAsAnExpression) {
  Scene scene = some_scene(3);
  scene.predicates->model = test::model_of(
      {{E::any({E::kind("snr"), E::all({E::kind("label"), E::negation(E::entry("entry 1"))})}), 1},
       {E::kind("confidence"), 2}});
  EXPECT_EQ(text_of(scene).find("bool entry0"), std::string::npos);
  add_ranges(12, scene.predicates->model);
  const std::string text = text_of(scene);
  EXPECT_NE(text.find("bool entry0 = (leaf0 || (leaf1 && !entry1));"), std::string::npos) << text;
  EXPECT_LT(text.find("bool entry1"), text.find("bool entry0")) << "what is referred to is first";
}

}  // namespace
}  // namespace nav::render
