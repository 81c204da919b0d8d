// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "devices/reopened_source.hpp"
#include "devices/usb/usb_link.hpp"

namespace nav::devices {

/// Times of a USB device.
struct UsbTimes {
  Duration silence = std::chrono::milliseconds(500);  ///< Without data it is silent, > 0.
  Duration lost = std::chrono::seconds(2);            ///< Without data it is lost, > silence.
  Duration first_retry = std::chrono::seconds(1);     ///< > 0; doubles with every failure.
  Duration longest_retry = std::chrono::seconds(5);   ///< >= first_retry.
};
/// Rejects times out of range.
Result<void> validate(const UsbTimes& times);

/// A device behind a UsbLink: opens it, sees to its transfers, notices silence, and opens it again
/// after a loss, which also finds a device that was plugged in again. Transfers that fail are
/// counted by cause ("stall", "overflow", "transfer_error", "empty"); kMostFailures in a row are a
/// loss. It has no thread: libusb's descriptors are waited for in next(), so that the transfers,
/// the parser and the samples are on one thread, and stop() waits for nobody.
class UsbSource : public ReopenedSource {
 public:
  static constexpr int kMostFailures = 8;

 protected:
  UsbSource(std::string name, const UsbTimes& times, UsbOpener open, const Clock& clock,
            Diagnostics& diagnostics, const char* reporter);

  // The work of a kind of device. next() alone calls these functions, on its thread.
  /// The device was opened: begins to set it up. The first call of step() is due at once.
  virtual void begin(Timestamp now) = 0;
  /// Does what is due, and returns when it is called again.
  virtual Timestamp step(Timestamp now) = 0;
  /// Takes what a transfer brought; bytes is not empty.
  virtual void take(const UsbTransfer& transfer, Timestamp received) = 0;
  /// A control transfer failed. By default it is only counted.
  virtual void control_failed(UsbEnd /*end*/) {}
  /// The device is closed while it is there: sends the last words to link().
  virtual void end() = 0;

  /// Precondition: has_link().
  [[nodiscard]] UsbLink& link() { return *link_; }
  /// A sample came: the device streams.
  void heard(Timestamp now);
  /// The device is expected to send from now on.
  void expect(Timestamp now) { heard_ = now; }
  /// Plans the next call of step().
  void set_step(Timestamp due);
  void close() noexcept final;
  /// False after a loss, also one that happens while a function above runs.
  [[nodiscard]] bool has_link() const { return link_ != nullptr; }

 private:
  /// A connection that never gave a sample is reported once for each cause, not for each attempt.
  [[nodiscard]] bool is_open() const final { return link_ != nullptr && streamed_; }
  void advance(Timestamp now) final;
  [[nodiscard]] Watched watched() const final {
    return link_ != nullptr ? link_->watched() : Watched{.fd = -1};
  }
  void attend(bool readable, bool writable) final;
  void open(Timestamp now);
  void begin_if_open();
  bool take_failure(const UsbTransfer& transfer);
  void plan();

  UsbTimes times_;
  UsbOpener open_;

  // Used by next() only.
  std::unique_ptr<UsbLink> link_;  ///< Null: it is not open.
  bool begun_ = false;             ///< begin() was called for this link.
  bool streamed_ = false;          ///< A sample came from this link.
  bool gone_ = false;              ///< Nothing more can be sent.
  Timestamp heard_{};              ///< When a sample came last.
  Timestamp step_due_ = Timestamp::max();
  int failures_ = 0;  ///< Transfers in a row that failed.
};

}  // namespace nav::devices
