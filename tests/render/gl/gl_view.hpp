// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstring>
#include <gtest/gtest.h>
#include <memory>
#include <vector>
#include <vtkOpenGLRenderWindow.h>
#include <vtkRenderer.h>

#include "render/gl/gl_volume_prop.hpp"
#include "render/vtk/vtk_offscreen.hpp"
#include "tests/support/matchers.hpp"

namespace nav::test {

inline bool same_bits(const std::vector<RgbaF>& a, const std::vector<RgbaF>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(RgbaF)) == 0;
}

/// A window with a view. Tests have access to its ray caster.
class GlViewTest : public testing::Test {
 protected:
  void SetUp() override {
    auto window = render::OffscreenWindow::create(96, 72);
    ASSERT_TRUE(has_value(window));
    window_ = std::move(window).value();
    view_ = std::make_unique<render::SceneView>(window_->window());
  }

  Result<void> try_to_draw(const render::Scene& scene, int coarse_factor = 1) {
    window_->window().SetSize(scene.width, scene.height);
    auto drawn = view_->draw(std::make_shared<const render::Scene>(scene), coarse_factor);
    if (!drawn) return drawn.error();
    return {};
  }
  /// Returns the image without its background.
  std::vector<RgbaF> draw(const render::Scene& scene) {
    EXPECT_TRUE(has_value(try_to_draw(scene)));
    return caster().read();
  }
  /// Returns the image of draw(), with every ray cast again.
  std::vector<RgbaF> draw_anew(const render::Scene& scene) {
    if (!other_) other_ = std::make_unique<render::SceneView>(window_->window());
    other_->raycaster().forget_image();
    view_->renderer().DrawOff();
    other_->renderer().DrawOn();
    EXPECT_TRUE(has_value(other_->draw(std::make_shared<const render::Scene>(scene))));
    view_->renderer().DrawOn();
    other_->renderer().DrawOff();
    return other_->raycaster().read();
  }
  render::GlRaycaster& caster() { return view_->raycaster(); }
  [[nodiscard]] render::RenderStatistics statistics() const {
    return view_->raycaster().statistics();
  }

  std::unique_ptr<render::OffscreenWindow> window_;
  std::unique_ptr<render::SceneView> view_;
  std::unique_ptr<render::SceneView> other_;  ///< The view of draw_anew(). It keeps its programs.
};

}  // namespace nav::test
