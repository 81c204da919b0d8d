// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include "app/verbs/simulate/simulate.hpp"

namespace nav::app {
namespace {

/// A number of the command line and what it may be, ends included.
struct NumberOption {
  const char* name;
  double found;
  double least, most;
  const char* unit;          ///< With its space; empty: none.
  bool not_least = false;    ///< Without the least itself.
  bool zero_is_own = false;  ///< 0 stands for the probe's own.
};

std::string expected_of(const NumberOption& option) {
  std::ostringstream text;
  text.precision(12);
  if (option.zero_is_own) text << "0 (the probe's own) or ";
  if (option.not_least) {
    text << "more than " << option.least << " and at most " << option.most << option.unit;
  } else {
    text << option.least << " to " << option.most << option.unit;
  }
  return text.str();
}

bool is_within(const NumberOption& option) {
  if (option.zero_is_own && option.found == 0) return true;
  if (!(option.found >= option.least && option.found <= option.most)) return false;
  return !option.not_least || option.found > option.least;
}

Error out_of_range(const std::string& name, const std::string& expected, double found) {
  std::ostringstream text;
  text.precision(12);
  text << name << ": expected " << expected << ", found " << found;
  return {ErrorCode::kUsage, text.str()};
}

/// Ranges are what the parts of a session take, or narrower where those take what makes no sense.
std::vector<NumberOption> number_options(const SimulateOptions& o) {
  constexpr double kHourMs = 3.6e6;
  return {{"--ct-spacing-mm", o.ct_spacing_mm, 0.2, 100, " mm"},
          {"--length-mm", o.length_mm, 0, 500, " mm"},
          {"--angle-deg", o.angle_deg, 0, 170, " degrees"},
          {"--breathing-mm", o.breathing_mm.value_or(0), 0, 60, " mm"},
          {"--breathing-period-s", o.breathing_period_s.value_or(1), 0.5, 30, " s"},
          {"--deform-mm", o.deform_mm, 0, 20, " mm"},
          {"--needle-bending-mm", o.needle_bending_mm.value_or(0), 0, 200, " mm"},
          {"--needle-bevel-deg", o.needle_bevel_deg, -360, 360, " degrees"},
          {"--needle-speed-mm-s", o.needle_speed_mm_s, 0, 1000, " mm/s"},
          {"--needle-length-mm", o.needle_length_mm, 0, 1000, " mm", true},
          {"--tracker-rate-hz", o.tracker_rate_hz, 0, 10000, " Hz", true},
          {"--latency-ms", o.latency_ms, 0, 10000, " ms"},
          {"--jitter-ms", o.jitter_ms, 0, 1000, " ms"},
          {"--clock-offset-ms", o.clock_offset_ms, -kHourMs, kHourMs, " ms"},
          {"--clock-drift-ppm", o.clock_drift_ppm, -10000, 10000, " ppm"},
          {"--loss", o.loss, 0, 1, ""},
          {"--picture-offset-ms", o.picture_offset_ms, -10000, 10000, " ms"},
          {"--duration-s", o.duration_s, 0, 3600, " s", true},
          {"--frame-rate-hz", o.frame_rate_hz, 0, 1000, " Hz", true},
          {"--columns", static_cast<double>(o.columns), 16, 4096, " pixels", false, true},
          {"--rows", static_cast<double>(o.rows), 16, 4096, " pixels", false, true}};
}

/// A bending of what does not bend.
Result<void> check_needle(const SimulateOptions& options) {
  if (options.needle != "straight" || options.needle_bending_mm.value_or(0) == 0) return {};
  return out_of_range("--needle-bending-mm", "0 mm of a straight needle",
                      *options.needle_bending_mm);
}

/// Nobody who asks for a breath shall get a patient without.
Result<void> check_breathing(const SimulateOptions& options) {
  if (options.breathing != "none") return {};
  const char* given = options.breathing_mm         ? "--breathing-mm"
                      : options.breathing_period_s ? "--breathing-period-s"
                                                   : nullptr;
  if (given == nullptr) return {};
  return Error{ErrorCode::kUsage, std::string(given) +
                                      ": expected --breathing rigid, affine or smooth beside it, "
                                      "found none, of a patient who does not breathe"};
}

}  // namespace

std::vector<std::pair<std::string, std::string>> simulate_ranges() {
  std::vector<std::pair<std::string, std::string>> ranges;
  for (const NumberOption& option : number_options({})) {
    ranges.emplace_back(option.name, expected_of(option));
  }
  return ranges;
}

Result<void> validate(const SimulateOptions& options) {
  for (const NumberOption& option : number_options(options)) {
    if (!is_within(option)) return out_of_range(option.name, expected_of(option), option.found);
  }
  if (options.look_at_mm) {
    for (const double coordinate : *options.look_at_mm) {
      if (!std::isfinite(coordinate)) {
        return out_of_range("--look-at", "3 finite numbers, mm", coordinate);
      }
    }
  }
  if (!(options.duration_s * options.frame_rate_hz >= 1)) {
    return out_of_range("--duration-s",
                        "time for two pictures at --frame-rate-hz, at least " +
                            std::to_string(1 / options.frame_rate_hz) + " s",
                        options.duration_s);
  }
  if (auto ok = check_needle(options); !ok) return ok;
  return check_breathing(options);
}

}  // namespace nav::app
