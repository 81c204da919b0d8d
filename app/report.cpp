// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/report.hpp"

#include <cmath>
#include <cstdio>
#include <iostream>

#include "io/atomic_file.hpp"
#include "registration/error_probability.hpp"

namespace nav::app {
namespace {

std::string escape(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    switch (c) {
      case '&':
        safe += "&amp;";
        break;
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '"':
        safe += "&quot;";
        break;
      default:
        safe += c;
    }
  }
  return safe;
}

constexpr const char* kStyle =
    "body{font:16px/1.5 system-ui,sans-serif;max-width:72rem;margin:2rem auto;padding:0 1rem;"
    "color:#1b2229;background:#fff}h1{font-size:1.6rem}h2{font-size:1.2rem;margin-top:2rem}"
    "p.summary{padding:.8rem 1rem;border-left:6px solid #2a9d4e;background:#eef8f1}"
    "p.warning{border-color:#d98200;background:#fff6e5}figure{margin:1.5rem 0}"
    "img{max-width:100%;height:auto;border-radius:4px;background:#101418}"
    "figcaption{color:#55606b;font-size:.9rem}table{border-collapse:collapse;min-width:30rem}"
    "td{border-bottom:1px solid #dde3e8;padding:.35rem .8rem .35rem 0;vertical-align:top}"
    "td:first-child{color:#55606b;white-space:nowrap}td+td{font-variant-numeric:tabular-nums;"
    "word-break:break-word}footer{margin-top:3rem;color:#55606b;font-size:.85rem}";

}  // namespace

io::Json json_number(double value) {
  return std::isfinite(value) ? io::Json(value) : io::Json(nullptr);
}

io::Json json_number(const std::optional<double>& value) {
  return value ? json_number(*value) : io::Json(nullptr);
}

io::Json json_of(const session::TissueFollower::Summary& summary) {
  io::Json json;
  json["pictures"] = summary.images;
  json["states"] = summary.states;
  json["alarms"] = io::Json::array();
  for (const auto& alarm : summary.alarms) {
    json["alarms"].push_back(
        {{"session_s", alarm.session_s}, {"state", alarm.state}, {"cause", alarm.cause}});
  }
  json["largest_displacement_mm"] = summary.largest_displacement_mm;
  json["cost_median"] = json_number(summary.cost_median);
  json["update_ms_median"] = json_number(1e3 * summary.update_s_median);
  json["updates_over_limit"] = summary.updates_over_limit;
  return json;
}

std::vector<std::pair<std::string, std::string>> rows_of(
    const session::TissueFollower::Summary& summary) {
  std::vector<std::pair<std::string, std::string>> rows;
  for (const auto& [state, count] : summary.states) rows.emplace_back(state, std::to_string(count));
  for (const auto& alarm : summary.alarms) {
    rows.emplace_back(alarm.state + " at " + quantity(alarm.session_s, 1, "s"), alarm.cause);
  }
  rows.emplace_back("largest displacement from the registration",
                    quantity(summary.largest_displacement_mm, 1, "mm"));
  rows.emplace_back("median time of an update", quantity(1e3 * summary.update_s_median, 1, "ms"));
  return rows;
}

io::Json json_of(const Eigen::Matrix4d& matrix) {
  io::Json numbers = io::Json::array();
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) numbers.push_back(matrix(row, column));
  }
  return numbers;
}

io::Json json_of(const tracking::StreamLedger& ledger) {
  io::Json json;
  json["received"] = ledger.received();
  json["shown"] = ledger.delivered();
  json["superseded"] = ledger.superseded();
  json["rejected"] = io::Json::object();
  for (const auto& [cause, count] : ledger.rejected()) json["rejected"][cause] = count;
  json["balanced"] = ledger.balanced();
  return json;
}

void report_placement(const session::Placement& placement, Diagnostics& diagnostics) {
  report_warnings(placement.warnings, diagnostics);
  for (const Finding& finding : placement.findings) diagnostics.report("placement", finding);
}

void report_warnings(const std::vector<std::string>& warnings, Diagnostics& diagnostics) {
  for (const std::string& warning : warnings) {
    diagnostics.report(Severity::kWarning, "registration", "accepted with a warning: " + warning);
  }
}

