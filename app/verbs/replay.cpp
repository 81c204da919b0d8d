// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/interrupt.hpp"
#include "app/report.hpp"
#include "app/verbs/placed_view.hpp"
#include "app/verbs/show_in_window.hpp"
#include "io/image_output.hpp"
#include "nav/cause_words.hpp"
#include "session/driver.hpp"
#include "session/recorded_session.hpp"

namespace nav::app {
namespace {

constexpr std::size_t kMostAnimated = 60;
constexpr int kReplayAnimationMs = 150;

constexpr const char* kPoseLogFile = "pose_log.csv";
constexpr const char* kFollowingFile = "following.csv";
constexpr const char* kSessionFile = "session.toml";
constexpr const char* kReportFile = "report.json";
constexpr const char* kPageFile = "report.html";
constexpr const char* kAnimationFile = "replay.webp";
constexpr const char* kImageSeries = "replay";

/// Null: images are drawn whole.
io::Json sector_json(const std::optional<SectorOutline>& sector) {
  if (!sector) return nullptr;
  return {{"apex_mm", {sector->apex_mm.x(), sector->apex_mm.y()}},
          {"radius_min_mm", sector->radius_min_mm},
          {"radius_max_mm", sector->radius_max_mm},
          {"half_angle_rad", sector->half_angle_rad}};
}

/// Null: nothing is drawn by predicates.
io::Json legend_json(const std::vector<LegendEntry>& legend) {
  if (legend.empty()) return nullptr;
  io::Json json = io::Json::array();
  for (const LegendEntry& entry : legend) {
    json.push_back({{"name", entry.name}, {"importance", entry.importance}});
  }
  return json;
}

class Replay {
 public:
  /// \p out: folder of images and report.
  Replay(const SessionConfig& config, Console& console, OutputFolder out,
         session::RecordedSession session, PlacedView::Parts parts)
      : config_(config),
        console_(console),
        out_(std::move(out)),
        session_(std::move(session)),
        view_(config, console, std::move(parts)),
        driver_(session_.session(), {std::nullopt, stride()}, listener()) {
    if (config_.plan) session_.navigator().set_plan(*config_.plan);
  }

  Result<void> run(const std::optional<std::string>& json) {
    console_.begin("replay");
    if (auto played = play(); !played) return with_outputs(played.error());
    console_.end(std::to_string(shown_) + " images");
    session_.navigator().finish();
    if (auto bad = session::bad_frames_finding(session_)) {
      console_.report("recording", *std::move(bad));
    }
    if (!view_.placement()) return session::nothing_paired(session_);
    if (const std::string outside = view_.outside(); !outside.empty()) {
      console_.report(Severity::kWarning, "placement", outside);
    }
    if (!animation_.empty()) {
      const auto file = out_ / kAnimationFile;
      if (auto written = io::write_animation(animation_, kReplayAnimationMs, file); !written) {
        return written;
      }
      out_.list(kAnimationFile);
    }
    const io::Json report = this->report();
    if (json) {
      if (auto written = write_json(report, *json); !written) return written;
    }
    if (auto written = write_folder(report); !written) return written;
    console_.say("images and report: " + (out_ / kPageFile).string());
    return {};
  }

 private:
  /// Every n-th paired image is shown if fewer are wanted than a survey has found.
  [[nodiscard]] std::int64_t stride() const {
    const std::int64_t most = config_.output.frames;
    if (most <= 0 || !view_.survey()) return 1;
    const auto paired = static_cast<std::int64_t>(view_.survey()->paired);
    return std::max<std::int64_t>(1, (paired + most - 1) / most);
  }

  session::Session::Listener listener() {
    return [this](const tracking::PairedImage& paired) {
      console_.progress(static_cast<double>(session_.frames_read()) /
                        static_cast<double>(std::max<std::int64_t>(session_.total_images(), 1)));
      if (!paired.tracked || failure_) return;
      const TrackedImage& image = *paired.tracked;
      const auto placed = view_.take(image, session::recording_read(session_, image.frame));
      if (!placed) {
        failure_ = placed.error();
      } else if (*placed) {
        session_.set_placement(**placed);
      }
    };
  }

  Result<void> show(const session::Epoch& epoch) {
    if (auto ok = view_.check_ultrasound(epoch); !ok) return ok;
    if (auto ok = view_.check_plane(epoch); !ok) return ok;
    auto image = view_.presenter().present(epoch);
    if (!image) return image.error();
    view_.say_note();
    char name[64];
    std::snprintf(name, sizeof name, "%s_%05d.png", kImageSeries, shown_++);
    if (auto written = out_.write_image(name, *image); !written) return written;
    if (animation_.size() < kMostAnimated) animation_.push_back(std::move(*image));
    return {};
  }

