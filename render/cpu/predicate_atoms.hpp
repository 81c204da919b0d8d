// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/predicate_march.hpp"
#include "render/predicates/set.hpp"

namespace nav::render {

/// A leaf of a set in the form in which the CPU engine tests it.
PredicateAtom atom_of(const PredicateSet& set, const PredicateSet::Leaf& leaf);
/// Rank of the cost of a test: values of the volume are available, positions are computed, features
/// are read.
int rank_of_test(const PredicateAtom& atom);

}  // namespace nav::render
