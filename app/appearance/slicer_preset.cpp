// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/appearance/slicer_preset.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace nav::app {
namespace {

using PresetJson = nlohmann::json;
constexpr std::size_t kMostPoints = 4096;
constexpr double kMostPosition = 1e9;

/// Point of a piecewise-linear curve: x and one value (opacity) or three (colour).
struct CurvePoint {
  double x;
  std::vector<double> y;
};
using Curve = std::vector<CurvePoint>;

struct SlicerProperty {
  bool shade = true;
  double diffuse = 0.9;
  double ambient = 0.1;
  double specular = 0.2;
  double power = 10;
  double unit_mm = 1;
  Curve opacity;
  Curve gradient;
  Curve colour;
};

Error rejected_preset(const std::string& where, const std::string& expected,
                      const std::string& found) {
  return {ErrorCode::kMalformedData, where + ": expected " + expected + ", found " + found};
}

std::string text_of(double x) {
  std::ostringstream text;
  text << x;
  return text.str();
}

/// Sorts the points and keeps all of them, as Slicer does. A point at the same x as the previous
/// one makes a step: it moves to the next single-precision number.
Curve sorted(Curve curve) {
  std::stable_sort(curve.begin(), curve.end(),
                   [](const CurvePoint& a, const CurvePoint& b) { return a.x < b.x; });
  constexpr float kFar = std::numeric_limits<float>::infinity();
  for (std::size_t i = 1; i < curve.size(); ++i) {
    const double before = curve[i - 1].x;
    if (curve[i].x <= before) curve[i].x = std::nextafter(static_cast<float>(before), kFar);
  }
  return curve;
}

Result<void> check_curve(const std::string& where, const Curve& curve, std::size_t least) {
  if (curve.size() < least || curve.size() > kMostPoints) {
    return rejected_preset(where,
                           std::to_string(least) + " to " + std::to_string(kMostPoints) + " points",
                           std::to_string(curve.size()));
  }
  for (const CurvePoint& point : curve) {
    if (!(std::abs(point.x) <= kMostPosition)) {
      return rejected_preset(where, "positions of at most 1e9", text_of(point.x));
    }
    for (const double y : point.y) {
      if (!(y >= 0 && y <= 1)) return rejected_preset(where, "values in [0, 1]", text_of(y));
    }
  }
  return {};
}

std::vector<double> at(const Curve& curve, double x) {
  const auto above =
      std::find_if(curve.begin(), curve.end(), [x](const CurvePoint& p) { return p.x > x; });
  if (above == curve.begin()) return curve.front().y;
  if (above == curve.end()) return curve.back().y;
  const CurvePoint& below = *(above - 1);
  const double w = (x - below.x) / (above->x - below.x);
  std::vector<double> y = below.y;
  for (std::size_t i = 0; i < y.size(); ++i) y[i] += w * (above->y[i] - y[i]);
  return y;
}

/// Gradient opacity in Sonde's form: the value of its plateau and a window.
struct GradientShare {
  double factor = 1;
  std::optional<render::GradientWindow> window;
};

Result<GradientShare> gradient_share(const std::string& where, const Curve& curve) {
  if (curve.empty()) return GradientShare{};
  double most = 0;
  for (const CurvePoint& p : curve) most = std::max(most, p.y[0]);
  const auto is = [](double a, double b) { return std::abs(a - b) < 1e-9; };
  if (std::all_of(curve.begin(), curve.end(),
                  [&](const CurvePoint& p) { return is(p.y[0], most); })) {
    return GradientShare{most, {}};
  }
  const auto plateau = [&](const CurvePoint& p) { return is(p.y[0], most); };
  const auto zero = [&](const CurvePoint& p) { return is(p.y[0], 0); };
  const auto first = std::find_if(curve.begin(), curve.end(), plateau);
  const auto last = std::find_if(curve.rbegin(), curve.rend(), plateau).base();  // One past it.
  const bool simple = std::all_of(first, last, plateau) &&
                      std::all_of(curve.begin(), first, zero) &&
                      std::all_of(last, curve.end(), zero) && curve.front().x >= 0;
  if (!simple) {
    return Error{ErrorCode::kUnsupportedData,
                 where +
                     ": expected a gradient opacity of one value, or from 0 to a plateau and "
                     "back to 0, found another curve"};
  }
  constexpr double kNoEnd = std::numeric_limits<double>::infinity();
  const bool rises = first != curve.begin();
  const bool falls = last != curve.end();
  return GradientShare{
      most, render::GradientWindow{rises ? (first - 1)->x : 0, rises ? first->x : 0,
                                   falls ? (last - 1)->x : kNoEnd, falls ? last->x : kNoEnd}};
}

Result<AppearanceFile> to_appearance(const std::string& name, SlicerProperty property) {
  for (const auto& [where, curve, least] :
       {std::tuple(name + ": scalar opacity", &property.opacity, std::size_t{2}),
        std::tuple(name + ": gradient opacity", &property.gradient, std::size_t{0}),
        std::tuple(name + ": colours", &property.colour, std::size_t{1})}) {
    if (const auto ok = check_curve(where, *curve, least); !ok) return ok.error();
    *curve = sorted(std::move(*curve));
  }
  const auto gradient = gradient_share(name + ": gradient opacity", property.gradient);
  if (!gradient) return gradient.error();
  std::vector<double> values;
  for (const CurvePoint& p : property.opacity) values.push_back(p.x);
  for (const CurvePoint& p : property.colour) values.push_back(p.x);
  std::sort(values.begin(), values.end());
  values.erase(std::unique(values.begin(), values.end()), values.end());
  render::TransferComponent component{"slicer", {}, gradient->window};
  for (const double x : values) {
    const double opacity = std::min(gradient->factor * at(property.opacity, x)[0], kMostOpaque);
    const auto rgb = at(property.colour, x);
    const double of_1_mm = -std::expm1(std::log1p(-opacity) / property.unit_mm);
    component.nodes.push_back({x, {rgb[0], rgb[1], rgb[2]}, std::min(of_1_mm, kMostOpaque), 0.5});
  }
  auto transfer = render::TransferFunction::blend(name, {component});
  if (!transfer) return transfer.error();
  render::Shading shading;
  shading.enabled = property.shade;
  shading.ambient = property.ambient;
  shading.diffuse = property.diffuse;
  shading.specular = property.specular;
  shading.shininess = property.power;
  return AppearanceFile{*std::move(transfer), shading, {}, {}};
}

/// Numbers in a line of a .vp file.
Result<std::vector<double>> numbers_of(const std::string& where, const std::string& line) {
  std::vector<double> numbers;
  std::istringstream stream(line);
  stream.imbue(std::locale::classic());
  for (std::string word; stream >> word;) {
    char* end = nullptr;
    const double number = std::strtod(word.c_str(), &end);
    if (*end != '\0' || !std::isfinite(number))
      return rejected_preset(where, "finite numbers", word);
    numbers.push_back(number);
  }
  return numbers;
}

/// Reads a curve from "count x y… x y…"; count is the number of all numbers after it.
Result<Curve> curve_of(const std::string& where, const std::string& line, std::size_t values) {
  const auto numbers = numbers_of(where, line);
  if (!numbers) return numbers.error();
  if (numbers->empty()) return rejected_preset(where, "a number of values", "an empty line");
  const double count = (*numbers)[0];
  const std::size_t group = values + 1;
  if (count != static_cast<double>(numbers->size() - 1) || (numbers->size() - 1) % group != 0) {
    return rejected_preset(
        where, "a count and that many numbers in groups of " + std::to_string(group),
        "count " + text_of(count) + " and " + std::to_string(numbers->size() - 1));
  }
  Curve curve;
  for (std::size_t i = 1; i < numbers->size(); i += group) {
    const auto begin = numbers->begin() + static_cast<std::ptrdiff_t>(i);
    curve.push_back({*begin, {begin + 1, begin + static_cast<std::ptrdiff_t>(group)}});
  }
  return curve;
}

/// Reads members of JSON objects and keeps the first problem.
class JsonReader {
 public:
  explicit JsonReader(std::string name) : name_(std::move(name)) {}
  [[nodiscard]] const std::optional<Error>& error() const { return error_; }

