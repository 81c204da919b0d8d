// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/replay.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <sstream>
#include <utility>

#include "app/engines.hpp"
#include "app/interrupt.hpp"
#include "app/predicates/predicate_volume.hpp"
#include "app/report.hpp"
#include "app/views/ct_window.hpp"
#include "app/views/presenter.hpp"
#include "io/picture.hpp"
#include "render/predicates/predicate_sampler.hpp"
#include "render/two_volumes.hpp"
#include "render/window/window.hpp"
#include "session/outside_ct.hpp"
#include "session/placement.hpp"
#include "session/recorded_session.hpp"
#include "session/tissue_follower.hpp"

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
constexpr const char* kPictureSeries = "replay";

std::string banner_of(const session::Placement& placement, bool follows) {
  if (placement.kind != "registered") return "recording, CT NOT REGISTERED";
  return follows ? "recording, CT follows the tissue" : "recording";
}

/// Null: pictures are drawn whole.
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

/// A centre outside of the CT is most likely a volume in another frame.
Result<void> draw_by_predicates(const SessionConfig& config, const Volume& ct, Presenter& presenter,
                                Console& console) {
  PredicateOptions options = config.predicates;
  // Drawn with the plan.
  if (!options.target && config.plan) {
    const auto& target_mm = config.plan->target_ct.mm;
    options.target =
        Eigen::Vector4d(target_mm.x(), target_mm.y(), target_mm.z(), config.plan->target_radius_mm);
  }
  auto made = prepare_predicates(
      options, config.output.threads, console,
      config.source.needle_frame.empty() ? DistancesFrom::kNoNeedle : DistancesFrom::kLiveNeedle);
  if (!made) return made.error();
  const auto& ultrasound = made->volume.ultrasound;
  if (session::mm_outside(ct, std::array{ultrasound->grid().centre()}) > 0) {
    console.report(Severity::kWarning, options.volume.string(),
                   "its centre lies outside of the CT: is it in the CT's frame?");
  }
  std::optional<render::SphereShape> target;
  if (config.predicates.target) target = target_sphere(*config.predicates.target);
  presenter.draw_by_predicates(
      {ultrasound, std::move(made->volume.predicates), options.ct_importance}, options.alone,
      target);
  return {};
}

/// Whether the 3D ultrasound of a scene shows anywhere, asked of a small picture.
Result<bool> shows_ultrasound(render::Scene scene) {
  constexpr int kWidth = 160;
  constexpr double kTransparentMm = 1e6;
  scene.height = std::max(16, kWidth * scene.height / scene.width);
  scene.width = kWidth;
  const auto engine = render::make_cpu_engine();
  const auto with = engine->render(scene);
  if (!with) return with.error();
  (scene.ultrasound ? scene.ultrasound->predicates : *scene.predicates).opacity_length_mm =
      kTransparentMm;
  const auto without = engine->render(scene);
  if (!without) return without.error();
  constexpr double kSeen = 1e-5;  // Less than one pixel by one of 255.
  return render::rms_difference(with->pixels, without->pixels) > kSeen;
}

constexpr const char* kEnded = "the recording has ended";

class Replay {
 public:
  /// out: where pictures and report go; none: the window alone shows the recording.
  Replay(const SessionConfig& config, Console& console, std::optional<OutputFolder> out,
         std::shared_ptr<const Volume> ct, session::RecordedSession session,
         session::Placement placement, Presenter presenter,
         std::optional<session::TissueFollower> follower)
      : config_(config),
        console_(console),
        out_(std::move(out)),
        ct_(std::move(ct)),
        session_(std::move(session)),
        placement_(std::move(placement)),
        presenter_(std::move(presenter)),
        follower_(std::move(follower)) {
    session_.set_placement(placement_.placement);
    if (config_.plan) session_.navigator().set_plan(*config_.plan);
  }

  Result<void> run(const std::optional<std::string>& json) {
    // Every n-th paired picture is shown when fewer are wanted than there are.
    const std::int64_t most = config_.output.frames;
    const std::int64_t total = session_.total_frames();
    stride_ = most > 0 ? std::max<std::int64_t>(1, (total + most - 1) / most) : 1;
    console_.begin("replay");
    if (auto played = config_.output.window ? play_in_window() : play(); !played) return played;
    console_.end(std::to_string(shown_) + " pictures");
    session_.navigator().finish();
    if (out_ && !animation_.empty()) {
      const auto file = *out_ / kAnimationFile;
      if (auto written = io::write_animation(animation_, kReplayAnimationMs, file); !written) {
        return written;
      }
      out_->list(kAnimationFile);
    }
    const io::Json report = this->report();
    if (json) {
      if (auto written = write_json(report, *json); !written) return written;
    }
    if (!out_) return {};
    if (auto written = write_folder(report); !written) return written;
    console_.say("pictures and report: " + (*out_ / kPageFile).string());
    return {};
  }

