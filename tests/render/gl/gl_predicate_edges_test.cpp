// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Values exactly at the ends of ranges, drawn by the own program of a predicate set and by the
// generic one.
#include "tests/render/gl/gl_predicate_view.hpp"
#include "tests/render/predicates/edge_scenes.hpp"

namespace nav::render {
namespace {

class GlPredicateEdgesTest : public test::GlPredicateViewTest {
 protected:
  void check(const std::vector<test::EdgeCase>& cases) {
    constexpr float kTolerance = 0.5F / 255;
    for (const test::EdgeCase& edge : cases) {
      Scene scene = edge.scene;
      scene.width = scene.height = 25;
      const float all = test::middle(draw(test::without_condition(scene))).r;
      ASSERT_GT(all, 0.1F);
      EXPECT_NEAR(test::middle(draw(scene)).r, edge.seen ? all : 0, kTolerance) << edge.name;
    }
  }
};

TEST_F(GlPredicateEdgesTest, GradientsAlongTheScanLineHaveTheirExactAngle) {
  caster().set_settled_after(1000);  // Never settled, so the generic program draws.
  check(test::angle_cases());
  caster().set_settled_after(0);
  check(test::angle_cases());
}

TEST_F(GlPredicateEdgesTest, ConstantsAreOnlyInRangesThatContainThem) {
  caster().set_settled_after(1000);  // Never settled, so the generic program draws.
  check(test::constant_cases());
  caster().set_settled_after(0);
  check(test::constant_cases());
}

}  // namespace
}  // namespace nav::render
