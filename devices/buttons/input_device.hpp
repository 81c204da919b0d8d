// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "devices/openigtlink/tcp_socket.hpp"
#include "nav/result.hpp"

namespace nav::devices {

/// A USB device by the numbers of its vendor and its product.
struct HidId {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
};

/// Finds the input device with these numbers that has the most of these keys, /dev/input/eventN.
/// A foot switch that shows itself as a keyboard, a mouse and more has several. Errors: kNotFound
/// where there is none; kUnavailable for two that fit equally well, by their paths.
Result<std::filesystem::path> find_input(
    const HidId& id, const std::vector<std::uint16_t>& keys,
    const std::filesystem::path& sys_class_input = "/sys/class/input",
    const std::filesystem::path& dev_input = "/dev/input");

/// Opens an input device for this program alone (EVIOCGRAB): its keys reach no other program, and
/// its events are stamped by the monotonic clock. Errors name the path and say what to do.
Result<FileDescriptor> open_input(const std::filesystem::path& path);

/// Keys that are down now, from the kernel: a bit for each. Absent: the kernel does not say.
std::optional<std::vector<std::uint8_t>> keys_down(const FileDescriptor& device);

/// Outcome of one read that does not wait. A device that was unplugged is the failure "unplugged".
TcpTransfer read_input(const FileDescriptor& device, std::span<std::byte> into);

}  // namespace nav::devices