  double number(const PresetJson& object, const char* key, double fallback, double low,
                double high) {
    if (!object.contains(key)) return fallback;
    const PresetJson& found = object[key];
    if (found.is_number() && found.get<double>() >= low && found.get<double>() <= high) {
      return found.get<double>();
    }
    fail(key, "a number in [" + text_of(low) + ", " + text_of(high) + "]",
         found.dump().substr(0, 40));
    return fallback;
  }
  bool flag(const PresetJson& object, const char* key, bool fallback) {
    if (!object.contains(key)) return fallback;
    if (object[key].is_boolean()) return object[key].get<bool>();
    fail(key, "true or false", object[key].dump().substr(0, 40));
    return fallback;
  }
  Curve curve(const PresetJson& component, const char* key, bool colour) {
    Curve curve;
    if (!component.contains(key)) return curve;
    const PresetJson& function = component[key];
    if (!function.is_object() || !function.contains("points") || !function["points"].is_array()) {
      fail(key, "an object with a list of points", function.dump().substr(0, 40));
      return curve;
    }
    for (const PresetJson& point : function["points"]) {
      if (error_ || curve.size() > kMostPoints) break;
      curve.push_back(one_point(point, key, colour));
    }
    return curve;
  }

 private:
  CurvePoint one_point(const PresetJson& point, const char* key, bool colour) {
    const char* value = colour ? "color" : "y";
    const bool known = point.is_object() && point.contains("x") && point["x"].is_number() &&
                       point.contains(value) &&
                       (colour ? is_colour(point[value]) : point[value].is_number());
    if (!known) {
      fail(key, colour ? "points of x and three colours" : "points of x and y",
           point.dump().substr(0, 60));
      return {};
    }
    const double midpoint = number(point, "midpoint", 0.5, 0, 1);
    const double sharpness = number(point, "sharpness", 0, 0, 1);
    if (midpoint != 0.5 || sharpness != 0) {
      error_ = Error{ErrorCode::kUnsupportedData,
                     name_ + ": " + key + ": expected midpoint 0.5 and sharpness 0, found " +
                         text_of(midpoint) + " and " + text_of(sharpness)};
    }
    if (!colour) return {point["x"].get<double>(), {point[value].get<double>()}};
    return {point["x"].get<double>(), point[value].get<std::vector<double>>()};
  }
  static bool is_colour(const PresetJson& list) {
    return list.is_array() && list.size() == 3 &&
           std::all_of(list.begin(), list.end(), [](const PresetJson& c) { return c.is_number(); });
  }
  void fail(const std::string& key, const std::string& expected, const std::string& found) {
    if (!error_) error_ = rejected_preset(name_ + ": " + key, expected, found);
  }
  std::string name_;
  std::optional<Error> error_;
};

}  // namespace

