// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/predicates/predicate_file.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "io/atomic_file.hpp"
#include "io/json_member.hpp"
#include "render/predicates/registry.hpp"
#include "render/predicates/set.hpp"
#include "render/transfer/smoothed_ct.hpp"

namespace nav::app {
namespace {

using render::PredicateExpression;
using Operator = PredicateExpression::Operator;

constexpr int kPredicateVersion = 1;
constexpr const char* kRad = "_rad";
// Levels of JSON: file, list and entry; two for each AND or OR; the predicate and its parameters.
// One more combination is allowed, so that the model rejects it with its own message.
static_assert(3 + 2 * (render::kDeepestCombination + 1) + 2 <= io::kDeepestJson);

bool in_radians(const render::PredicateParameter& p) { return p.name.ends_with(kRad); }

/// Name of a parameter in files, where angles are in degrees.
std::string key_of(const render::PredicateParameter& p) {
  return in_radians(p) ? p.name.substr(0, p.name.size() - 4) + "_deg" : p.name;
}

std::string interval(double low, double high) {
  std::ostringstream text;
  text.precision(12);
  text << "[" << low << ", " << high << "]";
  return text.str();
}

PredicateExpression read_kind(const std::string& name, const io::Json& json,
                              const std::string& where, std::optional<Error>& error) {
  PredicateExpression out = PredicateExpression::kind(name);
  const auto kind = render::find_predicate_kind(name);
  if (!kind) {
    if (!error) error = Error{kind.error().code, where + ": " + kind.error().message};
    return out;
  }
  io::JsonMember member(json, where + "." + name, error);
  for (const render::PredicateParameter& p : (*kind)->parameters()) {
    double value = p.initial;
    const double unit = in_radians(p) ? io::kRadPerDeg : 1;
    double found = value / unit;
    member.number(key_of(p).c_str(), found);
    if (json.is_object() && json.contains(key_of(p))) {
      value = found * unit;
      if (!(value >= p.low && value <= p.high)) {
        member.fail(key_of(p), "a number in " + interval(p.low / unit, p.high / unit), found);
      }
    }
    out.values.push_back(value);
  }
  member.finish();
  return out;
}

PredicateExpression read_expression(const io::Json& json, const std::string& where,
                                    std::optional<Error>& error) {
  io::JsonMember member(json, where, error);
  if (error) return {};
  if (json.size() != 1) {
    member.fail("", "one of not, all, any, connected, entry or a predicate", json);
    return {};
  }
  const std::string key = json.begin().key();
  const io::Json& value = json.begin().value();
  PredicateExpression out;
  if (key == "entry") {
    out.op = Operator::kEntry;
    member.text("entry", out.name);
  } else if (key == "not") {
    out = PredicateExpression::negation(read_expression(value, where + ".not", error));
  } else if (key == "connected") {
    double least_mm3 = 0;
    PredicateExpression operand;
    io::JsonMember inner(value, where + ".connected", error);
    inner.number("least_mm3", least_mm3);
    if (!(least_mm3 >= 0 && least_mm3 <= 1e9)) {
      inner.fail("least_mm3", "a number in [0, 1e9]", least_mm3);
    }
    if (const io::Json* of = inner.any("of")) {
      operand = read_expression(*of, where + ".connected.of", error);
    } else {
      inner.fail("of", "an expression", nullptr);
    }
    inner.finish();
    out = PredicateExpression::connected(std::move(operand), least_mm3);
  } else if (key == "all" || key == "any") {
    out.op = key == "all" ? Operator::kAnd : Operator::kOr;
    member.list(key.c_str(), [&](const io::Json& one, const std::string& at) {
      out.operands.push_back(read_expression(one, at, error));
    });
  } else {
    out = read_kind(key, value, where, error);
  }
  return out;
}

/// Reads entry and bar from one member of "predicates".
void read_entry(const io::Json& json, const std::string& where, render::PredicateModel& model,
                std::vector<render::PredicateHistogram::Bar>& bars, std::optional<Error>& error) {
  render::PredicateEntry entry;
  render::PredicateHistogram::Bar bar{1, 0, 0};
  io::JsonMember member(json, where, error);
  member.text("name", entry.name);
  member.number("importance", bar.importance);
  member.number("hue_deg", bar.hue_deg);
  member.number("saturation", bar.saturation);
  member.number("floor", entry.floor);
  if (const io::Json* expression = member.any("where")) {
    entry.expression = read_expression(*expression, where + ".where", error);
  } else {
    member.fail("where", "an expression", nullptr);
  }
  member.finish();
  model.entries.push_back(std::move(entry));
  bars.push_back(bar);
}

void read_hue_mean(io::JsonMember& member, PredicateFile& file) {
  std::string how = "circular";
  member.text("hue_mean", how);
  if (how != "circular" && how != "linear") member.fail("hue_mean", "circular or linear", how);
  file.hue_mean =
      how == "linear" ? render::spec::HueMean::kLinear : render::spec::HueMean::kCircular;
}

void read_vessels(io::JsonMember& member, VesselScales& vessels) {
  member.number("smallest_radius_mm", vessels.smallest_radius_mm);
  member.number("largest_radius_mm", vessels.largest_radius_mm);
  member.flag("bright", vessels.bright);
  member.finish();
  if (!(vessels.smallest_radius_mm >= 1e-3 && vessels.smallest_radius_mm <= 100)) {
    member.fail("smallest_radius_mm", "a number in [0.001, 100]", vessels.smallest_radius_mm);
  }
  if (!(vessels.largest_radius_mm >= vessels.smallest_radius_mm &&
        vessels.largest_radius_mm <= 100)) {
    member.fail("largest_radius_mm", "at least smallest_radius_mm, at most 100",
                vessels.largest_radius_mm);
  }
}

void read_smoothing(io::JsonMember& member, double& smoothing_mm) {
  member.number("smoothing_mm", smoothing_mm);
  member.finish();
  if (!(smoothing_mm >= 0 && smoothing_mm <= 20)) {
    member.fail("smoothing_mm", "a number in [0, 20]", smoothing_mm);
  }
}

void read_snr(io::JsonMember& member, render::features::SnrOptions& snr) {
  using render::features::WindowWeights;
  double voxels = snr.window_voxels;
  std::string weights = "uniform";
  member.number("window_voxels", voxels);
  member.text("weights", weights);
  member.finish();
  if (voxels >= 3 && voxels <= 31 && std::fmod(voxels, 2) == 1) {
    snr.window_voxels = static_cast<int>(voxels);
  } else {
    member.fail("window_voxels", "an odd number in [3, 31]", voxels);
  }
  if (weights != "uniform" && weights != "gaussian") {
    member.fail("weights", "uniform or gaussian", weights);
  }
  snr.weights = weights == "gaussian" ? WindowWeights::kGaussian : WindowWeights::kUniform;
}

void read_confidence(io::JsonMember& member, const std::string& name, std::optional<Error>& error,
                     render::features::ConfidenceOptions& confidence) {
  member.number("alpha", confidence.alpha);
  member.number("beta", confidence.beta);
  member.number("gamma", confidence.gamma);
  member.finish();
  if (error) return;
  if (const auto ok = validate(confidence); !ok) {
    error = Error{ErrorCode::kMalformedData, name + ": " + ok.error().message};
  }
}

void read_shading(io::JsonMember& member, PredicateFile& file) {
  member.number("smoothing_mm", file.shading_mm);
  member.number("full_gradient_per_mm", file.full_gradient_per_mm);
  member.finish();
  if (!(file.shading_mm >= 0 && file.shading_mm <= render::kMostSmoothingMm)) {
    member.fail("smoothing_mm", "a number in [0, 20]", file.shading_mm);
  }
  if (!(file.full_gradient_per_mm >= 1e-4 && file.full_gradient_per_mm <= 100)) {
    member.fail("full_gradient_per_mm", "a number in [0.0001, 100]", file.full_gradient_per_mm);
  }
}

/// Collects the predicates of an expression, each once.
void collect(const PredicateExpression& e, std::vector<PredicateExpression>& different) {
  for (const auto& operand : e.operands) collect(operand, different);
  const bool known = std::find(different.begin(), different.end(), e) != different.end();
  if (e.op == Operator::kKind && !known) different.push_back(e);
}

Result<PredicateFile> from_json(const std::string& name, const io::Json& root) {
  std::optional<Error> error;
  io::JsonMember member(root, name, error);
  member.version("sonde_predicates", kPredicateVersion);
  PredicateFile file{name, {}};
  std::vector<render::PredicateHistogram::Bar> bars;
  member.text("name", file.name);
  member.number("opacity_length_mm", file.opacity_length_mm);
  if (!(file.opacity_length_mm >= 1e-3 && file.opacity_length_mm <= 1e4)) {
    member.fail("opacity_length_mm", "a number in [0.001, 10000]", file.opacity_length_mm);
  }
  member.number("soft_thresholds", file.soft_share);
  if (!(file.soft_share >= 0 && file.soft_share <= 1)) {
    member.fail("soft_thresholds", "a number in [0, 1]", file.soft_share);
  }
  member.number("cutaway_importance", file.cutaway_importance);
  if (!(file.cutaway_importance >= 0 && file.cutaway_importance <= 1)) {
    member.fail("cutaway_importance", "a number in [0, 1]", file.cutaway_importance);
  }
  read_hue_mean(member, file);
  member.object("vessels", [&](io::JsonMember& vessels) { read_vessels(vessels, file.vessels); });
  member.object("gradient",
                [&](io::JsonMember& gradient) { read_smoothing(gradient, file.smoothing_mm); });
  member.object("snr", [&](io::JsonMember& snr) { read_snr(snr, file.snr); });
  member.object("confidence", [&](io::JsonMember& confidence) {
    read_confidence(confidence, name, error, file.confidence);
  });
  member.object("shading", [&](io::JsonMember& shading) { read_shading(shading, file); });
  member.list("predicates", [&](const io::Json& json, const std::string& at) {
    read_entry(json, at, file.model, bars, error);
  });
  member.finish();
  if (error) return *error;
  auto histogram = render::PredicateHistogram::create(std::move(bars));
  if (!histogram) return Error{histogram.error().code, name + ": " + histogram.error().message};
  file.model.histogram = *std::move(histogram);
  if (const auto ok = render::validate(file.model); !ok) {
    return Error{ok.error().code, name + ": " + ok.error().message};
  }
  std::vector<PredicateExpression> different;
  for (const auto& entry : file.model.entries) collect(entry.expression, different);
  if (different.size() > render::kMostLeaves) {
    return Error{ErrorCode::kMalformedData,
                 name + ": predicates: expected at most " + std::to_string(render::kMostLeaves) +
                     " different predicates, found " + std::to_string(different.size())};
  }
  return file;
}

io::Json kind_json(const PredicateExpression& e) {
  io::Json values = io::Json::object();
  const auto parameters = (*render::find_predicate_kind(e.name))->parameters();
  for (std::size_t i = 0; i < e.values.size(); ++i) {
    values[key_of(parameters[i])] =
        in_radians(parameters[i]) ? e.values[i] / io::kRadPerDeg : e.values[i];
  }
  return {{e.name, std::move(values)}};
}

io::Json expression_json(const PredicateExpression& e) {
  if (e.op == Operator::kKind) return kind_json(e);
  if (e.op == Operator::kEntry) return {{"entry", e.name}};
  if (e.op == Operator::kNot) return {{"not", expression_json(e.operands.front())}};
  if (e.op == Operator::kConnected) {
    return {{"connected",
             {{"least_mm3", e.values.front()}, {"of", expression_json(e.operands.front())}}}};
  }
  io::Json operands = io::Json::array();
  for (const auto& operand : e.operands) operands.push_back(expression_json(operand));
  return {{e.op == Operator::kAnd ? "all" : "any", std::move(operands)}};
}

}  // namespace

Result<PredicateFile> preset_predicate_file(const std::string& name) {
  auto model = render::preset_predicates(name);
  if (!model) return model.error();
  PredicateFile file{name, *std::move(model)};
  if (name == "carotid-vessel" || name == "thyroid") file.vessels = {2, 4.5, false};
  if (name == "abdomen") file.vessels = {1.5, 6, false};
  return file;
}

Result<PredicateFile> read_predicate_file(const std::filesystem::path& path) {
  constexpr std::uint64_t kMostBytes = 1 << 20;
  const auto root = io::read_json(path, kMostBytes);
  if (!root) return root.error();
  return from_json(path.string(), *root);
}

Result<PredicateFile> parse_predicate_text(const std::string& name, const std::string& text) {
  const auto root = io::parse_json(name, text);
  if (!root) return root.error();
  return from_json(name, *root);
}

std::string to_json_text(const PredicateFile& file) {
  io::Json root{{"sonde_predicates", kPredicateVersion}, {"name", file.name}};
  root["predicates"] = io::Json::array();
  for (std::size_t j = 0; j < file.model.entries.size(); ++j) {
    const auto& bar = file.model.histogram.bars()[j];
    root["predicates"].push_back({{"name", file.model.entries[j].name},
                                  {"importance", bar.importance},
                                  {"hue_deg", bar.hue_deg},
                                  {"saturation", bar.saturation},
                                  {"where", expression_json(file.model.entries[j].expression)}});
    const double floor = file.model.entries[j].floor;
    if (floor > 0) root["predicates"].back()["floor"] = floor;
  }
  root["opacity_length_mm"] = file.opacity_length_mm;
  root["cutaway_importance"] = file.cutaway_importance;
  if (file.soft_share > 0) root["soft_thresholds"] = file.soft_share;
  if (file.shading_mm > 0) {
    root["shading"] = {{"smoothing_mm", file.shading_mm},
                       {"full_gradient_per_mm", file.full_gradient_per_mm}};
  }
  root["vessels"] = {{"smallest_radius_mm", file.vessels.smallest_radius_mm},
                     {"largest_radius_mm", file.vessels.largest_radius_mm},
                     {"bright", file.vessels.bright}};
  root["gradient"] = {{"smoothing_mm", file.smoothing_mm}};
  const bool uniform = file.snr.weights == render::features::WindowWeights::kUniform;
  root["snr"] = {{"window_voxels", file.snr.window_voxels},
                 {"weights", uniform ? "uniform" : "gaussian"}};
  root["confidence"] = {{"alpha", file.confidence.alpha},
                        {"beta", file.confidence.beta},
                        {"gamma", file.confidence.gamma}};
  root["hue_mean"] = file.hue_mean == render::spec::HueMean::kLinear ? "linear" : "circular";
  return root.dump(2, ' ', false, io::Json::error_handler_t::replace) + "\n";
}

Result<void> write_predicate_file(const std::filesystem::path& path, const PredicateFile& file) {
  return io::write_file(path, to_json_text(file));
}

}  // namespace nav::app
