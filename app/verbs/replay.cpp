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
#include "app/views/live_view.hpp"
#include "app/views/presenter.hpp"
#include "io/image_output.hpp"
#include "render/predicates/predicate_sampler.hpp"
#include "render/two_volumes.hpp"
#include "render/window/window.hpp"
#include "session/driver.hpp"
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
constexpr const char* kImageSeries = "replay";

std::string banner_of(const session::Placement& placement, bool follows) {
  if (placement.kind != "registered") return "recording, CT NOT REGISTERED";
  return follows ? "recording, CT follows the tissue" : "recording";
}

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

/// True if the 3D ultrasound of a scene shows anywhere in a small image.
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

/// Parts that a replay needs before its first image.
struct ReplayParts {
  std::optional<OutputFolder> out;  ///< Folder of images and report; none: the window alone.
  std::shared_ptr<const Volume> ct;
  /// Placement that the options give; none: the first image decides.
  std::optional<session::Placement> given;
  session::RecordedSession session;
  /// The whole sweep, for camera and grey window; none: the first image decides.
  std::optional<session::SweepSurvey> survey;
  Presenter presenter;
};

class Replay {
 public:
  Replay(const SessionConfig& config, Console& console, ReplayParts parts)
      : config_(config),
        console_(console),
        out_(std::move(parts.out)),
        ct_(std::move(parts.ct)),
        given_(std::move(parts.given)),
        session_(std::move(parts.session)),
        survey_(std::move(parts.survey)),
        presenter_(std::move(parts.presenter)),
        driver_(session_.session(), {std::nullopt, stride()}, listener()) {
    if (config_.plan) session_.navigator().set_plan(*config_.plan);
  }

  Result<void> run(const std::optional<std::string>& json) {
    console_.begin("replay");
    if (auto played = config_.output.window ? play_in_window() : play(); !played) return played;
    console_.end(std::to_string(shown_) + " images");
    session_.navigator().finish();
    if (!placement_ && driver_.over()) return session::nothing_paired(session_);
    if (!placement_) return {};  // The window was closed before the first image.
    if (const std::string outside = outside_.warning(); !outside.empty()) {
      console_.report(Severity::kWarning, "placement", outside);
    }
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
    console_.say("images and report: " + (*out_ / kPageFile).string());
    return {};
  }

 private:
  /// Every n-th paired image is shown if fewer are wanted than a survey has found.
  [[nodiscard]] std::int64_t stride() const {
    const std::int64_t most = config_.output.frames;
    if (most <= 0 || !survey_) return 1;
    return std::max<std::int64_t>(1, (session_.total_frames() + most - 1) / most);
  }

  session::Session::Listener listener() {
    return [this](const tracking::PairedFrame& paired) {
      console_.progress(static_cast<double>(session_.frames_read()) /
                        static_cast<double>(std::max<std::int64_t>(session_.total_frames(), 1)));
      if (!paired.tracked || failure_) return;
      const TrackedFrame& image = *paired.tracked;
      if (!placement_) {
        if (auto begun = begin(image); !begun) failure_ = begun.error();
      }
      if (failure_) return;
      if (auto followed = follow(image); !followed) failure_ = followed.error();
      outside_.add(*ct_, placement_->placement, image);
      const std::string outside = outside_.warning();
      presenter_.set_warning(outside.empty() ? registration_warning(placement_->warnings)
                                             : outside);
    };
  }

  /// Everything that depends on where the images lie, decided with the first image.
  Result<void> begin(const TrackedFrame& image) {
    const auto first = session::survey_of(image);
    auto placement = session::place_sweep(config_.placement, given_, *ct_, first,
                                          session::recording_read(session_, image.frame));
    if (!placement) return placement.error();
    const auto& ct_from_reference = placement->placement.ct_from_reference;
    const session::SweepSurvey& seen = survey_ ? *survey_ : first;
    SessionFacts facts{
        .plan = config_.plan,
        .needle_expected = !config_.source.needle_frame.empty(),
        .focus_ct = ct_from_reference * seen.centroid,
        .window = ct_window(config_.view, *ct_, values_along(*ct_, ct_from_reference, seen.spread)),
        .banner = banner_of(*placement, config_.placement.follow)};
    if (const auto axes = session::mean_axes(seen)) {
      facts.typical_plane = SessionFacts::TypicalPlane{
          ct_from_reference * Transform<frames::Reference, frames::Image>(
                                  Eigen::Quaterniond(*axes).normalized(), seen.centroid.mm),
          seen.image_extent_mm};
    }
    presenter_.set_facts(std::move(facts));
    report_warnings(placement->warnings, console_);
    session_.set_placement(placement->placement);
    placement_ = std::move(*placement);
    return {};
  }

