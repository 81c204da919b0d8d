// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/device_report.hpp"

#include <algorithm>
#include <cstdio>

#include "app/console.hpp"
#include "app/report.hpp"
#include "nav/cause_words.hpp"
#include "session/played_recording.hpp"
#include "session/recorded_setup.hpp"

namespace nav::app {
namespace {

constexpr double kMs = 1e3;

/// Null: the device gives no time.
io::Json json_of_clock(const tracking::ClockModel* clock) {
  if (clock == nullptr || clock->state() == tracking::ClockState::kUnknown) return nullptr;
  return {{"kind", "device"},
          {"offset_ms", kMs * to_seconds(clock->offset())},
          {"skew_ppm", json_number(clock->skew_ppm())},
          {"skew_ci95_ppm", json_number(clock->skew_ci95_ppm())},
          {"residual_ms_p95", kMs * to_seconds(clock->residual_p95())},
          {"steps", clock->steps()}};
}

io::Json json_of_stream(const session::DeviceStatus::Stream& stream) {
  const auto& [info, ledger, timing] = stream.account;
  io::Json json;
  json["name"] = info.name;
  json["type"] = to_string(info.kind);
  json["role"] = info.kind == StreamKind::kPoses ? io::Json(to_string(info.role)) : io::Json();
  if (info.kind == StreamKind::kButtons) json["action"] = to_string(info.action);
  json["received"] = ledger.received();
  json["delivered"] = ledger.delivered();
  json["superseded"] = ledger.superseded();
  json["rejected"] = io::Json(ledger.rejected());
  json["dropped"] = io::Json(ledger.dropped());
  json["waiting"] = ledger.waiting();
  json["missing_by_counter"] = timing.missing;
  json["rate_hz"] = timing.rate_hz;
  json["period_ms"] = {{"p50", timing.period_p50_ms},
                       {"p95", timing.period_p95_ms},
                       {"p99", timing.period_p99_ms},
                       {"max", timing.period_max_ms}};
  return json;
}

}  // namespace

io::Json json_of(const std::vector<session::DeviceStatus>& devices) {
  io::Json list = io::Json::array();
  for (const auto& device : devices) {
    io::Json one;
    one["id"] = device.id;
    one["kind"] = device.kind;
    one["address"] = device.address;
    one["state"] = to_string(device.health.state);
    one["cause"] = device.health.cause;
    one["firmware"] = device.health.firmware;
    one["serial"] = device.health.serial;
    one["reconnects"] = device.health.reconnects;
    one["bytes"] = device.health.bytes;
    one["bad_messages"] = io::Json(device.health.bad_messages);
    one["repeats"] = device.health.repeats;
    one["streams"] = io::Json::array();
    one["clock"] = nullptr;
    for (const auto& stream : device.streams) {
      one["streams"].push_back(json_of_stream(stream));
      // One clock stamps all streams of a device; the first that knows it speaks for it.
      if (one["clock"].is_null()) one["clock"] = json_of_clock(stream.clock);
    }
    list.push_back(std::move(one));
  }
  return list;
}

io::Json json_of(const std::vector<session::PressedButton>& presses,
                 const std::vector<session::DeviceStatus>& devices) {
  io::Json list = io::Json::array();
  for (const session::PressedButton& press : presses) {
    list.push_back({{"time_s", to_seconds(press.acquired)},
                    {"device", devices.at(press.source).id},
                    {"button", press.button},
                    {"action", to_string(press.action)}});
  }
  return list;
}

io::Json json_of(const session::SessionRecorder* recorder) {
  if (recorder == nullptr) return nullptr;
  const session::RecordingAccount account = recorder->account();
  return {{"path", account.path.string()}, {"bytes", account.bytes},
          {"chunks", account.chunks},      {"received", account.received},
          {"written", account.written},    {"lost", account.lost()},
          {"dropped", account.dropped},    {"fsync_ms_p99", account.sync_p99_ms},
          {"stopped", account.stopped}};
}

Result<std::unique_ptr<session::SessionRecorder>> start_recording(const SessionConfig& config,
                                                                  const Clock& clock,
                                                                  Diagnostics& diagnostics) {
  session::SessionRecorder::Options options;
  options.path = config.output.record;
  if (!session::is_device_recording(options.path)) {
    return Error{ErrorCode::kUsage,
                 options.path.string() + ": expected the name of a recording that ends with .mcap"};
  }
  const std::string file = options.path.filename().string();
  const bool beside_images =
      !config.output.folder.empty() && options.path.parent_path() == config.output.folder;
  if ((file.starts_with("live_") || file.starts_with("capture_")) && beside_images) {
    return Error{ErrorCode::kUsage,
                 options.path.string() + ": expected another name than those of the images"};
  }
  options.facts = {{"version", SONDE_VERSION}};
  const auto session = to_toml(config);
  if (!session) return session.error();
  options.facts["session"] = *session;
  return session::SessionRecorder::start(options, clock, diagnostics);
}

Result<void> describe(const SessionConfig& config, const session::LiveSession& live,
                      session::SessionRecorder& recorder) {
  if (auto ok = recorder.add_devices(live.devices()); !ok) return ok;
  auto facts = session::facts_of(live.setup());
  facts["calibration"] = live.calibration_statement();
  facts["reference_frame"] = live.reference_frame();
  facts["reference"] = live.reference_statement();
  if (auto ok = recorder.add_facts(session::kSetupMetadata, facts); !ok) return ok;
  if (config.source.plus_config.empty()) return {};
  return recorder.attach(config.source.plus_config);
}

bool balanced(const std::vector<session::DeviceStatus>& devices) {
  return std::ranges::all_of(devices, [](const auto& device) {
    return std::ranges::all_of(device.streams,
                               [](const auto& s) { return s.account.ledger.balanced(); });
  });
}

std::string text_of(const std::vector<session::DeviceStatus>& devices) {
  std::string text;
  for (const auto& device : devices) {
    text += device.id + " (" + device.kind +
            (device.address.empty() ? "" : ", " + without_controls(device.address)) +
            "): " + to_string(device.health.state);
    if (!device.health.cause.empty()) {
      text += ", " + without_controls(words_of_cause(device.health.cause));
    }
    text += '\n';
    for (const auto& stream : device.streams) {
      const auto& [info, ledger, timing] = stream.account;
      if (info.kind == StreamKind::kButtons) {
        text += "  button " + without_controls(info.name) + " (" + to_string(info.action) + "): " +
                (ledger.received() == 0
                     ? "not pressed"
                     : "went down or came up " + std::to_string(ledger.received()) + " times") +
                '\n';
        continue;
      }
      char line[160];
      std::snprintf(line, sizeof line,
                    ": %llu samples, %.1f per second, periods of %.1f ms (p50) to %.1f ms (p99)\n",
                    static_cast<unsigned long long>(ledger.received()), timing.rate_hz,
                    timing.period_p50_ms, timing.period_p99_ms);
      text += "  " + std::string(to_string(info.kind)) + " " + without_controls(info.name) +
              (ledger.received() == 0 ? ": nothing came\n" : line);
      for (const auto& [cause, count] : ledger.rejected()) {
        text += "    rejected: " + std::to_string(count) + ", " + words_of_cause(cause) + '\n';
      }
    }
  }
  return text;
}

Result<void> check_all_deliver(const std::vector<session::DeviceStatus>& devices) {
  for (const auto& device : devices) {
    for (const auto& stream : device.streams) {
      if (stream.account.ledger.received() > 0) continue;
      // A button may stay up all the time; its device has to be there.
      const bool button = stream.account.info.kind == StreamKind::kButtons;
      if (button && device.health.state != SourceState::kWaiting) continue;
      // A recording has places for bodies that it does not track.
      const ToolRole role = stream.account.info.role;
      const bool place = role == ToolRole::kNeedle || role == ToolRole::kReference;
      if (device.kind == "recording" && place) continue;
      if (button) {
        return Error{ErrorCode::kUnavailable,
                     device.id + ": expected the device of button " + stream.account.info.name +
                         ", found it missing (" + words_of_cause(device.health.cause) + ")"};
      }
      return Error{
          ErrorCode::kUnavailable,
          device.id + ": expected samples of " + stream.account.info.name + ", found none" +
              (device.health.cause.empty() ? ""
                                           : " (" + words_of_cause(device.health.cause) + ")")};
    }
  }
  return {};
}

}  // namespace nav::app