 private:
  /// Plays on until a refresh is due; false at the end.
  Result<bool> advance() {
    for (;;) {
      bool due = false;
      const auto more = session_.step([&](const tracking::PairedFrame& paired) {
        if (!paired.tracked) return;
        if (follower_) session_.set_placement(follower_->follow(*paired.tracked));
        if (paired_++ % stride_ == 0) due = true;
      });
      if (!more) return more.error();
      console_.progress(static_cast<double>(session_.frames_read()) /
                        static_cast<double>(std::max<std::int64_t>(session_.total_frames(), 1)));
      if (due || !*more) return due;
    }
  }

  /// The next refresh once its time has come, by the recording's own pace from the first one on;
  /// nothing before, and at the end, when over_ is set. What is late by more than kLate is
  /// left out, unless every picture is written.
  Result<std::optional<session::Epoch>> advance_in_time(Timestamp now) {
    constexpr auto kLate = std::chrono::milliseconds(100);
    // Longer, and a window would not answer the mouse.
    constexpr auto kMostWork = std::chrono::milliseconds(50);
    const MonotonicClock since;
    while (!over_) {
      if (!waiting_) {
        const auto more = advance();
        if (!more) return more.error();
        waiting_ = *more;
        over_ = !*more;
        if (over_) break;
        if (!origin_) origin_ = now - session_.now().time_since_epoch();
      }
      const Duration early = *origin_ + session_.now().time_since_epoch() - now;
      if (early > Duration(0)) break;
      waiting_ = false;
      if (out_ || early >= -kLate || since.now() > Timestamp(kMostWork)) {
        return std::optional(session_.refresh());
      }
    }
    return std::optional<session::Epoch>();
  }

  /// Makes an epoch that is still shown as old as it is by now; whether its state is another then.
  bool has_aged(session::Epoch& epoch, Timestamp now) {
    const auto states = [](const session::Epoch& e) {
      return std::array{e.plane.state, e.needle.state};
    };
    const auto before = states(epoch);
    epoch = session_.navigator().aged(std::move(epoch), now - origin_->time_since_epoch());
    return states(epoch) != before;
  }

  /// Says, once, where nothing of the ultrasound volume is to be seen, and where a cutaway takes
  /// away some of what is most important in it.
  Result<void> check_ultrasound(const session::Epoch& epoch) {
    if (ultrasound_checked_ || config_.predicates.volume.empty()) return {};
    ultrasound_checked_ = true;
    const render::Scene scene = presenter_.scene(epoch);
    if (auto ok = check_importance(scene); !ok) return ok;
    const auto shows = shows_ultrasound(scene);
    if (!shows) return shows.error();
    if (*shows) return {};
    console_.report(Severity::kWarning, config_.predicates.volume.string(),
                    "nothing of it shows in the first picture: no sample in view satisfies a "
                    "predicate of importance above 0, the CT is more important "
                    "(--ct-importance), or the cutaway takes it away (--no-cutaway, "
                    "cutaway_importance of the set-up)");
    return {};
  }

  Result<void> check_importance(const render::Scene& scene) {
    if (!scene.cutaway) return {};
    const render::Scene alone = scene.ultrasound ? render::ultrasound_scene(scene) : scene;
    const auto set =
        render::PredicateSet::create(*alone.predicates, alone.ct, render::place_of(alone));
    if (!set) return set.error();
    const auto shared = render::shared_importance(*set);
    constexpr double kWorthSaying = 0.02;
    if (shared.share < kWorthSaying) return {};
    std::ostringstream text;
    text.precision(2);
    text << "'" << alone.predicates->model.entries[shared.entry].name
         << "', its most important predicate, is true together with others in "
         << std::lround(100 * shared.share)
         << " % of the voxels where it is true: there it counts for " << shared.importance
         << " of what it counts alone, and a cutaway takes it away; 'not' this entry in the others "
            "keeps it";
    console_.report(Severity::kWarning, config_.predicates.volume.string(), text.str());
    return {};
  }