  /// Lets the CT follow the tissue, from the first image on that meets it.
  Result<void> follow(const TrackedFrame& image) {
    if (!config_.placement.follow) return {};
    if (!follower_) {
      auto made = session::TissueFollower::create(ct_, placement_->placement, image,
                                                  config_.output.threads, console_);
      if (!made && made.error().code == ErrorCode::kRefused) return {};
      if (!made) return made.error();
      follower_ = std::move(*made);
    }
    session_.set_placement(follower_->follow(image));
    return {};
  }

  /// Makes an epoch that is still shown as old as it is by now; whether its state is another then.
  bool has_aged(session::Epoch& epoch, Timestamp now) {
    const auto states = [](const session::Epoch& e) {
      return std::array{e.plane.state, e.needle.state};
    };
    const auto before = states(epoch);
    epoch = driver_.aged(std::move(epoch), now);
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
                    "nothing of it shows in the first image: no sample in view satisfies a "
                    "predicate of importance above 0, the CT is more important "
                    "(--ct-importance), or the cutaway takes it away (--no-cutaway, "
                    "cutaway_importance of the predicate set)");
    return {};
  }

  Result<void> check_importance(const render::Scene& scene) {
    if (!scene.cutaway) return {};
    const render::Scene alone = scene.ultrasound ? render::ultrasound_scene(scene) : scene;
    const auto set =
        render::PredicateSet::create(*alone.predicates, alone.ct, render::position_of(alone));
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

  /// Reports the engine's note about the last image, once.
  void say_note() {
    if (presenter_.note() == note_) return;
    note_ = presenter_.note();
    if (!note_.empty()) console_.report(Severity::kWarning, "render", note_);
  }

  Result<void> show(const session::Epoch& epoch) {
    if (auto ok = check_ultrasound(epoch); !ok) return ok;
    auto image = presenter_.present(epoch);
    if (!image) return image.error();
    say_note();
    char name[64];
    std::snprintf(name, sizeof name, "%s_%05d.png", kImageSeries, shown_++);
    if (auto written = out_->write_image(name, *image); !written) return written;
    if (animation_.size() < kMostAnimated) animation_.push_back(std::move(*image));
    return {};
  }

  Result<void> play() {
    for (;;) {
      const auto epoch = driver_.next();
      if (!epoch) return epoch.error();
      if (failure_) return *failure_;
      if (!*epoch) return {};
      if (auto shown = show(**epoch); !shown) return shown;
      if (!survey_ && config_.output.frames > 0 && shown_ >= config_.output.frames) {
        session_.session().finish();
        return {};
      }
    }
  }

  Result<void> play_in_window() {
    const MonotonicClock clock;
    LiveView view(presenter_);
    std::optional<Error> failure;
    std::optional<session::Epoch> seen;
    bool last = false;  // Nothing more comes.
    const auto take = [&](session::Epoch epoch) -> Result<void> {
      seen = std::move(epoch);
      if (out_) return show(*seen);
      ++shown_;
      return check_ultrasound(*seen);
    };
    // Takes what has come by now. True if the window has to show something else.
    const auto advance = [&](Timestamp now) {
      auto epoch = driver_.next_at_pace(now, out_.has_value());
      if (failure_) epoch = *failure_;
      if (epoch && *epoch) {
        const auto taken = take(*std::move(*epoch));
        if (taken) return true;
        epoch = taken.error();
      }
      last = !epoch || driver_.over();
      if (!epoch) failure = epoch.error();
      if (!last) return seen && has_aged(*seen, now);
      if (!seen) return false;
      // Once more, as no longer live, with the cause.
      seen = session::ended(*std::move(seen), failure ? failure->message : kEnded);
      if (!failure) console_.say(std::string(kEnded) + ": close the window, or press Ctrl-C");
      return true;
    };
    const auto source = [&](render::WindowInput input) -> Result<Image2d<Rgba8>> {
      const bool first = !seen;
      // Nothing is to be seen yet that could be moved.
      if (first) input = render::WindowInput{.width = input.width, .height = input.height};
      bool changed = view.apply(input);
      const int written = shown_;
      if (!last) changed |= advance(clock.now());
      if (!seen || !(changed || view.wants_refinement(clock.now()))) return Image2d<Rgba8>();
      auto image = out_ && shown_ > written ? view.draw_presented(*seen, clock.now())
                                            : view.draw(*seen, clock.now(), last && !failure);
      if (!image) return image;
      say_note();
      // The search for the step of the first image takes seconds.
      if (first) driver_.restart_pace(clock.now());
      return image;
    };
    const PixelSize size = composed_size(presenter_.view_size());
    const PixelSize least = composed_size(view_size_within({}));
    const Interrupt interrupt;
    const auto window = render::show_window(
        source, {.width = size.width,
                 .height = size.height,
                 .least_width = least.width,
                 .least_height = least.height,
                 .close_when = [&] { return interrupt.asked() || (last && !seen); }});
    if (failure) return *failure;
    if (!window || !out_) return window;
    // The rest of the recording, if the window was closed before its end.
    if (driver_.waiting()) {
      if (auto shown = show(session_.refresh()); !shown) return shown;
    }
    return driver_.over() ? Result<void>() : play();
  }

  /// report.json.
  [[nodiscard]] io::Json report();
  Result<void> write_folder(const io::Json& report);

  const SessionConfig& config_;
  Console& console_;
  std::optional<OutputFolder> out_;
  std::shared_ptr<const Volume> ct_;
  std::optional<session::Placement> given_;
  session::RecordedSession session_;
  std::optional<session::SweepSurvey> survey_;
  std::optional<session::Placement> placement_;  ///< Decided with the first image.
  session::OutsideWatch outside_;
  Presenter presenter_;
  std::optional<session::TissueFollower> follower_;
  std::optional<Error> failure_;  ///< Failure of the listener.
  session::Driver driver_;
  int shown_ = 0;
  bool ultrasound_checked_ = false;
  std::string note_;  ///< The engine's note that was reported.
  std::vector<Image2d<Rgba8>> animation_;
};