Result<AppearanceFile> slicer_appearance_from_vp(const std::string& name, const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    if (line.find_first_not_of(" \t\r") != std::string::npos) lines.push_back(line);
  }
  constexpr std::size_t kLines = 9;
  if (lines.size() != kLines) {
    return rejected_preset(name, "the 9 lines of a Slicer volume property",
                           std::to_string(lines.size()));
  }
  std::array<double, 6> head{};
  const std::array<const char*, 6> names{"interpolation", "shade",    "diffuse",
                                         "ambient",       "specular", "specular power"};
  for (std::size_t i = 0; i < head.size(); ++i) {
    const auto numbers = numbers_of(name + ": " + names[i], lines[i]);
    if (!numbers) return numbers.error();
    if (numbers->size() != 1 || !((*numbers)[0] >= 0 && (*numbers)[0] <= 1000)) {
      return rejected_preset(name + ": " + names[i], "one number in [0, 1000]",
                             lines[i].substr(0, 40));
    }
    head[i] = (*numbers)[0];
  }
  if (head[0] == 0) return rejected_preset(name + ": interpolation", "1, linear", "0, nearest");
  SlicerProperty property;
  property.shade = head[1] != 0;
  property.diffuse = std::min(head[2], 10.0);
  property.ambient = std::min(head[3], 10.0);
  property.specular = std::min(head[4], 10.0);
  property.power = head[5];
  auto opacity = curve_of(name + ": scalar opacity", lines[6], 1);
  auto gradient = curve_of(name + ": gradient opacity", lines[7], 1);
  auto colour = curve_of(name + ": colours", lines[8], 3);
  for (const auto* curve : {&opacity, &gradient, &colour}) {
    if (!*curve) return curve->error();
  }
  property.opacity = *std::move(opacity);
  property.gradient = *std::move(gradient);
  property.colour = *std::move(colour);
  return to_appearance(name, std::move(property));
}

