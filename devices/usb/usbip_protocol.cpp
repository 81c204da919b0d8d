// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/usb/usbip_protocol.hpp"

#include "devices/openigtlink/igtl_bytes.hpp"
#include "nav/check.hpp"

namespace nav::devices {
namespace {

constexpr std::size_t kUsbipPathBytes = 256;

std::uint8_t byte_at(std::uint16_t value, int byte) {
  return static_cast<std::uint8_t>(value >> (8 * byte) & 0xFF);
}

}  // namespace

UsbipOperationHeader read_usbip_operation(std::span<const std::byte> bytes) {
  IgtlReader reader(bytes);
  UsbipOperationHeader header;
  header.version = reader.number<std::uint16_t>();
  header.code = reader.number<std::uint16_t>();
  header.status = reader.number<std::uint32_t>();
  return header;
}

void append_usbip_operation(std::vector<std::byte>& out, UsbipOperation code,
                            std::uint32_t status) {
  IgtlWriter writer(out);
  writer.number(UsbipOperationHeader{}.version);
  writer.number(static_cast<std::uint16_t>(code));
  writer.number(status);
}

UsbipDevice read_usbip_device(std::span<const std::byte> bytes) {
  IgtlReader reader(bytes);
  UsbipDevice device;
  device.path = reader.text(kUsbipPathBytes);
  device.bus_id = reader.text(kUsbipBusIdBytes);
  device.bus = reader.number<std::uint32_t>();
  device.device = reader.number<std::uint32_t>();
  device.speed = reader.number<std::uint32_t>();
  device.vendor = reader.number<std::uint16_t>();
  device.product = reader.number<std::uint16_t>();
  device.release = reader.number<std::uint16_t>();
  reader.bytes(4);  // Class, subclass, protocol, and the current configuration.
  device.configurations = reader.number<std::uint8_t>();
  device.interfaces = reader.number<std::uint8_t>();
  return device;
}

void append_usbip_device(std::vector<std::byte>& out, const UsbipDevice& device) {
  constexpr std::uint8_t kOfVendor = 0xFF;
  IgtlWriter writer(out);
  writer.text(device.path, kUsbipPathBytes);
  writer.text(device.bus_id, kUsbipBusIdBytes);
  for (const std::uint32_t one : {device.bus, device.device, device.speed}) writer.number(one);
  for (const std::uint16_t one : {device.vendor, device.product, device.release}) {
    writer.number(one);
  }
  for (const std::uint8_t one : {kOfVendor, std::uint8_t{0}, std::uint8_t{0}, std::uint8_t{1},
                                 device.configurations, device.interfaces}) {
    writer.number(one);
  }
}

void append_usbip_bus_id(std::vector<std::byte>& out, const std::string& bus_id) {
  IgtlWriter(out).text(bus_id, kUsbipBusIdBytes);
}

std::string read_usbip_bus_id(std::span<const std::byte> bytes) {
  IgtlReader reader(bytes);
  return std::string(reader.text(kUsbipBusIdBytes));
}

UsbipHeader read_usbip_header(std::span<const std::byte> bytes) {
  IgtlReader reader(bytes);
  UsbipHeader header;
  header.command = reader.number<std::uint32_t>();
  header.number = reader.number<std::uint32_t>();
  header.device = reader.number<std::uint32_t>();
  header.is_in = reader.number<std::uint32_t>() == 1;
  header.endpoint = reader.number<std::uint32_t>();
  const auto first = reader.number<std::uint32_t>();
  const auto second = reader.number<std::uint32_t>();
  reader.bytes(4);  // Start of isochronous transfers.
  const auto packets = reader.number<std::uint32_t>();
  reader.bytes(4);  // Interval, or count of errors.
  const auto setup = reader.bytes(header.setup.size());
  switch (static_cast<UsbipCommand>(header.command)) {
    case UsbipCommand::kSubmit:
      header.length = second;
      header.packets = packets;
      for (std::size_t i = 0; i < setup.size(); ++i) {
        header.setup[i] = std::to_integer<std::uint8_t>(setup[i]);
      }
      break;
    case UsbipCommand::kSubmitted:
      header.status = static_cast<std::int32_t>(first);
      header.length = second;
      header.packets = packets;
      break;
    case UsbipCommand::kUnlink:
      header.unlinked = first;
      break;
    case UsbipCommand::kUnlinked:
      header.status = static_cast<std::int32_t>(first);
      break;
  }
  return header;
}

void append_usbip_header(std::vector<std::byte>& out, const UsbipHeader& header) {
  IgtlWriter writer(out);
  const std::size_t begin = out.size();
  writer.number(header.command);
  writer.number(header.number);
  writer.number(header.device);
  writer.number(std::uint32_t{header.is_in ? 1U : 0U});
  writer.number(header.endpoint);
  const auto command = static_cast<UsbipCommand>(header.command);
  if (command == UsbipCommand::kUnlink) {
    writer.number(header.unlinked);
  } else if (command == UsbipCommand::kSubmit) {
    writer.number(std::uint32_t{0});  // Flags.
    writer.number(header.length);
    writer.number(std::uint32_t{0});  // Start of isochronous transfers.
    writer.number(header.packets);
    writer.number(std::uint32_t{0});  // Interval.
    for (const std::uint8_t byte : header.setup) writer.number(byte);
  } else {
    writer.number(static_cast<std::uint32_t>(header.status));
    if (command == UsbipCommand::kSubmitted) {
      writer.number(header.length);
      writer.number(std::uint32_t{0});  // Start of isochronous transfers.
      writer.number(header.packets);
    }
  }
  NAV_CHECK(out.size() - begin <= kUsbipHeaderBytes, out.size() - begin);
  out.resize(begin + kUsbipHeaderBytes, std::byte{0});
}

std::array<std::uint8_t, 8> usb_setup_bytes(const UsbSetup& setup, std::uint16_t length) {
  return {setup.request_type,      setup.request,           byte_at(setup.value, 0),
          byte_at(setup.value, 1), byte_at(setup.index, 0), byte_at(setup.index, 1),
          byte_at(length, 0),      byte_at(length, 1)};
}

UsbSetup usb_setup_of(const std::array<std::uint8_t, 8>& bytes) {
  return {.request_type = bytes[0],
          .request = bytes[1],
          .value = static_cast<std::uint16_t>(bytes[2] | bytes[3] << 8),
          .index = static_cast<std::uint16_t>(bytes[4] | bytes[5] << 8)};
}

std::uint16_t usb_setup_length(const std::array<std::uint8_t, 8>& bytes) {
  return static_cast<std::uint16_t>(bytes[6] | bytes[7] << 8);
}

}  // namespace nav::devices
