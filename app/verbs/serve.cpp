// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/serve.hpp"

#include <chrono>
#include <thread>

#include "app/interrupt.hpp"
#include "app/report.hpp"
#include "app/verbs/device_report.hpp"
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

}  // namespace

Result<void> run_serve(const SessionConfig& config, const ServeOptions& options,
                       const std::optional<std::string>& json, Console& console) {
  constexpr auto kPoll = std::chrono::milliseconds(2);
  const MonotonicClock clock;
  auto server = devices::OpenIgtLinkServer::start(
      {.address = options.listen, .port = static_cast<std::uint16_t>(options.port)}, console);
  if (!server) return server.error();
  const devices::OpenIgtLinkSender sender(**server, config.source.tracker_frame,
                                          wall_clock_at_zero(clock));
  std::vector<std::shared_ptr<Source>> sources;
  const auto tap = [&](std::size_t source, const Sample& sample) {
    sender.send(sources[source]->streams()[sample.stream], sample);
  };
  auto live = session::LiveSession::open(config.source, clock, console, tap);
  if (!live) return live.error();
  for (const auto& device : live->devices()) sources.push_back(device.source);
  session::Session& session = live->session();
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
  report["verb"] = "serve";
  report["version"] = SONDE_VERSION;
  report["seconds"] = to_seconds(clock.now());
  report["port"] = (*server)->port();
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
  report["diagnostics"] = json_of(console.entries());
  (*server)->stop();
  if (json) {
    if (auto written = write_json(report, *json); !written) return written;
  }
  if (session.failures().empty()) return {};
  return Error{ErrorCode::kUnavailable, session.failures().front()};
}

}  // namespace nav::app
