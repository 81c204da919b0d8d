// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/serve.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <thread>

#include "app/interrupt.hpp"
#include "app/report.hpp"
#include "app/verbs/device_report.hpp"
#include "devices/can/can_arm_sender.hpp"
#include "devices/ndi/ndi_sender.hpp"
#include "devices/openigtlink/openigtlink_sender.hpp"
#include "devices/usb/interson_sender.hpp"
#include "devices/usb/polhemus_sender.hpp"
#include "io/atomic_file.hpp"
#include "session/arm_file.hpp"
#include "session/live_session.hpp"

namespace nav::app {
namespace {

/// The wall clock when the session clock showed 0.
DeviceTime wall_clock_at_zero(const Clock& clock) {
  const auto wall = std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::system_clock::now().time_since_epoch());
  return DeviceTime(wall - clock.now().time_since_epoch());
}

constexpr std::uint16_t kNdiPort = 8765;

Error line_error(const char* expected, const std::string& found) {
  return {ErrorCode::kUsage,
          std::string("--line: expected ") + expected + ", found '" + found + "'"};
}

/// Port of "tcp:PORT"; absent: another text.
std::optional<std::uint16_t> tcp_port(std::string_view text) {
  constexpr std::string_view kBegin = "tcp:";
  if (!text.starts_with(kBegin)) return std::nullopt;
  text.remove_prefix(kBegin.size());
  std::uint16_t port = 0;
  const char* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, port);
  if (read.ec != std::errc() || read.ptr != end) return std::nullopt;
  return port;
}

/// "serial:PATH" or "tcp:PORT".
Result<devices::NdiEmulatorLine> ndi_line(const std::string& text) {
  constexpr std::string_view kSerial = "serial:";
  if (text.empty()) return devices::NdiEmulatorLine{.tcp = true, .port = kNdiPort};
  if (text.starts_with(kSerial) && text.size() > kSerial.size()) {
    return devices::NdiEmulatorLine{.link = text.substr(kSerial.size())};
  }
  if (const auto port = tcp_port(text)) return devices::NdiEmulatorLine{.tcp = true, .port = *port};
  return line_error("serial:PATH or tcp:PORT", text);
}

/// Port of a USB/IP server: "tcp:PORT".
Result<std::uint16_t> usbip_port(const std::string& text) {
  if (text.empty()) return devices::kUsbipPort;
  if (const auto port = tcp_port(text)) return *port;
  return line_error("tcp:PORT", text);
}

/// Tracked bodies of all devices, in order, each once.
std::vector<std::string> bodies_of(const session::LiveSession& live) {
  std::vector<std::string> bodies;
  for (const session::LiveDevice& device : live.devices()) {
    for (const StreamInfo& stream : device.source->streams()) {
      if (stream.kind != StreamKind::kPoses) continue;
      if (std::ranges::count(bodies, stream.name) == 0) bodies.push_back(stream.name);
    }
  }
  return bodies;
}

Result<std::unique_ptr<devices::NdiSender>> start_ndi(const session::LiveSession& live,
                                                      const ServeOptions& options,
                                                      Console& console) {
  using enum devices::NdiEmulatedFault;
  auto line = ndi_line(options.line);
  if (!line) return line.error();
  const std::vector<std::string> bodies = bodies_of(live);
  auto sender = devices::NdiSender::start(
      bodies, *std::move(line),
      {.seed = options.seed,
       .rate = options.fault_rate,
       .kinds = {kBadCrc, kSilence, kSplit, kTruncated, kGarbage, kRepeat}});
  if (!sender) return sender;
  const devices::NdiEmulator& emulator = (*sender)->emulator();
  console.say("emulating an NDI tracker at " +
              (emulator.path().empty() ? "tcp:127.0.0.1:" + std::to_string(emulator.port())
                                       : "serial:" + emulator.path()));
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    console.say("  " + bodies[i] + ": port:" + std::to_string(i + 1));
  }
  return sender;
}

/// "can:INTERFACE".
Result<std::string> can_interface(const std::string& text) {
  constexpr std::string_view kBegin = "can:";
  if (text.empty()) return std::string("vcan0");
  if (text.starts_with(kBegin) && text.size() > kBegin.size()) return text.substr(kBegin.size());
  return line_error("can:INTERFACE", text);
}

