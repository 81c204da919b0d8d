// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/devices.hpp"

#include <iostream>
#include <thread>

#include "app/interrupt.hpp"
#include "app/report.hpp"
#include "app/verbs/device_report.hpp"
#include "devices/inventory.hpp"
#include "session/live_session.hpp"
#include "sim/session/simulated_devices.hpp"

namespace nav::app {

namespace {

/// Shell command that starts a simulated device.
std::string start_of(const sim::SimulatedDevice& device) {
  return "sonde simulate --out FILE --" + device.kind + " " + device.name;
}

io::Json simulated(bool print) {
  io::Json list = io::Json::array();
  for (const auto& device : sim::simulated_devices()) {
    list.push_back({{"name", device.name},
                    {"kind", device.kind},
                    {"description", device.description},
                    {"start", start_of(device)}});
    if (!print) continue;
    std::cout << "simulated " << device.kind << ' ' << device.name << ": " << device.description
              << "\n  " << start_of(device) << '\n';
  }
  return list;
}

}  // namespace

Result<void> run_devices(const std::optional<std::string>& json, Console& console) {
  io::Json report;
  report["verb"] = "devices";
  report["usb"] = io::Json::array();
  report["can"] = io::Json::array();
  // An error on one bus does not hide the other.
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
      if (!json) std::cout << line << without_controls(device.product) << '\n';
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
  for (const auto kind :
       {devices::NodeKind::kSerial, devices::NodeKind::kVideo, devices::NodeKind::kInput}) {
    report[devices::to_string(kind)] = io::Json::array();
  }
  const auto nodes = devices::list_nodes();
  for (const auto& node : nodes) {
    const char* kind = devices::to_string(node.kind);
    report[kind].push_back(
        {{"path", node.path.string()}, {"name", node.name}, {"trouble", node.trouble}});
    if (json) continue;
    std::cout << kind << ' ' << node.path.string() << ": " << without_controls(node.name)
              << (node.trouble.empty() ? "" : " (" + node.trouble + ")") << '\n';
  }
  const bool none = report["usb"].empty() && report["can"].empty() && nodes.empty();
  if (!json && none) std::cout << "no devices on USB, CAN, serial ports, video or input\n";
  report["adapters"] = io::Json::array();
  for (const std::string& kind : session::device_kinds()) {
    // No device of any kind has been tried yet.
    report["adapters"].push_back({{"kind", kind}, {"verified_on_hardware", false}});
  }
  report["simulated"] = simulated(!json);
  add_messages(report, console.entries());
  if (json) return write_json(report, *json);
  return {};
}

Result<void> run_session_devices(const SessionConfig& config,
                                 const std::optional<std::string>& json, Console& console) {
  constexpr double kUsualSeconds = 5;
  constexpr auto kPoll = std::chrono::milliseconds(2);
  const bool records = !config.output.record.empty();
  // A recording goes on until it is ended.
  const double seconds =
      config.output.seconds > 0 || records ? config.output.seconds : kUsualSeconds;
  const MonotonicClock clock;
  std::unique_ptr<session::SessionRecorder> recorder;
  const auto tap = [&](std::size_t device, const Sample& sample) {
    recorder->record(device, sample);
  };
  auto live = session::LiveSession::open(
      config.source, clock, console,
      records ? std::function<void(std::size_t, const Sample&)>(tap) : nullptr,
      /*any_devices=*/true);
  if (!live) return live.error();
  if (records) {
    auto started = start_recording(config, clock, console);
    if (!started) return started.error();
    recorder = *std::move(started);
    if (auto ok = describe(config, *live, *recorder); !ok) return ok;
  }
  session::Session& session = live->session();
  console.begin(records ? "recording" : "listening");
  const Timestamp begun = clock.now();
  const auto elapsed_s = [&] { return to_seconds(clock.now() - begun); };
  live->start();
  const Interrupt interrupt;
  while (!interrupt.asked() && !session.ended() && !(seconds > 0 && elapsed_s() >= seconds)) {
    session.take_in();
    (void)session.refresh();
    if (seconds > 0) console.progress(elapsed_s() / seconds);
    std::this_thread::sleep_for(kPoll);
  }
  // Their states are those of the session, before it stops them.
  const auto before = live->status();
  session.finish();
  session.navigator().finish();
  const auto recorded = recorder ? recorder->finish() : Result<void>();
  console.end(std::to_string(before.size()) + " devices");
  auto devices = live->status();
  for (std::size_t i = 0; i < devices.size(); ++i) devices[i].health = before[i].health;
  io::Json report;
  report["verb"] = records ? "record" : "devices";
  report["version"] = SONDE_VERSION;
  report["seconds"] = elapsed_s();
  report["devices"] = json_of(devices);
  report["ledger_balanced"] = balanced(devices);
  report["recording"] = json_of(recorder.get());
  report["buttons"] = json_of(session.presses(), devices);
  report["calibration"] = live->calibration_statement();
  report["reference"] = live->reference_statement();
  report["failures"] = session.failures();
  add_messages(report, console.entries());
  if (json) {
    if (auto written = write_json(report, *json); !written) return written;
  } else {
    std::cout << text_of(devices);
  }
  if (records) {
    const auto account = recorder->account();
    console.say(account.path.string() + ": " + std::to_string(account.written) + " samples, " +
                std::to_string(account.lost()) + " lost");
  }
  NAV_CHECK(balanced(devices), "samples of a session are not accounted for");
  if (!recorded) return recorded;
  if (!session.failures().empty()) {
    return Error{ErrorCode::kUnavailable, session.failures().front()};
  }
  return check_all_deliver(devices);
}

}  // namespace nav::app
