// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/buttons/input_device.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fcntl.h>
#include <fstream>
#include <linux/input.h>
#include <sstream>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

#include "devices/buttons/evdev_codec.hpp"

namespace nav::devices {
namespace {

std::optional<std::uint16_t> hexadecimal_in(const std::filesystem::path& path) {
  std::string text;
  std::ifstream(path) >> text;
  std::uint16_t number = 0;
  const char* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, number, 16);
  if (read.ec != std::errc() || read.ptr != end) return std::nullopt;
  return number;
}

/// Keys of a device by its "capabilities/key": words in hexadecimal, the highest first.
std::size_t count_keys(const std::filesystem::path& path, const std::vector<std::uint16_t>& keys) {
  constexpr std::size_t kBits = 8 * sizeof(unsigned long);
  std::vector<std::uint64_t> words;
  std::ifstream file(path);
  for (std::string text; file >> text;) {
    std::uint64_t word = 0;
    std::from_chars(text.data(), text.data() + text.size(), word, 16);
    words.push_back(word);
  }
  std::ranges::reverse(words);
  return static_cast<std::size_t>(std::ranges::count_if(keys, [&](std::uint16_t key) {
    return key / kBits < words.size() && ((words[key / kBits] >> (key % kBits)) & 1) != 0;
  }));
}

std::string text_of(const HidId& id) {
  char text[16];
  std::snprintf(text, sizeof text, "%04x:%04x", id.vendor, id.product);
  return text;
}

Error input_error(const std::filesystem::path& path, int error) {
  const std::string name = path.string();
  switch (error) {
    case ENOENT:
    case ENODEV:
    case ENXIO:
      return {
          ErrorCode::kNotFound,
          name + ": expected an input device, found none; plug it in (sonde devices lists them)"};
    case EACCES:
    case EPERM:
      return {ErrorCode::kUnavailable,
              name +
                  ": expected to be readable, found permission denied: install "
                  "share/udev/70-sonde.rules, or add the user to the group input"};
    case EBUSY:
      return {ErrorCode::kUnavailable,
              name +
                  ": expected a device for this program alone, found that another program has "
                  "grabbed it; end that program"};
    case ENOTTY:
    case EINVAL:
      return {ErrorCode::kUnavailable,
              name + ": expected an input device (/dev/input/eventN), found another file"};
    default:
      return {ErrorCode::kUnavailable, name + ": cannot be opened: " + std::strerror(error)};
  }
}

}  // namespace

Result<std::filesystem::path> find_input(const HidId& id, const std::vector<std::uint16_t>& keys,
                                         const std::filesystem::path& sys_class_input,
                                         const std::filesystem::path& dev_input) {
  std::vector<std::filesystem::path> found;
  std::size_t most = 0;
  std::error_code status;
  for (const auto& entry : std::filesystem::directory_iterator(sys_class_input, status)) {
    const std::filesystem::path device = entry.path() / "device";
    const std::string node = entry.path().filename().string();
    if (!node.starts_with("event")) continue;
    if (hexadecimal_in(device / "id/vendor") != id.vendor) continue;
    if (hexadecimal_in(device / "id/product") != id.product) continue;
    const std::size_t has = count_keys(device / "capabilities/key", keys);
    if (has < most) continue;
    if (has > most) found.clear();
    most = has;
    found.push_back(dev_input / node);
  }
  std::ranges::sort(found);
  if (found.empty()) {
    return Error{ErrorCode::kNotFound, "hid:" + text_of(id) +
                                           ": expected an input device with these numbers, found "
                                           "none; plug it in (sonde devices lists them)"};
  }
  if (most == 0) {
    return Error{ErrorCode::kUnavailable,
                 "hid:" + text_of(id) + ": expected a device with the keys of the buttons, found " +
                     found.front().string() + " without any of them"};
  }
  if (found.size() > 1) {
    return Error{ErrorCode::kUnavailable, "hid:" + text_of(id) + ": expected one device, found " +
                                              found[0].string() + " and " + found[1].string() +
                                              "; name one as input:" + found[0].string()};
  }
  return found.front();
}

Result<FileDescriptor> open_input(const std::filesystem::path& path) {
  FileDescriptor device(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  if (!device.is_open()) return input_error(path, errno);
  int clock = CLOCK_MONOTONIC;
  if (::ioctl(device.get(), EVIOCSCLOCKID, &clock) != 0) return input_error(path, errno);
  if (::ioctl(device.get(), EVIOCGRAB, 1) != 0) return input_error(path, errno);
  return device;
}

std::optional<std::vector<std::uint8_t>> keys_down(const FileDescriptor& device) {
  std::vector<std::uint8_t> bits(kMostEvdevKey / 8 + 1);
  if (::ioctl(device.get(), EVIOCGKEY(bits.size()), bits.data()) < 0) return std::nullopt;
  return bits;
}

TcpTransfer read_input(const FileDescriptor& device, std::span<std::byte> into) {
  ssize_t got = 0;
  do {
    got = ::read(device.get(), into.data(), into.size());
  } while (got < 0 && errno == EINTR);
  if (got > 0) return {.bytes = static_cast<std::size_t>(got)};
  if (got == 0) return {.failure = TcpFailure{"closed", "the device was closed"}};
  if (errno == EAGAIN || errno == EWOULDBLOCK) return {};
  if (errno == ENODEV) {
    return {.failure = TcpFailure{"unplugged", "the device was unplugged; plug it in again"}};
  }
  return {.failure = TcpFailure{"error", std::strerror(errno)}};
}

}  // namespace nav::devices
