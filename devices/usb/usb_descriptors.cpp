// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/usb/usb_descriptors.hpp"

namespace nav::devices {
namespace {

constexpr unsigned kDeviceDescriptor = 1, kConfigurationDescriptor = 2, kStringDescriptor = 3,
                   kInterfaceDescriptor = 4, kEndpointDescriptor = 5, kQualifierDescriptor = 6;

class UsbWriter {
 public:
  void byte(unsigned value) { bytes_.push_back(static_cast<std::byte>(value & 0xFF)); }
  void word(unsigned value) {
    byte(value);
    byte(value >> 8);
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

std::vector<std::byte> device_descriptor(const UsbDescription& device) {
  UsbWriter out;
  out.byte(18);
  out.byte(kDeviceDescriptor);
  out.word(0x0200);
  out.byte(0xFF);  // Class, subclass and protocol of the maker.
  out.word(0);
  out.byte(64);
  out.word(device.vendor);
  out.word(device.product);
  out.word(0x0100);
  for (const unsigned string : {1U, 2U, 3U}) out.byte(string);
  out.byte(1);
  return out.take();
}

std::vector<std::byte> configuration_descriptor(const UsbDescription& device) {
  constexpr std::size_t kHead = 9, kInterface = 9, kEndpoint = 7;
  constexpr unsigned kBusPowered = 0x80, kBulk = 2;
  UsbWriter out;
  out.byte(kHead);
  out.byte(kConfigurationDescriptor);
  out.word(static_cast<unsigned>(kHead + kInterface + kEndpoint * device.endpoints.size()));
  out.byte(1);  // One interface.
  out.byte(1);
  out.byte(0);
  out.byte(kBusPowered);
  out.byte(250);  // 500 mA.
  out.byte(kInterface);
  out.byte(kInterfaceDescriptor);
  out.word(0);
  out.byte(static_cast<unsigned>(device.endpoints.size()));
  out.byte(0xFF);
  out.word(0);
  out.byte(0);
  for (const UsbEndpoint& endpoint : device.endpoints) {
    out.byte(kEndpoint);
    out.byte(kEndpointDescriptor);
    out.byte(endpoint.address);
    out.byte(kBulk);
    out.word(endpoint.packet);
    out.byte(0);
  }
  return out.take();
}

std::optional<std::vector<std::byte>> string_descriptor(const UsbDescription& device,
                                                        unsigned index) {
  constexpr unsigned kEnglish = 0x0409;
  UsbWriter out;
  if (index == 0) {
    out.byte(4);
    out.byte(kStringDescriptor);
    out.word(kEnglish);
    return out.take();
  }
  if (index > 3) return std::nullopt;
  const std::string& text = index == 1 ? device.maker : index == 2 ? device.name : device.serial;
  out.byte(static_cast<unsigned>(2 + 2 * text.size()));
  out.byte(kStringDescriptor);
  for (const char letter : text) out.word(static_cast<unsigned char>(letter));
  return out.take();
}

std::vector<std::byte> qualifier_descriptor() {
  UsbWriter out;
  out.byte(10);
  out.byte(kQualifierDescriptor);
  out.word(0x0200);
  out.byte(0xFF);
  out.word(0);
  out.byte(64);
  out.byte(1);
  out.byte(0);
  return out.take();
}

}  // namespace

std::optional<std::vector<std::byte>> usb_descriptor(const UsbDescription& device,
                                                     std::uint16_t kind) {
  switch (kind >> 8) {
    case kDeviceDescriptor:
      return device_descriptor(device);
    case kConfigurationDescriptor:
      return configuration_descriptor(device);
    case kStringDescriptor:
      return string_descriptor(device, kind & 0xFF);
    case kQualifierDescriptor:
      return qualifier_descriptor();
    default:
      return std::nullopt;
  }
}

}  // namespace nav::devices