/// An arm that carries the first tracked body.
Result<std::unique_ptr<devices::CanArmSender>> start_can_arm(const session::LiveSession& live,
                                                             const ServeOptions& options,
                                                             Console& console) {
  using enum devices::CanArmFault;
  const auto interface = can_interface(options.line);
  if (!interface) return interface.error();
  const std::vector<std::string> bodies = bodies_of(live);
  if (bodies.empty()) {
    return Error{ErrorCode::kUsage, "emulated arm: expected a tracked body, found none"};
  }
  auto sender = devices::CanArmSender::on_interface(
      *interface, bodies.front(),
      {.seed = options.seed,
       .rate = options.fault_rate,
       .kinds = {kMissing, kLate, kReboot, kEmergency, kForeign}});
  if (!sender) return Error{ErrorCode::kUnavailable, "--line: " + sender.error().message};
  console.say("emulating an encoder arm at can:" + *interface + " that carries " + bodies.front());
  return sender;
}

/// Gives a sample to the arm; the file of its kinematics is written when it is placed.
Result<void> send_by_arm(devices::CanArmSender& arm, const StreamInfo& stream, const Sample& sample,
                         const std::string& file, Console& console) {
  const auto placed = arm.send(stream, sample);
  if (!placed) return placed.error();
  if (!*placed) return {};
  const std::string text = session::arm_file_text(**placed);
  if (auto ok = io::write_file(file, std::string_view(text)); !ok) return ok;
  console.say("  its kinematics: " + file);
  return {};
}

void say_usbip(const std::string& device, std::uint16_t port, Console& console) {
  const std::string at = std::to_string(port);
  console.say("emulating " + device + " at usbip:127.0.0.1:" + at);
  console.say("  as a USB device of this machine, as root: usbip --tcp-port " + at +
              " attach --remote=127.0.0.1 --busid=1-1");
}

Result<std::unique_ptr<devices::IntersonSender>> start_interson(const ServeOptions& options,
                                                                Console& console) {
  using enum devices::IntersonFault;
  const auto port = usbip_port(options.line);
  if (!port) return port.error();
  auto sender =
      devices::IntersonSender::start({.seed = options.seed,
                                      .rate = options.fault_rate,
                                      .kinds = {kLostLine, kLostImage, kLineNumber, kCutLine,
                                                kEmpty, kStall, kOverflow, kProtocol}},
                                     "127.0.0.1", *port);
  if (!sender) return sender;
  say_usbip("an Interson SeeMore", (*sender)->emulator().server().port(), console);
  return sender;
}

/// The keys of a session file for the sector of an emulated probe.
void say_sector(const devices::EmulatedSector& sector, Console& console) {
  const devices::SectorShape& shape = sector.shape;
  char text[160];
  std::snprintf(text, sizeof text,
                "  radius_mm = %.4f, depth_mm = %.4f, angle_deg = %.4f, spacing_mm = %.4f",
                shape.radius_mm, shape.depth_mm, shape.angle_deg, shape.spacing_mm);
  console.say(text);
}

Result<std::unique_ptr<devices::PolhemusSender>> start_polhemus(const session::LiveSession& live,
                                                                const ServeOptions& options,
                                                                Console& console) {
  using enum devices::PolhemusFault;
  const auto port = usbip_port(options.line);
  if (!port) return port.error();
  const std::vector<std::string> bodies = bodies_of(live);
  auto sender = devices::PolhemusSender::start(
      bodies,
      {.seed = options.seed,
       .rate = options.fault_rate,
       .kinds = {kMagic, kCut, kSize, kFrameNumber, kNotFinite, kNoRotation, kError, kDistortion,
                 kLost, kRepeat, kSplit, kEmpty, kStall, kOverflow, kProtocol, kRestart}},
      "127.0.0.1", *port);
  if (!sender) return sender;
  say_usbip("a Polhemus Liberty", (*sender)->emulator().server().port(), console);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    console.say("  " + bodies[i] + ": station " + std::to_string(i + 1));
  }
  return sender;
}

