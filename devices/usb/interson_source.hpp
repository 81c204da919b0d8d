// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "devices/usb/interson_codec.hpp"
#include "devices/usb/sector_scan.hpp"
#include "devices/usb/usb_source.hpp"

namespace nav::devices {

struct IntersonOptions {
  std::string image = "Image";  ///< Name of the stream.
  IntersonSettings settings{};
  SectorShape shape{};  ///< Sector of the scan; the probe does not tell it.
  UsbTimes times{};
};
/// Rejects an empty name and values out of range.
Result<void> validate(const IntersonOptions& options);

/// An ultrasound probe on USB, Interson SeeMore: scan lines of a mechanical sector, made images
/// with their spacing and outline. An image whose lines did not all come has no known shape: it is
/// a missing image ("incomplete"), and not shown. The probe gives no times: `acquired` is the
/// middle between the arrival of the first line and that of the last. `sequence` follows the number
/// of the images (modulo 16). Its voltage and motor are switched off when the source is closed. It
/// has no thread of its own: call next() from a thread that does nothing else.
class IntersonSource final : public UsbSource {
 public:
  /// \p name: of the probe in messages, such as "usb:1921:0090". Errors: those of validate().
  static Result<std::unique_ptr<IntersonSource>> create(IntersonOptions options, std::string name,
                                                        UsbOpener open, const Clock& clock,
                                                        Diagnostics& diagnostics);
  ~IntersonSource() override { close(); }

 private:
  enum class Phase { kSetup, kMotor, kScanning };
  IntersonSource(IntersonOptions options, std::string name, UsbOpener open, const Clock& clock,
                 Diagnostics& diagnostics);
  void begin(Timestamp now) override;
  Timestamp step(Timestamp now) override;
  void take(const UsbTransfer& transfer, Timestamp received) override;
  void control_failed(UsbEnd end) override;
  void end() override;

  void write(const std::vector<IntersonWrite>& writes);
  void take_news(IntersonNews&& news, Timestamp received);

  IntersonOptions options_;
  SectorScan scan_;

  // Used by next() only.
  Phase phase_ = Phase::kSetup;
  IntersonAssembler assembler_;
  std::uint64_t sequence_ = 0;
};

}  // namespace nav::devices
