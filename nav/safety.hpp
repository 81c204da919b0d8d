// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "nav/time.hpp"

namespace nav {

/// State of one input, or of several inputs together: the worst one counts.
enum class SafetyState {
  kValid,     ///< Fresh, complete and within its limits: numbers may be shown.
  kDegraded,  ///< Usable with a stated doubt (status unknown, low overlap).
  kStale,     ///< Older than its validity period: drawn as a ghost, numbers hidden.
  kLost,      ///< Absent or rejected: not drawn.
};

/// Stable lower-case name, for reports.
const char* to_string(SafetyState state);

/// State with the one cause that decides it. The cause is empty if and only if the state is valid.
struct Safety {
  SafetyState state = SafetyState::kLost;
  std::string cause = "nothing received yet";
  [[nodiscard]] bool shows_numbers() const { return state == SafetyState::kValid; }
};

/// Worst state of a transform chain or a scene. The first of several equal states names the cause.
/// Precondition: at least one input, otherwise a Bug.
Safety compose(const std::vector<Safety>& inputs);

/// Ages at which the data of a source become stale and lost.
struct FreshnessLimits {
  Duration stale_after;  ///< max(2 periods, 1 period + 20 ms).
  Duration lost_after;   ///< Five times stale_after, at least 250 ms.
};
/// Limits for a source that delivers data every \p period. Precondition: period > 0, otherwise a
/// Bug.
FreshnessLimits freshness_limits(Duration period);

/// State at \p now of an input that was last acquired at \p acquired. A time after now is degraded:
/// a clock that runs ahead makes the age doubtful.
Safety freshness(std::string_view input, Timestamp acquired, Timestamp now,
                 const FreshnessLimits& limits);

}  // namespace nav
