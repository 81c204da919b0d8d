// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/diagnostics.hpp"

#include <utility>

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

std::string sentence_of(const Finding& finding) {
  std::string text = finding.subject + ": " + finding.key + ": ";
  const char* const between = finding.values.size() == 2 ? " against " : ", ";
  for (std::size_t i = 0; i < finding.values.size(); ++i) {
    text += (i > 0 ? between : "") + finding.values[i];
  }
  return text + "; used: " + finding.used;
}

std::string kind_of(const DiagnosticEntry& entry) {
  std::string kind = to_string(entry.severity);
  kind.append(1, '\0').append(entry.source).append(1, '\0');
  if (!entry.finding) return kind + entry.message;
  return kind.append(entry.finding->subject).append(1, '\0').append(entry.finding->key);
}

void Diagnostics::report(Severity severity, std::string_view source, std::string_view message) {
  take({severity, std::string(source), std::string(message)});
}

void Diagnostics::report(std::string_view source, Finding finding) {
  const Severity severity = finding.severity;
  std::string message = sentence_of(finding);
  take({severity, std::string(source), std::move(message), 1, std::move(finding)});
}

void CollectingDiagnostics::take(const DiagnosticEntry& entry) {
  const std::lock_guard lock(mutex_);
  std::string kind = kind_of(entry);
  const auto found = index_.find(kind);
  if (found != index_.end()) {
    entries_[found->second].count += entry.count;
    return;
  }
  if (entries_.size() >= capacity_) {
    dropped_ += entry.count;
    return;
  }
  index_.emplace(std::move(kind), entries_.size());
  entries_.push_back(entry);
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
