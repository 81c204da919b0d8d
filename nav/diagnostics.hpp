// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "nav/time.hpp"

namespace nav {

enum class Severity { kInfo, kWarning, kError };

/// Stable lower-case name, for reports.
const char* to_string(Severity severity);

/// The interface through which libraries report what they find. Libraries never print.
/// Implementations are thread-safe.
class Diagnostics {
 public:
  virtual ~Diagnostics() = default;
  /// \p source: the part that reports ("io", "tracking.gate"). \p message: one sentence.
  virtual void report(Severity severity, std::string_view source, std::string_view message) = 0;
};

/// One reported message and its number of repetitions.
struct DiagnosticEntry {
  Severity severity;
  std::string source;
  std::string message;
  std::size_t count = 1;  ///< Number of reports with the same text.
};

/// Stores reported messages for reports and tests. Repetitions of a message are counted, which
/// limits the rate. At most \p capacity different messages are stored; later ones are counted in
/// dropped().
class CollectingDiagnostics final : public Diagnostics {
 public:
  explicit CollectingDiagnostics(std::size_t capacity = 1000) : capacity_(capacity) {}
  void report(Severity severity, std::string_view source, std::string_view message) override;
  [[nodiscard]] std::vector<DiagnosticEntry> entries() const;
  [[nodiscard]] std::size_t dropped() const;

 private:
  mutable std::mutex mutex_;
  std::size_t capacity_;
  std::size_t dropped_ = 0;
  std::vector<DiagnosticEntry> entries_;
  std::map<std::string, std::size_t> index_;
};

}  // namespace nav
