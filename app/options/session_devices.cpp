// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/session_devices.hpp"

namespace nav::app {
namespace {

using session::DeviceBody;
using session::DeviceButton;
using session::DeviceOptions;

/// True for the .rom file of an NDI tool, not for "port:1".
bool is_file(const std::string& tool) { return !tool.empty() && !tool.starts_with("port:"); }

void read_bodies(Section& device, const std::string& name, std::vector<DeviceBody>& bodies,
                 bool with_stations = false) {
  const toml::array* list = device.tables("bodies");
  if (list == nullptr) return;
  for (const toml::node& element : *list) {
    Section one =
        device.inside(name + ".bodies[" + std::to_string(bodies.size()) + "]", element.as_table());
    DeviceBody body;
    one.required_text("name", body.name);
    if (with_stations) {
      one.integer("station", body.station);
    } else {
      one.text("tool", body.tool);
    }
    one.finish();
    bodies.push_back(std::move(body));
  }
}

bool is_camera(const DeviceOptions& device) {
  return device.kind == "camera-markers" || device.kind == "frame-grabber";
}

/// A film lies beside the session file.
constexpr std::string_view kFilm = "film:";

void read_camera(Section& device, const std::string& name, DeviceOptions& into) {
  device.text("address", into.address);
  if (into.address.starts_with(kFilm) && into.address.size() > kFilm.size()) {
    into.address =
        std::string(kFilm) + device.beside_file(into.address.substr(kFilm.size())).string();
  }
  device.integer("width", into.width);
  device.integer("height", into.height);
  device.number("images_hz", into.images_hz);
  if (into.kind == "frame-grabber") {
    device.text("image", into.image);
    device.numbers("crop", 4, into.crop);
    device.numbers("depth_display", 4, into.depth_display);
    return;
  }
  device.path("camera", into.camera);
  device.text("dictionary", into.dictionary);
  read_bodies(device, name, into.bodies);
}

toml::array array_of(const std::vector<double>& numbers) {
  toml::array array;
  for (const double number : numbers) array.push_back(number);
  return array;
}

toml::array array_of(const std::vector<DeviceBody>& bodies, bool with_files) {
  toml::array array;
  for (const DeviceBody& body : bodies) {
    toml::table one{{"name", body.name}};
    const bool file = with_files && is_file(body.tool);
    if (!body.tool.empty()) one.insert("tool", file ? absolute_text(body.tool) : body.tool);
    array.push_back(std::move(one));
  }
  return array;
}

void write_camera(toml::table& table, const DeviceOptions& device) {
  const bool film = device.address.starts_with(kFilm);
  table.insert("address",
               film ? std::string(kFilm) + absolute_text(device.address.substr(kFilm.size()))
                    : device.address);
  table.insert("width", device.width);
  table.insert("height", device.height);
  table.insert("images_hz", device.images_hz);
  if (device.kind == "frame-grabber") {
    table.insert("image", device.image);
    if (!device.crop.empty()) table.insert("crop", array_of(device.crop));
    if (!device.depth_display.empty())
      table.insert("depth_display", array_of(device.depth_display));
    return;
  }
  table.insert("camera", absolute_text(device.camera));
  table.insert("dictionary", device.dictionary);
  table.insert("bodies", array_of(device.bodies, false));
}

void read_buttons(Section& device, const std::string& name, DeviceOptions& into) {
  const toml::array* list = device.tables("buttons");
  if (list == nullptr) return;
  for (const toml::node& element : *list) {
    Section one = device.inside(name + ".buttons[" + std::to_string(into.buttons.size()) + "]",
                                element.as_table());
    DeviceButton button;
    one.required_text("name", button.name);
    one.text("action", button.action);
    if (into.kind == "footswitch") {
      one.required_text("key", button.key);
    } else if (into.kind == "simulated") {
      one.some_numbers("pressed_at_s", button.pressed_at_s);
    } else {
      one.integer("frame", button.frame);
      one.flag("extended", button.extended);
      one.integer("byte", button.byte);
      one.integer("bit", button.bit);
      one.flag("pressed_when_zero", button.pressed_when_zero);
    }
    one.finish();
    into.buttons.push_back(std::move(button));
  }
}

bool has_buttons(const DeviceOptions& device) {
  return device.kind == "footswitch" || device.kind == "can-buttons";
}

void write_buttons(toml::table& table, const DeviceOptions& device) {
  toml::array buttons;
  for (const DeviceButton& button : device.buttons) {
    toml::table one{{"name", button.name}, {"action", button.action}};
    if (device.kind == "footswitch") {
      one.insert("key", button.key);
    } else if (device.kind == "simulated") {
      one.insert("pressed_at_s", array_of(button.pressed_at_s));
    } else {
      one.insert("frame", static_cast<std::int64_t>(button.frame));
      one.insert("extended", button.extended);
      one.insert("byte", button.byte);
      one.insert("bit", button.bit);
      one.insert("pressed_when_zero", button.pressed_when_zero);
    }
    buttons.push_back(std::move(one));
  }
  table.insert("buttons", std::move(buttons));
  if (device.kind == "can-buttons") table.insert("silence_ms", device.silence_ms);
}

bool is_polhemus(const DeviceOptions& device) { return device.kind == "polhemus"; }

void read_polhemus(Section& device, const std::string& name, DeviceOptions& into) {
  device.text("address", into.address);
  device.numbers("hemisphere", 3, into.hemisphere);
  device.integer("distortion_limit", into.distortion_limit);
  read_bodies(device, name, into.bodies, true);
}

void write_polhemus(toml::table& table, const DeviceOptions& device) {
  table.insert("address", device.address);
  table.insert("hemisphere", array_of(device.hemisphere));
  table.insert("distortion_limit", device.distortion_limit);
  toml::array bodies;
  for (const DeviceBody& body : device.bodies) {
    bodies.push_back(toml::table{{"name", body.name}, {"station", body.station}});
  }
  table.insert("bodies", std::move(bodies));
}

bool is_interson(const DeviceOptions& device) { return device.kind == "interson"; }

void read_interson(Section& device, DeviceOptions& into) {
  into.images_hz = 15;
  device.text("address", into.address);
  device.text("image", into.image);
  device.integer("frequency", into.frequency);
  device.integer("band_pass", into.band_pass);
  device.integer("high_voltage", into.high_voltage);
  device.number("images_hz", into.images_hz);
  device.number("radius_mm", into.radius_mm);
  device.number("depth_mm", into.depth_mm);
  device.number("angle_deg", into.angle_deg);
  device.number("spacing_mm", into.spacing_mm);
}

void write_interson(toml::table& table, const DeviceOptions& device) {
  table.insert("address", device.address);
  table.insert("image", device.image);
  table.insert("frequency", device.frequency);
  table.insert("band_pass", device.band_pass);
  table.insert("high_voltage", device.high_voltage);
  table.insert("images_hz", device.images_hz);
  table.insert("radius_mm", device.radius_mm);
  table.insert("depth_mm", device.depth_mm);
  table.insert("angle_deg", device.angle_deg);
  table.insert("spacing_mm", device.spacing_mm);
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
      read_buttons(one, name, device);
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
    } else if (is_polhemus(device)) {
      read_polhemus(one, name, device);
    } else if (is_interson(device)) {
      read_interson(one, device);
    } else if (is_camera(device)) {
      read_camera(one, name, device);
    } else if (has_buttons(device)) {
      one.text("address", device.address);
      if (device.kind == "can-buttons") one.number("silence_ms", device.silence_ms);
      read_buttons(one, name, device);
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
      table.insert("address", writer.path(device.address));
    } else if (device.kind == "simulated") {
      table.insert("family", device.family);
      table.insert("tracker", device.tracker);
      table.insert("path", device.path);
      table.insert("needle", device.needle);
      table.insert("seed", static_cast<std::int64_t>(device.seed));
      table.insert("duration_s", device.duration_s);
      if (!device.buttons.empty()) write_buttons(table, device);
    } else if (is_polhemus(device)) {
      write_polhemus(table, device);
    } else if (is_interson(device)) {
      write_interson(table, device);
    } else if (is_camera(device)) {
      write_camera(table, device);
    } else if (has_buttons(device)) {
      table.insert("address", device.address);
      write_buttons(table, device);
    } else {
      toml::array bodies;
      for (const DeviceBody& body : device.bodies) {
        toml::table one{{"name", body.name}};
        const bool file = device.kind == "ndi" && is_file(body.tool);
        if (!body.tool.empty()) one.insert("tool", file ? writer.path(body.tool) : body.tool);
        bodies.push_back(std::move(one));
      }
      table.insert("address", device.address);
      if (device.kind == "ndi") {
        table.insert("baud", device.baud);
      } else if (device.kind == "can-arm") {
        table.insert("arm", writer.path(device.arm));
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