io::Json json_of(const registration::Decision& decision) {
  return {{"accepted", decision.accepted},
          {"verdict", registration::to_string(decision.verdict())},
          {"reasons", decision.reasons},
          {"warnings", decision.warnings}};
}

namespace {
io::Json as_json(const std::vector<registration::Misfit>& misfits) {
  io::Json list = io::Json::array();
  for (const registration::Misfit& misfit : misfits) {
    io::Json values = io::Json::array();
    for (const double value : misfit.values) values.push_back(json_number(value));
    io::Json deviations = io::Json::array();
    for (const double value : misfit.deviations) deviations.push_back(json_number(value));
    list.push_back(
        {{"cause", registration::to_string(misfit.cause)},
         {"excess_mm", json_number(misfit.excess_mm())},
         {"found_mm", json_number(misfit.found_mm)},
         {"noise_mm", json_number(misfit.noise_mm)},
         {"gain", json_number(misfit.gain)},
         {"unnoticed", json_number(misfit.unnoticed)},
         {"unnoticed_along", misfit.unnoticed_along.size() == 3 ? io::Json(misfit.unnoticed_along)
                                                                : io::Json(nullptr)},
         {"values", values},
         {"deviations", deviations}});
  }
  return list;
}

/// Tissue that the probe presses away; null if it was not estimated.
io::Json pressed_json(const registration::ImageRegistrationResult& result) {
  constexpr auto kIndex = registration::ImageErrors::kPressedIndex;
  if (!(result.error_sigmas[kIndex] > 0)) return nullptr;
  return {{"mm", json_number(result.errors.pressed_mm)},
          {"deviation_mm", json_number(result.error_deviations[kIndex])}};
}

io::Json bootstrap_json(const registration::ImageBootstrap& bootstrap,
                        const Point<frames::Ct>& target) {
  constexpr double kMost = 0.95;
  return {{"valid", bootstrap.valid},
          {"fault", bootstrap.fault},
          {"replicates", bootstrap.twists.size()},
          {"unsolved", bootstrap.unsolved},
          {"pictures", bootstrap.images},
          {"block_pictures", bootstrap.block},
          {"places", bootstrap.places},
          {"target_error_rms_mm", json_number(bootstrap.tre_rms_mm(target))},
          {"target_error_p95_mm", json_number(bootstrap.tre_quantile_mm(target, kMost))}};
}
}  // namespace

io::Json json_of(const registration::ImageRegistrationResult& result,
                 const registration::Decision& decision, const Point<frames::Ct>& target) {
  io::Json json = json_of(decision);
  json["iterations"] = result.iterations;
  json["seconds"] = result.total_s;
  json["termination"] = registration::to_string(result.termination);
  json["message"] = result.message;
  json["initial_cost"] = json_number(result.initial_cost);
  json["final_cost"] = json_number(result.final_cost);
  json["overlap"] = json_number(result.overlap);
  json["patches"] = result.patches;
  json["z_score"] = json_number(result.z_score);
  json["margin"] = result.margin ? json_number(*result.margin) : io::Json(nullptr);
  json["split_disagreement_mm"] = json_number(result.split_disagreement_mm);
  json["halves_disagreement_mm"] = json_number(result.halves_disagreement_mm);
  json["basin"] = {{"rise", json_number(result.basin.rise)},
                   {"shift_mm", json_number(result.basin.shift_mm)}};
  json["regions"] = io::Json::array();
  for (const auto& region : result.regions) {
    const Eigen::Vector3d& c = region.centre.mm;
    json["regions"].push_back({{"along", region.along},
                               {"deep", region.deep},
                               {"patches", region.patches},
                               {"cost", json_number(region.cost)},
                               {"pull_mm", json_number(region.pull_mm)},
                               {"centre_ct_mm", {c.x(), c.y(), c.z()}}});
  }
  json["misfits"] = as_json(result.misfits);
  json["pressed"] = pressed_json(result);
  json["predicted_target_error_rms_mm"] = json_number(result.tre_rms_mm(target));
  json["error_probability"] = json_number(registration::error_probability(result, target));
  json["clustered_target_error_rms_mm"] =
      result.covariance_valid ? json_number(result.clusters.tre_rms_mm(target)) : io::Json(nullptr);
  json["bootstrap"] = bootstrap_json(result.bootstrap, target);
  json["covariance_valid"] = result.covariance_valid;
  json["covariance_fault"] = result.covariance_fault;
  io::Json covariance = io::Json::array();
  for (int i = 0; i < 6; ++i) {
    for (int k = 0; k < 6; ++k) {
      covariance.push_back(json_number(result.uncertainty.covariance(i, k)));
    }
  }
  json["covariance"] = covariance;
  const Eigen::Vector3d centre = result.uncertainty.centre_ct.mm;
  json["covariance_centre_ct_mm"] = {json_number(centre.x()), json_number(centre.y()),
                                     json_number(centre.z())};
  json[pose_key(decision)] = json_of(result.ct_from_reference.matrix());
  return json;
}