  Result<void> show(const session::Epoch& epoch) {
    if (auto ok = check_ultrasound(epoch); !ok) return ok;
    auto picture = presenter_.present(epoch);
    if (!picture) return picture.error();
    if (presenter_.note() != note_) {
      note_ = presenter_.note();
      if (!note_.empty()) console_.report(Severity::kWarning, "render", note_);
    }
    char name[64];
    std::snprintf(name, sizeof name, "%s_%05d.png", kPictureSeries, shown_++);
    if (auto written = out_->write_picture(name, *picture); !written) return written;
    if (animation_.size() < kMostAnimated) animation_.push_back(std::move(*picture));
    return {};
  }

  Result<void> play() {
    for (;;) {
      const auto due = advance();
      if (!due) return due.error();
      if (!*due) return {};
      if (auto shown = show(session_.refresh()); !shown) return shown;
    }
  }

  Result<void> play_in_window() {
    const MonotonicClock clock;
    std::optional<Error> failure;
    std::optional<session::Epoch> seen;
    const auto show_next = [&](const session::Epoch& epoch) -> Result<void> {
      if (out_) return show(epoch);
      ++shown_;
      if (auto ok = check_ultrasound(epoch); !ok) return ok;
      return presenter_.choose_step(epoch);
    };
    bool last = false;  // Nothing more comes.
    const auto source = [&]() -> std::shared_ptr<const render::Scene> {
      if (last) return nullptr;
      auto epoch = advance_in_time(clock.now());
      if (epoch && *epoch) {
        if (const auto shown = show_next(**epoch); !shown) epoch = shown.error();
        // To find the step for the first one takes seconds.
        if (!seen) origin_ = clock.now() - session_.now().time_since_epoch();
      }
      last = !epoch || (!*epoch && over_);
      if (!epoch) failure = epoch.error();
      if (last && !seen) return nullptr;
      if (last) {
        // Once more, as no longer live, with the words that say why.
        seen = session::ended(*std::move(seen), failure ? failure->message : kEnded);
        if (!failure) console_.say(std::string(kEnded) + ": close the window, or press Ctrl-C");
      } else if (*epoch) {
        seen = *std::move(*epoch);
      } else if (!seen || !has_aged(*seen, clock.now())) {
        return nullptr;
      }
      return std::make_shared<const render::Scene>(presenter_.scene(*seen));
    };
    render::WindowOptions options;
    const Interrupt interrupt;
    options.close_when = [&] { return interrupt.asked(); };
    options.words = [&](const render::Camera& camera) {
      return seen ? presenter_.words(*seen, camera, over_) : std::vector<render::WindowWords>{};
    };
    auto window = render::show_window(source, options);
    if (failure) return *failure;
    if (!window || !out_) return window;
    // What the window did not live to see.
    if (waiting_) {
      if (auto shown = show(session_.refresh()); !shown) return shown;
    }
    return over_ ? Result<void>() : play();
  }

  /// report.json.
  [[nodiscard]] io::Json report();
  Result<void> write_folder(const io::Json& report);

  const SessionConfig& config_;
  Console& console_;
  std::optional<OutputFolder> out_;
  std::shared_ptr<const Volume> ct_;
  session::RecordedSession session_;
  session::Placement placement_;
  Presenter presenter_;
  std::optional<session::TissueFollower> follower_;
  std::int64_t stride_ = 1;
  std::int64_t paired_ = 0;
  int shown_ = 0;
  bool ultrasound_checked_ = false;
  bool waiting_ = false;  ///< Of advance_in_time(): a refresh is due, in a while.
  bool over_ = false;     ///< It has come to the recording's end.
  std::optional<Timestamp>
      origin_;        ///< When the recording's time 0 is, by the clock of the window.
  std::string note_;  ///< Of the engine, that was reported.
  std::vector<Image2d<Rgba8>> animation_;
};

