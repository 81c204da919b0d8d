// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/appearance/fitted_vessels.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "app/appearance/appearance_file.hpp"
#include "render/transfer/vessel_fit.hpp"

namespace nav::app {
namespace {

constexpr const char* kOrganComponent = "organs";

std::string ml_words(double ml) {
  std::ostringstream text;
  text.precision(3);
  text << ml << " ml";
  return text.str();
}

}  // namespace

Result<DrawnVessels> drawn_vessels(const render::TransferFunction& transfer,
                                   const SessionConfig::Appearance& appearance, const Volume& ct) {
  const auto component =
      std::ranges::find(transfer.components(), kVesselComponent, &render::TransferComponent::name);
  NAV_CHECK(component != transfer.components().end(), transfer.name());
  const auto pool = appearance.blood_at_mm ? render::blood_pool_at(ct, {*appearance.blood_at_mm})
                                           : render::find_blood_pool(ct);
  if (!pool && appearance.blood_at_mm) return pool.error();
  render::VesselWindow window = render::window_of(*component);
  render::TransferFunction shown = transfer;
  if (pool) {
    window = render::vessel_window(*pool);
    auto fitted = render::with_vessel_window(transfer, window, kVesselComponent, kOrganComponent);
    if (!fitted) return fitted.error();
    shown = *std::move(fitted);
  }
  const auto classes = render::classify_vessels(ct, window, appearance.least_vessel_ml);
  auto separated = render::separate_vessels(ct, classes, window, shown, kVesselComponent);
  if (!separated) return separated.error();
  std::ostringstream text;
  if (pool) {
    text << "vessels: blood of " << std::round(pool->mean_hu) << " HU "
         << (appearance.blood_at_mm ? "at the given point" : "found in the histogram")
         << ", drawn from " << window.zero_below << " to " << window.zero_above << " HU";
  } else {
    text << "vessels: no contrast-filled blood found (no peak of 2 ml to 2.5 l from 130 to 700 "
            "HU), so the "
            "window of "
         << transfer.name() << " is used, " << window.zero_below << " to " << window.zero_above
         << " HU (--blood-at X Y Z gives a point in a vessel)";
  }
  text << "; " << ml_words(classes.vessel_ml) << " shown, left out: bone "
       << ml_words(classes.bone_ml) << ", fragments " << ml_words(classes.fragment_ml);
  return DrawnVessels{std::move(separated->ct), std::move(separated->transfer), text.str()};
}

}  // namespace nav::app
