// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/live_devices.hpp"

#include <algorithm>
#include <charconv>
#include <utility>

#include "devices/can/can_arm_source.hpp"
#include "devices/ndi/ndi_source.hpp"
#include "devices/openigtlink/openigtlink_source.hpp"
#include "io/recording_source.hpp"
#include "session/arm_file.hpp"
#include "session/device_address.hpp"
#include "session/live_buttons.hpp"
#include "session/live_cameras.hpp"
#include "session/live_usb.hpp"
#include "session/paced_source.hpp"
#include "session/played_recording.hpp"
#include "sim/session/simulated_session.hpp"
#include "sim/simulated_source.hpp"

namespace nav::session {
namespace {

Result<LiveDevice> open_openigtlink(const DeviceOptions& device, const std::string& needle_body,
                                    const SourceOptions& source, const Clock& clock,
                                    Diagnostics& diagnostics) {
  const auto address = *tcp_address(device.address);
  devices::OpenIgtLinkOptions options;
  options.host = address.host;
  options.port = address.port;
  options.announce_version_2 = device.announce_version_2;
  for (const DeviceBody& body : device.bodies) {
    const std::string tool = body.tool.empty()
                                 ? devices::plus_transform_name(body.name, source.tracker_frame)
                                 : body.tool;
    const ToolRole role = body.name == needle_body ? ToolRole::kNeedle : role_of(body.name, source);
    options.streams.push_back({tool, StreamKind::kPoses, role});
  }
  if (!device.image.empty()) options.streams.push_back({device.image, StreamKind::kImages});
  auto opened = devices::OpenIgtLinkSource::create(options, clock, diagnostics);
  if (!opened) return opened.error();
  return LiveDevice{.options = device, .source = *std::move(opened)};
}

/// A tool of an NDI tracker: empty, "port:2", "port:2.1" (second channel) or a .rom file.
std::optional<devices::NdiTool> ndi_tool(const DeviceBody& body) {
  constexpr std::string_view kBegin = "port:";
  devices::NdiTool tool{.name = body.name};
  if (!body.tool.starts_with(kBegin)) {
    tool.rom = body.tool;
    return tool;
  }
  const std::string_view text = std::string_view(body.tool).substr(kBegin.size());
  devices::NdiPlace place;
  const char* const end = text.data() + text.size();
  auto read = std::from_chars(text.data(), end, place.port);
  if (read.ec == std::errc() && read.ptr != end && *read.ptr == '.') {
    read = std::from_chars(read.ptr + 1, end, place.channel);
  }
  if (read.ec != std::errc() || read.ptr != end || place.port == 0) return std::nullopt;
  tool.place = place;
  return tool;
}

Result<LiveDevice> open_ndi(const DeviceOptions& device, const std::string& needle_body,
                            const SourceOptions& source, const Clock& clock,
                            Diagnostics& diagnostics) {
  devices::NdiOptions options;
  options.baud = device.baud;
  for (const DeviceBody& body : device.bodies) {
    const ToolRole role = body.name == needle_body ? ToolRole::kNeedle : role_of(body.name, source);
    options.streams.push_back({*ndi_tool(body), role});
  }
  std::unique_ptr<devices::NdiTransport> transport;
  if (const auto path = serial_address(device.address)) {
    transport = devices::make_ndi_serial(*path);
  } else {
    const auto address = *tcp_address(device.address);
    auto made = devices::make_ndi_tcp(address.host, address.port);
    if (!made) return made.error();
    transport = *std::move(made);
  }
  auto opened = devices::NdiSource::create(options, std::move(transport), clock, diagnostics);
  if (!opened) return opened.error();
  return LiveDevice{.options = device, .source = *std::move(opened)};
}

Result<LiveDevice> open_can_arm(const DeviceOptions& device, const std::string& needle_body,
                                const SourceOptions& source, const Clock& clock,
                                Diagnostics& diagnostics) {
  auto arm = read_arm_file(device.arm);
  if (!arm) return arm.error();
  devices::CanArmOptions options;
  options.body = device.bodies.front().name;
  options.role = options.body == needle_body ? ToolRole::kNeedle : role_of(options.body, source);
  options.arm = *std::move(arm);
  options.period =
      std::chrono::duration_cast<Duration>(std::chrono::duration<double>(1 / device.rate_hz));
  const std::string interface = *can_address(device.address);
  auto opened = devices::CanArmSource::create(
      options, interface, devices::CanArmSource::on_interface(interface, options.arm), clock,
      diagnostics);
  if (!opened) return opened.error();
  return LiveDevice{.options = device, .source = *std::move(opened)};
}

/// A simulated session with the source of its streams.
struct Simulation {
  explicit Simulation(sim::SimulatedSession made) : session(std::move(made)) {}
  sim::SimulatedSession session;
  sim::SimulatedSource source;
};

Result<LiveDevice> open_simulated(const DeviceOptions& device, const Clock& clock) {
  sim::SimulatedSessionOptions options;
  options.family = device.family;
  options.seed = device.seed;
  options.duration_s = device.duration_s;
  const auto tracker = sim::tracker_kind_from(device.tracker);
  if (!tracker) return tracker.error();
  options.tracker = *tracker;
  const auto path = sim::hand_path_kind_from(device.path);
  if (!path) return path.error();
  options.path.kind = *path;
  if (device.needle) options.needle.emplace();
  auto made = sim::SimulatedSession::create(options);
  if (!made) return made.error();
  const auto simulation = std::make_shared<Simulation>(*std::move(made));
  const sim::SimulatedSession& session = simulation->session;
  simulation->source.add("Probe", ToolRole::kProbe, session.probe_poses());
  simulation->source.add("Reference", ToolRole::kReference, session.reference_poses());
  LiveDevice opened{.options = device, .source = nullptr};
  if (session.needle()) {
    simulation->source.add("Needle", ToolRole::kNeedle, session.needle_poses());
    opened.body_from_tip = session.needle()->hub_from_needle().matrix();
  }
  simulation->source.add("Image", session.frames());
  for (const DeviceButton& button : device.buttons) {
    simulation->source.add(button.name, *button_action_from(button.action),
                           simulated_changes(button));
  }
  opened.calibration = ProbeCalibration{session.probe_from_image()};
  opened.source = std::make_shared<PacedSource>(
      std::shared_ptr<Source>(simulation, &simulation->source), clock);
  return opened;
}

Result<LiveDevice> open_recording(const DeviceOptions& device, const SourceOptions& source,
                                  const Clock& clock, Diagnostics& diagnostics) {
  const auto opened = open_recording_source(device.address, source, diagnostics);
  if (!opened) return opened.error();
  const std::shared_ptr<io::RecordingSource>& recording = *opened;
  return LiveDevice{
      .options = device,
      .source = std::make_shared<PacedSource>(recording, clock),
      .calibration = ProbeCalibration{.probe_from_image = recording->calibration().probe_from_image,
                                      .doubt = recording->calibration_doubt()},
      .tracks_patient = recording->form() == io::RecordingForm::kTracked &&
                        recording->reference_frame() != source.tracker_frame};
}

Result<void> validate_ndi(const DeviceOptions& device, const std::string& name) {
  const auto reject = [&](const std::string& key, const std::string& expected,
                          const std::string& found) {
    return Error{ErrorCode::kUsage,
                 name + key + ": expected " + expected + ", found '" + found + "'"};
  };
  if (!serial_address(device.address) && !tcp_address(device.address)) {
    return reject(".address", "serial:/dev/… or tcp:host:port", device.address);
  }
  if (device.bodies.empty()) return reject(".bodies", "at least one body", "none");
  devices::NdiOptions options;
  options.baud = device.baud;
  for (std::size_t i = 0; i < device.bodies.size(); ++i) {
    const auto tool = ndi_tool(device.bodies[i]);
    if (!tool) {
      return reject(".bodies[" + std::to_string(i) + "].tool",
                    "a .rom file, port:NUMBER, or nothing", device.bodies[i].tool);
    }
    options.streams.push_back({.tool = *tool});
  }
  if (auto ok = devices::validate(options); !ok) {
    return Error{ErrorCode::kUsage, name + ": " + ok.error().message};
  }
  return {};
}

Result<void> validate_one(const DeviceOptions& device, const std::string& name) {
  const auto reject = [&](const char* key, const std::string& expected, const std::string& found) {
    return Error{ErrorCode::kUsage,
                 name + "." + key + ": expected " + expected + ", found '" + found + "'"};
  };
  constexpr std::size_t kLongestId = 64;
  const auto plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-' || c == '.';
  };
  if (device.id.empty() || device.id.size() > kLongestId ||
      !std::all_of(device.id.begin(), device.id.end(), plain)) {
    return reject("id", "1 to 64 letters, digits and _ - .", device.id);
  }
  if (std::ranges::count(device_kinds(), device.kind) == 0) {
    std::string kinds;
    for (const auto& kind : device_kinds()) kinds.append(kinds.empty() ? "" : ", ").append(kind);
    return reject("kind", "one of " + kinds, device.kind);
  }
  if (device.kind == "openigtlink") {
    if (!tcp_address(device.address)) {
      return reject("address", "tcp:host:port", device.address);
    }
    if (device.bodies.empty() && device.image.empty()) {
      return reject("bodies", "bodies or an image, or both", "neither");
    }
  }
  if (device.kind == "ndi") {
    if (auto ok = validate_ndi(device, name); !ok) return ok;
  }
  if (device.kind == "can-arm") {
    if (!can_address(device.address)) return reject("address", "can:INTERFACE", device.address);
    if (device.arm.empty()) return reject("arm", "the file of the arm's kinematics", "");
    if (device.bodies.size() != 1) {
      return reject("bodies", "the one body that the arm holds",
                    std::to_string(device.bodies.size()));
    }
    if (!(device.rate_hz >= 1 && device.rate_hz <= 1000)) {
      return reject("rate_hz", "1 to 1000 Hz", std::to_string(device.rate_hz));
    }
  }
  if (is_button_device(device) || device.kind == "simulated") {
    if (auto ok = validate_buttons(device, name); !ok) return ok;
  }
  if (is_camera(device)) {
    if (auto ok = validate_camera(device, name); !ok) return ok;
  }
  if (is_usb_device(device)) {
    if (auto ok = validate_usb(device, name); !ok) return ok;
  }
  if (device.kind == "recording" && device.address.empty()) {
    return reject("address", "the file of a PLUS sequence", device.address);
  }
  if (!(device.duration_s > 0 && device.duration_s <= 3600)) {
    return reject("duration_s", "more than 0 and at most 3600 s",
                  std::to_string(device.duration_s));
  }
  for (std::size_t i = 0; i < device.bodies.size(); ++i) {
    const DeviceBody& body = device.bodies[i];
    if (body.name.empty()) return reject("bodies", "a name of each body", "");
    for (std::size_t before = 0; before < i; ++before) {
      const DeviceBody& other = device.bodies[before];
      if (other.name == body.name) return reject("bodies", "a name of its own for each", body.name);
      if (!body.tool.empty() && other.tool == body.tool) {
        return reject("bodies",
                      "a tool of its own for each (" + other.name + ", " + body.name + ")",
                      body.tool);
      }
    }
  }
  return {};
}

}  // namespace