Result<AppearanceFile> slicer_appearance_from_json(const std::string& name,
                                                   const PresetJson& root) {
  const PresetJson& properties = root["volumeProperties"];
  if (!properties.is_array() || properties.size() != 1 || !properties[0].is_object() ||
      !properties[0].contains("components") || !properties[0]["components"].is_array()) {
    return rejected_preset(name + ": volumeProperties", "one volume property with components",
                           properties.dump().substr(0, 60));
  }
  const PresetJson& components = properties[0]["components"];
  if (components.size() != 1 || !components[0].is_object()) {
    return Error{ErrorCode::kUnsupportedData,
                 name + ": components: expected one, found " + std::to_string(components.size())};
  }
  const PresetJson interpolation = properties[0].value("interpolationType", PresetJson("linear"));
  if (interpolation != "linear") {
    return rejected_preset(name + ": interpolationType", "\"linear\"",
                           interpolation.dump().substr(0, 40));
  }
  if (properties[0].value("independentComponents", PresetJson(true)) != true) {
    return rejected_preset(name + ": independentComponents", "true, because there is one component",
                           properties[0]["independentComponents"].dump().substr(0, 40));
  }
  const PresetJson& component = components[0];
  JsonReader reader(name);
  SlicerProperty property;
  property.shade = reader.flag(component, "shade", false);  // Slicer's default.
  if (component.contains("lighting")) {
    const PresetJson& lighting = component["lighting"];
    if (!lighting.is_object()) {
      return rejected_preset(name + ": lighting", "an object", lighting.dump().substr(0, 40));
    }
    property.diffuse = reader.number(lighting, "diffuse", property.diffuse, 0, 10);
    property.ambient = reader.number(lighting, "ambient", property.ambient, 0, 10);
    property.specular = reader.number(lighting, "specular", property.specular, 0, 10);
    property.power = reader.number(lighting, "specularPower", property.power, 0, 1000);
  }
  property.unit_mm = reader.number(component, "scalarOpacityUnitDistance", 1, 1e-3, 1e3);
  property.opacity = reader.curve(component, "scalarOpacity", false);
  if (!reader.flag(component, "disableGradientOpacity", false)) {
    property.gradient = reader.curve(component, "gradientOpacity", false);
  }
  property.colour = reader.curve(component, "rgbTransferFunction", true);
  if (reader.error()) return *reader.error();
  for (const char* key : {"scalarOpacity", "rgbTransferFunction"}) {
    if (!component.contains(key)) return rejected_preset(name + ": " + key, "points", "none");
  }
  const PresetJson space = component["rgbTransferFunction"].value("colorSpace", PresetJson("rgb"));
  if (space != "rgb") {
    return rejected_preset(name + ": rgbTransferFunction.colorSpace", "\"rgb\"",
                           space.dump().substr(0, 40));
  }
  return to_appearance(name, std::move(property));
}

}  // namespace nav::app
