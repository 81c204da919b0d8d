// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "devices/buttons/button_filter.hpp"
#include "devices/reopened_source.hpp"

namespace nav::devices {

/// Opens a device; called for every attempt.
using ButtonOpener = std::function<Result<FileDescriptor>()>;

/// Times of a device of buttons.
struct ButtonTimes {
  /// Longest time between two messages of the device; 0: it speaks only when a button changes.
  Duration silence{0};
  Duration streaming = std::chrono::seconds(1);      ///< A change counts as streaming so long, > 0.
  Duration first_retry = std::chrono::seconds(1);    ///< > 0; doubles with every failure.
  Duration longest_retry = std::chrono::seconds(5);  ///< >= first_retry.
};
/// Rejects times out of range.
Result<void> validate(const ButtonTimes& times);

/// A device whose streams are buttons, behind one descriptor: connection, retries, and what a press
/// is, for the kinds of such devices. A device that waits for a foot is *ready*; it is *streaming*
/// for a while after each change. A lost device forgets which buttons are down: a button that comes
/// up while the device is away gives no sample.
class ButtonSource : public ReopenedSource {
 protected:
  /// \p buttons: streams of kind kButtons. The rest as in ReopenedSource.
  ButtonSource(std::string name, std::vector<StreamInfo> buttons, const ButtonTimes& times,
               ButtonOpener open, const Clock& clock, Diagnostics& diagnostics,
               const char* reporter);

  // next() alone calls these functions, on its thread.
  /// Reads what is there.
  virtual void read_device() = 0;
  /// The device has been opened again: what was read in part is forgotten.
  virtual void restart() = 0;

  [[nodiscard]] const FileDescriptor& device() const { return device_; }
  [[nodiscard]] bool is_down(std::size_t button) const { return contacts_[button].pressed(); }
  /// Counts bytes that came.
  void heard(std::size_t bytes);
  /// Takes a reading of a button, and delivers a change. \p time: of the reading, session clock.
  void take_contact(std::size_t button, bool pressed, Timestamp time);
  void forget_contacts();

 private:
  void advance(Timestamp now) final;
  [[nodiscard]] Watched watched() const final { return {.fd = device_.get(), .read = true}; }
  void attend(bool readable, bool writable) final;
  void close() noexcept final { device_.close(); }
  [[nodiscard]] bool is_open() const final { return device_.is_open(); }
  void plan();

  ButtonTimes times_;
  ButtonOpener open_;

  // Used by next() only.
  FileDescriptor device_;
  Timestamp heard_{};    ///< When anything came last, or the device was opened.
  Timestamp changed_{};  ///< When a button changed last.
  std::vector<ButtonFilter> contacts_;
  std::vector<std::uint64_t> sequences_;
};

}  // namespace nav::devices
