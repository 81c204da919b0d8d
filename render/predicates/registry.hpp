// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "render/predicates/feature.hpp"
#include "render/predicates/kind.hpp"

namespace nav::render {

// Declares <folder>_predicate() of every kind.
#define SONDE_PREDICATE(folder) const PredicateKind& folder##_predicate();
#include "render/predicates/registry.inc"
#undef SONDE_PREDICATE

/// Every kind of predicate, in the order of registry.inc.
const std::vector<const PredicateKind*>& predicate_kinds();

/// The kind with a name. For an unknown name, the kNotFound error lists the names.
Result<const PredicateKind*> find_predicate_kind(const std::string& name);

}  // namespace nav::render
