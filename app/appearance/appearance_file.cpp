// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/appearance/appearance_file.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "app/appearance/slicer_preset.hpp"
#include "io/atomic_file.hpp"
#include "io/json_member.hpp"
#include "render/transfer/smoothed_ct.hpp"

namespace nav::app {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kVersion = 1;
constexpr std::size_t kMostNodes = 4096;

/// JSON has no infinity: null stands for it.
io::Json finite_or_null(double x) { return std::isfinite(x) ? io::Json(x) : io::Json(nullptr); }

render::GradientWindow read_window(const io::Json& json, const std::string& where,
                                   std::optional<Error>& error) {
  render::GradientWindow window{0, 0, kInfinity, kInfinity};
  io::JsonMember member(json, where, error);
  member.number("zero_below", window.zero_below);
  member.number("full_from", window.full_from);
  member.number("full_to", window.full_to, true);
  member.number("zero_above", window.zero_above, true);
  member.finish();
  return window;
}

render::TransferComponent read_component(const io::Json& json, const std::string& where,
                                         std::optional<Error>& error) {
  render::TransferComponent component;
  io::JsonMember member(json, where, error);
  member.text("name", component.name);
  member.list("nodes", [&](const io::Json& node_json, const std::string& at) {
    render::TransferNode node{0, {1, 1, 1}, 0, 0.5};
    std::vector<double> rgb{1, 1, 1};
    io::JsonMember one(node_json, at, error);
    one.required_number("value", node.hu);
    one.numbers("rgb", 3, rgb);
    one.required_number("opacity_per_mm", node.opacity);
    one.number("importance", node.importance);
    one.finish();
    node.rgb = {rgb[0], rgb[1], rgb[2]};
    component.nodes.push_back(node);
  });
  if (const io::Json* gradient = member.any("gradient_per_mm"); gradient && !gradient->is_null()) {
    component.gradient = read_window(*gradient, where + ".gradient_per_mm", error);
  }
  member.finish();
  return component;
}

render::Shading read_shading(const io::Json& json, const std::string& where, double& smoothing_mm,
                             std::optional<Error>& error) {
  render::Shading s;
  std::string style = "phong";
  io::JsonMember member(json, where, error);
  member.flag("enabled", s.enabled);
  member.text("style", style);
  for (const auto& [key, value] : {std::pair("emphasis", &s.emphasis),
                                   {"full_gradient_per_mm", &s.full_gradient_per_mm},
                                   {"ambient", &s.ambient},
                                   {"diffuse", &s.diffuse},
                                   {"specular", &s.specular},
                                   {"shininess", &s.shininess},
                                   {"cool_share", &s.cool_share},
                                   {"warm_share", &s.warm_share},
                                   {"silhouette", &s.silhouette}}) {
    member.number(key, *value);
  }
  if (style != "phong" && style != "gooch") member.fail("style", "phong or gooch", style);
  member.number("smoothing_mm", smoothing_mm);
  if (!(smoothing_mm >= 0 && smoothing_mm <= render::kMostSmoothingMm)) {
    member.fail("smoothing_mm", "0 to 20 mm", smoothing_mm);
  }
  s.style = style == "gooch" ? render::ShadingStyle::kGooch : render::ShadingStyle::kPhong;
  member.finish();
  return s;
}

render::Cutaway read_cutaway(const io::Json& json, const std::string& where,
                             std::optional<Error>& error) {
  render::Cutaway c;
  io::JsonMember member(json, where, error);
  member.angle("theta1_deg", c.theta1_rad);
  member.angle("theta2_deg", c.theta2_rad);
  member.number("overlay_mm", c.overlay_mm, true);
  std::vector<double> thresholds;
  member.numbers("constant_thresholds", 2, thresholds);
  if (!thresholds.empty()) c.constant = {thresholds[0], thresholds[1]};
  if (c.constant && !(c.constant->lower >= 0 && c.constant->upper <= 1 &&
                      c.constant->lower < c.constant->upper)) {
    member.fail("constant_thresholds", "two numbers in [0, 1] in order", thresholds);
  }
  member.flag("around_plane", c.around_plane);
  member.flag("around_needle", c.around_needle);
  member.flag("around_targets", c.around_spheres);
  member.finish();
  // Checked here in the names and units of the file, before the scene reports its own.
  const auto degrees = [](double rad) {
    constexpr double kShares = 1e9;  // Parts of a degree; removes rounding errors.
    return std::round(rad * 180 / M_PI * kShares) / kShares;
  };
  for (const auto& [key, angle] :
       {std::pair("theta1_deg", c.theta1_rad), std::pair("theta2_deg", c.theta2_rad)}) {
    if (!(angle > 0 && angle < M_PI / 2)) member.fail(key, "an angle in (0, 90)", degrees(angle));
  }
  if (c.theta1_rad > c.theta2_rad) {
    member.fail("theta1_deg", "at most theta2_deg", degrees(c.theta1_rad));
  }
  return c;
}

/// Checks the shading and the cutaway alone with validate(Scene).
Result<void> check_in_scene(const std::string& name, const AppearanceFile& appearance) {
  static const auto voxel = std::make_shared<const Volume>(
      *Volume::create(VoxelGrid{{1, 1, 1}}, std::vector<std::int16_t>(1), "look"));
  render::Scene scene{.ct = voxel,
                      .transfer = appearance.transfer,
                      .shading = appearance.shading.value_or(render::Shading{}),
                      .camera = render::Camera{{{0, -10, 0}}, {{0, 0, 0}}, {{0, 0, 1}}}};
  if (appearance.cutaway) scene.cutaway = *appearance.cutaway;
  const auto ok = render::validate(scene);
  if (ok) return {};
  return Error{ErrorCode::kMalformedData, name + ": " + ok.error().message};
}

Result<AppearanceFile> appearance_from_json(const std::string& name, const io::Json& root) {
  std::optional<Error> error;
  io::JsonMember member(root, name, error);
  double version = 0;
  std::string title = name;
  std::vector<double> range;
  std::vector<render::TransferComponent> components;
  std::size_t nodes = 0;
  member.number("sonde_look", version);
  member.text("name", title);
  member.list("components", [&](const io::Json& json, const std::string& at) {
    components.push_back(read_component(json, at, error));
    nodes += components.back().nodes.size();
    if (nodes > kMostNodes) member.fail("components", "at most 4096 nodes", nodes);
  });
  member.numbers("value_range", 2, range);
  bool fit_vessels = false;
  member.flag("fit_vessels", fit_vessels);
  bool remove_table = false;
  member.flag("remove_table", remove_table);
  std::optional<render::Shading> shading;
  double smoothing_mm = 0;
  if (const io::Json* json = member.any("shading"))
    shading = read_shading(*json, name + ".shading", smoothing_mm, error);
  std::optional<std::optional<render::Cutaway>> cutaway;
  if (const io::Json* json = member.any("cutaway")) {
    cutaway.emplace();
    if (!json->is_null()) *cutaway = read_cutaway(*json, name + ".cutaway", error);
  }
  member.finish();
  if (version != kVersion) member.fail("sonde_look", "1", version);
  if (!range.empty() && !(range[0] < range[1])) {
    member.fail("value_range", "two numbers in order", range);
  }
  const auto is_vessels = [](const auto& one) { return one.name == kVesselComponent; };
  if (fit_vessels && std::ranges::none_of(components, is_vessels)) {
    member.fail("fit_vessels", "a component named vessels", "none");
  }
  if (fit_vessels && !range.empty()) {
    member.fail("fit_vessels", "HU, without value_range", "both");
  }
  if (remove_table && !range.empty()) {
    member.fail("remove_table", "HU, without value_range", "both");
  }
  if (error) return *error;
  auto transfer = render::TransferFunction::blend(title, std::move(components));
  if (!transfer) return Error{transfer.error().code, name + ": " + transfer.error().message};
  AppearanceFile appearance{.transfer = *std::move(transfer),
                            .shading = shading,
                            .cutaway = cutaway,
                            .value_range = {},
                            .fit_vessels = fit_vessels,
                            .remove_table = remove_table,
                            .smoothing_mm = smoothing_mm};
  if (!range.empty()) appearance.value_range = render::ValueRange{range[0], range[1]};
  if (const auto ok = check_in_scene(name, appearance); !ok) return ok.error();
  return appearance;
}

io::Json window_json(const render::GradientWindow& w) {
  return {{"zero_below", w.zero_below},
          {"full_from", w.full_from},
          {"full_to", finite_or_null(w.full_to)},
          {"zero_above", finite_or_null(w.zero_above)}};
}

io::Json component_json(const render::TransferComponent& component) {
  io::Json nodes = io::Json::array();
  for (const render::TransferNode& node : component.nodes) {
    nodes.push_back({{"value", node.hu},
                     {"rgb", {node.rgb.x(), node.rgb.y(), node.rgb.z()}},
                     {"opacity_per_mm", node.opacity},
                     {"importance", node.importance}});
  }
  io::Json json{{"name", component.name}, {"nodes", std::move(nodes)}};
  if (component.gradient) json["gradient_per_mm"] = window_json(*component.gradient);
  return json;
}

io::Json shading_json(const render::Shading& s, double smoothing_mm) {
  return {{"enabled", s.enabled},
          {"smoothing_mm", smoothing_mm},
          {"style", s.style == render::ShadingStyle::kGooch ? "gooch" : "phong"},
          {"emphasis", s.emphasis},
          {"full_gradient_per_mm", s.full_gradient_per_mm},
          {"ambient", s.ambient},
          {"diffuse", s.diffuse},
          {"specular", s.specular},
          {"shininess", s.shininess},
          {"cool_share", s.cool_share},
          {"warm_share", s.warm_share},
          {"silhouette", s.silhouette}};
}

}  // namespace

