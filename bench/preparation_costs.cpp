// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/preparation_costs.hpp"

#include "app/appearance/appearance.hpp"
#include "app/predicates/phantom_volume.hpp"
#include "app/views/panels.hpp"
#include "render/predicates/connected.hpp"
#include "render/predicates/shading_source.hpp"
#include "render/transfer/body.hpp"
#include "render/transfer/smoothed_ct.hpp"
#include "render/transfer/vessel_fit.hpp"

namespace nav::bench {
namespace {

constexpr const char* kContextual = "ct-contextual";
constexpr double kGradientSmoothingMm = 1;

struct Preparation {
  std::string what;
  Task run;
};

app::SessionConfig::Appearance appearance_of(const std::string& preset) {
  app::SessionConfig::Appearance appearance;
  appearance.preset = preset;
  return appearance;
}

Task resolve(const app::SessionConfig::Appearance& appearance, const Volume& ct,
             bool draws_it_as_it_is) {
  return [=, &ct]() -> Result<void> {
    const auto resolved = app::resolve_appearance(appearance, ct);
    if (!resolved) return resolved.error();
    NAV_CHECK(!draws_it_as_it_is || !resolved->drawn, appearance.preset);
    return {};
  };
}

Task fit_vessels(const Volume& ct) {
  return [&ct]() -> Result<void> {
    const auto pool = render::find_blood_pool(ct);
    const auto window =
        pool ? render::vessel_window(*pool) : render::VesselWindow{150, 200, 500, 550};
    const auto classes = render::classify_vessels(ct, window);
    const auto transfer = render::preset_transfer_function("cta-vessels");
    if (!transfer) return transfer.error();
    const auto separated = render::separate_vessels(ct, classes, window, *transfer, "vessels");
    if (!separated) return separated.error();
    return {};
  };
}

/// A predicate set of one entry on a simulated volume: bright voxels, in parts of at least 60 mm³
/// where asked for.
render::PredicateVolume bright_voxels(const render::PredicateVolume& volume, bool connected) {
  render::PredicateVolume out = volume;
  const auto bright = render::PredicateExpression::kind("intensity", {0.5, 1e6});
  out.predicates.model.entries = {
      {"bright", connected ? render::PredicateExpression::connected(bright, 60) : bright}};
  out.predicates.model.histogram = *render::PredicateHistogram::create({{1, 0, 0}});
  return out;
}

Task resolve_parts(const render::PredicateVolume& volume, bool connected) {
  return [=]() -> Result<void> {
    render::PredicateVolume one = bright_voxels(volume, connected);
    return render::resolve_connected(one);
  };
}

Task shade(const render::PredicateVolume& volume) {
  return [=]() -> Result<void> {
    const auto shading =
        render::shading_of_predicates(*volume.ultrasound, volume.predicates.intensity,
                                      kGradientSmoothingMm, render::kUsualFullGradientPerMm, 0);
    return shading ? Result<void>() : shading.error();
  };
}

/// An image around a grey 3D view, with or without legend and name of the appearance.
Task compose(const Volume& ct, bool legend) {
  struct Kept {
    session::Epoch epoch{};
    std::optional<NeedlePlan> plan{};
    std::string banner{};
    Image2d<Rgba8> view{800, 600, std::vector<Rgba8>(std::size_t{800} * 600, {60, 60, 60, 255})};
  };
  const auto kept = std::make_shared<Kept>();
  app::PanelContext context{
      .epoch = kept->epoch, .ct = ct, .plan = kept->plan, .banner = kept->banner};
  if (legend) {
    const auto transfer = render::preset_transfer_function("cta-liver-vessels");
    if (transfer) context.legend = app::legend_of(*transfer);
    context.appearance = "ct-contextual  E 0.4  theta1 25 deg  theta2 50 deg  d 15 mm";
  }
  return [kept, context]() -> Result<void> {
    const auto image = app::compose_panels(kept->view, context);
    NAV_CHECK(!image.empty());
    return {};
  };
}

}  // namespace

Result<std::vector<PreparationCost>> measure_preparations(const std::shared_ptr<const Volume>& ct,
                                                          const Repeats& repeats) {
  constexpr int kUltrasoundSide = 128;
  const auto ultrasound = app::phantom_volume("carotid", kUltrasoundSide);
  if (!ultrasound) return ultrasound.error();
  const std::vector<Preparation> all{
      {"contextual appearance, once for a CT", resolve(appearance_of(kContextual), *ct, false)},
      {"  unused: an appearance that asks for nothing",
       resolve(appearance_of("ct-bone"), *ct, true)},
      {"  vessels: blood, bone mask, components", fit_vessels(*ct)},
      {"  table",
       [ct]() -> Result<void> {
         NAV_CHECK(render::without_table(ct).ct != nullptr);
         return {};
       }},
      {"  smoothed gradients, 1 mm",
       [ct]() -> Result<void> {
         const auto made = render::smoothed_for_gradients(ct, kGradientSmoothingMm, 0);
         return made ? Result<void>() : made.error();
       }},
      {"connected predicates, once for 128^3", resolve_parts(*ultrasound, true)},
      {"  unused: the same set without connected", resolve_parts(*ultrasound, false)},
      {"shading of predicates, once for 128^3", shade(*ultrasound)},
      {"panels, legend and texts of an image, 800 x 600", compose(*ct, true)},
      {"  unused: without legend and name of the appearance", compose(*ct, false)}};
  std::vector<Task> tasks;
  for (const Preparation& one : all) tasks.push_back(one.run);
  const auto taken = time_in_turn(tasks, repeats);
  if (!taken) return taken.error();
  std::vector<PreparationCost> costs;
  for (std::size_t i = 0; i < all.size(); ++i) {
    costs.push_back({all[i].what, 1e3 * (*taken)[i].cpu_s, 1e3 * (*taken)[i].wall_s});
  }
  return costs;
}

}  // namespace nav::bench