  /// The error that ended the replay, and what is complete in spite of it.
  [[nodiscard]] Error with_outputs(const Error& error) const {
    return {error.code, error.message + "; complete in " + out_.path().string() + ": " +
                            std::to_string(out_.files().size()) +
                            " images; the report was not written"};
  }

  Result<void> play() {
    const Interrupt interrupt;
    for (;;) {
      if (interrupt.asked()) {
        return Error{ErrorCode::kCancelled, "replay: stopped by " + interrupt.by()};
      }
      const auto epoch = driver_.next();
      if (!epoch) return epoch.error();
      if (failure_) return *failure_;
      if (!*epoch) return {};
      if (auto shown = show(**epoch); !shown) return shown;
      if (!view_.survey() && config_.output.frames > 0 && shown_ >= config_.output.frames) {
        session_.session().finish();
        return {};
      }
    }
  }

  /// report.json.
  [[nodiscard]] io::Json report();
  Result<void> write_folder(const io::Json& report);

  const SessionConfig& config_;
  Console& console_;
  OutputFolder out_;
  session::RecordedSession session_;
  PlacedView view_;
  std::optional<Error> failure_;  ///< Failure of the listener.
  session::Driver driver_;
  int shown_ = 0;
  std::vector<Image2d<Rgba8>> animation_;
};

io::Json Replay::report() {
  const auto& ledger = session_.navigator().ledger();
  std::vector<std::string> warnings = view_.placement()->warnings;
  const std::string outside = view_.outside();
  if (!outside.empty()) warnings.push_back(outside);
  io::Json json;
  json["verb"] = "replay";
  json["version"] = SONDE_VERSION;
  json["simulated"] = false;
  json["sweep"] = config_.source.recording.string();
  json["ct"] = config_.ct.path.string();
  json["ultrasound_volume"] = config_.predicates.volume.string();
  json["predicates"] = legend_json(view_.presenter().legend());
  json["engine"] = view_.presenter().engine().name();
  json["device"] = view_.presenter().engine().device();
  json["placement"] = {
      {"kind", view_.placement()->kind},
      {"statement", view_.placement()->statement},
      {"warnings", warnings},
      {"ct_from_reference_mm", json_of(view_.placement()->placement.ct_from_reference.matrix())}};
  json["following"] = view_.follower() ? json_of(view_.follower()->summary()) : io::Json();
  json["reference"] = session_.reference_statement();
  json["transforms"] = session_.description();
  json["sector"] = sector_json(session_.outline());
  json["ledger"] = json_of(ledger);
  json["rejected_poses"] = session_.navigator().rejected_poses();
  say_sampling(view_.presenter().step(), config_.output.rms_error, console_);
  json["sampling"] = json_of(view_.presenter().step());
  json["ct_window"] = json_of(view_.presenter().window());
  json["grey_window"] = json_of(view_.presenter().grey());
  json["views_cast"] = view_.presenter().views_cast();
  json["cast_seconds"] = view_.presenter().cast_seconds();
  json["frames"] = out_.files();
  json["pose_log_sha256"] = io::sha256_hex(session_.log().text());
  json["image_sha256"] = out_.image_digest();
  add_messages(json, console_.entries());
  return json;
}

Result<void> Replay::write_folder(const io::Json& report) {
  OutputFolder& out = out_;
  const auto& ledger = session_.navigator().ledger();
  if (auto written = out.write_text(kPoseLogFile, session_.log().text()); !written) {
    return written;
  }
  if (view_.follower()) {
    if (auto written = out.write_text(kFollowingFile, view_.follower()->text()); !written) {
      return written;
    }
  }
  const auto session = to_toml(config_);
  if (!session) return session.error();
  if (auto written = out.write_session(kSessionFile, *session, console_); !written) return written;
  if (auto written = write_json(report, (out / kReportFile).string()); !written) return written;

  HtmlReport html;
  html.title = "Sonde: replay of " + config_.source.recording.filename().string();
  const std::string outside = view_.outside();
  html.warning = view_.placement()->kind != "registered" || !view_.placement()->warnings.empty() ||
                 !outside.empty();
  html.summary =
      view_.placement()->statement + " Patient's frame: " + session_.reference_statement() + ".";
  for (const std::string& warning : view_.placement()->warnings) {
    html.summary += " Accepted with a warning: " + warning + ".";
  }
  if (!outside.empty()) html.summary += " Warning: " + outside + ".";
  const auto& files = out.files();
  if (!animation_.empty()) {
    html.images.emplace_back(kAnimationFile,
                             "The replay. Left: the ultrasound plane inside the CT. Right: the "
                             "ultrasound image and the CT along the same plane.");
  }
  const std::size_t count = animation_.empty() ? files.size() : files.size() - 1;
  for (std::size_t i = 0; i < count; i += std::max<std::size_t>(1, count / 4)) {
    html.images.emplace_back(files[i], files[i]);
  }
  html.tables.push_back({"Ultrasound images",
                         {{"received", std::to_string(ledger.received())},
                          {"shown", std::to_string(ledger.delivered())},
                          {"superseded", std::to_string(ledger.superseded())},
                          {"rejected", std::to_string(ledger.rejected_total())}}});
  for (const auto& [cause, number] : ledger.rejected()) {
    html.tables.back().second.emplace_back("rejected: " + words_of_cause(cause),
                                           std::to_string(number));
  }
  if (!view_.presenter().legend().empty()) {
    html.tables.push_back({"Importance of predicates", {}});
    for (const LegendEntry& entry : view_.presenter().legend()) {
      html.tables.back().second.emplace_back(entry.name, entry.importance_words());
    }
  }
  if (view_.follower())
    html.tables.push_back({"Following the tissue", rows_of(view_.follower()->summary())});
  html.tables.push_back({"Input",
                         {{"sweep", config_.source.recording.string()},
                          {"calibration", config_.source.plus_config.string()},
                          {"transforms", session_.description()},
                          {"CT", config_.ct.path.string()},
                          {"ultrasound volume", config_.predicates.volume.string()}}});
  html.tables.push_back(
      {"Rendering",
       {{"engine", view_.presenter().engine().name() + ", " + view_.presenter().engine().device()},
        {"mean time per view", quantity(1e3 * view_.presenter().cast_seconds() /
                                            std::max(view_.presenter().views_cast(), 1),
                                        1, "ms")}}});
  html.tables.push_back({"Reported", {}});
  for (const DiagnosticEntry& entry : console_.entries()) {
    html.tables.back().second.emplace_back(
        std::string(to_string(entry.severity)) + ", " + std::to_string(entry.count) + " times",
        entry.source + ": " + entry.message);
  }
  return out.write_text(kPageFile, to_html(html));
}

}  // namespace

std::vector<std::string> replay_outputs() {
  return {kPoseLogFile, kFollowingFile, kSessionFile, kReportFile, kPageFile, kAnimationFile};
}

Result<void> run_replay(const SessionConfig& config, const std::optional<std::string>& json,
                        Console& console) {
  if (auto ok = require_path(config.source.recording, "sweep", "a recording"); !ok) return ok;
  if (auto ok = require_path(config.ct.path, "--ct", "a CT"); !ok) return ok;
  if (config.output.window && config.output.folder.empty()) return show_in_window(config, json);
  if (auto ok = require_path(config.output.folder, "--out", "a folder"); !ok) return ok;
  // It is written at the end; what it cannot hold is said before the work.
  if (const auto session = to_toml(config); !session) return session.error();
  // Not the session file, which may be the one that this run was started by.
  const RunFiles files{{kPoseLogFile, kFollowingFile, kReportFile, kPageFile, kAnimationFile},
                       {kImageSeries}};
  auto out = OutputFolder::open(config.output.folder, files);
  if (!out) return out.error();
  auto session = session::RecordedSession::open(config.source, console);
  if (!session) return session.error();
  auto parts = PlacedView::prepare(config, session->reference_frame(), console);
  if (!parts) return parts.error();
  parts->banner = "recording";
  parts->needle_expected = session->has_needle();
  // A pipe can be read only once.
  const bool pipe = std::filesystem::is_fifo(config.source.recording);
  if (config.source.survey && pipe) {
    console.report(Severity::kInfo, "recording",
                   config.source.recording.string() +
                       " is a pipe: the first image decides camera and grey window");
  }
  if (config.source.survey && !pipe) {
    console.begin("surveying the sweep");
    auto surveyed = session::survey(*session, config.source.skip_bad_frames);
    if (!surveyed) return surveyed.error();
    console.end(std::to_string(surveyed->paired) + " images with a pose");
    if (!surveyed->warning.empty()) {
      console.report(Severity::kWarning, "recording", surveyed->warning);
    }
    parts->survey = *std::move(surveyed);
  }
  if (!config.source.whole_image) {
    if (auto ok = session->learn_outline(); !ok) return ok;
  }

  if (!*out) {
    auto made = OutputFolder::create(config.output.folder);
    if (!made) return made.error();
    *out = *std::move(made);
  }
  if (const auto fresh = (*out)->forget_earlier_run(files); !fresh) return fresh;
  {
    Replay replay(config, console, **std::move(out), std::move(*session), std::move(*parts));
    if (auto done = replay.run(json); !done) return done;
  }
  // The images are there; the window shows the session from its beginning.
  return config.output.window ? show_in_window(config, std::nullopt) : Result<void>();
}

}  // namespace nav::app