Result<AppearanceFile> read_appearance_file(const std::filesystem::path& path) {
  constexpr std::uint64_t kMostBytes = 1 << 20;
  auto text = io::read_file(path, kMostBytes);
  if (!text) return text.error();
  const std::string name = path.string();
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  if (text->starts_with(kByteOrderMark)) text->erase(0, kByteOrderMark.size());
  const auto first = text->find_first_not_of(" \t\r\n");
  if (first == std::string::npos) {
    return Error{
        ErrorCode::kMalformedData,
        name + ": expected an appearance or a Slicer volume property, found an empty file"};
  }
  if ((*text)[first] != '{' && path.extension() != ".json") {
    return slicer_appearance_from_vp(name, *text);
  }
  const auto root = io::parse_json(name, *text);
  if (!root) return root.error();
  try {
    if (root->is_object() && root->contains("volumeProperties")) {
      return slicer_appearance_from_json(name, nlohmann::json(*root));
    }
    return appearance_from_json(name, *root);
  } catch (const nlohmann::json::exception&) {
    return Error{ErrorCode::kMalformedData,
                 name + ": expected the members of an appearance, found one of another type"};
  }
}

Result<AppearanceFile> parse_appearance_text(const std::string& name, const std::string& text) {
  const auto root = io::parse_json(name, text);
  if (!root) return root.error();
  try {
    return appearance_from_json(name, *root);
  } catch (const nlohmann::json::exception&) {
    return Error{ErrorCode::kMalformedData,
                 name + ": expected the members of an appearance, found one of another type"};
  }
}

