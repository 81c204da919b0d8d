// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/demo.hpp"

#include <cstdio>
#include <random>

#include "app/engines.hpp"
#include "app/report.hpp"
#include "app/verbs/register/registration_image.hpp"
#include "app/views/ct_window.hpp"
#include "app/views/presenter.hpp"
#include "io/image_output.hpp"
#include "nav/cause_words.hpp"
#include "nav/threads.hpp"
#include "session/driver.hpp"
#include "sim/ct_scanner.hpp"
#include "sim/simulated_source.hpp"

namespace nav::app {
namespace {

constexpr int kSweepFrames = 60;
constexpr int kDefaultApproachImages = 30;
/// The approach takes the time of at least so many images: no hand moves a needle faster.
constexpr int kLeastApproachImages = 8;
constexpr double kFrameRateHz = 20;
constexpr Duration kRefreshPeriod = std::chrono::milliseconds(100);
constexpr Duration kStampOffset = std::chrono::milliseconds(30);
constexpr Duration kImageLatency = std::chrono::milliseconds(45);
constexpr int kAnimationMs = 120;

constexpr const char* kDemoPoseLogFile = "pose_log.csv";
constexpr const char* kDemoAnimationFile = "demo.webp";
constexpr const char* kDemoReportFile = "report.json";
constexpr const char* kDemoPageFile = "report.html";
constexpr const char* kSweepSeries = "sweep";
constexpr const char* kApproachSeries = "approach";

/// The truth turned and moved by a planted error about a centre, in a seeded direction.
Transform<frames::Ct, frames::Reference> with_error(
    const Transform<frames::Ct, frames::Reference>& truth, const Point<frames::Ct>& centre,
    double shift_mm, double turn_rad, std::uint64_t seed) {
  std::mt19937_64 random(seed * 7919 + 17);
  const auto unit = [&] {
    for (;;) {
      Eigen::Vector3d v;
      for (int i = 0; i < 3; ++i) {
        v[i] = static_cast<double>(random() >> 11) * 0x1.0p-52 - 1.0;
      }
      if (v.norm() > 0.1 && v.norm() < 1) return Eigen::Vector3d(v.normalized());
    }
  };
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(turn_rad, unit()));
  const Transform<frames::Ct, frames::Ct> error(turn,
                                                centre.mm - turn * centre.mm + shift_mm * unit());
  return error * truth;
}

/// Images of the approach that are shown.
int approach_images(const DemoOptions& options) {
  return options.output.frames > 0 ? options.output.frames : kDefaultApproachImages;
}

sim::SimulatedSessionOptions session_options(const DemoOptions& options) {
  sim::SimulatedSessionOptions session = sim::demonstrated_procedure(options.seed);
  session.frame_rate_hz = kFrameRateHz;
  session.duration_s = (kSweepFrames - 1) / kFrameRateHz;
  // Two images arrive between two refreshes.
  const int images = std::max(approach_images(options), kLeastApproachImages);
  session.approach->duration_s = (2 * images - 1) / kFrameRateHz;
  session.image_timing = {kStampOffset, kImageLatency};
  return session;
}

/// Pose of the image at the end of the approach.
Transform<frames::Ct, frames::Image> last_view(const sim::SimulatedSession& simulation) {
  return simulation.truth(simulation.frame_count() - 1).ct_from_image;
}

/// Everything that the phases of the demo share.
class Demo {
 public:
  Demo(const DemoOptions& options, Console& console, OutputFolder out,
       const sim::SimulatedSession& simulation, std::shared_ptr<const Volume> ct,
       Presenter presenter, const render::HuWindow& window)
      : options_(options),
        console_(console),
        out_(std::move(out)),
        simulation_(simulation),
        ct_(std::move(ct)),
        presenter_(std::move(presenter)),
        session_(setup(simulation), console),
        driver_(session_, {kRefreshPeriod}, [this](const tracking::PairedImage& paired) {
          if (paired.tracked && sweeping_) sweep_.push_back(*paired.tracked);
        }) {
    session_.add(sim::source_of(simulation));
    presenter_.set_facts(
        {.plan = plan(),
         .focus_ct = plan().target_ct,
         .typical_plane =
             SessionFacts::TypicalPlane{last_view(simulation), simulation.options().probe.depth_mm},
         .window = window,
         .banner = "simulated patient " + std::to_string(options.seed),
         .simulated = true});
    session_.navigator().set_plan(plan());
  }

  Result<void> run();

