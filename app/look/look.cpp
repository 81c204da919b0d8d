// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/look/look.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <sstream>

#include "app/look/look_file.hpp"
#include "render/default_window.hpp"

namespace nav::app {
namespace {

Result<render::TransferFunction> transfer_of(const SessionConfig::Look& look, const Volume& ct,
                                             const std::optional<LookFile>& file) {
  const auto base = [&]() -> Result<render::TransferFunction> {
    if (file) return file->transfer;
    if (!look.nodes.empty()) return render::TransferFunction::create("session file", look.nodes);
    return render::preset_for(look.preset, ct);
  }();
  if (!base) return base.error();
  return render::with_importance(*base, look.importance);
}

/// True when the session sets any property of the cutaway's shape.
bool shapes(const SessionConfig::Look::Cutaway& said) {
  return said.theta1_deg || said.theta2_deg || said.overlay_mm || said.around_plane ||
         said.around_needle || said.around_targets;
}

Result<std::optional<render::Cutaway>> cutaway_of(const SessionConfig::Look::Cutaway& said,
                                                  const std::optional<LookFile>& file) {
  const bool file_says = file && file->cutaway;
  const bool in_file = !file_says || file->cutaway->has_value();
  if (!in_file && !said.enabled && shapes(said)) {
    return Error{ErrorCode::kUsage,
                 "look.cutaway: angles, overlay and objects require enabled = true, because the "
                 "appearance file does not cut"};
  }
  if (!said.enabled.value_or(in_file)) return std::optional<render::Cutaway>{};
  render::Cutaway cutaway =
      file_says ? file->cutaway->value_or(render::Cutaway{}) : render::Cutaway{};
  constexpr double kRadPerDeg = M_PI / 180;
  if (said.theta1_deg) cutaway.theta1_rad = *said.theta1_deg * kRadPerDeg;
  if (said.theta2_deg) cutaway.theta2_rad = *said.theta2_deg * kRadPerDeg;
  cutaway.overlay_mm = said.overlay_mm.value_or(cutaway.overlay_mm);
  cutaway.around_plane = said.around_plane.value_or(cutaway.around_plane);
  cutaway.around_needle = said.around_needle.value_or(cutaway.around_needle);
  cutaway.around_spheres = said.around_targets.value_or(cutaway.around_spheres);
  if (cutaway.theta1_rad > cutaway.theta2_rad) {
    std::ostringstream text;
    text << "look.cutaway.theta1_deg: expected at most theta2_deg, "
         << cutaway.theta2_rad / kRadPerDeg << ", found " << cutaway.theta1_rad / kRadPerDeg;
    return Error{ErrorCode::kUsage, text.str()};
  }
  return std::optional<render::Cutaway>(cutaway);
}

}  // namespace

Result<ResolvedLook> resolve_look(const SessionConfig::Look& look, const Volume& ct) {
  if (const auto ok = validate(look); !ok) return ok.error();
  std::optional<LookFile> file;
  if (!look.file.empty()) {
    auto read = read_look_file(look.file);
    if (!read) return read.error();
    auto laid = look_for(*std::move(read), ct);
    if (!laid) return Error{laid.error().code, look.file.string() + ": " + laid.error().message};
    file = *std::move(laid);
  }
  auto transfer = transfer_of(look, ct, file);
  if (!transfer) return transfer.error();
  auto cutaway = cutaway_of(look.cutaway, file);
  if (!cutaway) return cutaway.error();
  ResolvedLook resolved{*std::move(transfer), {}, *std::move(cutaway), {}};
  if (file) {
    resolved.shading = file->shading.value_or(render::Shading{});
    resolved.value_range = file->value_range;
  } else if (look.nodes.empty() && look.preset == "mr-default") {
    resolved.value_range = render::value_range(ct);
    resolved.shading = render::rescaled({}, render::kNominalRange, *resolved.value_range);
  }
  // A style in the session turns shading on, even when the file turns it off.
  const bool in_file = resolved.shading.enabled || look.style.has_value();
  if (look.shading && !in_file && look.emphasis) {
    return Error{ErrorCode::kUsage,
                 "look.emphasis: requires shading, which is off in " + look.file.string()};
  }
  resolved.shading.enabled = in_file && look.shading;
  resolved.shading.emphasis = look.emphasis.value_or(resolved.shading.emphasis);
  if (look.style) {
    resolved.shading.style =
        *look.style == "gooch" ? render::ShadingStyle::kGooch : render::ShadingStyle::kPhong;
  }
  resolved.projection = look.projection == "maximum"   ? render::Projection::kMaximum
                        : look.projection == "minimum" ? render::Projection::kMinimum
                        : look.projection == "mean"    ? render::Projection::kMean
                                                       : render::Projection::kComposite;
  return resolved;
}

namespace {

/// Opacity of a component at a value.
double opacity_at(const render::TransferComponent& component, double value) {
  const auto& nodes = component.nodes;
  const auto next = std::ranges::upper_bound(nodes, value, {}, &render::TransferNode::hu);
  if (next == nodes.begin()) return nodes.front().opacity;
  if (next == nodes.end()) return nodes.back().opacity;
  const auto& before = *std::prev(next);
  return std::lerp(before.opacity, next->opacity, (value - before.hu) / (next->hu - before.hu));
}

}  // namespace

void warn_of_lost_components(const render::TransferFunction& transfer, Diagnostics& diagnostics) {
  constexpr double kLeastShare = 0.5;  // Share of the component's greatest opacity.
  for (const render::TransferComponent& component : transfer.components()) {
    const auto most = std::ranges::max_element(component.nodes, {}, &render::TransferNode::opacity);
    const double drawn = std::max(opacity_at(component, std::floor(most->hu)),
                                  opacity_at(component, std::ceil(most->hu)));
    if (drawn >= kLeastShare * most->opacity) continue;
    std::ostringstream text;
    text << (component.name.empty() ? "transfer function" : "component " + component.name)
         << ": expected nodes at least 1 apart, because values are classified at whole numbers, "
            "found an opacity of "
         << most->opacity << " at " << most->hu << ", of which " << drawn
         << " is drawn: multiply the volume's values and the nodes by a constant";
    diagnostics.report(Severity::kWarning, "look", text.str());
  }
}

void warn_of_units(const SessionConfig::Look& look, const Volume& ct, Diagnostics& diagnostics) {
  const bool of_hounsfield_units =
      look.file.empty() && look.nodes.empty() && look.preset.starts_with("ct");
  if (!of_hounsfield_units || look.projection != "composite" || render::is_hounsfield(ct)) return;
  diagnostics.report(
      Severity::kWarning, "look",
      look.preset + ": expected a CT in Hounsfield units, found less than 1 % of " + ct.name() +
          " below -200 (air): if it is an MR or has another unit, its colours have "
          "no meaning (use --transfer-function mr-default, or a --look made for it)");
}

Result<void> save_look(const std::filesystem::path& path, const ResolvedLook& look) {
  if (path.empty()) return {};
  return write_look_file(path, {look.transfer, look.shading, look.cutaway, look.value_range});
}

}  // namespace nav::app