std::string to_json_text(const AppearanceFile& appearance) {
  io::Json root{{"sonde_look", kVersion}, {"name", appearance.transfer.name()}};
  root["components"] = io::Json::array();
  for (const auto& component : appearance.transfer.components()) {
    root["components"].push_back(component_json(component));
  }
  if (appearance.value_range)
    root["value_range"] = {appearance.value_range->low, appearance.value_range->high};
  if (appearance.fit_vessels) root["fit_vessels"] = true;
  if (appearance.remove_table) root["remove_table"] = true;
  if (appearance.shading) {
    root["shading"] = shading_json(*appearance.shading, appearance.smoothing_mm);
  }
  if (appearance.cutaway) {
    const auto& c = *appearance.cutaway;
    root["cutaway"] = !c ? io::Json(nullptr)
                         : io::Json{{"theta1_deg", c->theta1_rad / io::kRadPerDeg},
                                    {"theta2_deg", c->theta2_rad / io::kRadPerDeg},
                                    {"overlay_mm", finite_or_null(c->overlay_mm)},
                                    {"around_plane", c->around_plane},
                                    {"around_needle", c->around_needle},
                                    {"around_targets", c->around_spheres}};
    if (c && c->constant) {
      root["cutaway"]["constant_thresholds"] = {c->constant->lower, c->constant->upper};
    }
  }
  return root.dump(2, ' ', false, io::Json::error_handler_t::replace) + "\n";
}

Result<void> write_appearance_file(const std::filesystem::path& path,
                                   const AppearanceFile& appearance) {
  return io::write_file(path, to_json_text(appearance));
}

Result<AppearanceFile> appearance_for(AppearanceFile appearance, const Volume& volume) {
  if (!appearance.value_range) return appearance;
  const render::ValueRange range = render::value_range(volume);
  auto laid = render::rescaled(appearance.transfer, *appearance.value_range, range);
  if (!laid) {
    return Error{laid.error().code,
                 "value_range: nodes become equal when mapped to the volume's range: " +
                     laid.error().message};
  }
  appearance.transfer = *std::move(laid);
  appearance.shading = render::rescaled(appearance.shading.value_or(render::Shading{}),
                                        *appearance.value_range, range);
  appearance.value_range = range;
  return appearance;
}

}  // namespace nav::app