io::Json Replay::report() {
  const auto& ledger = session_.navigator().ledger();
  std::vector<std::string> warnings = placement_.warnings;
  if (!placement_.outside.empty()) warnings.push_back(placement_.outside);
  io::Json json;
  json["verb"] = "replay";
  json["version"] = SONDE_VERSION;
  json["simulated"] = false;
  json["sweep"] = config_.source.recording.string();
  json["ct"] = config_.ct.path.string();
  json["ultrasound_volume"] = config_.predicates.volume.string();
  json["predicates"] = legend_json(presenter_.legend());
  json["engine"] = presenter_.engine().name();
  json["device"] = presenter_.engine().device();
  json["placement"] = {
      {"kind", placement_.kind},
      {"statement", placement_.statement},
      {"warnings", warnings},
      {"ct_from_reference_mm", json_of(placement_.placement.ct_from_reference.matrix())}};
  json["following"] = follower_ ? json_of(follower_->summary()) : io::Json();
  json["reference"] = session_.reference_statement();
  json["transforms"] = session_.description();
  json["sector"] = sector_json(session_.outline());
  json["ledger"] = json_of(ledger);
  json["rejected_poses"] = session_.navigator().rejected_poses();
  say_sampling(presenter_.step(), config_.output.rms_error, console_);
  json["sampling"] = json_of(presenter_.step());
  json["ct_window"] = json_of(presenter_.window());
  json["grey_window"] = json_of(presenter_.grey());
  json["views_cast"] = presenter_.views_cast();
  json["cast_seconds"] = presenter_.cast_seconds();
  json["frames"] = out_ ? io::Json(out_->files()) : io::Json::array();
  json["pose_log_sha256"] = io::sha256_hex(session_.log().text());
  json["image_sha256"] = out_ ? io::Json(out_->image_digest()) : io::Json();
  json["diagnostics"] = json_of(console_.entries());
  return json;
}

