// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "devices/usb/usb_link.hpp"

namespace nav::devices {

/// The wire of an Interson SeeMore probe: registers that control requests write and read, and scan
/// lines of 1024 bytes at a bulk endpoint. The first byte of a line is the number of its image, 0
/// to 15; a line has no number of its own. Source: the public code of KitwareMedical's
/// IntersonManager. This file does no I/O.
inline constexpr std::uint16_t kIntersonVendor = 0x1921;
inline constexpr std::uint16_t kSeeMoreProduct = 0x0090;
inline constexpr std::uint8_t kIntersonIn = 0x82;  ///< Endpoint.
inline constexpr std::size_t kIntersonLineBytes = 1024;
inline constexpr std::size_t kIntersonSamples = kIntersonLineBytes - 1;  ///< Samples of a line.
inline constexpr std::size_t kIntersonLines = 241;                       ///< Lines of an image.
inline constexpr unsigned kIntersonNumbers = 16;  ///< Images are counted modulo this.

/// A byte for a register of the probe.
struct IntersonWrite {
  std::uint16_t reg = 0;
  std::uint8_t value = 0;
  friend bool operator==(const IntersonWrite&, const IntersonWrite&) = default;
};
namespace interson {
inline constexpr std::uint16_t kMode = 0x0000;  ///< 0 stop, 1 B-mode. Read: version of the FPGA.
inline constexpr std::uint16_t kFrequency = 0x0100, kFrequencyInit = 0x0101;
inline constexpr std::uint16_t kVoltageOn = 0x0200, kVoltage = 0x0201;
inline constexpr std::uint16_t kInit = 0x0300, kBandPass = 0x0400, kSampler = 0x0600;
inline constexpr std::uint16_t kMotor = 0x0800, kMotorSpeed = 0x0801;  ///< And six after it.
}  // namespace interson
/// Request that writes or reads a register: 0xD8, the register as its value.
UsbSetup interson_write_setup(std::uint16_t reg);
UsbSetup interson_read_setup(std::uint16_t reg);

struct IntersonSettings {
  int frequency = 0;      ///< Index of the probe's frequencies, [0, 3].
  int band_pass = 0;      ///< Index of its filters, [0, 3].
  int high_voltage = 0;   ///< At the transducer, the probe's scale, [1, 178].
  double images_hz = 15;  ///< 10, 12.5 or 15.
};
/// Rejects values out of range.
Result<void> validate(const IntersonSettings& settings);
/// Everything but the start: stop, frequency, filter, motor, voltage. Precondition: valid settings.
std::vector<IntersonWrite> interson_setup(const IntersonSettings& settings);
/// Time from the start of the motor to the start of the images.
inline constexpr Duration kIntersonMotorStart = std::chrono::milliseconds(100);
std::vector<IntersonWrite> interson_start();
std::vector<IntersonWrite> interson_stop();

/// Lines of one image, the first sample first: kIntersonLines x kIntersonSamples.
using IntersonLines = std::vector<std::uint8_t>;

/// A piece of news from the wire.
struct IntersonNews {
  enum class Kind {
    kImage,       ///< All lines came, and then the next image began.
    kIncomplete,  ///< Lines are missing, or too many came. Nobody can say which, so it has no
                  ///< shape.
    kBad,         ///< Bytes that cannot be used.
  };
  Kind kind = Kind::kBad;
  unsigned advance = 1;        ///< Images since the one before, by their numbers, 1 to 16.
  std::size_t lines = 0;       ///< That came.
  Timestamp begun{}, ended{};  ///< Times of arrival of the first line and the last.
  IntersonLines samples{};     ///< Only for kImage.
  /// Cause of kBad: "cut_line", "line_number" (a number that differs from those around it; the line
  /// is kept at its place), "alignment" (half a line was lost).
  const char* cause = "";
};

/// Makes images of the transfers of a probe. A line that is missing costs its image only. An image
/// is given when the first line of the next one has come: only then is it known that the lines were
/// not shifted.
class IntersonAssembler {
 public:
  using Take = std::function<void(IntersonNews&&)>;
  void take(std::span<const std::byte> transfer, Timestamp received, const Take& out);
  /// The probe was started: the stream may begin in the middle of an image, which is left out.
  void restart();

 private:
  void take_line(std::span<const std::byte> line, const Take& out);
  void begin_image(unsigned number);
  void end_image(unsigned next, const Take& out);
  void append(std::span<const std::byte> line);

  std::vector<std::byte> bytes_;      ///< A part of a line.
  std::optional<unsigned> number_{};  ///< Image that is being made.
  std::optional<unsigned> given_{};   ///< Number of the image before it.
  std::size_t lines_ = 0;
  bool first_ = true;  ///< The stream may have begun in the middle of this image.
  Timestamp now_{}, begun_{}, ended_{};
  IntersonLines samples_;
  std::optional<std::vector<std::byte>>
      odd_{};        ///< A line of another number; the next one decides.
  int strange_ = 0;  ///< Lines in a row whose number is above 15.
};

}  // namespace nav::devices
