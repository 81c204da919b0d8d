// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>

#include "render/gl_program.hpp"
#include "shaders/shaders.hpp"
#include "tests/support/test_data.hpp"

namespace nav::render {
namespace {

GlFeatures features_of_bits(int bits) {
  GlFeatures f;
  f.shading = (bits & 1) != 0;
  f.plane = (bits & 2) != 0;
  f.needle = (bits & 4) != 0;
  f.spheres = (bits & 8) != 0;
  f.skipping = (bits & 16) != 0;
  f.shared_depth = (bits & 32) != 0;
  f.manual_filter = (bits & 64) != 0;
  return f;
}

TEST(ShadersTest, UnknownNamesAreEmpty) {
  EXPECT_TRUE(shaders::source("no.such").empty());
  EXPECT_FALSE(shaders::source("raycast.frag").empty());
}

TEST(ShadersTest, LeaveOutWhatAPictureDoesNotNeed) {
  // The feature's code is there in the text but no #define switches it on.
  const std::string none = raycast_fragment_source({});
  for (const char* feature :
       {"SHADING", "PLANE", "NEEDLE", "SPHERES", "SKIPPING", "SHARED_DEPTH", "MANUAL_FILTER"}) {
    EXPECT_EQ(none.find(std::string("#define ") + feature), std::string::npos) << feature;
  }
}

TEST(ShadersTest, EverySetOfFeaturesIsValidGlsl) {
  if (std::system("command -v glslangValidator > /dev/null") != 0) {
    GTEST_SKIP() << "glslangValidator not found (Debian: glslang-tools)";
  }
  const test::TemporaryFolder folder;
  std::string files;
  const auto add = [&](const std::string& name, const std::string& text) {
    std::ofstream(folder / name) << text;
    files += ' ' + (folder / name).string();
  };
  for (int bits = 0; bits < 128; ++bits) {
    add("raycast" + std::to_string(bits) + ".frag",
        raycast_fragment_source(features_of_bits(bits)));
  }
  for (const char* name : {"fullscreen.vert", "composite.frag", "filter_probe.frag"}) {
    add(name, assembled_shader(name));
  }
  const std::string log = (folder / "log").string();
  const int result = std::system(("glslangValidator" + files + " > " + log + " 2>&1").c_str());
  std::ifstream said(log);
  EXPECT_EQ(result, 0) << std::string(std::istreambuf_iterator<char>(said), {});
}

}  // namespace
}  // namespace nav::render
