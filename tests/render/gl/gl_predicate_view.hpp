// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "tests/render/gl/gl_pictures.hpp"
#include "tests/render/gl/gl_view.hpp"
#include "tests/render/scene_support.hpp"

namespace nav::test {

/// A view whose predicates are drawn by their own programs at once, beside the reference.
class GlPredicateViewTest : public GlViewTest {
 protected:
  /// Of pixels whose values lie on an end of a range but for rounding.
  static constexpr double kShare = 0.002;

  void SetUp() override {
    GlViewTest::SetUp();
    caster().set_settled_after(0);  // Each set by its own program.
  }
  /// Over the background, as engines give it.
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
  /// Of pixels that differ by more from the reference.
  double share_beyond(const render::Scene& scene, double limit_255 = kAgreement255) {
    const render::RenderedImage expected = test::draw(*reference_, scene);
    return difference(draw(scene).pixels, expected.pixels, limit_255).fraction_above;
  }

  std::unique_ptr<render::Engine> reference_ = render::make_reference_engine();
};

}  // namespace nav::test
