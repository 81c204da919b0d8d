// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>

#include "nav/result.hpp"

namespace nav::sim {

/// Returns the kind whose to_string() is \p name; kUsage with all names for an unknown one. \p
/// what: subject of the message. At least two kinds.
template <class Kind>
Result<Kind> kind_by_name(std::string_view what, std::initializer_list<Kind> kinds,
                          std::string_view name) {
  std::string known;
  for (const Kind* kind = kinds.begin(); kind != kinds.end(); ++kind) {
    if (name == to_string(*kind)) return *kind;
    if (kind != kinds.begin()) known += kind + 1 == kinds.end() ? " or " : ", ";
    known += to_string(*kind);
  }
  return Error{ErrorCode::kUsage,
               std::string(what) + ": expected " + known + ", found " + std::string(name)};
}

}  // namespace nav::sim
