// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/devices.hpp"

#include <iostream>

#include "app/report.hpp"
#include "devices/inventory.hpp"

namespace nav::app {

Result<void> run_devices(const std::optional<std::string>& json, Console& console) {
  Json report;
  report["verb"] = "devices";
  report["usb"] = Json::array();
  report["can"] = Json::array();
  // One bus that cannot be asked does not hide the other.
  if (const auto usb = devices::list_usb(); usb) {
    for (const auto& device : *usb) {
      report["usb"].push_back({{"bus", device.bus},
                               {"address", device.address},
                               {"vendor_id", device.vendor_id},
                               {"product_id", device.product_id},
                               {"product", device.product}});
      char line[64];
      std::snprintf(line, sizeof line, "usb %03d:%03d %04x:%04x ", device.bus, device.address,
                    device.vendor_id, device.product_id);
      if (!json) std::cout << line << device.product << '\n';
    }
  } else {
    console.report(Severity::kWarning, "devices", usb.error().message);
  }
  if (const auto can = devices::list_can(); can) {
    for (const auto& interface : *can) {
      report["can"].push_back({{"name", interface.name}, {"up", interface.up}});
      if (!json) std::cout << "can " << interface.name << (interface.up ? " up" : " down") << '\n';
    }
  } else {
    console.report(Severity::kWarning, "devices", can.error().message);
  }
  report["diagnostics"] = json_of(console.entries());
  if (json) return write_json(report, *json);
  if (report["usb"].empty() && report["can"].empty()) std::cout << "no devices\n";
  return {};
}

}  // namespace nav::app
