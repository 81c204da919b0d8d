// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/usb/interson_emulator.hpp"

#include <algorithm>
#include <utility>

namespace nav::devices {
namespace {

constexpr std::size_t kEmulatedTransfer = 16 * kIntersonLineBytes;
/// Transfers that wait for a host that does not ask: four images; more replace the oldest.
constexpr std::size_t kMostUnreadLines = 64;

}  // namespace

IntersonEmulatedProbe::IntersonEmulatedProbe(IntersonEmulatedOptions options,
                                             IntersonFaultPlan plan)
    : options_(std::move(options)),
      description_{.vendor = kIntersonVendor,
                   .product = kSeeMoreProduct,
                   .maker = "Sonde",
                   .name = "Interson SeeMore, EMULATED",
                   .serial = "EMULATED",
                   .endpoints = {{kIntersonIn}}},
      faults_(std::move(plan)) {}

void IntersonEmulatedProbe::inject(IntersonFault fault, int images) {
  const std::lock_guard lock(mutex_);
  faults_.inject(fault, images);
}

void IntersonEmulatedProbe::hush(bool silent) {
  const std::lock_guard lock(mutex_);
  silent_ = silent;
}

std::uint8_t IntersonEmulatedProbe::reg(std::uint16_t number) const {
  const std::lock_guard lock(mutex_);
  return reg_now(number);
}

std::uint8_t IntersonEmulatedProbe::reg_now(std::uint16_t number) const {
  const auto found = registers_.find(number);
  return found == registers_.end() ? 0 : found->second;
}

void IntersonEmulatedProbe::attach(Timestamp now) {
  const std::lock_guard lock(mutex_);
  registers_.clear();
  sent_.clear();
  next_ = now;
  image_ = 0;
}

UsbReply IntersonEmulatedProbe::control(const UsbSetup& setup, std::span<const std::byte> bytes,
                                        std::size_t /*room*/) {
  constexpr std::uint8_t kRegister = 0xD8;
  const std::lock_guard lock(mutex_);
  if (setup.request != kRegister) return {.fault = UsbFault::kStall};
  if (setup.is_in()) return {.bytes = {std::byte{reg_now(setup.value)}}};
  if (bytes.size() != 1) return {.fault = UsbFault::kStall};
  registers_[setup.value] = std::to_integer<std::uint8_t>(bytes[0]);
  if (!scans()) sent_.clear();
  return {};
}

UsbFault IntersonEmulatedProbe::take(std::uint8_t /*endpoint*/,
                                     std::span<const std::byte> /*bytes*/, Timestamp /*now*/) {
  return UsbFault::kStall;  // It has no OUT endpoint.
}

bool IntersonEmulatedProbe::scans() const {
  using namespace interson;
  return reg_now(kMode) == 1 && reg_now(kVoltageOn) == 1 && reg_now(kVoltage) > 0 &&
         reg_now(kMotor) == 1;
}

/// The time of an image, by the first byte of the motor's speed.
Duration IntersonEmulatedProbe::period() const {
  const std::uint8_t speed = reg_now(interson::kMotorSpeed);
  const double hz = speed == 0x7A ? 15 : speed == 0x93 ? 12.5 : 10;
  return std::chrono::duration_cast<Duration>(std::chrono::duration<double>(1 / hz));
}

Timestamp IntersonEmulatedProbe::due() const {
  const std::lock_guard lock(mutex_);
  if (!sent_.empty()) return sent_.front().due;
  return scans() ? next_ : Timestamp::max();
}

std::optional<UsbReply> IntersonEmulatedProbe::give(std::uint8_t /*endpoint*/, std::size_t room,
                                                    Timestamp now) {
  const std::lock_guard lock(mutex_);
  if (scans() && next_ <= now) {
    // Images that were due while nobody asked are not sent later.
    const Timestamp begin = std::max(next_, now - period());
    next_ = begin + period();
    if (!silent_) make_image(begin);
  }
  if (sent_.empty() || sent_.front().due > now) return std::nullopt;
  UsbReply reply = std::move(sent_.front().reply);
  sent_.pop_front();
  if (reply.bytes.size() > room) return UsbReply{.fault = UsbFault::kOverflow};
  return reply;
}

void IntersonEmulatedProbe::make_image(Timestamp begin) {
  const auto samples = options_.see(image_);
  if (!samples || samples->size() != kIntersonLines * kIntersonSamples) return;
  const auto fault = faults_.next();
  const auto number = static_cast<std::uint8_t>(image_ % kIntersonNumbers);
  ++image_;
  if (fault == IntersonFault::kLostImage) return;
  constexpr std::size_t kBroken = 100;  // The line that a fault concerns.
  std::vector<std::byte> bytes;
  bytes.reserve(kIntersonLines * kIntersonLineBytes);
  for (std::size_t line = 0; line < kIntersonLines; ++line) {
    if (line == kBroken && fault == IntersonFault::kLostLine) continue;
    const bool odd = line == kBroken && fault == IntersonFault::kLineNumber;
    bytes.push_back(std::byte{odd ? static_cast<std::uint8_t>(number ^ 5U) : number});
    const auto sample = samples->begin() + static_cast<std::ptrdiff_t>(line * kIntersonSamples);
    for (auto one = sample; one != sample + kIntersonSamples; ++one)
      bytes.push_back(std::byte{*one});
  }
  if (fault == IntersonFault::kEmpty) sent_.push_back({begin, {}});
  for (std::size_t at = 0; at < bytes.size(); at += kEmulatedTransfer) {
    const auto first = bytes.begin() + static_cast<std::ptrdiff_t>(at);
    auto length = static_cast<std::ptrdiff_t>(std::min(kEmulatedTransfer, bytes.size() - at));
    const bool broken = at == 4 * kEmulatedTransfer;
    if (broken && fault == IntersonFault::kCutLine) length -= 700;
    UsbReply reply{.bytes = {first, first + length}};
    if (broken && fault == IntersonFault::kStall) reply = {.fault = UsbFault::kStall};
    if (broken && fault == IntersonFault::kOverflow) reply = {.fault = UsbFault::kOverflow};
    if (broken && fault == IntersonFault::kProtocol) reply = {.fault = UsbFault::kProtocol};
    const double share = static_cast<double>(at) / static_cast<double>(bytes.size());
    const Timestamp due = begin + std::chrono::duration_cast<Duration>(share * period());
    sent_.push_back({due, std::move(reply)});
  }
  while (sent_.size() > kMostUnreadLines) sent_.pop_front();
}

Result<std::unique_ptr<IntersonEmulator>> IntersonEmulator::start(IntersonEmulatedOptions options,
                                                                  IntersonFaultPlan plan,
                                                                  const std::string& address,
                                                                  std::uint16_t port) {
  auto emulator = std::make_unique<IntersonEmulator>();
  auto probe = std::make_unique<IntersonEmulatedProbe>(std::move(options), std::move(plan));
  emulator->probe_ = probe.get();
  auto server = UsbipServer::start(std::move(probe), address, port);
  if (!server) return server.error();
  emulator->server_ = *std::move(server);
  return emulator;
}

}  // namespace nav::devices
