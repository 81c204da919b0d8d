// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/console.hpp"
#include "app/predicate_file.hpp"
#include "app/predicate_options.hpp"
#include "bench/predicate_phantom.hpp"

namespace nav::app {

/// A volume that predicates can draw.
struct PreparedPredicates {
  PredicateFile file;             ///< The set-up, edits applied.
  bench::PredicateVolume volume;  ///< With the scene part that the set-up and its features give.
};

/// The set-up, a preset by its name or a file, with the edits and values of the options. Refuses
/// (kUsage) names that are neither, and values that the set-up's others rule out.
Result<PredicateFile> set_up_of(const PredicateOptions& options);

/// Reads the set-up, the volume (or makes the phantom), its labels and scan lines, and derives the
/// features that the set-up asks for. Before anything is computed it refuses (kUsage) what
/// predicates ask for and nobody gave.
Result<PreparedPredicates> prepare_predicates(const PredicateOptions& options, int threads,
                                              Console& console);

}  // namespace nav::app
