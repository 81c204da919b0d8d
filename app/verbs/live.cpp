// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/live.hpp"

#include <algorithm>
#include <cstdio>
#include <thread>
#include <utility>

#include "app/interrupt.hpp"
#include "app/report.hpp"
#include "app/verbs/device_report.hpp"
#include "app/verbs/placed_view.hpp"
#include "app/verbs/show_in_window.hpp"
#include "session/driver.hpp"
#include "session/live_session.hpp"

namespace nav::app {
namespace {

constexpr const char* kLivePoseLogFile = "pose_log.csv";
constexpr const char* kLiveSessionFile = "session.toml";
constexpr const char* kLiveReportFile = "report.json";
constexpr const char* kLiveSeries = "live";
constexpr const char* kCaptureSeries = "capture";
constexpr const char* kDevicesEnded = "the devices have nothing more";
constexpr auto kPoll = std::chrono::milliseconds(2);

/// Times from the acquisition of an image to its reception, and from there on, ms.
struct Latencies {
  std::vector<double> received, paired, rendered, presented;
};

io::Json percentiles(std::vector<double> values) {
  if (values.empty()) return nullptr;
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
  };
  return {{"p50", at(0.5)}, {"p95", at(0.95)}, {"p99", at(0.99)}};
}

/// Kind of the session, which every image shows.
std::string banner_of(const std::vector<session::DeviceOptions>& devices) {
  switch (session::live_kind(devices)) {
    case session::LiveKind::kSimulated:
      return "SIMULATED DEVICE";
    case session::LiveKind::kRecording:
      return "RECORDING PLAYED AS A DEVICE";
    case session::LiveKind::kLive:
      break;
  }
  return "live";
}

class Live {
 public:
  Live(const SessionConfig& config, Console& console, const Clock& clock, OutputFolder out,
       session::LiveSession live, PlacedView::Parts parts, session::SessionRecorder* recorder)
      : config_(config),
        console_(console),
        clock_(clock),
        out_(std::move(out)),
        live_(std::move(live)),
        recorder_(recorder),
        view_(config, console, std::move(parts)),
        driver_(live_.session(), {}, listener()) {
    if (config_.plan) live_.session().navigator().set_plan(*config_.plan);
  }

  Result<void> run(const std::optional<std::string>& json) {
    if (const auto placement = view_.show_before_images()) {
      live_.session().navigator().set_placement(*placement);
    }
    begun_ = clock_.now();
    live_.start();
    console_.begin("live");
    const auto played = play();
    const auto health = live_.status();  // Before stop(): their states are those of the session.
    live_.session().finish();
    live_.session().navigator().finish();
    const auto recorded = recorder_ != nullptr ? recorder_->finish() : Result<void>();
    console_.end(std::to_string(shown_) + " images");
    if (!played) return played;
    if (const std::string outside = view_.outside(); !outside.empty()) {
      console_.report(Severity::kWarning, "placement", outside);
    }
    auto devices = live_.status();
    for (std::size_t i = 0; i < devices.size(); ++i) devices[i].health = health[i].health;
    if (auto written = write(report(devices), json); !written) return written;
    NAV_CHECK(balanced(devices), "samples of a live session are not accounted for");
    if (!recorded) return recorded;
    if (!live_.session().failures().empty()) {
      return Error{ErrorCode::kUnavailable, live_.session().failures().front()};
    }
    return check_all_deliver(devices);
  }

 private:
  session::Session::Listener listener() {
    session::Session::Listener hears([this](const tracking::PairedImage& paired) {
      if (!paired.tracked || failure_) return;
      const auto placed = view_.take(*paired.tracked, std::nullopt);
      if (!placed) {
        failure_ = placed.error();
      } else if (*placed) {
        live_.session().navigator().set_placement(**placed);
      }
    });
    hears.pressed = [this](const session::PressedButton& press) { obey(press); };
    return hears;
  }

