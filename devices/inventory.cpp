// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/inventory.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <libusb-1.0/libusb.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <optional>
#include <system_error>
#include <unistd.h>

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

std::string first_line(const std::filesystem::path& path) {
  std::string line;
  std::ifstream file(path);
  std::getline(file, line);
  return line;
}

/// The name of a node; absent: it is none of its kind, or has no hardware behind it.
std::optional<std::string> node_name(NodeKind kind, const std::filesystem::path& entry) {
  if (kind == NodeKind::kVideo) return first_line(entry / "name");
  std::error_code status;
  const auto device = entry / "device";
  if (kind == NodeKind::kInput) {
    if (entry.filename().string().rfind("event", 0) != 0) return std::nullopt;
    return first_line(device / "name");
  }
  const auto driver = std::filesystem::read_symlink(device / "driver", status);
  if (status) return std::nullopt;  // A console.
  // A port of the main board without a chip has type 0; adapters have no such file.
  if (first_line(entry / "type") == "0") return std::nullopt;
  return driver.filename().string();
}

}  // namespace

const char* to_string(NodeKind kind) {
  switch (kind) {
    case NodeKind::kSerial:
      return "serial";
    case NodeKind::kVideo:
      return "video";
    case NodeKind::kInput:
      return "input";
  }
  return "unknown";
}

std::vector<DeviceNode> list_nodes(const std::filesystem::path& sys_class,
                                   const std::filesystem::path& dev) {
  struct Class {
    NodeKind kind;
    const char* folder;
    const char* dev_folder;
  };
  constexpr Class kClasses[] = {{NodeKind::kSerial, "tty", ""},
                                {NodeKind::kVideo, "video4linux", ""},
                                {NodeKind::kInput, "input", "input"}};
  std::vector<DeviceNode> nodes;
  for (const Class& of : kClasses) {
    std::error_code status;
    for (const auto& entry : std::filesystem::directory_iterator(sys_class / of.folder, status)) {
      auto name = node_name(of.kind, entry.path());
      if (!name) continue;
      DeviceNode node{.kind = of.kind,
                      .path = dev / of.dev_folder / entry.path().filename(),
                      .name = *std::move(name),
                      .trouble = {}};
      if (::access(node.path.c_str(), R_OK) != 0) {
        node.trouble = std::generic_category().message(errno);
      }
      nodes.push_back(std::move(node));
    }
  }
  std::sort(nodes.begin(), nodes.end(), [](const DeviceNode& a, const DeviceNode& b) {
    return std::pair(a.kind, a.path) < std::pair(b.kind, b.path);
  });
  return nodes;
}

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
