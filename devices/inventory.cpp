// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/inventory.hpp"

#include <algorithm>
#include <array>
#include <fstream>
#include <libusb-1.0/libusb.h>
#include <net/if.h>
#include <net/if_arp.h>

namespace nav::devices {
namespace {

std::string product_name(libusb_device* device, const libusb_device_descriptor& descriptor) {
  libusb_device_handle* handle = nullptr;
  if (descriptor.iProduct == 0 || libusb_open(device, &handle) != 0) return "";
  std::array<unsigned char, 256> text{};
  const int length = libusb_get_string_descriptor_ascii(handle, descriptor.iProduct, text.data(),
                                                        static_cast<int>(text.size()));
  libusb_close(handle);
  return length > 0 ? std::string(text.begin(), text.begin() + length) : "";
}

}  // namespace

Result<std::vector<UsbDevice>> list_usb() {
  libusb_context* context = nullptr;
  if (const int code = libusb_init(&context); code != 0) {
    return Error{ErrorCode::kUnavailable,
                 std::string("USB: cannot start the USB library: ") + libusb_strerror(code)};
  }
  libusb_device** list = nullptr;
  const auto count = libusb_get_device_list(context, &list);
  if (count < 0) {
    libusb_exit(context);
    return Error{ErrorCode::kUnavailable, std::string("USB: cannot list the devices: ") +
                                              libusb_strerror(static_cast<int>(count))};
  }
  std::vector<UsbDevice> devices;
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    libusb_device_descriptor descriptor{};
    if (libusb_get_device_descriptor(list[i], &descriptor) != 0) continue;
    devices.push_back({.bus = libusb_get_bus_number(list[i]),
                       .address = libusb_get_device_address(list[i]),
                       .vendor_id = descriptor.idVendor,
                       .product_id = descriptor.idProduct,
                       .product = product_name(list[i], descriptor)});
  }
  libusb_free_device_list(list, 1);
  libusb_exit(context);
  std::sort(devices.begin(), devices.end(), [](const UsbDevice& a, const UsbDevice& b) {
    return std::pair(a.bus, a.address) < std::pair(b.bus, b.address);
  });
  return devices;
}

Result<std::vector<CanInterface>> list_can(const std::filesystem::path& sys_class_net) {
  std::error_code status;
  std::vector<CanInterface> interfaces;
  std::filesystem::directory_iterator folder(sys_class_net, status);
  if (status) {
    return Error{
        ErrorCode::kUnavailable,
        sys_class_net.string() + ": cannot list the network interfaces: " + status.message()};
  }
  for (const auto& entry : folder) {
    int type = -1;
    std::ifstream(entry.path() / "type") >> type;
    if (type != ARPHRD_CAN) continue;
    unsigned flags = 0;
    std::ifstream(entry.path() / "flags") >> std::hex >> flags;
    interfaces.push_back({entry.path().filename().string(), (flags & IFF_UP) != 0});
  }
  std::sort(interfaces.begin(), interfaces.end(),
            [](const CanInterface& a, const CanInterface& b) { return a.name < b.name; });
  return interfaces;
}

}  // namespace nav::devices