  void obey(const session::PressedButton& press) {
    char when[32];
    std::snprintf(when, sizeof when, "%.3f s", to_seconds(press.acquired));
    switch (press.action) {
      case ButtonAction::kNone:
        return;
      case ButtonAction::kCapture:
        ++captures_wanted_;
        return;
      case ButtonAction::kFreeze:
        frozen_ = !frozen_;
        console_.say(std::string(frozen_ ? "frozen" : "live again") + " at " + when + " (" +
                     without_controls(press.button) + ")");
        return;
      case ButtonAction::kMark:
        console_.say(std::string("mark at ") + when + " (" + without_controls(press.button) + ")");
        if (recorder_ != nullptr || std::exchange(unrecorded_mark_, true)) return;
        console_.report(Severity::kWarning, "buttons",
                        "a mark was set, but nothing is recorded (--record): it stands in the "
                        "report only");
    }
  }

  /// Writes the images that a button asked for, once there is one.
  Result<void> write_captures() {
    for (; newest_ && captures_wanted_ > 0; --captures_wanted_) {
      char name[64];
      std::snprintf(name, sizeof name, "%s_%05d.png", kCaptureSeries, captures_);
      if (auto written = out_.write_image(name, *newest_); !written) return written;
      ++captures_;
      console_.say("captured " + (out_ / name).string());
    }
    return {};
  }

  [[nodiscard]] bool time_is_up() const {
    const double seconds = config_.output.seconds;
    return seconds > 0 && to_seconds(clock_.now() - begun_) >= seconds;
  }

  /// The newest epoch, if one is due.
  Result<std::optional<session::Epoch>> next() {
    auto epoch = driver_.next_at_pace(clock_.now(), false);
    if (failure_) return *failure_;
    return epoch;
  }

  Result<void> show(const session::Epoch& epoch) {
    const double paired_ms = age_ms(epoch);
    auto image = view_.presenter().present(epoch);
    if (!image) return image.error();
    const double rendered_ms = age_ms(epoch);
    view_.say_note();
    char name[64];
    std::snprintf(name, sizeof name, "%s_%05d.png", kLiveSeries, shown_++);
    if (auto written = out_.write_image(name, *image); !written) return written;
    newest_ = *std::move(image);
    if (epoch.frame_is_new) {
      const UltrasoundImage& shown = epoch.frame->frame;
      latencies_.received.push_back(1e3 * to_seconds(shown.received - shown.acquired));
      latencies_.paired.push_back(paired_ms);
      latencies_.rendered.push_back(rendered_ms);
      latencies_.presented.push_back(age_ms(epoch));
    }
    return view_.check_plane(epoch);  // Takes time once, so after the image.
  }

  /// Time since the epoch's image was received, ms.
  [[nodiscard]] double age_ms(const session::Epoch& epoch) const {
    return epoch.frame ? 1e3 * to_seconds(clock_.now() - epoch.frame->frame.received) : 0.0;
  }

  Result<void> play() {
    const Interrupt interrupt;
    while (!interrupt.asked() && !time_is_up()) {
      const auto epoch = next();
      if (!epoch) return epoch.error();
      if (auto written = write_captures(); !written) return written;
      if (*epoch && (!frozen_ || !newest_)) {
        if (auto shown = show(**epoch); !shown) return shown;
      } else if (driver_.over()) {
        return {};
      } else {
        std::this_thread::sleep_for(kPoll);
      }
      if (config_.output.frames > 0 && shown_ >= config_.output.frames) return {};
    }
    return {};
  }

  io::Json report(const std::vector<session::DeviceStatus>& devices) {
    io::Json json;
    json["verb"] = "live";
    json["version"] = SONDE_VERSION;
    json["seconds"] = to_seconds(clock_.now() - begun_);
    json["devices"] = json_of(devices);
    json["latency_ms"] = {{"received", percentiles(latencies_.received)},
                          {"paired", percentiles(latencies_.paired)},
                          {"rendered", percentiles(latencies_.rendered)},
                          {"presented", percentiles(latencies_.presented)}};
    json["ledger_balanced"] = balanced(devices);
    json["recording"] = json_of(recorder_);
    json["ct"] = config_.ct.path.string();
    json["calibration"] = live_.calibration_statement();
    json["reference"] = live_.reference_statement();
    if (const auto& placement = view_.placement()) {
      json["placement"] = {
          {"kind", placement->kind},
          {"statement", placement->statement},
          {"warnings", placement->warnings},
          {"ct_from_reference_mm", json_of(placement->placement.ct_from_reference.matrix())}};
    } else {
      json["placement"] = nullptr;
    }
    json["ledger"] = json_of(live_.session().navigator().ledger());
    json["rejected_poses"] = live_.session().navigator().rejected_poses();
    json["images"] = shown_;
    json["captures"] = captures_;
    json["buttons"] = json_of(live_.session().presses(), devices);
    json["engine"] = view_.engine_name();
    json["failures"] = live_.session().failures();
    add_messages(json, console_.entries());
    return json;
  }

