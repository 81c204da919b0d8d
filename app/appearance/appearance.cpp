// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/appearance/appearance.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <sstream>

#include "app/appearance/appearance_file.hpp"
#include "app/appearance/preset_folder.hpp"
#include "nav/hounsfield.hpp"
#include "render/default_window.hpp"
#include "render/transfer/body.hpp"
#include "render/transfer/smoothed_ct.hpp"

namespace nav::app {
namespace {

/// Drawn by default where the folder of the presets is missing.
constexpr const char* kBuiltInForCt = "ct-soft-tissue";
constexpr const char* kBuiltInForMr = "mr-default";

Result<render::TransferFunction> transfer_of(const SessionConfig::Appearance& appearance,
                                             const Volume& ct,
                                             const std::optional<AppearanceFile>& file) {
  const auto base = [&]() -> Result<render::TransferFunction> {
    if (file) return file->transfer;
    if (!appearance.nodes.empty())
      return render::TransferFunction::create("session file", appearance.nodes);
    return render::preset_for(preset_name(appearance, ct), ct);
  }();
  if (!base) return base.error();
  return render::with_importance(*base, appearance.importance);
}

/// The appearance file of the session, or that of its preset, for a volume; absent for built-in
/// presets and nodes.
Result<std::optional<AppearanceFile>> file_of(const SessionConfig::Appearance& appearance,
                                              const Volume& ct) {
  const auto builtin = render::preset_names();
  const std::string preset = preset_name(appearance, ct);
  const bool named = !appearance.file.empty();
  const bool is_builtin = std::ranges::find(builtin, preset) != builtin.end();
  if (!named && (!appearance.nodes.empty() || is_builtin)) return std::optional<AppearanceFile>{};
  auto read = named ? read_appearance_file(appearance.file) : read_preset(preset);
  if (!read) return read.error();
  auto laid = appearance_for(*std::move(read), ct);
  if (!laid) {
    return Error{laid.error().code,
                 (named ? appearance.file.string() : preset) + ": " + laid.error().message};
  }
  return std::optional(*std::move(laid));
}

bool has_vessels(const render::TransferFunction& transfer) {
  return std::ranges::find(transfer.components(), kVesselComponent,
                           &render::TransferComponent::name) != transfer.components().end();
}

/// True when the session sets any property of the cutaway's shape.
bool shapes(const SessionConfig::Appearance::Cutaway& said) {
  return said.theta1_deg || said.theta2_deg || said.overlay_mm || said.constant ||
         said.around_plane || said.around_needle || said.around_targets;
}

Result<std::optional<render::Cutaway>> cutaway_of(const SessionConfig::Appearance::Cutaway& said,
                                                  const std::optional<AppearanceFile>& file) {
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
  if (said.constant) {
    const auto& tau = *said.constant;
    cutaway.constant = {tau[0], tau[1]};
    if (!(tau[0] >= 0 && tau[1] <= 1 && tau[0] < tau[1])) {
      std::ostringstream text;
      text << "look.cutaway.constant_thresholds: expected two numbers in [0, 1] in order, found "
           << tau.transpose();
      return Error{ErrorCode::kUsage, text.str()};
    }
  }
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

/// The CT that is drawn instead, without the table and with fitted vessels; absent if it is drawn
/// as it is.
Result<std::optional<DrawnCt>> drawn_ct(const ResolvedAppearance& resolved,
                                        const SessionConfig::Appearance& appearance,
                                        const Volume& ct) {
  if (resolved.projection != render::Projection::kComposite) return std::optional<DrawnCt>{};
  const bool in_hu = (resolved.fit_vessels || resolved.remove_table) && is_hounsfield(ct);
  const bool fits = resolved.fit_vessels && in_hu;
  DrawnCt drawn{std::make_shared<const Volume>(ct), resolved.transfer};
  if (resolved.remove_table && in_hu) {
    const render::BodyOnly body = render::without_table(drawn.ct);
    if (body.removed_ml > 0) {
      std::ostringstream text;
      text.precision(3);
      text << "table: " << body.removed_ml << " ml beside the body are not drawn";
      drawn.statements.push_back(text.str());
      drawn.ct = body.ct;
    }
  }
  const std::shared_ptr<const Volume> body = drawn.ct;
  if (fits) {
    auto vessels = drawn_vessels(resolved.transfer, appearance, *body);
    if (!vessels) return vessels.error();
    drawn.ct = std::move(vessels->ct);
    drawn.transfer = std::move(vessels->transfer);
    drawn.statements.push_back(std::move(vessels->statement));
  }
  const bool smooths = resolved.shading.enabled && resolved.smoothing_mm > 0;
  if (smooths || fits) {
    // Values that were moved for drawing have no gradients of their own.
    auto source = render::smoothed_for_gradients(body, smooths ? resolved.smoothing_mm : 0, 0);
    if (!source) return source.error();
    drawn.gradient_source = *std::move(source);
  }
  const bool as_it_is = drawn.statements.empty() && !drawn.gradient_source;
  return as_it_is ? std::optional<DrawnCt>{} : std::optional(std::move(drawn));
}

}  // namespace

std::string preset_name(const SessionConfig::Appearance& appearance, const Volume& ct) {
  if (appearance.preset != kContextualPreset) return appearance.preset;
  const bool in_hu = is_hounsfield(ct);
  std::error_code none;
  if (!std::filesystem::is_directory(preset_folder(), none)) {
    return in_hu ? kBuiltInForCt : kBuiltInForMr;
  }
  return in_hu ? "ct-contextual" : "mr-contextual";
}

Result<ResolvedAppearance> resolve_appearance(const SessionConfig::Appearance& appearance,
                                              const Volume& ct) {
  if (const auto ok = validate(appearance); !ok) return ok.error();
  auto file = file_of(appearance, ct);
  if (!file) return file.error();
  auto transfer = transfer_of(appearance, ct, *file);
  if (!transfer) return transfer.error();
  auto cutaway = cutaway_of(appearance.cutaway, *file);
  if (!cutaway) return cutaway.error();
  ResolvedAppearance resolved{*std::move(transfer), {}, *std::move(cutaway), {}};
  if (*file) {
    resolved.shading = (*file)->shading.value_or(render::Shading{});
    resolved.value_range = (*file)->value_range;
    resolved.fit_vessels = (*file)->fit_vessels;
  } else if (appearance.nodes.empty() && preset_name(appearance, ct) != kBuiltInForMr) {
    resolved.fit_vessels = has_vessels(resolved.transfer);
  } else if (appearance.nodes.empty()) {
    resolved.value_range = render::value_range(ct);
    resolved.shading = render::rescaled({}, render::kNominalRange, *resolved.value_range);
  }
  // A style in the session turns shading on, even when the file turns it off.
  const bool in_file = resolved.shading.enabled || appearance.style.has_value();
  if (appearance.shading && !in_file && appearance.emphasis) {
    return Error{ErrorCode::kUsage,
                 "look.emphasis: requires shading, which is off in " + appearance.file.string()};
  }
  resolved.shading.enabled = in_file && appearance.shading;
  resolved.shading.emphasis = appearance.emphasis.value_or(resolved.shading.emphasis);
  if (appearance.style) {
    resolved.shading.style =
        *appearance.style == "gooch" ? render::ShadingStyle::kGooch : render::ShadingStyle::kPhong;
  }
  resolved.projection = appearance.projection == "maximum"   ? render::Projection::kMaximum
                        : appearance.projection == "minimum" ? render::Projection::kMinimum
                        : appearance.projection == "mean"    ? render::Projection::kMean
                                                             : render::Projection::kComposite;
  if (appearance.blood_at_mm && !has_vessels(resolved.transfer)) {
    return Error{ErrorCode::kUsage,
                 "look.blood_at_mm: expected an appearance with a component named vessels, found " +
                     resolved.transfer.name()};
  }
  resolved.fit_vessels = (resolved.fit_vessels || appearance.blood_at_mm) && appearance.fit_vessels;
  resolved.remove_table = *file && (*file)->remove_table && appearance.remove_table;
  resolved.smoothing_mm = appearance.smoothing_mm.value_or(*file ? (*file)->smoothing_mm : 0.0);
  auto drawn = drawn_ct(resolved, appearance, ct);
  if (!drawn) return drawn.error();
  resolved.drawn = *std::move(drawn);
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
    diagnostics.report(Severity::kWarning, "appearance", text.str());
  }
}

void warn_of_missing_presets(const SessionConfig::Appearance& appearance, const Volume& ct,
                             Diagnostics& diagnostics) {
  const std::filesystem::path folder = preset_folder();
  std::error_code none;
  const bool by_preset = appearance.file.empty() && appearance.nodes.empty();
  if (!by_preset || appearance.preset != kContextualPreset ||
      std::filesystem::is_directory(folder, none)) {
    return;
  }
  diagnostics.report(Severity::kWarning, "appearance",
                     folder.string() + ": expected the folder of the presets, found none: " +
                         preset_name(appearance, ct) + " is drawn in place of " +
                         kContextualPreset + " (SONDE_APPEARANCES names another folder)");
}

bool draws_hounsfield_units(const SessionConfig::Appearance& appearance) {
  return appearance.file.empty() && appearance.nodes.empty() &&
         !appearance.preset.starts_with("mr");
}

Result<void> save_appearance(const std::filesystem::path& path,
                             const ResolvedAppearance& appearance) {
  if (path.empty()) return {};
  return write_appearance_file(
      path, {appearance.transfer, appearance.shading, appearance.cutaway, appearance.value_range,
             appearance.fit_vessels, appearance.remove_table, appearance.smoothing_mm});
}

}  // namespace nav::app
