// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <atomic>
#include <linux/input.h>
#include <mutex>
#include <span>
#include <sys/socket.h>
#include <thread>

#include "devices/buttons/evdev_codec.hpp"
#include "devices/buttons/foot_switch_source.hpp"
#include "devices/can/can_button_source.hpp"
#include "devices/can/can_socket.hpp"

namespace nav::devices {

/// The other side of a device of buttons: what is written here, the device reads. A local socket
/// stands for the file of the kernel.
class ButtonLine {
 public:
  /// \p type: SOCK_STREAM for the events of evdev, SOCK_SEQPACKET for the frames of a CAN bus.
  explicit ButtonLine(int type) : type_(type) {}

  Result<FileDescriptor> open() {
    const std::lock_guard lock(mutex_);
    if (!there_) return Error{ErrorCode::kNotFound, "the buttons are not there"};
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, type_ | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends.data()) != 0) {
      return Error{ErrorCode::kUnavailable, "no sockets are left"};
    }
    line_ = FileDescriptor(ends[0]);
    ++opened_;
    return FileDescriptor(ends[1]);
  }
  ButtonOpener opener() {
    return [this] { return open(); };
  }
  void plug() { set(true); }
  void unplug() { set(false); }
  void write(std::span<const std::byte> bytes) {
    const std::lock_guard lock(mutex_);
    if (line_.is_open()) (void)send_now(line_, bytes);
  }
  [[nodiscard]] int opened() const { return opened_; }

  /// Events of a key and the report that follows them.
  void key(std::uint16_t code, int value, std::chrono::microseconds time) {
    event({time, EV_MSC, MSC_SCAN, 0x70004});
    event({time, EV_KEY, code, value});
    event({time, EV_SYN, SYN_REPORT, 0});
  }
  void event(const EvdevEvent& event) { write(encode_evdev(event)); }
  void frame(const CanFrame& frame) { write(encode_can(frame)); }

 private:
  void set(bool there) {
    const std::lock_guard lock(mutex_);
    there_ = there;
    if (!there) line_.close();
  }
  int type_;
  mutable std::mutex mutex_;
  bool there_ = true;
  std::atomic<int> opened_{0};
  FileDescriptor line_;
};

/// Now on the clock that the kernel stamps events by.
inline std::chrono::microseconds kernel_now() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return std::chrono::seconds(now.tv_sec) + std::chrono::microseconds(now.tv_nsec / 1000);
}

}  // namespace nav::devices
