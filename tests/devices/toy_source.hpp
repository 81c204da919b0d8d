// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <mutex>
#include <sstream>
#include <sys/socket.h>
#include <thread>

#include "devices/polled_source.hpp"

namespace nav::devices {

/// The example of docs/how-to-add.md: a tracker that sends lines "x y z" in mm, one for
/// each pose of its only body.
class ToySource final : public PolledSource {
 public:
  using Opener = std::function<Result<FileDescriptor>()>;
  ToySource(Opener open, const Clock& clock, Diagnostics& diagnostics)
      : PolledSource(clock, diagnostics, "devices.toy"), open_(std::move(open)), due_(clock.now()) {
    add_stream({"Probe", StreamKind::kPoses, ToolRole::kProbe});
  }
  [[nodiscard]] SourceHealth health() const override {
    const std::lock_guard lock(mutex_);
    SourceHealth health = health_;
    if (is_stopped()) health.state = SourceState::kEnded;
    return health;
  }

 private:
  static constexpr Duration kSilence = std::chrono::milliseconds(100);
  static constexpr std::size_t kLongestLine = 200;

  [[nodiscard]] std::string name() const override { return "toy"; }
  [[nodiscard]] Timestamp wake_time() const override { return due_; }
  [[nodiscard]] Watched watched() const override { return {.fd = line_.get(), .read = true}; }
  void close() noexcept override { line_.close(); }

  /// Connects, or notices that nothing comes any more.
  void advance(Timestamp now) override {
    if (line_.is_open()) return lose("silent", "nothing has come for 0.1 s");
    auto opened = open_();
    if (!opened) return lose("unavailable", opened.error().message);
    line_ = *std::move(opened);
    due_ = now + kSilence;
  }
  void attend(bool readable, bool /*writable*/) override {
    if (!readable) return;
    std::array<std::byte, 4096> bytes{};
    const TcpTransfer got = receive_now(line_, bytes);
    for (std::size_t i = 0; i < got.bytes; ++i) take(static_cast<char>(bytes[i]));
    const std::lock_guard lock(mutex_);
    health_.bytes += got.bytes;
    if (got.failure) lose_locked(got.failure->cause, got.failure->message);
  }
  void take(char letter) {
    if (letter != '\n') {
      if (text_.size() < kLongestLine) text_ += letter;
      return;
    }
    std::istringstream line(std::exchange(text_, {}));
    PoseSample sample;
    sample.pose.tracker_from_body.setIdentity();
    for (int k = 0; k < 3; ++k) line >> sample.pose.tracker_from_body(k, 3);
    const std::lock_guard lock(mutex_);
    if (line.fail() || !(line >> std::ws).eof()) {
      ++health_.bad_messages["malformed"];
      return report_once(Severity::kWarning, "expected three numbers, found another line");
    }
    due_ = clock().now() + kSilence;
    retry_.reset();
    reported_.clear();
    if (health_.state != SourceState::kStreaming) health_.reconnects = connections_++;
    health_.state = SourceState::kStreaming;
    sample.pose.acquired = sample.pose.received = clock().now();
    sample.pose.status = TrackingStatus::kOk;
    const Timestamp received = sample.pose.received;
    deliver({.sequence = sequence_++, .received = received, .what = std::move(sample)});
  }
  void lose(const std::string& cause, const std::string& message) {
    const std::lock_guard lock(mutex_);
    lose_locked(cause, message);
  }
  void lose_locked(const std::string& cause, const std::string& message) {
    line_.close();
    text_.clear();
    health_.state = SourceState::kWaiting;
    health_.cause = cause;
    if (reported_ != cause) report(Severity::kWarning, message + "; it is tried again");
    reported_ = cause;
    due_ = clock().now() + retry_.take();
  }

  Opener open_;
  FileDescriptor line_;
  Timestamp due_;
  RetryTimes retry_{std::chrono::milliseconds(20), std::chrono::milliseconds(50)};
  std::string text_, reported_;
  std::uint64_t connections_ = 0, sequence_ = 0;
  mutable std::mutex mutex_;  ///< Guards the health.
  SourceHealth health_;
};

/// The other side of a ToySource: sends a line every few milliseconds.
class Toy {
 public:
  Toy() : talker_([this](const std::stop_token& stop) { run(stop); }) {}
  Result<FileDescriptor> open() {
    const std::lock_guard lock(mutex_);
    if (!there_) return Error{ErrorCode::kNotFound, "the toy is not there"};
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends.data()) != 0) {
      return Error{ErrorCode::kUnavailable, "no sockets are left"};
    }
    line_ = FileDescriptor(ends[0]);
    return FileDescriptor(ends[1]);
  }
  void appear() { set(true, true); }
  void vanish() { set(false, false); }
  void hush() { set(true, false); }

 private:
  void set(bool there, bool talks) {
    const std::lock_guard lock(mutex_);
    there_ = there;
    talks_ = talks;
    if (!there) line_.close();
  }
  void run(const std::stop_token& stop) {
    const std::string text = "1 2 3\n";
    while (!stop.stop_requested()) {
      {
        const std::lock_guard lock(mutex_);
        if (talks_ && line_.is_open()) (void)send_now(line_, std::as_bytes(std::span(text)));
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(3));
    }
  }
  std::mutex mutex_;
  bool there_ = false, talks_ = false;
  FileDescriptor line_;
  std::jthread talker_;
};

}  // namespace nav::devices
