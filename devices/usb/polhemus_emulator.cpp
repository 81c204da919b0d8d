// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/usb/polhemus_emulator.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <limits>

namespace nav::devices {
namespace {

constexpr std::uint8_t kInvalidCommand = 1, kInvalidParameter = 4;
/// Frames that wait for a host that does not ask; more replace the oldest.
constexpr std::size_t kMostUnread = 32;
constexpr std::size_t kEmulatedPacket = 512;

/// Items of a record as the device is delivered: position, angles, end of line.
std::vector<int> usual_items() { return {2, 4, 1}; }

/// Numbers of "8,9,11"; absent: another text.
std::optional<std::vector<double>> numbers_of(std::string_view text) {
  std::vector<double> numbers;
  while (!text.empty()) {
    double value = 0;
    const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
    if (read.ec != std::errc()) return std::nullopt;
    numbers.push_back(value);
    text.remove_prefix(static_cast<std::size_t>(read.ptr - text.data()));
    if (text.empty()) return numbers;
    if (text.front() != ',') return std::nullopt;
    text.remove_prefix(1);
  }
  return std::nullopt;
}

void append_word(std::vector<std::byte>& out, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) out.push_back(static_cast<std::byte>(value >> (8 * i) & 0xFF));
}

void append_float(std::vector<std::byte>& out, float value) {
  append_word(out, std::bit_cast<std::uint32_t>(value));
}

}  // namespace

PolhemusEmulatedTracker::PolhemusEmulatedTracker(PolhemusEmulatedOptions options,
                                                 PolhemusFaultPlan plan)
    : options_(std::move(options)),
      description_{.vendor = kPolhemusVendor,
                   .product = kLibertyProduct,
                   .maker = "Sonde",
                   .name = "Polhemus Liberty, EMULATED",
                   .serial = "EMULATED",
                   .endpoints = {{kLibertyOut}, {kLibertyIn}}},
      faults_(std::move(plan)),
      items_(usual_items()) {}

void PolhemusEmulatedTracker::inject(PolhemusFault fault, int frames) {
  const std::lock_guard lock(mutex_);
  faults_.inject(fault, frames);
}

void PolhemusEmulatedTracker::hush(bool silent) {
  const std::lock_guard lock(mutex_);
  silent_ = silent;
}

std::vector<std::string> PolhemusEmulatedTracker::commands() const {
  const std::lock_guard lock(mutex_);
  return commands_;
}

bool PolhemusEmulatedTracker::is_in_centimetres() const {
  const std::lock_guard lock(mutex_);
  return centimetres_;
}

void PolhemusEmulatedTracker::attach(Timestamp now) {
  const std::lock_guard lock(mutex_);
  command_.clear();
  replies_.clear();
  reset(now);
}

/// The state after power was switched on.
void PolhemusEmulatedTracker::reset(Timestamp now) {
  binary_ = centimetres_ = continuous_ = false;
  items_ = usual_items();
  began_ = next_ = now;
  frame_ = 0;
}

UsbReply PolhemusEmulatedTracker::control(const UsbSetup& /*setup*/,
                                          std::span<const std::byte> /*bytes*/,
                                          std::size_t /*room*/) {
  return {.fault = UsbFault::kStall};  // It has no requests of its own.
}

UsbFault PolhemusEmulatedTracker::take(std::uint8_t /*endpoint*/, std::span<const std::byte> bytes,
                                       Timestamp now) {
  constexpr std::size_t kLongestCommand = 256;
  const std::lock_guard lock(mutex_);
  for (const std::byte byte : bytes) {
    const char letter = static_cast<char>(byte);
    // 'p' acts at once; all others end with a carriage return.
    if (letter == 'p' && command_.empty()) {
      obey("p", now);
    } else if (letter != '\r') {
      if (command_.size() < kLongestCommand) command_ += letter;
    } else if (!command_.empty()) {
      obey(std::exchange(command_, {}), now);
    }
  }
  return UsbFault::kNone;
}