io::Json json_of(const std::optional<render::StepChoice>& step) {
  if (!step) return nullptr;
  return {{"step_voxels", step->step_voxels},
          {"pixel_error", step->pixel_error},
          {"estimated_rms", json_number(step->rms)},
          {"reached", std::isnan(step->rms) ? io::Json() : io::Json(step->reached)}};
}

io::Json json_of(const render::HuWindow& window) {
  return {{"level", window.level}, {"width", window.width}};
}

io::Json json_of(const std::optional<render::GreyWindow>& window) {
  if (!window) return nullptr;
  return {{"level", window->level_hu}, {"width", window->width_hu}};
}

void add_messages(io::Json& report, const std::vector<DiagnosticEntry>& entries) {
  report["diagnostics"] = io::Json::array();
  report["findings"] = io::Json::array();
  for (const DiagnosticEntry& entry : entries) {
    report["diagnostics"].push_back({{"severity", to_string(entry.severity)},
                                     {"source", entry.source},
                                     {"message", entry.message},
                                     {"count", entry.count}});
    if (!entry.finding) continue;
    report["findings"].push_back({{"subject", entry.finding->subject},
                                  {"key", entry.finding->key},
                                  {"values", entry.finding->values},
                                  {"used", entry.finding->used},
                                  {"severity", to_string(entry.severity)},
                                  {"count", entry.count}});
  }
}

Result<void> write_json(const io::Json& json, const std::string& where) {
  // Bytes that are not UTF-8 (in file names or header fields) must not stop a report.
  const std::string text = json.dump(2, ' ', false, io::Json::error_handler_t::replace) + "\n";
  if (where == "-") {
    std::cout << text << std::flush;
    if (!std::cout) return Error{ErrorCode::kIo, "standard output: could not be written"};
    return {};
  }
  return io::write_file(where, std::string_view(text));
}

std::string quantity(double value, int digits, const std::string& unit) {
  if (!std::isfinite(value)) return "withdrawn";
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  return unit.empty() ? text : std::string(text) + " " + unit;
}

std::string to_html(const HtmlReport& report) {
  std::string html =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width\"><title>" +
      escape(report.title) + "</title><style>" + kStyle + "</style></head><body>\n";
  html += "<h1>" + escape(report.title) + "</h1>\n<p class=\"summary" +
          std::string(report.warning ? " warning" : "") + "\">" + escape(report.summary) + "</p>\n";
  for (const auto& [file, caption] : report.images) {
    html += "<figure><img src=\"" + escape(file) + "\" alt=\"" + escape(caption) +
            "\"><figcaption>" + escape(caption) + "</figcaption></figure>\n";
  }
  for (const auto& [heading, rows] : report.tables) {
    html += "<h2>" + escape(heading) + "</h2>\n<table>\n";
    for (const auto& [key, value] : rows) {
      html += "<tr><td>" + escape(key) + "</td><td>" + escape(value) + "</td></tr>\n";
    }
    html += "</table>\n";
  }
  html += "<footer>Sonde " SONDE_VERSION
          ". Research software, not a medical device.</footer>\n</body></html>\n";
  return html;
}

}  // namespace nav::app
