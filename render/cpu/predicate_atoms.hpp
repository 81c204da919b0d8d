// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/predicate_march.hpp"
#include "render/predicates/set.hpp"

namespace nav::render {

/// A leaf of a set as the CPU engine tests it.
PredicateAtom atom_of(const PredicateSet& set, const PredicateSet::Leaf& leaf);
/// What a test costs, in ranks: values of the volume are there, places are computed, features read.
int rank_of_test(const PredicateAtom& atom);

}  // namespace nav::render
