// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>

#include "app/predicates/predicate_options.hpp"

namespace nav::app {

/// Rejects the first option that no predicate of the set reads: scan lines without a predicate of
/// depth, labels without a predicate of labels. Reads the set only where such an option was given.
/// kUsage, and the errors of reading the set.
Result<void> reject_idle_of_set(const CLI::App& parser, const PredicateOptions& options);

}  // namespace nav::app
