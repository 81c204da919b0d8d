// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/live_usb.hpp"

#include <algorithm>
#include <utility>

#include "devices/usb/interson_source.hpp"
#include "devices/usb/libusb_link.hpp"
#include "devices/usb/polhemus_source.hpp"
#include "devices/usb/usbip_link.hpp"
#include "session/device_address.hpp"

namespace nav::session {
namespace {

constexpr const char* kPolhemusKind = "polhemus";
constexpr const char* kIntersonKind = "interson";

/// Numbers of the device that a kind reads, for an address without them.
devices::UsbId usual_id(const DeviceOptions& device) {
  if (device.kind == kIntersonKind) {
    return {.vendor = devices::kIntersonVendor, .product = devices::kSeeMoreProduct};
  }
  return {.vendor = devices::kPolhemusVendor, .product = devices::kLibertyProduct};
}

devices::UsbOpener usb_opener_of(const DeviceOptions& device) {
  if (const auto usb = usb_address(device.address)) {
    const devices::UsbId id{.vendor = usb->vendor, .product = usb->product, .serial = usb->serial};
    return [id] { return devices::open_usb(id); };
  }
  const auto server = *usbip_address(device.address);
  return
      [server, id = usual_id(device)] { return devices::open_usbip(server.host, server.port, id); };
}

devices::PolhemusOptions polhemus_of(const DeviceOptions& device, const std::string& needle_body,
                                     const SourceOptions& source) {
  devices::PolhemusOptions options;
  options.distortion_limit = device.distortion_limit;
  std::copy_n(device.hemisphere.begin(), std::min<std::size_t>(device.hemisphere.size(), 3),
              options.hemisphere.begin());
  for (const DeviceBody& body : device.bodies) {
    const ToolRole role = body.name == needle_body ? ToolRole::kNeedle : role_of(body.name, source);
    options.bodies.push_back({.name = body.name, .station = body.station, .role = role});
  }
  return options;
}

devices::IntersonOptions interson_of(const DeviceOptions& device) {
  constexpr double kUsualHz = 15;
  return {.image = device.image,
          .settings = {.frequency = device.frequency,
                       .band_pass = device.band_pass,
                       .high_voltage = device.high_voltage,
                       .images_hz = device.images_hz > 0 ? device.images_hz : kUsualHz},
          .shape = {.radius_mm = device.radius_mm,
                    .depth_mm = device.depth_mm,
                    .angle_deg = device.angle_deg,
                    .spacing_mm = device.spacing_mm}};
}

template <class Opened>
Result<LiveDevice> opened_usb(const DeviceOptions& device, Opened opened) {
  if (!opened) return opened.error();
  return LiveDevice{.options = device, .source = *std::move(opened)};
}

}  // namespace

bool is_usb_device(const DeviceOptions& device) {
  return device.kind == kPolhemusKind || device.kind == kIntersonKind;
}

Result<void> validate_usb(const DeviceOptions& device, const std::string& name) {
  if (!usb_address(device.address) && !usbip_address(device.address)) {
    return Error{ErrorCode::kUsage, name + ".address: expected usb:VENDOR:PRODUCT (" +
                                        devices::usb_name(usual_id(device)) +
                                        "), usb:VENDOR:PRODUCT:SERIAL or usbip:HOST:PORT, found '" +
                                        device.address + "'"};
  }
  if (device.kind == kIntersonKind) {
    const auto ok = validate(interson_of(device));
    return ok ? ok : Result<void>(Error{ErrorCode::kUsage, name + ": " + ok.error().message});
  }
  if (device.hemisphere.size() != 3) {
    return Error{ErrorCode::kUsage, name + ".hemisphere: expected three numbers, found " +
                                        std::to_string(device.hemisphere.size())};
  }
  if (auto ok = validate(polhemus_of(device, "", {})); !ok) {
    return Error{ErrorCode::kUsage, name + ": " + ok.error().message};
  }
  return {};
}

Result<LiveDevice> open_usb_device(const DeviceOptions& device, const std::string& needle_body,
                                   const SourceOptions& source, const Clock& clock,
                                   Diagnostics& diagnostics) {
  if (device.kind == kIntersonKind) {
    return opened_usb(device,
                      devices::IntersonSource::create(interson_of(device), device.address,
                                                      usb_opener_of(device), clock, diagnostics));
  }
  return opened_usb(device, devices::PolhemusSource::create(
                                polhemus_of(device, needle_body, source), device.address,
                                usb_opener_of(device), clock, diagnostics));
}

}  // namespace nav::session