/// Serves a session. Where a device is emulated (options.emulated), its poses or images come from
/// that.
Result<void> serve(const char* verb, const SessionConfig& config, const ServeOptions& options,
                   const std::optional<std::string>& json, Console& console) {
  constexpr auto kPoll = std::chrono::milliseconds(2);
  const MonotonicClock clock;
  auto server = devices::OpenIgtLinkServer::start(
      {.address = options.listen, .port = static_cast<std::uint16_t>(options.port)}, console);
  if (!server) return server.error();
  const devices::OpenIgtLinkSender sender(**server, config.source.tracker_frame,
                                          wall_clock_at_zero(clock));
  std::vector<std::shared_ptr<Source>> sources;
  std::unique_ptr<devices::NdiSender> ndi;
  std::unique_ptr<devices::CanArmSender> arm;
  std::unique_ptr<devices::PolhemusSender> polhemus;
  std::unique_ptr<devices::IntersonSender> interson;
  const auto tap = [&](std::size_t source, const Sample& sample) {
    const StreamInfo& stream = sources[source]->streams()[sample.stream];
    if (ndi != nullptr && stream.kind == StreamKind::kPoses) {
      ndi->send(stream, sample);
    } else if (arm != nullptr && stream.kind == StreamKind::kPoses && stream.name == arm->body()) {
      const auto sent = send_by_arm(*arm, stream, sample, options.arm, console);
      if (!sent) console.report(Severity::kError, "emulated arm", sent.error().message);
    } else if (polhemus != nullptr && stream.kind == StreamKind::kPoses) {
      polhemus->send(stream, sample);
    } else if (interson != nullptr && stream.kind == StreamKind::kImages) {
      if (const auto sector = interson->send(sample)) say_sector(*sector, console);
    } else {
      sender.send(stream, sample);
    }
  };
  auto live = session::LiveSession::open(config.source, clock, console, tap);
  if (!live) return live.error();
  for (const auto& device : live->devices()) sources.push_back(device.source);
  session::Session& session = live->session();
  if (options.emulated == "interson") {
    auto started = start_interson(options, console);
    if (!started) return started.error();
    interson = *std::move(started);
  }
  if (options.emulated == "polhemus") {
    auto started = start_polhemus(*live, options, console);
    if (!started) return started.error();
    polhemus = *std::move(started);
  }
  if (options.emulated == "can-arm") {
    auto started = start_can_arm(*live, options, console);
    if (!started) return started.error();
    arm = *std::move(started);
  }
  if (options.emulated == "ndi") {
    auto started = start_ndi(*live, options, console);
    if (!started) return started.error();
    ndi = *std::move(started);
  }
  console.say("serving at tcp:" + options.listen + ":" + std::to_string((*server)->port()));
  live->start();
  const double seconds = config.output.seconds;
  const Interrupt interrupt;
  while (!interrupt.asked() && !session.ended() &&
         !(seconds > 0 && to_seconds(clock.now()) >= seconds)) {
    session.take_in();
    (void)session.refresh();
    std::this_thread::sleep_for(kPoll);
  }
  session.finish();
  session.navigator().finish();
  io::Json report;
  report["verb"] = verb;
  report["version"] = SONDE_VERSION;
  report["seconds"] = to_seconds(clock.now());
  report["port"] = (*server)->port();
  if (ndi != nullptr) report["commands"] = ndi->emulator().commands();
  if (arm != nullptr) {
    report["syncs"] = arm->syncs();
    report["out_of_reach"] = arm->out_of_reach();
  }
  if (polhemus != nullptr) {
    report["commands"] = polhemus->emulator().tracker().commands().size();
    report["transfers"] = polhemus->emulator().server().transfers();
  }
  if (interson != nullptr) {
    report["transfers"] = interson->emulator().server().transfers();
  }
  report["clients"] = io::Json::array();
  for (const auto& client : (*server)->clients()) {
    report["clients"].push_back({{"version", client.version},
                                 {"messages", client.messages},
                                 {"superseded", client.superseded}});
  }
  report["devices"] = json_of(live->status());
  report["buttons"] = json_of(session.presses(), live->status());
  report["ledger_balanced"] = balanced(live->status());
  report["calibration"] = live->calibration_statement();
  report["reference"] = live->reference_statement();
  report["recording"] = nullptr;
  report["failures"] = session.failures();
  add_messages(report, console.entries());
  (*server)->stop();
  if (json) {
    if (auto written = write_json(report, *json); !written) return written;
  }
  if (session.failures().empty()) return {};
  return Error{ErrorCode::kUnavailable, session.failures().front()};
}

}  // namespace

Result<void> run_serve(const SessionConfig& config, const ServeOptions& options,
                       const std::optional<std::string>& json, Console& console) {
  return serve("serve", config, options, json, console);
}

Result<void> run_emulate(const SessionConfig& config, const ServeOptions& options,
                         const std::optional<std::string>& json, Console& console) {
  return serve("emulate", config, options, json, console);
}

}  // namespace nav::app