 private:
  static session::SessionSetup setup(const sim::SimulatedSession& simulation) {
    session::SessionSetup setup{ProbeCalibration{simulation.probe_from_image()}};
    setup.navigator.pairing.temporal_offset = kStampOffset;
    setup.navigator.frame_period = from_seconds(1 / kFrameRateHz);
    setup.images = session::QueuePolicy::kLossless;
    return setup;
  }
  /// \p images: number of the images that are shown, evenly spread up to \p until; 0: all.
  Result<void> play(const std::string& name, Timestamp until, bool end_of_stream, int images = 0);
  Result<void> register_ct();
  Result<void> write_report();
  [[nodiscard]] const NeedlePlan& plan() const { return simulation_.needle()->plan(); }
  [[nodiscard]] double target_error_mm(
      const Transform<frames::Ct, frames::Reference>& estimate) const;

  const DemoOptions& options_;
  Console& console_;
  OutputFolder out_;
  const sim::SimulatedSession& simulation_;
  std::shared_ptr<const Volume> ct_;
  Presenter presenter_;
  session::Session session_;
  std::vector<TrackedImage> sweep_;
  bool sweeping_ = true;
  session::Driver driver_;
  std::vector<Image2d<Rgba8>> animation_;
  std::optional<NeedleGuidance> last_guidance_;
  std::optional<Transform<frames::Ct, frames::Reference>> start_;
  std::optional<registration::ImageRegistrationResult> registration_;
  registration::Decision decision_{false, {"not run"}};
};

double Demo::target_error_mm(const Transform<frames::Ct, frames::Reference>& estimate) const {
  const auto target = plan().target_ct;
  return (estimate * (simulation_.ct_from_reference().inverse() * target) - target).v.norm();
}

Result<void> Demo::play(const std::string& name, Timestamp until, bool end_of_stream, int images) {
  console_.begin(name);
  const Timestamp begun = session_.now();
  const auto refreshes = (until - begun) / kRefreshPeriod;
  int index = 0;
  for (;;) {
    if (index < images) {
      const Timestamp before = begun + ((index + 1) * refreshes / images - 1) * kRefreshPeriod;
      if (auto passed = driver_.pass(before); !passed) return passed;
    }
    const auto epoch = driver_.next(until, end_of_stream);
    if (!epoch) return epoch.error();
    if (!*epoch) break;
    if (!(*epoch)->frame) continue;  // Nothing has arrived yet: nothing to show.
    last_guidance_ = (*epoch)->guidance;
    auto image = presenter_.present(**epoch);
    if (!image) return image.error();
    char file[64];
    std::snprintf(file, sizeof file, "%s_%03d.png", name.c_str(), index++);
    if (const auto written = out_.write_image(file, *image); !written) return written;
    animation_.push_back(std::move(*image));
    console_.progress(to_seconds(session_.now() - begun) / to_seconds(until - begun));
  }
  console_.end(std::to_string(index) + " images");
  return {};
}

Result<void> Demo::register_ct() {
  sweeping_ = false;
  auto sweep = Sweep::create(sweep_, "simulated calibration");
  if (!sweep) return sweep.error();
  const Point<frames::Ct> centre = simulation_.ct_from_reference() * sweep->centroid();
  start_ = with_error(simulation_.ct_from_reference(), centre, options_.start_error_mm,
                      options_.start_error_deg * M_PI / 180, options_.seed);
  registration::ImageRegistrationOptions options;
  options.threads = usable_threads(options_.output.threads > 0 ? options_.output.threads : 2);
  options.seed = options_.seed;
  console_.begin("registration");
  auto result =
      registration::register_sweep(*ct_, *sweep, *start_, options, console_, [&](double fraction) {
        console_.progress(fraction);
        return true;
      });
  if (!result) return result.error();
  registration_ = std::move(*result);
  decision_ = registration::decide(*registration_, {}, plan().target_ct);
  console_.end(decision_.accepted ? "accepted" : "refused");
  const TrackedImage& middle = sweep->frames()[sweep->frames().size() / 2];
  if (const auto written = out_.write_image(
          kRegistrationImage,
          registration_image(*ct_, middle, *start_, registration_->ct_from_reference,
                             decision_.accepted, presenter_.window()));
      !written) {
    return written;
  }
  report_warnings(decision_.warnings, console_);
  SessionFacts facts = presenter_.facts();
  facts.warning = registration_warning(decision_.warnings);
  if (decision_.accepted && registration_->covariance_valid) {
    facts.uncertainty = registration_->uncertainty;
  }
  presenter_.set_facts(std::move(facts));
  if (decision_.accepted) {
    session_.navigator().set_placement(
        {registration_->ct_from_reference, {SafetyState::kValid, ""}});
  }
  return {};
}

Result<void> Demo::run() {
  const auto& phases = simulation_.phases();
  const Timestamp sweep_end = phases.front().end + std::chrono::milliseconds(150);
  if (auto played = play(kSweepSeries, sweep_end, false); !played) return played;
  if (auto registered = register_ct(); !registered) return registered;
  if (decision_.accepted) {
    // Nobody looks while the probe changes hands.
    if (auto passed = driver_.pass(phases.back().begin); !passed) return passed;
    // Two images arrive between two refreshes.
    const Timestamp end = session_.now() + phases.back().frame_count / 2 * kRefreshPeriod;
    if (auto played = play(kApproachSeries, end, true, approach_images(options_)); !played) {
      return played;
    }
  } else {
    session_.finish();
  }
  session_.navigator().finish();
  if (const auto written = io::write_animation(animation_, kAnimationMs, out_ / kDemoAnimationFile);
      !written) {
    return written;
  }
  out_.list(kDemoAnimationFile);
  if (auto written = write_report(); !written) return written;
  console_.say("images and report: " + (out_ / kDemoPageFile).string());
  if (!decision_.accepted) {
    std::string reasons;
    for (const std::string& reason : decision_.reasons) {
      reasons += (reasons.empty() ? "" : "; ") + reason;
    }
    return Error{ErrorCode::kRefused, "registration: refused: " + reasons};
  }
  return {};
}

Result<void> Demo::write_report() {
  const Point<frames::Ct> target = plan().target_ct;
  const double start_mm = target_error_mm(*start_);
  const double error_mm = target_error_mm(registration_->ct_from_reference);
  io::Json json;
  json["verb"] = "demo";
  json["version"] = SONDE_VERSION;
  json["simulated"] = true;
  json["seed"] = options_.seed;
  json["engine"] = presenter_.engine().name();
  json["device"] = presenter_.engine().device();
  json["start_translation_mm"] = options_.start_error_mm;
  json["start_rotation_deg"] = options_.start_error_deg;
  json["start_error_mm"] = start_mm;
  json["target_error_mm"] = json_number(error_mm);
  json["registration"] = json_of(*registration_, decision_, target);
  json["ledger"] = json_of(session_.navigator().ledger());
  json["rejected_poses"] = session_.navigator().rejected_poses();
  json["final_tip_to_target_mm"] =
      last_guidance_ ? io::Json(last_guidance_->tip_to_target_mm) : io::Json(nullptr);
  say_sampling(presenter_.step(), options_.output.rms_error, console_);
  json["sampling"] = json_of(presenter_.step());
  json["ct_window"] = json_of(presenter_.window());
  json["grey_window"] = json_of(presenter_.grey());
  json["views_cast"] = presenter_.views_cast();
  json["views_reused"] = presenter_.views_reused();
  json["cast_seconds"] = presenter_.cast_seconds();
  json["frames"] = out_.files();
  json["pose_log_sha256"] = io::sha256_hex(session_.log().text());
  json["image_sha256"] = out_.image_digest();
  add_messages(json, console_.entries());
  if (auto written = out_.write_text(kDemoPoseLogFile, session_.log().text()); !written)
    return written;
  if (auto written = write_json(json, (out_ / kDemoReportFile).string()); !written) return written;
  if (options_.json) {
    if (auto written = write_json(json, *options_.json); !written) return written;
  }

  HtmlReport html;
  html.title = "Sonde: simulated procedure";
  html.warning = !decision_.accepted;
  html.summary =
      "Simulated patient " + std::to_string(options_.seed) +
      ". The CT was registered to a sweep of " + std::to_string(sweep_.size()) +
      " ultrasound images from a start error of " + quantity(start_mm, 1, "mm") +
      " at the target; " +
      (decision_.accepted ? "accepted, with a true target error of " + quantity(error_mm, 2, "mm") +
                                " (known only because the patient is simulated)."
                          : "refused, so the ultrasound was never drawn inside the CT.");
  html.images = {
      {kDemoAnimationFile,
       "The whole procedure: sweep, registration, needle approach. Left: the live "
       "ultrasound plane inside the CT with needle and target. Right: the ultrasound "
       "image and the CT along the same plane."},
      {kRegistrationImage, "One image of the sweep, and checkerboards of ultrasound and CT."}};
  for (const std::string& file : out_.files()) {
    if (file.starts_with(kApproachSeries) && file.ends_with("0.png")) {
      html.images.emplace_back(file, file);
    }
  }
  const auto& ledger = session_.navigator().ledger();
  html.tables.push_back(
      {"Registration",
       {{"decision", decision_.accepted ? "accepted" : "refused"},
        {"start error at the target", quantity(start_mm, 2, "mm")},
        {"true target error", quantity(error_mm, 2, "mm")},
        {"predicted target error, RMS", quantity(registration_->tre_rms_mm(target), 2, "mm")},
        {"cost before, after", quantity(registration_->initial_cost, 4, "") + ", " +
                                   quantity(registration_->final_cost, 4, "")},
        {"overlap", quantity(100 * registration_->overlap, 1, "%")},
        {"iterations", std::to_string(registration_->iterations)},
        {"time", quantity(registration_->total_s, 2, "s")}}});
  for (const std::string& reason : decision_.reasons) {
    html.tables.back().second.emplace_back("reason", reason);
  }
  html.tables.push_back({"Ultrasound images",
                         {{"received", std::to_string(ledger.received())},
                          {"shown", std::to_string(ledger.delivered())},
                          {"superseded", std::to_string(ledger.superseded())},
                          {"rejected", std::to_string(ledger.rejected_total())}}});
  for (const auto& [cause, count] : ledger.rejected()) {
    html.tables.back().second.emplace_back("rejected: " + words_of_cause(cause),
                                           std::to_string(count));
  }
  html.tables.push_back(
      {"Needle",
       {{"tip to target at the end",
         last_guidance_ ? quantity(last_guidance_->tip_to_target_mm, 1, "mm") : "withdrawn"}}});
  html.tables.push_back(
      {"Rendering",
       {{"engine", presenter_.engine().name() + ", " + presenter_.engine().device()},
        {"3D views cast, reused", std::to_string(presenter_.views_cast()) + ", " +
                                      std::to_string(presenter_.views_reused())},
        {"mean time per cast view",
         quantity(1e3 * presenter_.cast_seconds() / std::max(presenter_.views_cast(), 1), 1,
                  "ms")}}});
  return out_.write_text(kDemoPageFile, to_html(html));
}

}  // namespace

