// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/session_devices.hpp"

namespace nav::app {
namespace {

using session::DeviceBody;
using session::DeviceOptions;

/// True for the .rom file of an NDI tool, not for "port:1".
bool is_file(const std::string& tool) { return !tool.empty() && !tool.starts_with("port:"); }

void read_bodies(Section& device, const std::string& name, std::vector<DeviceBody>& bodies) {
  const toml::array* list = device.tables("bodies");
  if (list == nullptr) return;
  for (const toml::node& element : *list) {
    Section one =
        device.inside(name + ".bodies[" + std::to_string(bodies.size()) + "]", element.as_table());
    DeviceBody body;
    one.required_text("name", body.name);
    one.text("tool", body.tool);
    one.finish();
    bodies.push_back(std::move(body));
  }
}

}  // namespace

void read_devices(Section& root, const char* key, Settings& settings) {
  const toml::array* list = root.tables(key);
  if (list == nullptr) return;
  auto& devices = settings.config.source.devices;
  for (const toml::node& element : *list) {
    const std::string name = "devices[" + std::to_string(devices.size()) + "]";
    Section one = root.inside(name, element.as_table());
    DeviceOptions device;
    one.required_text("id", device.id);
    one.required_text("kind", device.kind);
    if (device.kind == "recording") {
      std::filesystem::path file;
      one.path("address", file);
      device.address = file.string();
    } else if (device.kind == "simulated") {
      one.text("family", device.family);
      one.text("tracker", device.tracker);
      one.text("path", device.path);
      one.flag("needle", device.needle);
      one.integer("seed", device.seed);
      one.number("duration_s", device.duration_s);
    } else if (device.kind == "ndi") {
      one.text("address", device.address);
      one.integer("baud", device.baud);
      read_bodies(one, name, device.bodies);
      for (DeviceBody& body : device.bodies) {
        // A tool definition lies beside the session file.
        if (is_file(body.tool)) body.tool = one.beside_file(body.tool).string();
      }
    } else if (device.kind == "can-arm") {
      one.text("address", device.address);
      one.path("arm", device.arm);
      one.number("rate_hz", device.rate_hz);
      read_bodies(one, name, device.bodies);
    } else {
      one.text("address", device.address);
      one.text("image", device.image);
      one.flag("announce_version_2", device.announce_version_2);
      read_bodies(one, name, device.bodies);
    }
    one.finish();
    devices.push_back(std::move(device));
  }
}

void write_devices(KeyWriter& writer, const char* key, const Settings& settings) {
  toml::array list;
  for (const DeviceOptions& device : settings.config.source.devices) {
    toml::table table;
    table.insert("id", device.id);
    table.insert("kind", device.kind);
    if (device.kind == "recording") {
      table.insert("address", absolute_text(device.address));
    } else if (device.kind == "simulated") {
      table.insert("family", device.family);
      table.insert("tracker", device.tracker);
      table.insert("path", device.path);
      table.insert("needle", device.needle);
      table.insert("seed", static_cast<std::int64_t>(device.seed));
      table.insert("duration_s", device.duration_s);
    } else {
      toml::array bodies;
      for (const DeviceBody& body : device.bodies) {
        toml::table one{{"name", body.name}};
        const bool file = device.kind == "ndi" && is_file(body.tool);
        if (!body.tool.empty()) one.insert("tool", file ? absolute_text(body.tool) : body.tool);
        bodies.push_back(std::move(one));
      }
      table.insert("address", device.address);
      if (device.kind == "ndi") {
        table.insert("baud", device.baud);
      } else if (device.kind == "can-arm") {
        table.insert("arm", absolute_text(device.arm));
        table.insert("rate_hz", device.rate_hz);
      } else {
        if (!device.image.empty()) table.insert("image", device.image);
        table.insert("announce_version_2", device.announce_version_2);
      }
      if (!bodies.empty()) table.insert("bodies", std::move(bodies));
    }
    list.push_back(std::move(table));
  }
  if (!list.empty()) writer.table.insert(key, std::move(list));
}

}  // namespace nav::app
