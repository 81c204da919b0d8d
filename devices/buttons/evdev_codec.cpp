// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/buttons/evdev_codec.hpp"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <linux/input.h>

namespace nav::devices {
namespace {

static_assert(sizeof(input_event) == kEvdevBytes, "a machine with another layout of input_event");
static_assert(kMostEvdevKey == KEY_MAX);

constexpr std::int32_t kEvdevUp = 0;
constexpr std::int32_t kEvdevDown = 1;
constexpr std::int32_t kEvdevRepeat = 2;

struct NamedKey {
  const char* name;
  std::uint16_t key;
};
#define SONDE_KEY(name) \
  { #name, name }
/// Keys that foot switches and hand switches send; others are given by their number.
constexpr NamedKey kNamedKeys[] = {
    SONDE_KEY(BTN_0),          SONDE_KEY(BTN_1),         SONDE_KEY(BTN_2),
    SONDE_KEY(BTN_3),          SONDE_KEY(BTN_4),         SONDE_KEY(BTN_5),
    SONDE_KEY(BTN_6),          SONDE_KEY(BTN_7),         SONDE_KEY(BTN_8),
    SONDE_KEY(BTN_9),          SONDE_KEY(BTN_LEFT),      SONDE_KEY(BTN_RIGHT),
    SONDE_KEY(BTN_MIDDLE),     SONDE_KEY(BTN_SIDE),      SONDE_KEY(BTN_EXTRA),
    SONDE_KEY(BTN_TRIGGER),    SONDE_KEY(BTN_THUMB),     SONDE_KEY(BTN_THUMB2),
    SONDE_KEY(BTN_TOP),        SONDE_KEY(BTN_TOP2),      SONDE_KEY(BTN_PINKIE),
    SONDE_KEY(BTN_BASE),       SONDE_KEY(BTN_BASE2),     SONDE_KEY(BTN_BASE3),
    SONDE_KEY(BTN_SOUTH),      SONDE_KEY(BTN_EAST),      SONDE_KEY(BTN_NORTH),
    SONDE_KEY(BTN_WEST),       SONDE_KEY(KEY_ESC),       SONDE_KEY(KEY_TAB),
    SONDE_KEY(KEY_ENTER),      SONDE_KEY(KEY_SPACE),     SONDE_KEY(KEY_BACKSPACE),
    SONDE_KEY(KEY_LEFTCTRL),   SONDE_KEY(KEY_LEFTSHIFT), SONDE_KEY(KEY_LEFTALT),
    SONDE_KEY(KEY_UP),         SONDE_KEY(KEY_DOWN),      SONDE_KEY(KEY_LEFT),
    SONDE_KEY(KEY_RIGHT),      SONDE_KEY(KEY_PAGEUP),    SONDE_KEY(KEY_PAGEDOWN),
    SONDE_KEY(KEY_HOME),       SONDE_KEY(KEY_END),       SONDE_KEY(KEY_INSERT),
    SONDE_KEY(KEY_DELETE),     SONDE_KEY(KEY_MUTE),      SONDE_KEY(KEY_VOLUMEUP),
    SONDE_KEY(KEY_VOLUMEDOWN), SONDE_KEY(KEY_NEXTSONG),  SONDE_KEY(KEY_PREVIOUSSONG),
    SONDE_KEY(KEY_PLAYPAUSE),  SONDE_KEY(KEY_0),         SONDE_KEY(KEY_1),
    SONDE_KEY(KEY_2),          SONDE_KEY(KEY_3),         SONDE_KEY(KEY_4),
    SONDE_KEY(KEY_5),          SONDE_KEY(KEY_6),         SONDE_KEY(KEY_7),
    SONDE_KEY(KEY_8),          SONDE_KEY(KEY_9),         SONDE_KEY(KEY_A),
    SONDE_KEY(KEY_B),          SONDE_KEY(KEY_C),         SONDE_KEY(KEY_D),
    SONDE_KEY(KEY_E),          SONDE_KEY(KEY_F),         SONDE_KEY(KEY_G),
    SONDE_KEY(KEY_H),          SONDE_KEY(KEY_I),         SONDE_KEY(KEY_J),
    SONDE_KEY(KEY_K),          SONDE_KEY(KEY_L),         SONDE_KEY(KEY_M),
    SONDE_KEY(KEY_N),          SONDE_KEY(KEY_O),         SONDE_KEY(KEY_P),
    SONDE_KEY(KEY_Q),          SONDE_KEY(KEY_R),         SONDE_KEY(KEY_S),
    SONDE_KEY(KEY_T),          SONDE_KEY(KEY_U),         SONDE_KEY(KEY_V),
    SONDE_KEY(KEY_W),          SONDE_KEY(KEY_X),         SONDE_KEY(KEY_Y),
    SONDE_KEY(KEY_Z),          SONDE_KEY(KEY_F1),        SONDE_KEY(KEY_F2),
    SONDE_KEY(KEY_F3),         SONDE_KEY(KEY_F4),        SONDE_KEY(KEY_F5),
    SONDE_KEY(KEY_F6),         SONDE_KEY(KEY_F7),        SONDE_KEY(KEY_F8),
    SONDE_KEY(KEY_F9),         SONDE_KEY(KEY_F10),       SONDE_KEY(KEY_F11),
    SONDE_KEY(KEY_F12),        SONDE_KEY(KEY_F13),       SONDE_KEY(KEY_F14),
    SONDE_KEY(KEY_F15),        SONDE_KEY(KEY_F16),       SONDE_KEY(KEY_F17),
    SONDE_KEY(KEY_F18),        SONDE_KEY(KEY_F19),       SONDE_KEY(KEY_F20),
    SONDE_KEY(KEY_F21),        SONDE_KEY(KEY_F22),       SONDE_KEY(KEY_F23),
    SONDE_KEY(KEY_F24)};
#undef SONDE_KEY

}  // namespace

std::array<std::byte, kEvdevBytes> encode_evdev(const EvdevEvent& event) {
  constexpr std::int64_t kMicroseconds = 1'000'000;
  input_event raw{};
  raw.input_event_sec = event.time.count() / kMicroseconds;
  raw.input_event_usec = event.time.count() % kMicroseconds;
  raw.type = event.type;
  raw.code = event.code;
  raw.value = event.value;
  std::array<std::byte, kEvdevBytes> bytes{};
  std::memcpy(bytes.data(), &raw, sizeof raw);
  return bytes;
}

EvdevEvent decode_evdev(std::span<const std::byte, kEvdevBytes> bytes) {
  // Longer times would overflow; no machine runs that long.
  constexpr std::int64_t kMostSeconds = std::int64_t{1} << 40;
  constexpr std::int64_t kMicroseconds = 1'000'000;
  input_event raw{};
  std::memcpy(&raw, bytes.data(), sizeof raw);
  const std::int64_t seconds = std::clamp<std::int64_t>(raw.input_event_sec, 0, kMostSeconds);
  const std::int64_t rest = std::clamp<std::int64_t>(raw.input_event_usec, 0, kMicroseconds - 1);
  return {.time = std::chrono::seconds(seconds) + std::chrono::microseconds(rest),
          .type = raw.type,
          .code = raw.code,
          .value = raw.value};
}

std::optional<EvdevNews> EvdevParser::read(const EvdevEvent& event) {
  if (event.type == EV_SYN && event.code == SYN_DROPPED) {
    lost_ = true;
    return std::nullopt;
  }
  if (lost_) {
    if (event.type != EV_SYN || event.code != SYN_REPORT) return std::nullopt;
    lost_ = false;
    return EvdevNews{.kind = EvdevNews::Kind::kLost};
  }
  if (event.type != EV_KEY || event.value == kEvdevRepeat) return std::nullopt;
  if (event.code > kMostEvdevKey || (event.value != kEvdevUp && event.value != kEvdevDown)) {
    return EvdevNews{.kind = EvdevNews::Kind::kMalformed};
  }
  return EvdevNews{
      .kind = event.value == kEvdevDown ? EvdevNews::Kind::kDown : EvdevNews::Kind::kUp,
      .key = event.code,
      .time = event.time};
}

std::optional<std::uint16_t> evdev_key(std::string_view name) {
  for (const NamedKey& one : kNamedKeys) {
    if (name == one.name) return one.key;
  }
  const bool hexadecimal = name.starts_with("0x");
  if (hexadecimal) name.remove_prefix(2);
  std::uint16_t key = 0;
  const char* const end = name.data() + name.size();
  const auto read = std::from_chars(name.data(), end, key, hexadecimal ? 16 : 10);
  if (read.ec != std::errc() || read.ptr != end || key > kMostEvdevKey) return std::nullopt;
  return key;
}

std::string evdev_key_name(std::uint16_t key) {
  for (const NamedKey& one : kNamedKeys) {
    if (key == one.key) return one.name;
  }
  return std::to_string(key);
}

}  // namespace nav::devices