void PolhemusEmulatedTracker::obey(const std::string& command, Timestamp now) {
  commands_.push_back(command);
  const std::string rest = command.size() > 1 ? command.substr(1) : "";
  const auto of_all = [&]() -> std::optional<std::vector<double>> {
    if (!rest.starts_with("*,")) return std::nullopt;
    return numbers_of(std::string_view(rest).substr(2));
  };
  switch (command.front()) {
    case 'p':
      if (!std::exchange(continuous_, false)) make_frame(now);
      return;
    case 'c':
      continuous_ = true;
      next_ = now;
      return;
    case 'f':
      if (rest != "0" && rest != "1") return reply_error('f', kInvalidParameter);
      binary_ = rest == "1";
      return;
    case 'u':
      if (rest != "0" && rest != "1") return reply_error('u', kInvalidParameter);
      centimetres_ = rest == "1";
      return;
    case 'O':
      if (const auto numbers = of_all(); numbers && std::ranges::all_of(*numbers, [](double one) {
                                           return one >= 0 && one < 64;
                                         })) {
        items_.assign(numbers->begin(), numbers->end());
        return;
      }
      return reply_error('O', kInvalidParameter);
    case 'h':
      if (const auto numbers = of_all(); numbers && numbers->size() == 3) return;
      return reply_error('h', kInvalidParameter);
    default:
      return reply_error(command.front(), kInvalidCommand);
  }
}

void PolhemusEmulatedTracker::reply_error(char command, std::uint8_t error) {
  if (!binary_) return;
  std::vector<std::byte> bytes;
  append_polhemus_header(bytes, 0, command, error, 0);
  replies_.push_back({.bytes = std::move(bytes)});
}

Timestamp PolhemusEmulatedTracker::due() const {
  const std::lock_guard lock(mutex_);
  if (!replies_.empty()) return Timestamp{};
  return continuous_ ? next_ : Timestamp::max();
}

std::optional<UsbReply> PolhemusEmulatedTracker::give(std::uint8_t endpoint, std::size_t room,
                                                      Timestamp now) {
  const std::lock_guard lock(mutex_);
  if (endpoint != kLibertyIn) return std::nullopt;
  const auto period =
      std::chrono::duration_cast<Duration>(std::chrono::duration<double>(1 / options_.rate_hz));
  while (continuous_ && next_ <= now) {
    if (silent_) {
      next_ = now + period;
      break;
    }
    make_frame(next_);
    next_ += period;
    if (replies_.size() > kMostUnread) replies_.pop_front();
  }
  if (replies_.empty()) return std::nullopt;
  UsbReply reply = std::move(replies_.front());
  replies_.pop_front();
  if (reply.bytes.size() > room) return UsbReply{.fault = UsbFault::kOverflow};
  return reply;
}

PolhemusRecord PolhemusEmulatedTracker::record_of(int station, const PolhemusReading& reading,
                                                  Timestamp now) const {
  const double mm_per_unit = centimetres_ ? 10.0 : 25.4;
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(now - began_).count();
  PolhemusRecord record{.station = station,
                        .error = reading.error,
                        .time_ms = options_.first_ms + static_cast<std::uint32_t>(ms),
                        .frame = frame_,
                        .distortion = reading.distortion};
  for (std::size_t i = 0; i < 3; ++i) {
    record.position_cm[i] = static_cast<float>(reading.position_mm[i] / mm_per_unit);
  }
  for (std::size_t i = 0; i < 4; ++i) {
    record.rotation_wxyz[i] = static_cast<float>(reading.rotation_wxyz[i]);
  }
  return record;
}

/// Appends a message with the items that were asked for.
void PolhemusEmulatedTracker::append_message(std::vector<std::byte>& out,
                                             const PolhemusRecord& record) const {
  std::vector<std::byte> body;
  for (const int item : items_) {
    switch (item) {
      case 2:
      case 3:
        for (const float one : record.position_cm) append_float(body, one);
        break;
      case 4:  // Angles; only their number of bytes matters here.
        for (int i = 0; i < 3; ++i) append_float(body, 0);
        break;
      case 7:
        for (const float one : record.rotation_wxyz) append_float(body, one);
        break;
      case 8:
        append_word(body, record.time_ms);
        break;
      case 9:
        append_word(body, record.frame);
        break;
      case 11:
        append_word(body, static_cast<std::uint32_t>(record.distortion));
        break;
      default:
        break;
    }
  }
  append_polhemus_header(out, record.station, 'C', record.error, body.size());
  out.insert(out.end(), body.begin(), body.end());
}

