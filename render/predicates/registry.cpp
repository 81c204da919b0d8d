// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/predicates/registry.hpp"

#include <algorithm>

namespace nav::render {

const std::vector<const PredicateKind*>& predicate_kinds() {
#define SONDE_PREDICATE(folder) &folder##_predicate(),
  static const std::vector<const PredicateKind*> kinds{
#include "render/predicates/registry.inc"
  };
#undef SONDE_PREDICATE
  return kinds;
}

Result<const PredicateKind*> find_predicate_kind(const std::string& name) {
  const auto& kinds = predicate_kinds();
  const auto found = std::find_if(kinds.begin(), kinds.end(),
                                  [&](const PredicateKind* kind) { return kind->name() == name; });
  if (found != kinds.end()) return *found;
  std::string known;
  for (const PredicateKind* kind : kinds) known += (known.empty() ? "" : ", ") + kind->name();
  return Error{ErrorCode::kNotFound,
               "predicate: expected one of " + known + ", found \"" + name + "\""};
}

}  // namespace nav::render
