// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace nav {

/// The words for a cause that reports and ledgers have by a stable name: "nothing listens there"
/// for "no_listener", "the probe is not tracked" for "Probe.not_tracked". A name that is not known
/// has its underscores replaced.
std::string words_of_cause(std::string_view name);

}  // namespace nav