/// Queues bytes in transfers of at most a packet.
void PolhemusEmulatedTracker::queue(std::vector<std::byte> bytes) {
  for (std::size_t at = 0; at < bytes.size(); at += kEmulatedPacket) {
    const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(at);
    const auto length = static_cast<std::ptrdiff_t>(std::min(kEmulatedPacket, bytes.size() - at));
    replies_.push_back({.bytes = {begin, begin + length}});
  }
}

void PolhemusEmulatedTracker::make_frame(Timestamp now) {
  const auto fault = faults_.next();
  if (fault == PolhemusFault::kRestart) {
    began_ = now;
    frame_ = 0;
    centimetres_ = false;  // The setup is gone, but its records keep their form.
  }
  std::vector<std::byte> bytes;
  bool first = true;
  for (int station = 1; station <= options_.stations; ++station) {
    auto reading = options_.see(station, frame_);
    if (!reading) continue;
    const bool broken = std::exchange(first, false) && fault;
    if (broken && fault == PolhemusFault::kError) reading->error = 'S';
    if (broken && fault == PolhemusFault::kDistortion) reading->distortion = 99;
    PolhemusRecord record = record_of(station, *reading, now);
    if (broken && fault == PolhemusFault::kFrameNumber) record.frame ^= 0x40;
    if (broken && fault == PolhemusFault::kNotFinite) {
      record.position_cm[1] = std::numeric_limits<float>::quiet_NaN();
    }
    if (broken && fault == PolhemusFault::kNoRotation) {
      for (float& one : record.rotation_wxyz) one *= 2;
    }
    append_message(bytes, record);
  }
  if (bytes.empty()) return;
  ++frame_;
  if (fault == PolhemusFault::kLost) return;
  if (!binary_) {
    constexpr std::string_view kText = "01   0.00 0.00 0.00 0.00 0.00 0.00\r\n";
    const auto text = std::as_bytes(std::span(kText));
    bytes.assign(text.begin(), text.end());
    return queue(std::move(bytes));
  }
  if (!fault) return queue(std::move(bytes));
  switch (*fault) {
    case PolhemusFault::kMagic:
      bytes[1] = std::byte{'Z'};
      return queue(std::move(bytes));
    case PolhemusFault::kSize:
      bytes[6] = std::byte{0xFF};
      return queue(std::move(bytes));
    case PolhemusFault::kCut:
      bytes.resize(bytes.size() - 7);
      return queue(std::move(bytes));
    case PolhemusFault::kRepeat:
      queue(bytes);
      return queue(std::move(bytes));
    case PolhemusFault::kSplit:
      queue({bytes.begin(), bytes.begin() + kPolhemusHeaderBytes - 1});
      return queue({bytes.begin() + kPolhemusHeaderBytes - 1, bytes.end()});
    case PolhemusFault::kEmpty:
      replies_.push_back({});
      return queue(std::move(bytes));
    case PolhemusFault::kStall:
      replies_.push_back({.fault = UsbFault::kStall});
      return;
    case PolhemusFault::kOverflow:
      replies_.push_back({.fault = UsbFault::kOverflow});
      return;
    case PolhemusFault::kProtocol:
      replies_.push_back({.fault = UsbFault::kProtocol});
      return;
    default:
      return queue(std::move(bytes));
  }
}

Result<std::unique_ptr<PolhemusEmulator>> PolhemusEmulator::start(PolhemusEmulatedOptions options,
                                                                  PolhemusFaultPlan plan,
                                                                  const std::string& address,
                                                                  std::uint16_t port) {
  if (options.stations < 1 || options.stations > kMostPolhemusStations) {
    return Error{ErrorCode::kUsage, "emulated Polhemus tracker: expected 1 to 16 stations, found " +
                                        std::to_string(options.stations)};
  }
  if (!(options.rate_hz >= 20 && options.rate_hz <= 240)) {
    return Error{ErrorCode::kUsage, "emulated Polhemus tracker: expected 20 to 240 Hz, found " +
                                        std::to_string(options.rate_hz)};
  }
  auto emulator = std::make_unique<PolhemusEmulator>();
  auto tracker = std::make_unique<PolhemusEmulatedTracker>(std::move(options), std::move(plan));
  emulator->tracker_ = tracker.get();
  auto server = UsbipServer::start(std::move(tracker), address, port);
  if (!server) return server.error();
  emulator->server_ = *std::move(server);
  return emulator;
}

}  // namespace nav::devices