Result<void> Replay::write_folder(const io::Json& report) {
  OutputFolder& out = *out_;
  const auto& ledger = session_.navigator().ledger();
  if (auto written = out.write_text(kPoseLogFile, session_.log().text()); !written) {
    return written;
  }
  if (follower_) {
    if (auto written = out.write_text(kFollowingFile, follower_->text()); !written) {
      return written;
    }
  }
  const auto session = to_toml(config_);
  if (!session) return session.error();
  if (auto written = out.write_text(kSessionFile, *session); !written) return written;
  if (auto written = write_json(report, (out / kReportFile).string()); !written) return written;

  HtmlReport html;
  html.title = "Sonde: replay of " + config_.source.recording.filename().string();
  html.warning = placement_.kind != "registered" || !placement_.warnings.empty() ||
                 !placement_.outside.empty();
  html.summary = placement_.statement + " Patient's frame: " + session_.reference_statement() + ".";
  for (const std::string& warning : placement_.warnings) {
    html.summary += " Accepted with a warning: " + warning + ".";
  }
  if (!placement_.outside.empty()) html.summary += " Warning: " + placement_.outside + ".";
  const auto& files = out.files();
  if (!animation_.empty()) {
    html.pictures.emplace_back(kAnimationFile,
                               "The replay. Left: the ultrasound plane inside the CT. Right: the "
                               "ultrasound picture and the CT along the same plane.");
  }
  const std::size_t count = animation_.empty() ? files.size() : files.size() - 1;
  for (std::size_t i = 0; i < count; i += std::max<std::size_t>(1, count / 4)) {
    html.pictures.emplace_back(files[i], files[i]);
  }
  html.tables.push_back({"Pictures",
                         {{"received", std::to_string(ledger.received())},
                          {"shown", std::to_string(ledger.shown())},
                          {"superseded", std::to_string(ledger.superseded())},
                          {"rejected", std::to_string(ledger.rejected_total())}}});
  for (const auto& [cause, number] : ledger.rejected()) {
    html.tables.back().second.emplace_back("rejected: " + cause, std::to_string(number));
  }
  if (!presenter_.legend().empty()) {
    html.tables.push_back({"Importance of predicates", {}});
    for (const LegendEntry& entry : presenter_.legend()) {
      html.tables.back().second.emplace_back(entry.name, entry.importance_words());
    }
  }
  if (follower_) html.tables.push_back({"Following the tissue", rows_of(follower_->summary())});
  html.tables.push_back({"Input",
                         {{"sweep", config_.source.recording.string()},
                          {"calibration", config_.source.plus_config.string()},
                          {"transforms", session_.description()},
                          {"CT", config_.ct.path.string()},
                          {"ultrasound volume", config_.predicates.volume.string()}}});
  html.tables.push_back(
      {"Rendering",
       {{"engine", presenter_.engine().name() + ", " + presenter_.engine().device()},
        {"mean time per view",
         quantity(1e3 * presenter_.cast_seconds() / std::max(presenter_.views_cast(), 1), 1,
                  "ms")}}});
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
  const bool writes = !config.output.window || !config.output.folder.empty();
  if (writes) {
    if (auto ok = require_path(config.output.folder, "--out", "a folder"); !ok) return ok;
  }
  // It is written at the end; what it cannot hold is said before the work.
  if (const auto session = to_toml(config); !session) return session.error();
  if (writes) {
    if (auto ok = forget_earlier_reports(config.output.folder); !ok) return ok;
  }
  auto session = session::RecordedSession::open(config.source, console);
  if (!session) return session.error();
  console.begin("reading the CT");
  const auto ct = session::read_session_ct(config.ct, console);
  if (!ct) return ct.error();
  const std::shared_ptr<const Volume> shared_ct = *ct;
  console.end(std::to_string(shared_ct->grid().voxel_count()) + " voxels");
  console.begin("surveying the sweep");
  const auto sweep = session::survey(*session, config.source.skip_bad_frames);
  if (!sweep) return sweep.error();
  const auto sector = config.source.whole_picture ? std::nullopt : session::sector_of(*sweep);
  if (sector) session->set_outline(*sector);
  console.end(std::to_string(sweep->paired) + " pictures with a pose" +
              (sector ? ", of a sector" : ""));
  if (!sweep->warning.empty()) console.report(Severity::kWarning, "recording", sweep->warning);
  auto placement =
      session::place_ct(config.placement, *shared_ct, *sweep, session->reference_frame());
  if (!placement) return placement.error();

  auto engine = make_engine(config.output.engine, config.output.threads, console);
  if (!engine) return engine.error();
  const auto window =
      ct_window(config.view, *shared_ct,
                values_along(*shared_ct, placement->placement.ct_from_reference, sweep->spread));
  auto presenter = Presenter::create(
      {config.look, config.view, config.output.width, config.output.height,
       config.output.step_voxels, config.output.rms_error, config.output.pixel_error, window,
       config.quality, config.source.needle_size},
      shared_ct, std::move(*engine));
  if (!presenter) return presenter.error();
  if (auto ok = save_look(config.look.save, presenter->look()); !ok) return ok;
  warn_of_lost_components(presenter->look().transfer, console);
  if (!config.predicates.alone || config.predicates.volume.empty()) {
    warn_of_units(config.look, *shared_ct, console);
  }
  const auto shapes = read_cutaway_objects(config.cutaway_objects, *shared_ct, console);
  if (!shapes) return shapes.error();
  if (const auto ok = presenter->cut_free(*shapes); !ok) return ok;
  presenter->set_focus(placement->placement.ct_from_reference * sweep->centroid);
  if (const auto axes = session::mean_axes(*sweep)) {
    presenter->set_typical_plane(
        placement->placement.ct_from_reference *
            Transform<frames::Reference, frames::Image>(Eigen::Quaterniond(*axes).normalized(),
                                                        sweep->centroid.mm),
        sweep->picture_extent_mm);
  }
  std::optional<session::TissueFollower> follower;
  if (config.placement.follow) {
    console.begin("preparing to follow the tissue");
    auto made = session::TissueFollower::create(*sweep, *shared_ct, placement->placement,
                                                config.output.threads, console);
    if (!made) return made.error();
    follower = std::move(*made);
    console.end();
  }
  if (config.plan) {
    session::warn_outside(*config.plan, *shared_ct, console);
    presenter->set_plan(*config.plan);
  }
  presenter->set_banner(banner_of(*placement, follower.has_value()));
  presenter->set_registration_warnings(placement->warnings);
  report_warnings(placement->warnings, console);
  if (!placement->outside.empty()) {
    presenter->set_warning(placement->outside);
    console.report(Severity::kWarning, "placement", placement->outside);
  }
  if (!config.source.needle_frame.empty()) presenter->expect_needle();
  if (!config.predicates.volume.empty()) {
    if (auto ok = draw_by_predicates(config, *shared_ct, *presenter, console); !ok) return ok;
  }
  std::optional<OutputFolder> out;
  if (writes) {
    auto made = OutputFolder::create(config.output.folder);
    if (!made) return made.error();
    // Not the session file, which may be the one that this run was started by.
    const auto fresh =
        made->forget_earlier_run({kPoseLogFile, kFollowingFile, kAnimationFile}, {kPictureSeries});
    if (!fresh) return fresh.error();
    out = *std::move(made);
  }
  Replay replay(config, console, std::move(out), shared_ct, std::move(*session),
                std::move(*placement), std::move(*presenter), std::move(follower));
  return replay.run(json);
}

}  // namespace nav::app