io::Json Replay::report() {
  const auto& ledger = session_.navigator().ledger();
  std::vector<std::string> warnings = placement_->warnings;
  const std::string outside = outside_.warning();
  if (!outside.empty()) warnings.push_back(outside);
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
      {"kind", placement_->kind},
      {"statement", placement_->statement},
      {"warnings", warnings},
      {"ct_from_reference_mm", json_of(placement_->placement.ct_from_reference.matrix())}};
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
  const std::string outside = outside_.warning();
  html.warning =
      placement_->kind != "registered" || !placement_->warnings.empty() || !outside.empty();
  html.summary =
      placement_->statement + " Patient's frame: " + session_.reference_statement() + ".";
  for (const std::string& warning : placement_->warnings) {
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
  // A fault of the placement itself is reported before any work.
  auto given = session::given_placement(config.placement, *shared_ct, session->reference_frame());
  if (!given) return given.error();
  std::optional<session::SweepSurvey> sweep;
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
    sweep = *std::move(surveyed);
    console.end(std::to_string(sweep->paired) + " images with a pose");
    if (!sweep->warning.empty()) console.report(Severity::kWarning, "recording", sweep->warning);
  }
  if (!config.source.whole_image) session->learn_outline();

  auto engine = make_engine(config.output.engine, config.output.threads, console);
  if (!engine) return engine.error();
  auto presenter = Presenter::create({.appearance = config.appearance,
                                      .view = config.view,
                                      .width = config.output.width,
                                      .height = config.output.height,
                                      .step_voxels = config.output.step_voxels,
                                      .rms_error = config.output.rms_error,
                                      .pixel_error = config.output.pixel_error,
                                      .quality = config.quality,
                                      .needle = config.source.needle_size},
                                     shared_ct, std::move(*engine));
  if (!presenter) return presenter.error();
  if (auto ok = save_appearance(config.appearance.save, presenter->appearance()); !ok) return ok;
  warn_of_lost_components(presenter->appearance().transfer, console);
  if (!config.predicates.alone || config.predicates.volume.empty()) {
    warn_of_units(config.appearance, *shared_ct, console);
  }
  const auto shapes = read_cutaway_objects(config.cutaway_objects, *shared_ct, console);
  if (!shapes) return shapes.error();
  if (const auto ok = presenter->cut_free(*shapes); !ok) return ok;
  if (config.plan) session::warn_outside(*config.plan, *shared_ct, console);
  if (!config.predicates.volume.empty()) {
    if (auto ok = draw_by_predicates(config, *shared_ct, *presenter, console); !ok) return ok;
  }
  std::optional<OutputFolder> out;
  if (writes) {
    auto made = OutputFolder::create(config.output.folder);
    if (!made) return made.error();
    // Not the session file, which may be the one that this run was started by.
    const auto fresh =
        made->forget_earlier_run({kPoseLogFile, kFollowingFile, kAnimationFile}, {kImageSeries});
    if (!fresh) return fresh.error();
    out = *std::move(made);
  }
  Replay replay(config, console,
                {.out = std::move(out),
                 .ct = shared_ct,
                 .given = *std::move(given),
                 .session = std::move(*session),
                 .survey = std::move(sweep),
                 .presenter = std::move(*presenter)});
  return replay.run(json);
}

}  // namespace nav::app
