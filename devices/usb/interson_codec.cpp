// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/usb/interson_codec.hpp"

#include <algorithm>
#include <utility>

namespace nav::devices {
namespace {

constexpr std::uint8_t kRegisterRequest = 0xD8;
constexpr std::size_t kHalfLine = kIntersonLineBytes / 2;
/// Lines in a row with impossible numbers after which half a line is skipped.
constexpr int kMostStrange = 4;

/// Bytes of the motor's registers for a rate.
struct IntersonSpeed {
  double images_hz;
  std::array<std::uint8_t, 7> bytes;
};
constexpr std::array<IntersonSpeed, 3> kIntersonSpeeds = {
    {{10, {0xB9, 0x04, 0x00, 0x00, 0xB7, 0xA4, 0x32}},
     {12.5, {0x93, 0x07, 0x00, 0x00, 0x93, 0xA4, 0x32}},
     {15, {0x7A, 0x0D, 0x00, 0x00, 0x80, 0xA4, 0x32}}}};

const IntersonSpeed* speed_of(double images_hz) {
  const auto found = std::ranges::find(kIntersonSpeeds, images_hz, &IntersonSpeed::images_hz);
  return found == kIntersonSpeeds.end() ? nullptr : &*found;
}

unsigned number_of(std::span<const std::byte> line) {
  return std::to_integer<unsigned>(line.front());
}

bool is_number(unsigned number) { return number < kIntersonNumbers; }

unsigned number_after(unsigned number) { return (number + 1) % kIntersonNumbers; }

}  // namespace

UsbSetup interson_write_setup(std::uint16_t reg) {
  return {.request_type = 0x40, .request = kRegisterRequest, .value = reg};
}

UsbSetup interson_read_setup(std::uint16_t reg) {
  return {.request_type = 0xC0, .request = kRegisterRequest, .value = reg};
}

Result<void> validate(const IntersonSettings& settings) {
  constexpr int kMostIndex = 3, kMostVoltage = 178;
  const auto reject = [](const char* key, const char* expected, const std::string& found) {
    return Error{ErrorCode::kUsage, std::string("Interson probe: expected ") + expected + " for " +
                                        key + ", found " + found};
  };
  for (const auto& [key, index] :
       {std::pair{"frequency", settings.frequency}, {"band_pass", settings.band_pass}}) {
    if (index < 0 || index > kMostIndex) return reject(key, "0 to 3", std::to_string(index));
  }
  if (settings.high_voltage < 1 || settings.high_voltage > kMostVoltage) {
    return reject("high_voltage", "1 to 178", std::to_string(settings.high_voltage));
  }
  if (speed_of(settings.images_hz) == nullptr) {
    return reject("images_hz", "10, 12.5 or 15", std::to_string(settings.images_hz));
  }
  return {};
}

std::vector<IntersonWrite> interson_setup(const IntersonSettings& settings) {
  constexpr std::uint8_t kUsualSampler = 64;
  using namespace interson;
  std::vector<IntersonWrite> writes{{kMode, 0},
                                    {kFrequencyInit, 0},
                                    {kInit, 0},
                                    {kFrequency, static_cast<std::uint8_t>(settings.frequency)},
                                    {kBandPass, static_cast<std::uint8_t>(settings.band_pass)}};
  std::uint16_t reg = kMotorSpeed;
  for (const std::uint8_t byte : speed_of(settings.images_hz)->bytes)
    writes.push_back({reg++, byte});
  writes.push_back({kVoltage, static_cast<std::uint8_t>(settings.high_voltage)});
  writes.push_back({kVoltageOn, 1});
  writes.push_back({kSampler, kUsualSampler});
  writes.push_back({kMotor, 1});
  return writes;
}

std::vector<IntersonWrite> interson_start() { return {{interson::kMode, 1}}; }

std::vector<IntersonWrite> interson_stop() {
  return {{interson::kMode, 0}, {interson::kVoltageOn, 0}, {interson::kMotor, 0}};
}

void IntersonAssembler::restart() {
  bytes_.clear();
  odd_.reset();
  number_.reset();
  lines_ = 0;
  first_ = true;
  strange_ = 0;
}

void IntersonAssembler::take(std::span<const std::byte> transfer, Timestamp received,
                             const Take& out) {
  now_ = received;
  bytes_.insert(bytes_.end(), transfer.begin(), transfer.end());
  std::size_t at = 0;
  while (bytes_.size() - at >= kIntersonLineBytes) {
    const auto line = std::span<const std::byte>(bytes_).subspan(at, kIntersonLineBytes);
    strange_ = is_number(number_of(line)) ? 0 : strange_ + 1;
    if (strange_ > kMostStrange) {
      // Half a line was lost: what is taken for the number is a sample.
      strange_ = 0;
      at += kHalfLine;
      out({.cause = "alignment"});
      continue;
    }
    take_line(line, out);
    at += kIntersonLineBytes;
  }
  bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(at));
  // A transfer ends with a short packet where a line was cut; the next one begins with a line.
  if (!bytes_.empty() && transfer.size() % kHalfLine != 0) {
    bytes_.clear();
    out({.cause = "cut_line"});
  }
}

void IntersonAssembler::begin_image(unsigned number) {
  number_ = number;
  lines_ = 0;
  begun_ = now_;
  samples_.clear();
  samples_.reserve(kIntersonLines * kIntersonSamples);
}

void IntersonAssembler::append(std::span<const std::byte> line) {
  if (++lines_ > kIntersonLines) return;
  ended_ = now_;
  for (const std::byte sample : line.subspan(1)) {
    samples_.push_back(std::to_integer<std::uint8_t>(sample));
  }
}

/// Ends an image, since a line of the image \p next came.
void IntersonAssembler::end_image(unsigned next, const Take& out) {
  const unsigned number = *number_;
  unsigned advance = 1;
  if (given_) {
    const unsigned steps = (number + kIntersonNumbers - *given_) % kIntersonNumbers;
    advance = steps == 0 ? kIntersonNumbers : steps;
  }
  const bool was_first = std::exchange(first_, false);
  if (lines_ == kIntersonLines && next == number_after(number)) {
    out({.kind = IntersonNews::Kind::kImage,
         .advance = advance,
         .lines = lines_,
         .begun = begun_,
         .ended = ended_,
         .samples = std::move(samples_)});
  } else if (!was_first) {
    out({.kind = IntersonNews::Kind::kIncomplete,
         .advance = advance,
         .lines = lines_,
         .begun = begun_,
         .ended = ended_});
  }
  given_ = number;
}

void IntersonAssembler::take_line(std::span<const std::byte> line, const Take& out) {
  const unsigned number = number_of(line);
  if (odd_) {
    const std::vector<std::byte> odd = *std::exchange(odd_, std::nullopt);
    if (is_number(number) && number == number_of(odd)) {
      end_image(number, out);
      begin_image(number);
    } else {
      out({.cause = "line_number"});
    }
    append(odd);
  }
  if (!number_) {
    if (!is_number(number)) return out({.cause = "line_number"});
    begin_image(number);
  }
  if (number != *number_) {
    if (lines_ != kIntersonLines || number != number_after(*number_)) {
      odd_.emplace(line.begin(), line.end());
      return;
    }
    end_image(number, out);
    begin_image(number);
  }
  append(line);
}

}  // namespace nav::devices
