// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Values exactly at the ends of ranges, on every CPU engine. For OpenGL see
// gl/gl_predicate_edges_test.cpp.
#include "tests/render/predicates/edge_scenes.hpp"

namespace nav::render {
namespace {

class PredicateEdgesTest : public test::EngineTest {
 protected:
  void check(const test::EdgeCase& edge) {
    constexpr float kTolerance = 1e-5F;
    const float all = test::middle(test::draw(*engine_, test::without_condition(edge.scene))).r;
    ASSERT_GT(all, 0.1F);
    for (const bool skip : {true, false}) {
      Scene scene = edge.scene;
      scene.quality.skip_empty_bricks = skip;
      EXPECT_NEAR(test::middle(test::draw(*engine_, scene)).r, edge.seen ? all : 0, kTolerance)
          << edge.name << (skip ? ", bricks skipped" : "");
    }
  }
};
INSTANTIATE_TEST_SUITE_P(Engines, PredicateEdgesTest, ::testing::ValuesIn(test::engine_cases()),
                         [](const auto& of) { return std::string(of.param.name); });

TEST_P(PredicateEdgesTest, GradientsAlongTheScanLineHaveTheirExactAngle) {
  for (const auto& edge : test::angle_cases()) check(edge);
}

TEST_P(PredicateEdgesTest, ConstantsAreOnlyInRangesThatContainThem) {
  for (const auto& edge : test::constant_cases()) check(edge);
}

}  // namespace
}  // namespace nav::render
