// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <mutex>
#include <string>

#include "devices/polled_source.hpp"

namespace nav::devices {

/// A polled device that is opened again after each loss, with growing pauses: keeps its name, its
/// state, its health and the time of the next step.
class ReopenedSource : public PolledSource {
 public:
  /// Thread-safe.
  [[nodiscard]] SourceHealth health() const override;

 protected:
  /// \p retry: pauses between attempts. The rest as in PolledSource.
  ReopenedSource(std::string name, RetryTimes retry, const Clock& clock, Diagnostics& diagnostics,
                 const char* reporter);

  [[nodiscard]] virtual bool is_open() const = 0;

  /// Counts what could not be used, by cause. Thread-safe.
  void count(const char* cause, std::uint64_t times = 1);
  /// Counts bytes that came. Thread-safe.
  void count_bytes(std::size_t bytes);

  /// Counts samples that the device gave again. Thread-safe.
  void count_repeat();

  // next() alone calls these functions, on its thread.
  [[nodiscard]] SourceState state() const { return state_; }
  void set_state(SourceState state);
  void set_cause(const std::string& cause);
  /// Plans the next call of advance().
  void set_due(Timestamp due) { due_ = due; }
  [[nodiscard]] Timestamp due() const { return due_; }
  /// Counts a connection that works; the next pause is the shortest again. Returns true if a loss
  /// was reported before.
  bool connected();
  /// Closes the device and tries it again later. A loss is reported once for each connection, and
  /// once for each cause while the device is away.
  void lose(const TcpFailure& failure);

 private:
  [[nodiscard]] std::string name() const final { return name_; }
  [[nodiscard]] Timestamp wake_time() const final { return due_; }

  std::string name_;

  // Used by next() only.
  Timestamp due_;  ///< When advance() has something to do.
  RetryTimes retry_;
  std::string reported_loss_;
  SourceState state_ = SourceState::kStarting;
  std::uint64_t connections_ = 0;

  mutable std::mutex mutex_;  ///< Guards the health; never held while calling out.
  SourceHealth health_;
};

}  // namespace nav::devices
