// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/buttons/foot_switch_source.hpp"

#include <algorithm>
#include <set>
#include <time.h>
#include <utility>

namespace nav::devices {
namespace {

std::vector<StreamInfo> streams_of(const std::vector<FootSwitchButton>& buttons) {
  std::vector<StreamInfo> streams;
  for (const FootSwitchButton& button : buttons) {
    streams.push_back({button.name, StreamKind::kButtons, ToolRole::kOther, button.action});
  }
  return streams;
}

/// Time since an event that the kernel stamped by the monotonic clock, at least 0. A device that
/// keeps another clock gives 0 rather than a time that cannot be.
Duration age_of_event(std::chrono::microseconds stamp) {
  constexpr Duration kLongest = std::chrono::seconds(1);
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  const Duration age =
      std::chrono::seconds(now.tv_sec) + std::chrono::nanoseconds(now.tv_nsec) - stamp;
  return age > kLongest ? Duration(0) : std::max(age, Duration(0));
}

}  // namespace

Result<void> validate(const FootSwitchOptions& options) {
  const auto reject = [](const std::string& what) {
    return Error{ErrorCode::kUsage, "foot switch: expected " + what};
  };
  if (options.buttons.empty()) return reject("at least one button, found none");
  std::set<std::string> names;
  std::set<std::uint16_t> keys;
  for (const FootSwitchButton& button : options.buttons) {
    if (button.name.empty()) return reject("a name of each button, found none");
    if (!names.insert(button.name).second) {
      return reject("a name of its own for each button, found '" + button.name + "' twice");
    }
    if (button.key > kMostEvdevKey) {
      return reject("a key of at most " + std::to_string(kMostEvdevKey) + ", found " +
                    std::to_string(button.key));
    }
    if (!keys.insert(button.key).second) {
      return reject("a key of its own for each button, found " + evdev_key_name(button.key) +
                    " twice");
    }
  }
  return validate(options.times);
}

Result<std::unique_ptr<FootSwitchSource>> FootSwitchSource::create(FootSwitchOptions options,
                                                                   std::string name,
                                                                   ButtonOpener open,
                                                                   const Clock& clock,
                                                                   Diagnostics& diagnostics) {
  if (const auto ok = validate(options); !ok) return ok.error();
  return std::unique_ptr<FootSwitchSource>(new FootSwitchSource(
      std::move(options), std::move(name), std::move(open), clock, diagnostics));
}

ButtonOpener FootSwitchSource::at_path(std::filesystem::path path) {
  return [path = std::move(path)] { return open_input(path); };
}

ButtonOpener FootSwitchSource::with_id(const HidId& id,
                                       const std::vector<FootSwitchButton>& buttons) {
  std::vector<std::uint16_t> keys;
  for (const FootSwitchButton& button : buttons) keys.push_back(button.key);
  return [id, keys]() -> Result<FileDescriptor> {
    const auto path = find_input(id, keys);
    if (!path) return path.error();
    return open_input(*path);
  };
}

FootSwitchSource::FootSwitchSource(FootSwitchOptions options, std::string name, ButtonOpener open,
                                   const Clock& clock, Diagnostics& diagnostics)
    : ButtonSource(std::move(name), streams_of(options.buttons), options.times, std::move(open),
                   clock, diagnostics, "devices.foot_switch"),
      options_(std::move(options)) {}

void FootSwitchSource::read_device() {
  constexpr std::size_t kEventsAtOnce = 64;
  constexpr int kMostReads = 16;
  std::array<std::byte, kEventsAtOnce * kEvdevBytes> bytes{};
  for (int i = 0; i < kMostReads && device().is_open(); ++i) {
    const TcpTransfer got = read_input(device(), bytes);
    if (got.bytes > 0) {
      heard(got.bytes);
      parser_.take(std::span(bytes).first(got.bytes),
                   [this](const EvdevNews& news) { take(news); });
    }
    if (got.failure) return lose(*got.failure);
    if (got.bytes < bytes.size()) return;
  }
}

void FootSwitchSource::take(const EvdevNews& news) {
  switch (news.kind) {
    case EvdevNews::Kind::kMalformed:
      return count("malformed");
    case EvdevNews::Kind::kLost:
      count("kernel_drops");
      return ask_keys();
    case EvdevNews::Kind::kDown:
    case EvdevNews::Kind::kUp:
      break;
  }
  const auto button =
      std::ranges::find(options_.buttons, news.key, [](const auto& one) { return one.key; });
  if (button == options_.buttons.end()) {
    const std::string key = evdev_key_name(news.key);
    return report_once(Severity::kInfo, "key " + key,
                       "key " + key + " was pressed, which is none of the buttons");
  }
  take_contact(static_cast<std::size_t>(button - options_.buttons.begin()),
               news.kind == EvdevNews::Kind::kDown, clock().now() - age_of_event(news.time));
}

/// Takes the keys as they are now, after events were lost.
void FootSwitchSource::ask_keys() {
  const auto down = options_.down(device());
  if (!down) return forget_contacts();
  for (std::size_t i = 0; i < options_.buttons.size(); ++i) {
    const std::size_t key = options_.buttons[i].key;
    const bool pressed = key / 8 < down->size() && ((*down)[key / 8] >> (key % 8) & 1) != 0;
    take_contact(i, pressed, clock().now());
  }
}

}  // namespace nav::devices
