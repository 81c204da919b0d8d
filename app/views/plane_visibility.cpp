// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/views/plane_visibility.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <sstream>
#include <vector>

#include "render/engine.hpp"
#include "render/transfer/transfer_function.hpp"

namespace nav::app {
namespace {

/// The scene with a plane of one grey level.
render::Scene with_grey_plane(render::Scene scene, std::uint8_t grey) {
  const auto& pixels = scene.plane->frame.pixels;
  scene.plane->frame.pixels = {
      pixels.width(), pixels.height(),
      std::vector<std::uint8_t>(
          static_cast<std::size_t>(pixels.width()) * static_cast<std::size_t>(pixels.height()),
          grey)};
  return scene;
}

/// Light of a white plane that reaches the eye, summed over the pixels.
Result<double> light_of_plane(render::Engine& engine, const render::Scene& scene) {
  const auto white = engine.render(with_grey_plane(scene, 255));
  if (!white) return white.error();
  const auto black = engine.render(with_grey_plane(scene, 0));
  if (!black) return black.error();
  double sum = 0;
  const auto a = white->pixels.pixels();
  const auto b = black->pixels.pixels();
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].g - b[i].g;
  return sum;
}

/// The scene without anything of its volumes.
Result<render::Scene> without_volume(render::Scene scene) {
  constexpr double kTransparentMm = 1e6;
  auto clear = render::TransferFunction::create(
      "clear", {{-32768, {0, 0, 0}, 0, 0}, {32767, {0, 0, 0}, 0, 0}});
  if (!clear) return clear.error();
  scene.transfer = *std::move(clear);
  scene.ultrasound.reset();
  if (scene.predicates) scene.predicates->opacity_length_mm = kTransparentMm;
  return scene;
}

/// The function without the components of a name; absent if it has no others.
std::optional<render::TransferFunction> without_component(const render::TransferFunction& transfer,
                                                          const std::string& name) {
  std::vector<render::TransferComponent> others;
  std::ranges::copy_if(transfer.components(), std::back_inserter(others),
                       [&](const auto& component) { return component.name != name; });
  if (others.empty()) return std::nullopt;
  auto made = render::TransferFunction::blend(transfer.name(), std::move(others));
  if (!made) return std::nullopt;
  return *std::move(made);
}

}  // namespace

Result<PlaneVisibility> plane_visibility(render::Scene scene) {
  constexpr int kWidth = 120;
  PlaneVisibility found;
  const bool drawn = scene.plane && scene.plane->safety.state <= SafetyState::kDegraded;
  if (!drawn || scene.projection != render::Projection::kComposite) return found;
  scene.height = std::max(16, kWidth * scene.height / scene.width);
  scene.width = kWidth;
  scene.quality.pixel_error = 0;
  const auto engine = render::make_cpu_engine();
  const auto bare = without_volume(scene);
  if (!bare) return bare.error();
  const auto all = light_of_plane(*engine, *bare);
  if (!all) return all.error();
  constexpr double kLeastPixels = 4;
  if (*all < kLeastPixels) return found;
  const auto seen = light_of_plane(*engine, scene);
  if (!seen) return seen.error();
  found.share = std::clamp(*seen / *all, 0.0, 1.0);
  if (found.share >= kLeastPlaneShare || scene.predicates) return found;
  std::set<std::string> names;
  for (const auto& component : scene.transfer.components()) names.insert(component.name);
  found.without = found.share;
  for (const std::string& name : names) {
    const auto others = without_component(scene.transfer, name);
    if (name.empty() || !others) continue;
    render::Scene less = scene;
    less.transfer = *others;
    const auto light = light_of_plane(*engine, less);
    if (!light) return light.error();
    const double share = std::clamp(*light / *all, 0.0, 1.0);
    // A component that hides less than as much again as is seen is not the cause.
    if (share > 2 * found.share && share > found.without) {
      found.hidden = name;
      found.without = share;
    }
  }
  return found;
}

std::string hidden_plane_words(const PlaneVisibility& found) {
  if (found.share >= kLeastPlaneShare) return {};
  std::ostringstream text;
  text << "the live plane is hidden in the first image: " << std::lround(100 * found.share)
       << " % of its light passes the CT in front of it";
  if (!found.hidden.empty()) {
    text << ", " << std::lround(100 * found.without) << " % without '" << found.hidden
         << "'. --importance " << found.hidden << ":-1024:3071=0.5 cuts these away like organs;";
  } else {
    text << ".";
  }
  text << " --cutaway-thresholds 0 1 fades everything in front of it";
  return text.str();
}

}  // namespace nav::app
