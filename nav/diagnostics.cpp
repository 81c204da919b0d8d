// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/diagnostics.hpp"

namespace nav {

const char* to_string(Severity severity) {
  switch (severity) {
    case Severity::kInfo:
      return "info";
    case Severity::kWarning:
      return "warning";
    case Severity::kError:
      return "error";
  }
  return "unknown";
}

void CollectingDiagnostics::report(Severity severity, std::string_view source,
                                   std::string_view message) {
  const std::lock_guard lock(mutex_);
  std::string key;
  key.append(to_string(severity)).append(1, '\0').append(source).append(1, '\0').append(message);
  const auto found = index_.find(key);
  if (found != index_.end()) {
    ++entries_[found->second].count;
    return;
  }
  if (entries_.size() >= capacity_) {
    ++dropped_;
    return;
  }
  index_.emplace(std::move(key), entries_.size());
  entries_.push_back({severity, std::string(source), std::string(message), 1});
}

std::vector<DiagnosticEntry> CollectingDiagnostics::entries() const {
  const std::lock_guard lock(mutex_);
  return entries_;
}

std::size_t CollectingDiagnostics::dropped() const {
  const std::lock_guard lock(mutex_);
  return dropped_;
}

}  // namespace nav
