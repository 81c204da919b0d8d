// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/views/live_view.hpp"

namespace nav::app {

LiveView::LiveView(Presenter& presenter, const render::ProgressiveOptions& options)
    : presenter_(presenter),
      renderer_(presenter.engine(), options),
      view_size_(presenter.view_size()) {}

bool LiveView::apply(const render::WindowInput& input) {
  const PixelSize size = view_size_within({input.width, input.height});
  bool changed = size != view_size_;
  view_size_ = size;
  if (input.keys.find_first_of("rR") != std::string::npos) {
    changed |= camera_.has_value();
    camera_.reset();
  }
  if (!input.orbit.isZero(0) || !input.pan.isZero(0) || input.zoom != 1) {
    camera_ = render::moved(camera_.value_or(presenter_.camera()), input);
    changed = true;
  }
  return changed;
}

Result<Image2d<Rgba8>> LiveView::draw(const session::Epoch& epoch, Timestamp now, bool ended) {
  if (auto ok = presenter_.choose_step(epoch); !ok) return ok.error();
  render::Scene scene = presenter_.scene(epoch);
  if (camera_) scene.camera = *camera_;
  scene.width = view_size_.width;
  scene.height = view_size_.height;
  const auto drawn = renderer_.draw(scene, now);
  if (!drawn) return drawn.error();
  presenter_.count(drawn->image.statistics);
  return presenter_.compose_for_window(render::to_8bit(drawn->image.pixels), epoch, scene.camera,
                                       ended);
}

Result<Image2d<Rgba8>> LiveView::draw_presented(const session::Epoch& epoch, Timestamp now) {
  if (camera_ || view_size_ != presenter_.view_size()) return draw(epoch, now, false);
  return presenter_.compose_for_window(presenter_.view(), epoch, presenter_.camera(), false);
}

}  // namespace nav::app
