// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nav/time.hpp"

namespace nav {

enum class Severity { kInfo, kWarning, kError };

/// Stable lower-case name, for reports.
const char* to_string(Severity severity);

/// A contradiction in the user's files and options: two statements of the same thing that differ, a
/// value of another unit, a part that is missing.
struct Finding {
  std::string subject;              ///< File, folder or stream that it is about.
  std::string key;                  ///< Name of the statement: a field, or "spacing".
  std::vector<std::string> values;  ///< The values found, each with its place; at least one.
  std::string used;                 ///< The value that counts in spite of it.
  Severity severity = Severity::kWarning;
};

/// The sentence of a finding, the same wherever it appears: "ct.nii: spacing: 1 1 1 mm (s-form)
/// against 2 2 4 mm (pixdim); used: s-form".
std::string sentence_of(const Finding& finding);

/// One reported message and its number of repetitions.
struct DiagnosticEntry {
  Severity severity;
  std::string source;
  std::string message;
  std::size_t count = 1;  ///< Number of reports of the same kind.
  /// The finding that the message puts into words; absent for other messages. Findings of one
  /// subject and key are of one kind, and the first is kept; other messages are of one kind if
  /// their texts are equal.
  std::optional<Finding> finding = std::nullopt;
};

/// Names the kind of a message: entries of one kind are counted together.
std::string kind_of(const DiagnosticEntry& entry);

/// The interface through which libraries report what they find. Libraries never print.
/// Implementations are thread-safe.
class Diagnostics {
 public:
  virtual ~Diagnostics() = default;
  /// \p source: the part that reports ("io", "tracking.gate"). \p message: one sentence.
  void report(Severity severity, std::string_view source, std::string_view message);
  void report(std::string_view source, Finding finding);
  /// Takes one report, which implementations store, show or pass on.
  virtual void take(const DiagnosticEntry& entry) = 0;
};

/// Stores reported messages for reports and tests. Repetitions of a message are counted, which
/// limits the rate. At most \p capacity different messages are stored; later ones are counted in
/// dropped().
class CollectingDiagnostics final : public Diagnostics {
 public:
  explicit CollectingDiagnostics(std::size_t capacity = 1000) : capacity_(capacity) {}
  void take(const DiagnosticEntry& entry) override;
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