ToolRole role_of(const std::string& body, const SourceOptions& source) {
  const auto named = [](const std::string& given, const char* usual) {
    return given.empty() ? std::string(usual) : given;
  };
  if (body == source.probe_frame) return ToolRole::kProbe;
  if (body == named(source.reference_frame, "Reference")) return ToolRole::kReference;
  if (body == "Stylus") return ToolRole::kStylus;
  if (body == "Phantom") return ToolRole::kPhantom;
  return ToolRole::kOther;
}

LiveKind live_kind(const std::vector<DeviceOptions>& devices) {
  const auto has = [&](const char* kind) {
    return std::ranges::any_of(devices, [&](const auto& device) { return device.kind == kind; });
  };
  if (has("simulated")) return LiveKind::kSimulated;
  return has("recording") ? LiveKind::kRecording : LiveKind::kLive;
}

const std::vector<std::string>& device_kinds() {
  static const std::vector<std::string> kinds{
      "openigtlink",   "ndi",      "can-arm",  "footswitch", "can-buttons", "camera-markers",
      "frame-grabber", "polhemus", "interson", "simulated",  "recording"};
  return kinds;
}

Result<void> validate(const std::vector<DeviceOptions>& devices) {
  for (std::size_t i = 0; i < devices.size(); ++i) {
    const std::string name = "devices[" + std::to_string(i) + "]";
    if (auto ok = validate_one(devices[i], name); !ok) return ok;
    for (std::size_t before = 0; before < i; ++before) {
      if (devices[before].id != devices[i].id) continue;
      return Error{ErrorCode::kUsage, name + ".id: expected an id of its own, found '" +
                                          devices[i].id + "' as in devices[" +
                                          std::to_string(before) + "]"};
    }
  }
  return {};
}

Result<LiveDevice> open_device(const DeviceOptions& device, const std::string& needle_body,
                               const SourceOptions& source, const Clock& clock,
                               Diagnostics& diagnostics) {
  auto opened =
      device.kind == "simulated" ? open_simulated(device, clock)
      : device.kind == "ndi"     ? open_ndi(device, needle_body, source, clock, diagnostics)
      : device.kind == "can-arm" ? open_can_arm(device, needle_body, source, clock, diagnostics)
      : is_button_device(device) ? open_buttons(device, clock, diagnostics)
      : is_camera(device)        ? open_camera(device, needle_body, source, clock, diagnostics)
      : is_usb_device(device)    ? open_usb_device(device, needle_body, source, clock, diagnostics)
      : device.kind == "recording"
          ? open_recording(device, source, clock, diagnostics)
          : open_openigtlink(device, needle_body, source, clock, diagnostics);
  if (!opened) return Error{opened.error().code, device.id + ": " + opened.error().message};
  return opened;
}

}  // namespace nav::session
