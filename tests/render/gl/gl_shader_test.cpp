// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>

#include "render/gl/gl_program.hpp"
#include "shaders/shaders.hpp"
#include "tests/support/test_data.hpp"

namespace nav::render {
namespace {

/// Feature sets that contain every pair of values of any two members. The members run through their
/// values at different speeds.
std::vector<GlFeatures> many_features() {
  std::vector<GlFeatures> all;
  for (int i = 0; i < 192; ++i) {
    GlFeatures f;
    const auto bit = [&](int which) { return ((i * 2654435761U) >> (which + 7) & 1) != 0; };
    f.projection = static_cast<Projection>(i % 8 < 5 ? 0 : i % 8 - 4);
    f.classified = static_cast<GlFeatures::Classified>(i % 3);
    f.shaded = static_cast<GlFeatures::Shaded>(i / 3 % 3);
    f.emphasis = bit(0);
    f.gradient_texture = bit(10);
    f.cutaway = bit(1);
    f.cut_field = f.cutaway && bit(9);
    f.skipping = bit(2);
    f.jitter = bit(3);
    f.plane = bit(4);
    f.solids = bit(5);
    f.capsules = f.solids && bit(6);
    f.shared_depth = bit(7);
    f.filter = static_cast<GlFilter>(i / 9 % 3);
    f.voxel_pairs = bit(13);
    f.sparse = bit(11) && !f.jitter;
    f.means = f.sparse && bit(12);
    all.push_back(f);
  }
  return all;
}

/// The parts of predicates.frag other than the text of the predicate set, which other tests check.
GlPredicateForm some_form(int i) {
  GlPredicateForm form;
  form.feature_textures = i % 4;
  form.volume_in_features = form.feature_textures > 0 && i % 3 < 2;
  form.undefined = form.feature_textures > 0 && i % 2 == 0;
  form.labels = i % 3 == 0;
  form.log_importance = i % 4 < 2;
  form.appearance_table = i % 7 < 4;
  const std::string count = std::to_string(std::max(form.feature_textures, 1));
  form.text = "uint predicate_leaves(vec4 texels[" + count +
              "], float volume, uint undefined, uint labels, vec3 position) {\n"
              "  return volume + texels[0].x > position.x ? labels : undefined;\n}\n"
              "uint predicate_class(uint leaves) { return leaves; }\n";
  return form;
}

TEST(ShadersTest, UnknownNamesGiveAnEmptySource) {
  EXPECT_TRUE(shaders::source("no.such").empty());
  EXPECT_FALSE(shaders::source("raycast.frag").empty());
}

TEST(ShadersTest, LeaveOutWhatAnImageDoesNotNeed) {
  // The text contains the code of the feature, but no #define switches it on.
  const std::string none = raycast_source({});
  for (const char* feature :
       {"PROJECTION", "MAXIMUM",   "MINIMUM",    "GRADIENT_WINDOWS", "SHADING",
        "PHONG",      "GOOCH",     "GRADIENTS",  "GRADIENT_TEXTURE", "EMPHASIS",
        "CUTAWAY",    "CUT_FIELD", "IMPORTANCE", "SKIPPING",         "JITTER",
        "PLANE",      "SOLIDS",    "CAPSULES",   "SHARED_DEPTH",     "MANUAL_FILTER",
        "SPARSE",     "COMPUTE",   "UNROLLED",   "GATHERS",          "STORAGE"}) {
    EXPECT_EQ(none.find(std::string("#define ") + feature + '\n'), std::string::npos) << feature;
  }
  EXPECT_NE(none.find("#define PREINTEGRATED\n"), std::string::npos);
}

TEST(ShadersTest, ProgramsForOneVolumeContainNoSecondVolume) {
  GlFeatures features;
  features.skipping = features.cutaway = features.plane = true;
  const std::string ct = raycast_source(features);
  features.predicates = some_form(1);
  const std::string ultrasound = raycast_source(features);
  for (const std::string& one : {ct, ultrasound}) {
    EXPECT_EQ(one.find("#define TWO_VOLUMES\n"), std::string::npos);
    EXPECT_EQ(one.find("second_"), std::string::npos);
    EXPECT_EQ(one.find("slab"), std::string::npos);
  }
  features.beside_ct = true;
  EXPECT_NE(raycast_source(features).find("uniform sampler3D ct;"), std::string::npos);
  EXPECT_NE(raycast_source(features).find("#define ct second_ct\n"), std::string::npos);
}

TEST(ShadersTest, AProjectionNeedsNoTransferFunction) {
  GlFeatures features;
  features.projection = Projection::kMaximum;
  features.shaded = GlFeatures::Shaded::kGooch;
  features.emphasis = features.cutaway = features.skipping = true;
  const std::string text = raycast_source(features);
  for (const char* feature :
       {"PREINTEGRATED", "SHADING", "GOOCH", "EMPHASIS", "CUTAWAY", "IMPORTANCE"}) {
    EXPECT_EQ(text.find(std::string("#define ") + feature + '\n'), std::string::npos) << feature;
  }
  EXPECT_NE(text.find("#define SKIPPING\n"), std::string::npos) << "by ranges of values";
}

TEST(ShadersTest, EveryFeatureSetIsValidGlsl) {
  if (std::system("command -v glslangValidator > /dev/null") != 0) {
    GTEST_SKIP() << "glslangValidator not found (Debian: glslang-tools)";
  }
  const test::TemporaryFolder folder;
  std::string files;
  const auto add = [&](const std::string& name, const std::string& text) {
    std::ofstream(folder / name) << text;
    files += ' ' + (folder / name).string();
  };
  // If a compute shader exists, every second text is compiled as one.
  int added = 0;
  const auto add_features = [&](const std::string& name, GlFeatures features) {
    features.unrolled = ++added % 3 == 0;
    features.compute = !features.sparse && !features.means && added % 2 == 0;
    features.storage = features.compute && added % 4 == 0;
    add(name + (features.compute ? ".comp" : ".frag"), raycast_source(features));
  };
  int count = 0;
  for (const GlFeatures& features : many_features()) {
    add_features("raycast" + std::to_string(count++), features);
  }
  for (GlFeatures features : many_features()) {
    if (features.projection != Projection::kComposite || count % 2 != 0) {
      ++count;
      continue;
    }
    features.predicates = some_form(count / 2);
    add_features("predicates" + std::to_string(count), features);
    features.beside_ct = true;
    add_features("two_volumes" + std::to_string(count++), features);
  }
  for (const char* name : {"fullscreen.vert", "composite.frag", "cost_sums.frag",
                           "filter_probe.frag", "resolve.frag"}) {
    add(name, assembled_shader(name));
  }
  add("speed_probe.frag", assembled_shader("speed_probe.frag"));
  add("speed_probe.comp", as_compute(assembled_shader("speed_probe.frag")));
  const std::string log = (folder / "log").string();
  const int result = std::system(("glslangValidator" + files + " > " + log + " 2>&1").c_str());
  std::ifstream said(log);
  EXPECT_EQ(result, 0) << std::string(std::istreambuf_iterator<char>(said), {});
}

}  // namespace
}  // namespace nav::render