  Result<void> write(const io::Json& report, const std::optional<std::string>& json) {
    if (json) {
      if (auto written = write_json(report, *json); !written) return written;
    }
    if (auto written = out_.write_text(kLivePoseLogFile, live_.session().log().text()); !written) {
      return written;
    }
    const auto session = to_toml(config_);
    if (!session) return session.error();
    if (auto written = out_.write_session(kLiveSessionFile, *session, console_); !written) {
      return written;
    }
    if (auto written = write_json(report, (out_ / kLiveReportFile).string()); !written) {
      return written;
    }
    console_.say("images and report: " + out_.path().string());
    return {};
  }

  const SessionConfig& config_;
  Console& console_;
  const Clock& clock_;
  OutputFolder out_;
  session::LiveSession live_;
  session::SessionRecorder* recorder_;  ///< Null: nothing is recorded.
  PlacedView view_;
  std::optional<Error> failure_;  ///< Failure of the listener.
  session::Driver driver_;
  Timestamp begun_{};
  int shown_ = 0;
  // Orders of buttons.
  bool frozen_ = false;           ///< The newest image stays; samples are taken in.
  bool unrecorded_mark_ = false;  ///< A mark was set without a recording, and that was said.
  int captures_wanted_ = 0;
  int captures_ = 0;                      ///< Written.
  std::optional<Image2d<Rgba8>> newest_;  ///< Image that is shown.
  Latencies latencies_;
};

/// The window writes no series of images.
Result<void> check_window(const SessionConfig& config) {
  if (config.output.folder.empty()) return {};
  return Error{ErrorCode::kUsage, "--window of live devices excludes --out " +
                                      config.output.folder.string() +
                                      ": it writes no images (--record keeps the data; replay its "
                                      "recording with --out for images)"};
}

}  // namespace

std::vector<std::string> live_outputs() {
  return {kLivePoseLogFile, kLiveSessionFile, kLiveReportFile};
}

Result<void> run_live(const SessionConfig& config, const std::optional<std::string>& json,
                      Console& console) {
  if (auto ok = require_path(config.ct.path, "--ct", "a CT"); !ok) return ok;
  if (config.output.window) {
    if (auto ok = check_window(config); !ok) return ok;
    return show_in_window(config, json);
  }
  if (auto ok = require_path(config.output.folder, "--out", "a folder"); !ok) return ok;
  // It is written at the end; what it cannot hold is said before the work.
  if (const auto session = to_toml(config); !session) return session.error();
  const MonotonicClock clock;
  std::unique_ptr<session::SessionRecorder> recorder;  // Started last.
  std::function<void(std::size_t, const Sample&)> tap;
  if (!config.output.record.empty()) {
    tap = [&](std::size_t device, const Sample& sample) { recorder->record(device, sample); };
  }
  auto live = session::LiveSession::open(config.source, clock, console, tap);
  if (!live) return live.error();
  auto parts = PlacedView::prepare(config, live->reference_frame(), console);
  if (!parts) return parts.error();
  parts->banner = banner_of(config.source.devices);
  auto out = OutputFolder::create(config.output.folder);
  if (!out) return out.error();
  if (auto ok = out->forget_earlier_run(
          {{kLivePoseLogFile, kLiveReportFile}, {kLiveSeries, kCaptureSeries}});
      !ok) {
    return ok;
  }
  if (!config.output.record.empty()) {
    auto started = start_recording(config, clock, console);
    if (!started) return started.error();
    recorder = *std::move(started);
    if (auto ok = describe(config, *live, *recorder); !ok) return ok;
  }
  Live run(config, console, clock, *std::move(out), *std::move(live), *std::move(parts),
           recorder.get());
  return run.run(json);
}

}  // namespace nav::app
