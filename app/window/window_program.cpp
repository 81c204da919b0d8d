// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/window_program.hpp"

#include <QGuiApplication>
#include <QLibraryInfo>
#include <algorithm>
#include <utility>

#include "app/interrupt.hpp"
#include "app/output_folder.hpp"
#include "app/report.hpp"
#include "app/window/display_check.hpp"
#include "app/window/key_filter.hpp"
#include "app/window/main_window.hpp"
#include "app/window/script_player.hpp"
#include "app/window/session_keeper.hpp"
#include "app/window/timed_application.hpp"
#include "app/window/window_controls.hpp"
#include "io/atomic_file.hpp"
#include "session/played_recording.hpp"

namespace nav::app {
namespace {

constexpr std::size_t kLargestScript = 1 << 24;
constexpr int kInterruptMs = 100;

/// 3D ultrasound is shown alone.
bool shows_volume(const Settings& settings) {
  return !settings.window.phantom.empty() || !settings.config.predicates.volume.empty();
}

Result<SessionConfig> config_of(const Settings& settings) {
  if (settings.session.empty()) {
    SessionConfig config = settings.config;
    config.source.kind = SessionConfig::SourceKind::kSimulated;
    config.source.seed = settings.window.seed;
    config.appearance = {.preset = "ct-liver", .nodes = {}};
    config.view = settings.demo.view;
    if (!shows_volume(settings)) return config;
    config.source.kind = SessionConfig::SourceKind::kRecording;
    config.predicates.alone = true;
    if (!settings.window.phantom.empty()) config.predicates.phantom = settings.window.phantom;
    return config;
  }
  auto config = read_session_config(settings.session);
  if (!config) return config.error();
  if (auto ok = validate(*config); !ok) return ok.error();
  return config;
}

/// The file that the session is saved as. One in memory (sonde live --window) is none.
std::filesystem::path file_of(const Settings& settings) {
  return settings.session.string().starts_with("/proc/") ? std::filesystem::path()
                                                         : settings.session;
}

Result<std::vector<ScriptLine>> script_of(const WindowOptions& options) {
  if (options.script.empty()) return std::vector<ScriptLine>();
  const auto text = io::read_file(options.script, kLargestScript);
  if (!text) return text.error();
  auto lines = parse_script(*text);
  if (!lines) {
    return Error{ErrorCode::kRefused, options.script.string() + ": " + lines.error().message};
  }
  return lines;
}

/// Names a recording that cannot be made before the window opens.
Result<void> check_record(const std::filesystem::path& record, const SessionConfig& config) {
  if (record.empty()) return {};
  if (config.source.kind != SessionConfig::SourceKind::kLive) {
    return Error{ErrorCode::kUsage,
                 "--record: expected a session of live devices, found a recording or a simulated "
                 "procedure"};
  }
  if (!session::is_device_recording(record)) {
    return Error{ErrorCode::kUsage,
                 record.string() + ": expected the name of a recording that ends with .mcap"};
  }
  std::error_code failed;
  if (!std::filesystem::exists(record, failed)) return {};
  return Error{ErrorCode::kUsage,
               "--record: expected a file that does not exist, found " + record.string()};
}

/// Time since the session has begun or failed; absent: it is loading.
class SessionTime {
 public:
  std::optional<double> seconds(const SessionNews& news, Timestamp now) {
    if (!begun_ && news.stage != SessionNews::Stage::kLoading) begun_ = now;
    if (!begun_) return std::nullopt;
    return to_seconds(now - *begun_);
  }

 private:
  std::optional<Timestamp> begun_;
};

}  // namespace

Result<void> run_window(const Settings& settings, int& argc, char** argv, Console& console) {
  const WindowOptions& options = settings.window;
  auto config = config_of(settings);
  if (!config) return config.error();
  config->output.record = settings.config.output.record;
  config->output.seconds = settings.config.output.seconds;
  if (auto ok = check_record(config->output.record, *config); !ok) return ok;
  auto lines = script_of(options);
  if (!lines) return lines.error();
  if (!options.shots.empty()) {
    if (auto folder = OutputFolder::create(options.shots); !folder) return folder.error();
  }
  if (auto display = check_display(); !display) return display;

  // A locale's decimal comma would change numbers that are read and written.
  QLocale::setDefault(QLocale::c());
  const MonotonicClock clock;
  WindowReport report;
  TimedApplication application(argc, argv);
  application.measure_into(&report);
  const bool has_session = !settings.session.empty() || options.simulated || shows_volume(settings);
  // A script shows the same on every account, and changes nothing there.
  const std::filesystem::path users_folder =
      options.script.empty() ? settings_folder() : std::filesystem::path();
  const auto found = read_user_settings(users_folder);
  if (!found) console.report(Severity::kWarning, "window.settings", found.error().message);
  const UserSettings user = found ? *found : UserSettings();
  MainWindow window({.loop = {.config = *config,
                              .engine = options.engine,
                              .loop = !options.once,
                              .has_session = has_session},
                     .title = has_session ? session_title(*config) : QStringLiteral("Sonde"),
                     .snapshot_folder = QString::fromStdString(options.shots.string()),
                     .session_file = file_of(settings),
                     .state_folder = state_folder(),
                     .user = user,
                     .settings_folder = users_folder},
                    clock, console, report);
  KeyFilter filter(window);
  application.installEventFilter(&filter);
  std::optional<Error> failure;
  std::optional<ScriptPlayer> player;
  if (!options.script.empty()) {
    player.emplace(std::move(*lines),
                   ScriptPlayer::Options{QString::fromStdString(options.shots.string())}, window,
                   clock, report, [&](std::optional<Error> error) {
                     failure = std::move(error);
                     QCoreApplication::quit();
                   });
  }
  const Interrupt interrupt;
  QTimer look;
  SessionTime session_time;
  bool time_is_up = false;
  const double most_seconds = config->output.seconds;
  QObject::connect(&look, &QTimer::timeout, &window, [&] {
    const auto seconds = session_time.seconds(window.loop().news(), clock.now());
    time_is_up = most_seconds > 0 && seconds && *seconds >= most_seconds;
    if (interrupt.asked() || time_is_up) QCoreApplication::quit();
  });
  look.start(kInterruptMs);
  window.show();
  window.start();
  QCoreApplication::exec();
  // A script and a time limit are an end that was asked for; unsaved changes of a user wait for the
  // next window.
  window.keep_recovery(options.script.empty() && !time_is_up);
  application.measure_into(nullptr);
  io::Json json = report.json();
  json["controls"] = controls_of(window);
  window.stop();
  json["toolkit"] = std::string("Qt ") + qVersion();
  json["platform"] = QGuiApplication::platformName().toStdString();
  json["device_pixel_ratio"] = window.devicePixelRatioF();
  window.loop().complete(json);
  add_messages(json, console.entries());
  console.say_suppressed();
  if (!settings.json.empty()) {
    if (auto written = write_json(json, settings.json); !written) return written;
  }
  if (failure) {
    return Error{ErrorCode::kRefused, options.script.string() + ": " + failure->message};
  }
  return window.loop().recorded();
}

}  // namespace nav::app
