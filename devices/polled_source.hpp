// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "devices/openigtlink/tcp_socket.hpp"
#include "nav/diagnostics.hpp"
#include "nav/source.hpp"

namespace nav::devices {

/// Times between attempts to reach a device: they double from the first to the longest.
class RetryTimes {
 public:
  RetryTimes(Duration first, Duration longest) : first_(first), longest_(longest), next_(first) {}
  /// Time to wait now; the next one is longer.
  Duration take() {
    const Duration now = next_;
    next_ = std::min(2 * next_, longest_);
    return now;
  }
  void reset() { next_ = first_; }

 private:
  Duration first_, longest_, next_;
};

/// A device behind one descriptor, without a thread of its own: next() waits for the descriptor and
/// for what is due, whichever comes first, and hands out the samples that the device has made of
/// it. stop() ends a waiting next() at once. A new kind of device derives from this class
/// (docs/how-to-add.md).
class PolledSource : public Source {
 public:
  [[nodiscard]] const std::vector<StreamInfo>& streams() const final { return infos_; }
  Result<Sample> next(Deadline deadline) final;
  void stop() noexcept final;

 protected:
  /// \p clock advances with real time; clock and diagnostics must outlive the source. \p reporter:
  /// name of the kind in diagnostics, such as "devices.ndi"; a literal.
  PolledSource(const Clock& clock, Diagnostics& diagnostics, const char* reporter);

  // The work of a device. next() alone calls these functions, on its thread.
  /// Name of the device in messages, such as "/dev/ttyUSB0".
  [[nodiscard]] virtual std::string name() const = 0;
  /// Time at which advance() has something to do.
  [[nodiscard]] virtual Timestamp wake_time() const = 0;
  /// Does what is due: connects, asks, notices silence.
  virtual void advance(Timestamp now) = 0;
  /// The descriptor to wait for, and what for; negative: none.
  [[nodiscard]] virtual Watched watched() const = 0;
  /// Reads and writes what can be, without waiting. Also called when neither can be.
  virtual void attend(bool readable, bool writable) = 0;
  /// Closes the descriptor after stop().
  virtual void close() noexcept = 0;

  void add_stream(StreamInfo info) { infos_.push_back(std::move(info)); }
  /// Hands out a sample, after those before it.
  void deliver(Sample sample) { ready_.push_back(std::move(sample)); }
  /// Samples that wait to be handed out, in order.
  [[nodiscard]] std::vector<Sample>& ready() { return ready_; }
  /// Reports a message after the name of the device, at the end of what runs now.
  void report(Severity severity, std::string message);
  /// Reports what may repeat with every message, the first time only.
  void report_once(Severity severity, std::string_view key, const std::string& message);
  void report_once(Severity severity, const std::string& message) {
    report_once(severity, message, message);
  }
  /// A message without the name of the device, which every report begins with.
  [[nodiscard]] std::string without_name(const std::string& message) const;
  /// Lets report_once() report it again.
  void forget_report(std::string_view key);
  void forget_reports() { reported_.clear(); }
  /// True after stop(). Thread-safe.
  [[nodiscard]] bool is_stopped() const { return stopped_; }
  [[nodiscard]] const Clock& clock() const { return clock_; }

 private:
  struct Report {
    Severity severity;
    std::string message;
  };
  bool take_ready(Sample& sample);
  void send_reports();

  const Clock& clock_;
  Diagnostics& diagnostics_;
  const char* reporter_;
  std::vector<StreamInfo> infos_;
  WakeEvent wake_;
  std::atomic<bool> stopped_{false};

  // Used by next() only.
  std::vector<Sample> ready_;
  std::size_t taken_ = 0;
  std::vector<Report> reports_;
  std::set<std::string, std::less<>> reported_;
};

}  // namespace nav::devices
