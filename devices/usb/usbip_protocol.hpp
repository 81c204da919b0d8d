// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "devices/usb/usb_link.hpp"

namespace nav::devices {

/// USB/IP, version 1.1.1 (Documentation/usb/usbip_protocol.rst of Linux): requests and answers
/// about devices, and then the transfers of one imported device. Numbers are big endian.
inline constexpr std::uint16_t kUsbipPort = 3240;
inline constexpr std::size_t kUsbipOperationBytes = 8;
inline constexpr std::size_t kUsbipDeviceBytes = 312;
inline constexpr std::size_t kUsbipBusIdBytes = 32;
inline constexpr std::size_t kUsbipHeaderBytes = 48;
/// Largest transfer that is taken from a peer, bytes.
inline constexpr std::uint32_t kUsbipLargestTransfer = 1U << 20;

enum class UsbipOperation : std::uint16_t {
  kListRequest = 0x8005,
  kListReply = 0x0005,
  kImportRequest = 0x8003,
  kImportReply = 0x0003,
};
struct UsbipOperationHeader {
  std::uint16_t version = 0x0111;
  std::uint16_t code = 0;
  std::uint32_t status = 0;  ///< 0: done.
};
/// Precondition: kUsbipOperationBytes bytes, otherwise a Bug; likewise for those below.
UsbipOperationHeader read_usbip_operation(std::span<const std::byte> bytes);
void append_usbip_operation(std::vector<std::byte>& out, UsbipOperation code,
                            std::uint32_t status = 0);

/// A device as a server describes it.
struct UsbipDevice {
  std::string path{};
  std::string bus_id{};  ///< Such as "1-1".
  std::uint32_t bus = 1, device = 1;
  std::uint32_t speed = 3;  ///< 1 low, 2 full, 3 high.
  std::uint16_t vendor = 0, product = 0, release = 0;
  std::uint8_t configurations = 1;
  std::uint8_t interfaces = 1;
};
UsbipDevice read_usbip_device(std::span<const std::byte> bytes);
void append_usbip_device(std::vector<std::byte>& out, const UsbipDevice& device);
/// The bus id of an import, filled with NULs.
void append_usbip_bus_id(std::vector<std::byte>& out, const std::string& bus_id);
std::string read_usbip_bus_id(std::span<const std::byte> bytes);

enum class UsbipCommand : std::uint32_t {
  kSubmit = 1,
  kUnlink = 2,
  kSubmitted = 3,
  kUnlinked = 4,
};
/// Header of every message after an import. Of the fields that only one kind of message has, those
/// of other kinds are 0.
struct UsbipHeader {
  std::uint32_t command = 0;
  std::uint32_t number = 0;  ///< Number of the transfer, which its answer repeats.
  std::uint32_t device = 0;
  bool is_in = false;
  std::uint32_t endpoint = 0;           ///< Without the bit of its direction.
  std::uint32_t length = 0;             ///< Submit: bytes; answer: bytes that were moved.
  std::uint32_t packets = 0;            ///< Isochronous only; 0 or 0xFFFFFFFF otherwise.
  std::int32_t status = 0;              ///< Answers: 0, or an errno with a minus.
  std::uint32_t unlinked = 0;           ///< Unlink: number of the transfer to end.
  std::array<std::uint8_t, 8> setup{};  ///< Submit to endpoint 0.
};
UsbipHeader read_usbip_header(std::span<const std::byte> bytes);
void append_usbip_header(std::vector<std::byte>& out, const UsbipHeader& header);

/// The eight bytes of a setup packet, and back; its length apart.
std::array<std::uint8_t, 8> usb_setup_bytes(const UsbSetup& setup, std::uint16_t length);
UsbSetup usb_setup_of(const std::array<std::uint8_t, 8>& bytes);
std::uint16_t usb_setup_length(const std::array<std::uint8_t, 8>& bytes);

}  // namespace nav::devices
