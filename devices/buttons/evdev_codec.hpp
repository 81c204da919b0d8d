// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "nav/time.hpp"

namespace nav::devices {

/// One event of an input device of the kernel (struct input_event of <linux/input.h>).
struct EvdevEvent {
  std::chrono::microseconds time{0};  ///< On the clock that the device was set to.
  std::uint16_t type = 0;
  std::uint16_t code = 0;
  std::int32_t value = 0;
  friend bool operator==(const EvdevEvent&, const EvdevEvent&) = default;
};

/// Bytes of an event in the kernel's layout, in the byte order of the machine.
inline constexpr std::size_t kEvdevBytes = 24;
std::array<std::byte, kEvdevBytes> encode_evdev(const EvdevEvent& event);
EvdevEvent decode_evdev(std::span<const std::byte, kEvdevBytes> bytes);

/// News about the keys of an input device.
struct EvdevNews {
  enum class Kind {
    kDown,
    kUp,
    kLost,       ///< The kernel has lost events: the keys have to be asked for.
    kMalformed,  ///< An event of a key with another value than up, down and repeat.
  };
  Kind kind = Kind::kMalformed;
  std::uint16_t key = 0;              ///< kDown, kUp.
  std::chrono::microseconds time{0};  ///< kDown, kUp.
};

/// Reads the bytes of an input device, in parts of any size. Not thread-safe.
class EvdevParser {
 public:
  /// Takes bytes and calls \p hears for all news, in order. Repeats of a key that is held, and
  /// events of other types, are no news. Events between a loss and the next report are not used.
  template <class Hears>
  void take(std::span<const std::byte> bytes, Hears hears) {
    while (!bytes.empty()) {
      const std::size_t part = std::min(kEvdevBytes - have_, bytes.size());
      std::copy_n(bytes.begin(), part, event_.begin() + static_cast<std::ptrdiff_t>(have_));
      bytes = bytes.subspan(part);
      have_ += part;
      if (have_ < kEvdevBytes) return;
      have_ = 0;
      if (const auto news = read(decode_evdev(event_))) hears(*news);
    }
  }
  /// Forgets half an event, as after a lost connection.
  void restart() {
    have_ = 0;
    lost_ = false;
  }

 private:
  std::optional<EvdevNews> read(const EvdevEvent& event);

  std::array<std::byte, kEvdevBytes> event_{};
  std::size_t have_ = 0;
  bool lost_ = false;
};

/// Largest number of a key.
inline constexpr std::uint16_t kMostEvdevKey = 0x2FF;
/// Number of a key by its name in <linux/input-event-codes.h> ("BTN_0", "KEY_A", "KEY_F12"), or as
/// a number ("256", "0x100"). Absent: none of the usual names, or out of range.
std::optional<std::uint16_t> evdev_key(std::string_view name);
/// Name of a key; its number where it has no usual name.
std::string evdev_key_name(std::uint16_t key);

}  // namespace nav::devices
