// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "nav/time.hpp"

namespace nav {

/// State of one input, or of everything composed from several: the worst wins.
enum class SafetyState {
  kValid,     ///< Fresh, complete, within its limits: numbers may be shown.
  kDegraded,  ///< Usable with a stated doubt (status unknown, low overlap).
  kStale,     ///< Older than its validity period: drawn as a ghost, numbers withdrawn.
  kLost,      ///< Absent or refused: not drawn.
};

/// Stable lower-case name, for reports.
const char* to_string(SafetyState state);

/// A state with the one cause that decides it. The cause is empty exactly when valid.
struct Safety {
  SafetyState state = SafetyState::kLost;
  std::string cause = "nothing received yet";
  [[nodiscard]] bool shows_numbers() const { return state == SafetyState::kValid; }
};

/// Worst state of a transform chain or of a scene; the first of equals names the cause.
/// Precondition: at least one input, otherwise a Bug.
Safety compose(const std::vector<Safety>& inputs);

/// When data of a source stop being live.
struct FreshnessLimits {
  Duration stale_after;  ///< max(2 periods, 1 period + 20 ms).
  Duration lost_after;   ///< Five times stale_after, at least 250 ms.
};
/// Limits for a source that delivers every period. Precondition: period > 0, otherwise a Bug.
FreshnessLimits freshness_limits(Duration period);

/// State of an input last acquired at a time, seen at now. A time after now is degraded: a clock
/// that runs ahead is a doubt, not freshness.
Safety freshness(std::string_view input, Timestamp acquired, Timestamp now,
                 const FreshnessLimits& limits);

}  // namespace nav