std::vector<std::string> demo_outputs() {
  return {kDemoPoseLogFile, kRegistrationImage, kDemoAnimationFile, kDemoReportFile, kDemoPageFile};
}

Result<void> run_demo(const DemoOptions& options, Console& console) {
  const RunFiles files{
      {kDemoPoseLogFile, kRegistrationImage, kDemoAnimationFile, kDemoReportFile, kDemoPageFile},
      {kSweepSeries, kApproachSeries}};
  auto opened = OutputFolder::open(options.output.folder, files);
  if (!opened) return opened.error();
  std::optional<OutputFolder> out = *std::move(opened);
  auto engine = make_engine(options.output.engine, options.output.threads, console);
  if (!engine) return engine.error();

  console.begin("simulated patient");
  const auto made = sim::SimulatedSession::create(session_options(options));
  if (!made) return made.error();
  const sim::SimulatedSession& simulation = *made;
  sim::CtOptions ct_options;
  ct_options.seed = options.seed;
  auto ct = sim::scan_ct(simulation.patient(), ct_options);
  if (!ct) return ct.error();
  auto shared_ct = std::make_shared<const Volume>(std::move(*ct));
  console.end("CT of " + std::to_string(shared_ct->grid().voxel_count()) + " voxels");

  // The grey window depends on the plane in which the needle comes.
  const auto& probe = simulation.options().probe;
  const Eigen::AlignedBox2d image_mm(Eigen::Vector2d(-probe.depth_mm / 2, 0),
                                     Eigen::Vector2d(probe.depth_mm / 2, probe.depth_mm));
  const auto window = ct_window(options.view, *shared_ct,
                                values_along(*shared_ct, last_view(simulation), image_mm));
  auto appearance = resolve_appearance(options.appearance, *shared_ct);
  if (!appearance) return appearance.error();
  if (auto ok = save_appearance(options.appearance.save, *appearance); !ok) return ok;
  if (appearance->drawn) {
    for (const auto& statement : appearance->drawn->statements) console.say(statement);
  }
  warn_of_lost_components(appearance->transfer, console);
  warn_of_missing_presets(options.appearance, *shared_ct, console);
  auto shapes = read_cutaway_objects(options.cutaway_objects, *shared_ct, console);
  if (!shapes) return shapes.error();
  auto presenter = Presenter::create({.appearance = options.appearance,
                                      .view = options.view,
                                      .width = options.output.width,
                                      .height = options.output.height,
                                      .step_voxels = options.output.step_voxels,
                                      .rms_error = options.output.rms_error,
                                      .pixel_error = options.output.pixel_error,
                                      .quality = options.quality,
                                      .cut_free = *std::move(shapes)},
                                     *std::move(appearance), shared_ct, std::move(*engine));
  if (!presenter) return presenter.error();
  if (!out) {
    auto made_folder = OutputFolder::create(options.output.folder);
    if (!made_folder) return made_folder.error();
    out = *std::move(made_folder);
  }
  if (const auto fresh = out->forget_earlier_run(files); !fresh) return fresh;
  Demo demo(options, console, std::move(*out), simulation, shared_ct, std::move(*presenter),
            window);
  return demo.run();
}

}  // namespace nav::app
