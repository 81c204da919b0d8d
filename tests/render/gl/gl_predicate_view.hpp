// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "tests/render/gl/gl_images.hpp"
#include "tests/render/gl/gl_view.hpp"
#include "tests/render/scene_support.hpp"

namespace nav::test {

/// A view that draws predicate sets by their own programs at once. Compares with the reference.
class GlPredicateViewTest : public GlViewTest {
 protected:
  /// Share of the pixels whose values lie at an end of a range, except for rounding.
  static constexpr double kShare = 0.002;

  void SetUp() override {
    GlViewTest::SetUp();
    caster().set_settled_after(0);  // Each predicate set uses its own program.
  }
  /// Returns the image over the background, like engines do.
  render::RenderedImage draw(const render::Scene& scene) {
    EXPECT_TRUE(has_value(try_to_draw(scene)));
    std::vector<RgbaF> pixels = caster().read();
    const Eigen::Vector3f background = scene.background_rgb.cast<float>();
    for (RgbaF& p : pixels) {
      const float rest = 1 - p.a;
      p = {p.r + rest * background.x(), p.g + rest * background.y(), p.b + rest * background.z(),
           1};
    }
    return {{scene.width, scene.height, std::move(pixels)}, caster().statistics()};
  }
  /// Share of the pixels that differ from the reference by more than the limit.
  double share_beyond(const render::Scene& scene, double limit_255 = kAgreement255) {
    const render::RenderedImage expected = test::draw(*reference_, scene);
    return difference(draw(scene).pixels, expected.pixels, limit_255).fraction_above;
  }

  std::unique_ptr<render::Engine> reference_ = render::make_reference_engine();
};

}  // namespace nav::test
