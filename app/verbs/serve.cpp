// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/serve.hpp"

#include <algorithm>
#include <charconv>
#include <chrono>
#include <thread>

#include "app/interrupt.hpp"
#include "app/report.hpp"
#include "app/verbs/device_report.hpp"
#include "devices/ndi/ndi_sender.hpp"
#include "devices/openigtlink/openigtlink_sender.hpp"
#include "session/live_session.hpp"

namespace nav::app {
namespace {

/// The wall clock when the session clock showed 0.
DeviceTime wall_clock_at_zero(const Clock& clock) {
  const auto wall = std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::system_clock::now().time_since_epoch());
  return DeviceTime(wall - clock.now().time_since_epoch());
}

/// "serial:PATH" or "tcp:PORT".
Result<devices::NdiEmulatorLine> ndi_line(const std::string& text) {
  const auto after = [&](std::string_view begin) -> std::optional<std::string> {
    if (!text.starts_with(begin)) return std::nullopt;
    return text.substr(begin.size());
  };
  if (const auto path = after("serial:"); path && !path->empty()) {
    return devices::NdiEmulatorLine{.link = *path};
  }
  if (const auto port = after("tcp:")) {
    devices::NdiEmulatorLine line{.tcp = true};
    const char* const end = port->data() + port->size();
    const auto read = std::from_chars(port->data(), end, line.port);
    if (read.ec == std::errc() && read.ptr == end) return line;
  }
  return Error{ErrorCode::kUsage, "--line: expected serial:PATH or tcp:PORT, found '" + text + "'"};
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

/// Serves a session; \p emulates: its poses come from an emulated tracker.
Result<void> serve(const char* verb, bool emulates, const SessionConfig& config,
                   const ServeOptions& options, const std::optional<std::string>& json,
                   Console& console) {
  constexpr auto kPoll = std::chrono::milliseconds(2);
  const MonotonicClock clock;
  auto server = devices::OpenIgtLinkServer::start(
      {.address = options.listen, .port = static_cast<std::uint16_t>(options.port)}, console);
  if (!server) return server.error();
  const devices::OpenIgtLinkSender sender(**server, config.source.tracker_frame,
                                          wall_clock_at_zero(clock));
  std::vector<std::shared_ptr<Source>> sources;
  std::unique_ptr<devices::NdiSender> ndi;
  const auto tap = [&](std::size_t source, const Sample& sample) {
    const StreamInfo& stream = sources[source]->streams()[sample.stream];
    if (ndi != nullptr && stream.kind == StreamKind::kPoses) {
      ndi->send(stream, sample);
    } else {
      sender.send(stream, sample);
    }
  };
  auto live = session::LiveSession::open(config.source, clock, console, tap);
  if (!live) return live.error();
  for (const auto& device : live->devices()) sources.push_back(device.source);
  session::Session& session = live->session();
  if (emulates) {
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
  report["clients"] = io::Json::array();
  for (const auto& client : (*server)->clients()) {
    report["clients"].push_back({{"version", client.version},
                                 {"messages", client.messages},
                                 {"superseded", client.superseded}});
  }
  report["devices"] = json_of(live->status());
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
  return serve("serve", false, config, options, json, console);
}

Result<void> run_emulate(const SessionConfig& config, const ServeOptions& options,
                         const std::optional<std::string>& json, Console& console) {
  return serve("emulate", options.emulated == "ndi", config, options, json, console);
}

}  // namespace nav::app
