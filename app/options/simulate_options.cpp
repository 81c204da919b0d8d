// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <sstream>

#include "app/options/option.hpp"

namespace nav::app {
namespace {

Error out_of_range(const std::string& name, const std::string& expected, double found) {
  std::ostringstream text;
  text.precision(12);
  text << name << ": expected " << expected << ", found " << found;
  return {ErrorCode::kUsage, text.str()};
}

/// Rejects the bending of a needle that does not bend.
Result<void> check_needle(const SimulateOptions& options) {
  if (options.needle != "straight" || options.needle_bending_mm.value_or(0) == 0) return {};
  return out_of_range("--needle-bending-mm", "0 mm of a straight needle",
                      *options.needle_bending_mm);
}

/// Rejects a breath of a patient who does not breathe.
Result<void> check_breathing(const SimulateOptions& options) {
  if (options.breathing != "none") return {};
  const char* given = options.breathing_mm         ? "--breathing-mm"
                      : options.breathing_period_s ? "--breathing-period-s"
                                                   : nullptr;
  if (given == nullptr) return {};
  return Error{ErrorCode::kUsage,
               std::string(given) + " requires --breathing rigid, affine or smooth (found none)"};
}

}  // namespace

Result<void> validate(const SimulateOptions& options) {
  Settings settings;
  settings.simulate = options;
  for (const Option* option : options_of("simulate")) {
    if (const auto ok = check_value(*option, settings); !ok) {
      return Error{ok.error().code, option->name + ": " + ok.error().message};
    }
  }
  if (options.duration_s && !(*options.duration_s * options.frame_rate_hz >= 1)) {
    return out_of_range("--duration-s",
                        "time for two images at --frame-rate-hz, at least " +
                            std::to_string(1 / options.frame_rate_hz) + " s",
                        *options.duration_s);
  }
  if (auto ok = check_needle(options); !ok) return ok;
  return check_breathing(options);
}

}  // namespace nav::app
