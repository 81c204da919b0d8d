// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/window_report.hpp"

#include <numeric>

namespace nav::app {
namespace {

/// Percentiles by name; null without values.
io::Json shares_of(std::vector<double> values,
                   const std::vector<std::pair<const char*, double>>& wanted) {
  if (values.empty()) return nullptr;
  std::sort(values.begin(), values.end());
  io::Json json;
  for (const auto& [name, share] : wanted) {
    json[name] =
        values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
  }
  return json;
}

io::Json mean_of(const std::vector<double>& values) {
  if (values.empty()) return nullptr;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

}  // namespace

void WindowReport::state(double t_s, const InputStatus& input) {
  std::string& now = state_now_[input.name];
  const std::string state = to_string(input.safety.state);
  if (now == state) return;
  now = state;
  states_.push_back({t_s, input.name, state, input.safety.cause});
}

void WindowReport::job(const std::string& name, double seconds, bool cancelled,
                       std::optional<double> cancel_ms) {
  jobs_.push_back({{"name", name},
                   {"seconds", seconds},
                   {"cancelled", cancelled},
                   {"cancel_took_ms", cancel_ms ? io::Json(*cancel_ms) : io::Json(nullptr)}});
}

io::Json WindowReport::json() const {
  io::Json json;
  for (const char* later :
       {"toolkit", "platform", "engine", "device", "device_pixel_ratio", "superseded", "ledger",
        "recordings", "latency_independent_ms", "controls", "diagnostics", "findings"}) {
    json[later] = nullptr;
  }
  json["refreshes"] = refreshes_;
  json["latency_ms"] =
      shares_of(latency_ms_, {{"p50", 0.5}, {"p95", 0.95}, {"p99", 0.99}, {"max", 1}});
  json["input_to_paint_ms"] =
      shares_of(input_to_paint_ms_, {{"p50", 0.5}, {"p95", 0.95}, {"max", 1}});
  json["handler_ms"] = shares_of(handler_ms_, {{"p99", 0.99}, {"max", 1}});
  json["longest_block_ms"] = longest_block_ms_;
  json["paint_cpu_ms"] = {
      {"mean", mean_of(paint_ms_)}, {"800x600", nullptr}, {"1600x900", nullptr}};
  json["convert_cpu_ms"] = mean_of(convert_ms_);
  json["withdrawn_after_ms"] = shares_of(withdrawn_ms_, {{"max", 1}});
  json["covered_after_ms"] = shares_of(covered_ms_, {{"max", 1}});
  json["epochs_disagree"] = epochs_disagree_;
  json["states"] = io::Json::array();
  for (const StateChange& change : states_) {
    json["states"].push_back({{"t_s", change.t_s},
                              {"input", change.input},
                              {"state", change.state},
                              {"cause", change.cause}});
  }
  json["jobs"] = jobs_;
  json["costs"] = io::Json::array();
  for (const auto& [view, times] : draw_ms_) {
    json["costs"].push_back({{"element", view}, {"ms", mean_of(times)}, {"drawn", times.size()}});
  }
  json["shots"] = shots_;
  return json;
}

}  // namespace nav::app
