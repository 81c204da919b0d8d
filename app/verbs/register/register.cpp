// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <cmath>
#include <iomanip>
#include <map>
#include <sstream>

#include "app/verbs/register/landmark_outcome.hpp"
#include "app/verbs/register/register_bone.hpp"
#include "app/verbs/register/register_shape.hpp"
#include "app/verbs/register/registration_image.hpp"
#include "app/verbs/replay.hpp"
#include "app/views/ct_window.hpp"
#include "io/own_mark.hpp"
#include "io/transform_file.hpp"
#include "nav/hounsfield.hpp"
#include "nav/stopwatch.hpp"
#include "nav/threads.hpp"
#include "registration/acceptance.hpp"
#include "registration/search/skin_search.hpp"
#include "registration/uncertainty/misfit.hpp"
#include "session/placement.hpp"
#include "session/recorded_session.hpp"
#include "session/registration_file.hpp"

namespace nav::app {
namespace {

bool moves(const MotionOptions& motion) { return motion.breath_period_s || motion.deformable; }

std::string joined(const std::vector<std::string>& reasons) {
  std::string text;
  for (const std::string& reason : reasons) text += (text.empty() ? "" : "; ") + reason;
  return text;
}

io::Json as_json(const Point<frames::Ct>& p) { return {p.mm.x(), p.mm.y(), p.mm.z()}; }

/// JSON of the scales that were refined together with the pose; null when there are none.
io::Json as_json(const registration::ImageScale& stretch, const std::string& model) {
  if (model == "none") return nullptr;
  io::Json json = {{"model", model}, {"depth_scale", stretch.depth_scale}};
  for (int i = 0; i < 9; ++i) json["strain"].push_back(stretch.strain(i / 3, i % 3));
  const Eigen::Vector3d& c = stretch.centre_mm;
  json["centre_reference_mm"] = {c.x(), c.y(), c.z()};
  return json;
}

/// Files that the verb writes.
class Results {
 public:
  /// Takes the folder, if there is one. Removes nothing: the inputs have yet to be read.
  static Result<Results> open(const SessionConfig& config, const RegisterOptions& options,
                              const std::optional<std::string>& json_file) {
    const std::filesystem::path& transform = options.save_transform;
    if (!transform.empty() && !io::is_transform_file(transform)) {
      return Error{
          ErrorCode::kUsage,
          "--save-transform: expected a name that ends with .tfm, found " + transform.string()};
    }
    Results results(config.output.folder, json_file, transform);
    auto folder = OutputFolder::open(config.output.folder, files());
    if (!folder) return folder.error();
    results.out_ = *std::move(folder);
    return results;
  }
  /// Removes the results of an earlier run, so that they do not seem to be of this run if it stops.
  Result<void> begin() {
    std::error_code ignored;
    if (json_file_ && std::filesystem::is_regular_file(*json_file_, ignored)) {
      const auto own = io::is_own_file(*json_file_);
      if (own && *own) std::filesystem::remove(*json_file_, ignored);
    }
    // A transform says nothing of its origin: an earlier one must not seem to be of this run.
    if (!transform_.empty() && std::filesystem::is_regular_file(transform_, ignored)) {
      const auto earlier = io::read_ct_from_reference(transform_);
      if (!earlier) {
        return Error{ErrorCode::kUsage,
                     "--save-transform: expected no file, or a transform that "
                     "this run may replace, found another file: " +
                         transform_.string()};
      }
      std::filesystem::remove(transform_, ignored);
    }
    if (folder_.empty()) return {};
    if (!out_) {
      auto made = OutputFolder::create(folder_);
      if (!made) return made.error();
      out_ = *std::move(made);
    }
    return out_->forget_earlier_run(files());
  }
  Result<void> deliver(const io::Json& json) {
    if (out_) {
      if (auto written = write_json(json, (*out_ / "report.json").string()); !written) {
        return written;
      }
    }
    if (auto written = write_transform(json); !written) return written;
    return write_json(json, json_file_.value_or("-"));
  }
  /// Null: images are not wanted.
  OutputFolder* folder() { return out_ ? &*out_ : nullptr; }

 private:
  Results(std::filesystem::path folder, std::optional<std::string> json_file,
          std::filesystem::path transform)
      : folder_(std::move(folder)),
        json_file_(std::move(json_file)),
        transform_(std::move(transform)) {}
  /// Writes the pose of an accepted registration.
  Result<void> write_transform(const io::Json& json) const {
    const io::Json& registration = json.at("registration");
    if (transform_.empty() || registration.at("accepted") != true) return {};
    const auto numbers = registration.at("ct_from_reference_mm").get<std::vector<double>>();
    NAV_CHECK(numbers.size() == 16);
    const Eigen::Matrix4d matrix =
        Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers.data());
    return io::write_ct_from_reference(matrix, transform_);
  }
  static RunFiles files() {
    const auto names = register_outputs();
    return {{names.begin(), names.end()}, {}};
  }
  std::filesystem::path folder_;
  std::optional<std::string> json_file_;
  std::filesystem::path transform_;  ///< Empty: not wanted.
  std::optional<OutputFolder> out_;
};

struct Ground {
  std::shared_ptr<const Volume> ct;  ///< Absent for registration by landmarks alone.
  std::optional<LandmarkOutcome> landmarks;
};

Result<Ground> read_ground(const SessionConfig& config, const RegisterOptions& options,
                           Console& console) {
  Ground ground;
  if (!config.ct.path.empty()) {
    auto ct = session::read_session_ct(config.ct, console);
    if (!ct) return ct.error();
    ground.ct = std::move(*ct);
  }
  if (!options.landmarks.empty()) {
    auto outcome =
        register_landmark_file(options.landmarks, options.ct_landmarks, ground.ct.get(), console);
    if (!outcome) return outcome.error();
    ground.landmarks = std::move(*outcome);
  }
  return ground;
}

Result<void> register_by_landmarks(const SessionConfig& config, const RegisterOptions& options,
                                   const Ground& ground, Results& results, Console& console) {
  if (auto ok = results.begin(); !ok) return ok;
  const auto& fit = ground.landmarks->fit;
  const Point<frames::Ct> target =
      options.target_ct ? Point<frames::Ct>{*options.target_ct} : fit.uncertainty.centre_ct;
  const auto decision = decide(*ground.landmarks, target);
  report_warnings(decision.warnings, console);
  io::Json json =
      landmark_report(*ground.landmarks, decision, target,
                      {ground.ct.get(), config.ct.path.string()}, config.source.reference_frame);
  add_messages(json, console.entries());
  if (auto written = results.deliver(json); !written) return written;
  if (!decision.accepted) {
    return Error{ErrorCode::kRefused, "registration: refused: " + joined(decision.reasons)};
  }
  return {};
}

/// Start of a registration by shape: landmarks, or the declared matrix.
Result<Transform<frames::Ct, frames::Reference>> shape_start(const SessionConfig& config,
                                                             const Ground& ground) {
  if (ground.landmarks) return ground.landmarks->fit.ct_from_reference;
  if (config.placement.ct_from_reference) {
    return rigid_from_matrix<frames::Ct, frames::Reference>(*config.placement.ct_from_reference);
  }
  return Error{ErrorCode::kUsage,
               "--points requires a start pose by --landmarks or --ct-from-reference"};
}

/// Compares a pose by shape with landmarks. An offset that all points share (of the pointer or of
/// the segmentation) shifts the pose by shape without a residual; only landmarks can show it. Adds
/// a reason against the pose when the two poses are farther apart at the target than their
/// predicted errors explain.
io::Json second_opinion(const Ground& ground, const registration::ShapeRegistration& result,
                        const Point<frames::Ct>& target, registration::Decision& decision) {
  constexpr double kSigmas = 3;
  if (!ground.landmarks) return nullptr;
  const auto& fit = ground.landmarks->fit;
  const Point<frames::Ct> there =
      fit.ct_from_reference * (result.ct_from_reference.inverse() * target);
  const double apart_mm = (there - target).v.norm();
  const double limit_mm = kSigmas * std::hypot(result.tre_rms_mm(target),
                                               registration::predicted_tre_rms_mm(fit, target));
  if (!(apart_mm <= limit_mm)) {
    std::ostringstream text;
    text << std::setprecision(3) << "landmarks and shape: expected poses at most " << limit_mm
         << " mm apart at the target (from their predicted errors), found " << apart_mm << " mm";
    decision.reject(text.str());
  }
  return {{"apart_mm", json_number(apart_mm)}, {"limit_mm", json_number(limit_mm)}};
}

/// Knowledge that rules rivals of a shape out: landmarks, within three times their predicted error
/// over the points, or a start that the user vouches for.
std::optional<registration::KnownPose> known_pose(
    const Ground& ground, const RegisterOptions& options,
    const Transform<frames::Ct, frames::Reference>& start,
    const registration::ShapeRegistration& result) {
  constexpr double kSigmas = 3;
  std::optional<registration::KnownPose> known;
  if (options.shape.start_within_mm) {
    known = {.ct_from_reference = start,
             .within_mm = *options.shape.start_within_mm,
             .tells_sides = false};
  }
  if (!ground.landmarks || !ground.landmarks->no_majority.empty() || ground.landmarks->scale) {
    return known;
  }
  const auto& fit = ground.landmarks->fit;
  double squares = 0;
  for (const auto& p : result.some_points) {
    squares += std::pow(registration::predicted_tre_rms_mm(fit, fit.ct_from_reference * p), 2);
  }
  const double within_mm =
      kSigmas * std::sqrt(squares / static_cast<double>(result.some_points.size()));
  return registration::KnownPose{
      .ct_from_reference = fit.ct_from_reference,
      .within_mm = known ? std::min(within_mm, known->within_mm) : within_mm,
      .tells_sides = !ground.landmarks->mirrored_fre_rms_mm};
}

Result<void> register_by_shape(const SessionConfig& config, const RegisterOptions& options,
                               const Ground& ground, Results& results, Console& console) {
  const auto start = shape_start(config, ground);
  if (!start) return start.error();
  const auto result = register_shape_files(options.shape, *start, console);
  if (!result) return result.error();
  if (auto ok = results.begin(); !ok) return ok;
  const Point<frames::Ct> target =
      options.target_ct ? Point<frames::Ct>{*options.target_ct} : result->uncertainty.centre_ct;
  auto decision = registration::decide(
      *result, registration::ShapeLimits{}, target, registration::kShapeWarnings,
      known_pose(ground, options, *start, *result), options.shape.sigma_mm);
  const io::Json opinion = second_opinion(ground, *result, target, decision);
  report_warnings(decision.warnings, console);
  io::Json json;
  json["verb"] = "register";
  json["version"] = SONDE_VERSION;
  json["method"] = options.shape.surface.empty() ? "vessels" : "surface";
  json["ct"] = config.ct.path.string();
  json["ct_sha256"] = ground.ct ? io::Json(session::ct_digest(*ground.ct)) : io::Json(nullptr);
  json["points"] = options.shape.points.string();
  json["shape"] =
      (options.shape.surface.empty() ? options.shape.centre_lines : options.shape.surface).string();
  json["start"] = {{"kind", ground.landmarks ? "landmarks" : "declared"},
                   {"ct_from_reference_mm", json_of(start->matrix())}};
  json["target_ct_mm"] = as_json(target);
  json["reference_frame"] = config.source.reference_frame.empty()
                                ? io::Json(nullptr)
                                : io::Json(config.source.reference_frame);
  json["registration"] = json_of(*result, decision, target);
  json["registration"]["landmarks"] = opinion;
  add_messages(json, console.entries());
  if (auto written = results.deliver(json); !written) return written;
  if (!decision.accepted) {
    return Error{ErrorCode::kRefused, "registration: refused: " + joined(decision.reasons)};
  }
  return {};
}

/// Value of an option whose to_string() is the given name.
template <class T>
Result<T> one_of(const std::string& option, const std::string& found,
                 std::initializer_list<T> values) {
  std::string expected;
  for (const T value : values) {
    const std::string name = to_string(value);
    if (found == name) return value;
    expected += (expected.empty() ? "" : ", ") + name;
  }
  return Error{ErrorCode::kUsage, option + ": expected one of " + expected + ", found " + found};
}

struct Solver {
  registration::ImageRegistrationOptions options;
  registration::AcceptanceLimits limits;
};

Result<Solver> choose_solver(const RegisterOptions& options) {
  using registration::Effort;
  using registration::PatchLoss;
  using registration::ScaleModel;
  const auto effort = one_of("--effort", options.effort, {Effort::kQuick, Effort::kUsual});
  if (!effort) return effort.error();
  if (*effort == Effort::kQuick && moves(options.motion)) {
    return Error{ErrorCode::kUsage, "--effort quick excludes --breath-period and --deformable"};
  }
  const auto loss = one_of("--loss", options.loss,
                           {PatchLoss::kNone, PatchLoss::kCauchy, PatchLoss::kGemanMcClure});
  if (!loss) return loss.error();
  const auto stretch = one_of("--scale", options.stretch,
                              {ScaleModel::kNone, ScaleModel::kSoundSpeed, ScaleModel::kAffine});
  if (!stretch) return stretch.error();
  registration::ImageRegistrationOptions solver = registration::with_effort(*effort);
  if (options.time_limit_s) solver.time_limit_s = *options.time_limit_s;
  solver.loss.kind = *loss;
  solver.stretch = *stretch;
  solver.calibration_sigma_mm = options.calibration_sigma_mm;
  solver.delay_sigma_s = 1e-3 * options.delay_sigma_ms;
  if (const auto ok = registration::validate(solver); !ok) return ok.error();
  return Solver{solver, registration::limits_for(*effort)};
}

/// Warning about an error of the needle that ultrasound images cannot show; empty for none. A wrong
/// probe calibration may be hidden in the registered pose; a separately tracked needle is then
/// displaced by this error. The warning is given when the hidden error may be large and is not part
/// of the predicted error.
std::string hidden_from_needle(const SessionConfig& config, const RegisterOptions& options,
                               const registration::ImageRegistrationResult& result) {
  constexpr double kMostUnnoticedMm = 2;
  if (config.source.needle_frame.empty() || options.calibration_sigma_mm > 0) return "";
  for (const registration::Misfit& misfit : result.misfits) {
    const bool calibration = misfit.cause == registration::MisfitCause::kCalibration;
    if (!calibration || !(misfit.unnoticed > kMostUnnoticedMm)) continue;
    return "needle: " + registration::unnoticed_in_words({misfit}) +
           ": turn the probe around another axis too, or give the accuracy of its calibration "
           "(--calibration-sigma-mm)";
  }
  return "";
}

Result<Sweep> read_sweep(session::RecordedSession& session, const std::string& calibration_id) {
  std::vector<TrackedImage> frames;
  const auto played = session.play([&](const tracking::PairedImage& paired) {
    if (!paired.tracked) return;
    frames.push_back(*paired.tracked);
    frames.back().frame.colours = {};  // Not needed, and thrice the memory.
  });
  if (!played) return played.error();
  return Sweep::create(std::move(frames), calibration_id);
}

/// Options of the search over the skin, with the declared direction of the probe's marker, if any.
/// Directions are in Ct (LPS).
Result<registration::SkinSearchOptions> choose_search(const SessionConfig& config,
                                                      const RegisterOptions& options) {
  const std::map<std::string, Eigen::Vector3d> directions = {
      {"left", {1, 0, 0}},      {"right", {-1, 0, 0}},   {"posterior", {0, 1, 0}},
      {"anterior", {0, -1, 0}}, {"superior", {0, 0, 1}}, {"inferior", {0, 0, -1}}};
  registration::SkinSearchOptions search;
  if (options.marker_towards.empty()) return search;
  const auto found = directions.find(options.marker_towards);
  if (found == directions.end()) {
    return Error{ErrorCode::kUsage,
                 "--marker-towards: expected right, left, anterior, posterior, superior or "
                 "inferior, found " +
                     options.marker_towards};
  }
  if (config.placement.ct_from_reference || !config.placement.registration.empty() ||
      !options.landmarks.empty()) {
    return Error{ErrorCode::kUsage,
                 "--marker-towards: expected no start pose, because a start pose already says how "
                 "the probe was held, found one"};
  }
  search.marker_towards = found->second;
  return search;
}

/// Registers a sweep from its start pose. Without a start pose it searches over the skin of the
/// whole body and sets start.kind to "skin". If the CT shows no skin that the sweep fits, it starts
/// from the centre rule.
Result<registration::ImageRegistrationResult> register_from(
    session::Placement& start, const Volume& ct, const Sweep& sweep,
    const registration::ImageRegistrationOptions& solver,
    const registration::SkinSearchOptions& search, Console& console) {
  const auto progress = [&](double fraction) {
    console.progress(fraction);
    return true;
  };
  registration::ImageRegistrationOptions from_start = solver;
  if (start.kind == "centred") {
    const auto begin = std::chrono::steady_clock::now();
    auto found = registration::register_on_skin(ct, sweep, solver, search, console, progress);
    if (found) start.kind = "skin";
    // Refused, not a timeout: the user set this limit, and no device failed.
    if (!found && found.error().code == ErrorCode::kTimeout) {
      return Error{ErrorCode::kRefused, found.error().message};
    }
    // If no pose agrees with the declared marker, no other pose may be the answer.
    if (found || search.marker_towards || found.error().code != ErrorCode::kRefused) return found;
    from_start.time_limit_s = std::max(solver.time_limit_s - seconds_since(begin), 1e-9);
    console.report(Severity::kWarning, "register",
                   found.error().message + "; the search starts from: " + start.statement);
  }
  return registration::register_sweep(ct, sweep, start.placement.ct_from_reference, from_start,
                                      console, progress);
}

/// Sweep with the start of its registration.
struct OpenedSweep {
  session::RecordedSession session;
  session::SweepSurvey survey;
  session::Placement start;
  Sweep sweep;
};

Result<OpenedSweep> open_sweep(const SessionConfig& config, const Ground& ground,
                               Console& console) {
  auto session = session::RecordedSession::open(config.source, console);
  if (!session) return session.error();
  auto surveyed = session::survey(*session, config.source.skip_bad_frames);
  if (!surveyed) return surveyed.error();
  if (!surveyed->warning.empty()) {
    console.report(Severity::kWarning, "recording", surveyed->warning);
  }
  auto start = session::place_ct(config.placement, *ground.ct, *surveyed, surveyed->recording,
                                 session->reference_frame());
  if (!start) return start.error();
  if (start->kind == "declared" && !start->outside.empty()) {
    console.report(Severity::kWarning, "start", start->outside);
  }
  if (ground.landmarks) {
    start->placement.ct_from_reference = ground.landmarks->fit.ct_from_reference;
    start->kind = "landmarks";
  }
  auto sweep = read_sweep(*session, config.source.plus_config.string());
  if (!sweep) return sweep.error();
  return OpenedSweep{std::move(*session), std::move(*surveyed), std::move(*start),
                     std::move(*sweep)};
}

/// Contents of report.json for a sweep, without the results.
io::Json report_of(const SessionConfig& config, const RegisterOptions& options, const Volume& ct,
                   const OpenedSweep& opened, const Point<frames::Ct>& target) {
  io::Json json;
  json["verb"] = "register";
  json["version"] = SONDE_VERSION;
  json["method"] = "image";
  json["sweep"] = config.source.recording.string();
  json["ct"] = config.ct.path.string();
  json["ct_sha256"] = session::ct_digest(ct);
  json["recording"] = json_of(opened.survey.recording);
  json["reference"] = opened.session.reference_statement();
  json["reference_frame"] = opened.session.reference_frame();
  const session::Placement& start = opened.start;
  json["start"] = {{"kind", start.kind},
                   {"ct_from_reference_mm",
                    start.kind == "skin" ? io::Json(nullptr)
                                         : json_of(start.placement.ct_from_reference.matrix())}};
  json["target_ct_mm"] = as_json(target);
  json["effort"] = options.effort;
  json["similarity"] = registration::to_string(registration::Similarity::kLc2);
  json["loss"] = options.loss;
  json["calibration_sigma_mm"] = options.calibration_sigma_mm;
  json["delay_sigma_ms"] = options.delay_sigma_ms;
  return json;
}

/// Writes the image with the middle of the sweep before and after registration.
Result<void> write_registration_image(const SessionConfig& config, Results& results,
                                      const Volume& ct, const OpenedSweep& opened,
                                      const Transform<frames::Ct, frames::Reference>& answer,
                                      bool accepted) {
  if (results.folder() == nullptr) return {};
  const auto& frames = opened.sweep.frames();
  const auto window = ct_window(config.view, ct, values_along(ct, answer, frames));
  return results.folder()->write_image(
      kRegistrationImage,
      registration_image(ct, frames[frames.size() / 2], opened.start.placement.ct_from_reference,
                         answer, accepted, window));
}

/// A registration by bone with its report.
struct BoneReport {
  io::Json json;
  registration::Decision decision;
  registration::Pose ct_from_reference;
};

/// Registers an opened sweep by the bone that it shows, from a pose.
Result<BoneReport> report_bone(const SessionConfig& config, const RegisterOptions& options,
                               const Ground& ground, const OpenedSweep& opened,
                               const registration::Pose& from, double time_limit_s,
                               Console& console) {
  const auto begin = std::chrono::steady_clock::now();
  const int threads = config.output.threads > 0 ? usable_threads(config.output.threads) : 2;
  const auto outcome =
      register_bone_of(opened.sweep, *ground.ct, options.shape.surface, from, threads,
                       [&] { return seconds_since(begin) < time_limit_s; });
  if (!outcome) {
    if (outcome.error().code != ErrorCode::kCancelled) return outcome.error();
    return Error{ErrorCode::kRefused, "registration by bone: the time limit was reached"};
  }
  const auto& shape = outcome->result.shape;
  const Point<frames::Ct> target =
      options.target_ct ? Point<frames::Ct>{*options.target_ct} : shape.uncertainty.centre_ct;
  auto decision =
      registration::decide(outcome->result, registration::ShapeLimits{}, target,
                           known_pose(ground, options, from, shape), options.shape.sigma_mm);
  const io::Json opinion = second_opinion(ground, shape, target, decision);
  if (decision.accepted && !opened.survey.warning.empty()) {
    decision.warnings.push_back(opened.survey.warning);
  }
  io::Json json = report_of(config, options, *ground.ct, opened, target);
  json["method"] = "bone";
  json["similarity"] = nullptr;
  json["registration"] = json_of(*outcome, decision, target);
  json["registration"]["landmarks"] = opinion;
  json["registration"]["seconds"] = seconds_since(begin);
  json["ledger"] = json_of(opened.session.navigator().ledger());
  add_messages(json, console.entries());
  return BoneReport{std::move(json), std::move(decision), shape.ct_from_reference};
}

/// Says whether bone would register a sweep that tissue does not. Its pose is not taken: bone alone
/// may fit another vertebra or another patient as well, which the user has to exclude.
void suggest_bone(const SessionConfig& config, const RegisterOptions& options, const Ground& ground,
                  const OpenedSweep& opened, const registration::Pose& from, double time_limit_s,
                  Console& console) {
  const auto report = report_bone(config, options, ground, opened, from, time_limit_s, console);
  if (!report) return;
  console.report(Severity::kInfo, "registration",
                 report->decision.accepted
                     ? "the sweep shows bone that fits the CT: try --by bone, with landmarks or "
                       "--start-within"
                     : "by bone: refused: " + joined(report->decision.reasons));
}

/// Compares a pose by tissue with one by bone, sought from it. Rejects the former if the bone
/// determines a pose that is farther away at the target than the predicted errors explain, or if
/// the sweep shows too little bone.
void judge_by_bone(const SessionConfig& config, const RegisterOptions& options,
                   const Ground& ground, const OpenedSweep& opened,
                   const registration::ImageRegistrationResult& answer,
                   const Point<frames::Ct>& target, registration::Decision& decision,
                   Console& console) {
  constexpr double kSigmas = 3;
  const int threads = config.output.threads > 0 ? usable_threads(config.output.threads) : 2;
  const auto bone = register_bone_of(opened.sweep, *ground.ct, options.shape.surface,
                                     answer.ct_from_reference, threads, {});
  if (!bone) {
    decision.reject("by bone: " + bone.error().message);
    return;
  }
  const auto& shape = bone->result.shape;
  if (!shape.sliding.empty()) {
    console.report(Severity::kInfo, "registration",
                   "by bone: it leaves the " + shape.sliding.front().description +
                       " free, so that it does not judge the pose by tissue");
    return;
  }
  const Point<frames::Ct> there =
      shape.ct_from_reference * (answer.ct_from_reference.inverse() * target);
  const double apart_mm = (there - target).v.norm();
  const double limit_mm = kSigmas * std::hypot(shape.tre_rms_mm(target), answer.tre_rms_mm(target));
  if (apart_mm <= limit_mm) return;
  std::ostringstream text;
  text << std::setprecision(3) << "bone and tissue: expected poses at most " << limit_mm
       << " mm apart at the target (from their predicted errors), found " << apart_mm << " mm";
  decision.reject(text.str());
}

/// Writes report and image of a registration by bone; kRefused if it was not accepted.
Result<void> deliver_bone(const BoneReport& report, const SessionConfig& config,
                          const Ground& ground, const OpenedSweep& opened, Results& results,
                          Console& console) {
  report_warnings(report.decision.warnings, console);
  if (auto written = results.deliver(report.json); !written) return written;
  if (auto written = write_registration_image(config, results, *ground.ct, opened,
                                              report.ct_from_reference, report.decision.accepted);
      !written) {
    return written;
  }
  if (report.decision.accepted) return {};
  return Error{ErrorCode::kRefused, "registration: refused: " + joined(report.decision.reasons)};
}

Result<void> register_by_images(const SessionConfig& config, const RegisterOptions& options,
                                const Ground& ground, Results& results, Console& console) {
  if (!ground.ct) return Error{ErrorCode::kUsage, "--ct: expected a CT, found nothing"};
  const Volume& ct = *ground.ct;
  if (const auto ok = validate(options.motion); !ok) return ok;
  auto chosen = choose_solver(options);
  if (!chosen) return chosen.error();
  registration::ImageRegistrationOptions& solver = chosen->options;
  solver.speed_from_ct = is_hounsfield(ct);
  if (config.output.threads > 0) solver.threads = usable_threads(config.output.threads);
  const auto search = choose_search(config, options);
  if (!search) return search.error();
  auto opened = open_sweep(config, ground, console);
  if (!opened) return opened.error();
  if (auto ok = results.begin(); !ok) return ok;
  if (options.by == "bone" && opened->start.kind != "centred") {
    console.begin("registration by bone");
    const auto report =
        report_bone(config, options, ground, *opened, opened->start.placement.ct_from_reference,
                    solver.time_limit_s, console);
    if (!report) return report.error();
    console.end(registration::in_words(report->decision.verdict()));
    return deliver_bone(*report, config, ground, *opened, results, console);
  }

  console.begin("registration");
  const auto begin = std::chrono::steady_clock::now();
  const auto result = register_from(opened->start, ct, opened->sweep, solver, *search, console);
  if (!result) return result.error();
  const Point<frames::Ct> target = options.target_ct
                                       ? Point<frames::Ct>{*options.target_ct}
                                       : result->ct_from_reference * opened->sweep.centroid();
  console.end(
      registration::in_words(registration::decide(*result, chosen->limits, target).verdict()));
  auto motion = refine_motion(ct, opened->sweep, *result, target, options.motion, solver,
                              chosen->limits, console);
  if (!motion) return motion.error();
  motion->result.total_s = seconds_since(begin);
  const auto& answer = motion->result;
  auto& decision = motion->decision;
  if (options.by == "bone") {
    // Without a start, tissue finds the one for bone.
    const auto report = report_bone(config, options, ground, *opened, answer.ct_from_reference,
                                    solver.time_limit_s, console);
    if (!report) return report.error();
    return deliver_bone(*report, config, ground, *opened, results, console);
  }
  if (options.by == "auto" && !decision.accepted && !moves(options.motion)) {
    suggest_bone(config, options, ground, *opened,
                 opened->start.kind != "skin" ? opened->start.placement.ct_from_reference
                                              : answer.ct_from_reference,
                 solver.time_limit_s, console);
  }
  if (options.by == "both")
    judge_by_bone(config, options, ground, *opened, answer, target, decision, console);
  if (const auto hidden = hidden_from_needle(config, options, answer);
      decision.accepted && !hidden.empty()) {
    decision.warnings.push_back(hidden);
  }
  report_warnings(decision.warnings, console);
  // This warning was reported before the registration; an accepted registration keeps it.
  const std::string& moved = opened->survey.warning;
  if (decision.accepted && !moved.empty()) decision.warnings.push_back(moved);
  if (const auto blind = registration::unnoticed_in_words(answer.misfits); !blind.empty()) {
    console.report(Severity::kInfo, "registration", blind);
  }

  io::Json json = report_of(config, options, ct, *opened, target);
  json["registration"] = json_of(answer, decision, target);
  json["stretch"] = as_json(answer.stretch, options.stretch);
  json.update(motion->json);
  json["ledger"] = json_of(opened->session.navigator().ledger());
  add_messages(json, console.entries());
  if (auto written = results.deliver(json); !written) return written;
  if (auto written = write_registration_image(config, results, ct, *opened,
                                              answer.ct_from_reference, decision.accepted);
      !written) {
    return written;
  }
  if (!decision.accepted) {
    return Error{ErrorCode::kRefused, "registration: refused: " + joined(decision.reasons)};
  }
  std::ostringstream summary;
  summary.precision(2);
  summary << "predicted error at the target " << answer.tre_rms_mm(target) << " mm rms, cost "
          << answer.final_cost;
  console.say(summary.str());
  return {};
}

/// Rejects options that contradict each other or lack the input that they need.
Result<void> reject_contradictions(const SessionConfig& config, const RegisterOptions& options,
                                   const Ground& ground) {
  const auto reject = [](const std::string& text) { return Error{ErrorCode::kUsage, text}; };
  const bool by_shape = !options.shape.points.empty();
  const bool by_images = !config.source.recording.empty();
  const bool moving = moves(options.motion);
  const bool by_bone = by_images && (options.by == "bone" || options.by == "both");
  if (by_bone && moving) {
    return reject("--by " + options.by + " excludes " +
                  (options.motion.breath_period_s ? "--breath-period" : "--deformable"));
  }
  if (by_shape && moving) {
    return reject(std::string("--points excludes ") +
                  (options.motion.breath_period_s ? "--breath-period" : "--deformable") +
                  ", which requires a sweep");
  }
  if (!options.marker_towards.empty() && (by_shape || !by_images)) {
    return reject("--marker-towards requires a sweep");
  }
  if (by_shape && !by_images) return {};
  const bool mesh = !options.shape.surface.empty() && !by_bone;
  if (by_shape || mesh || !options.shape.centre_lines.empty()) {
    return reject(
        "--surface and --centre-lines require --points and exclude a sweep, except --surface with "
        "--by bone or both");
  }
  if (!by_images && moving) {
    return reject("--breath-period and --deformable require a sweep");
  }
  if (!by_images && !ground.landmarks) {
    return reject("register requires a sweep, --points or --landmarks");
  }
  return {};
}

}  // namespace

std::vector<std::string> register_outputs() {
  return {"report.json", "report.html", kRegistrationImage};
}

Result<void> run_register(const SessionConfig& config, const RegisterOptions& options,
                          const std::optional<std::string>& json_file, Console& console) {
  auto results = Results::open(config, options, json_file);
  if (!results) return results.error();
  const auto ground = read_ground(config, options, console);
  if (!ground) return ground.error();
  if (const auto ok = reject_contradictions(config, options, *ground); !ok) return ok;
  if (!config.source.recording.empty()) {
    return register_by_images(config, options, *ground, *results, console);
  }
  if (!options.shape.points.empty()) {
    return register_by_shape(config, options, *ground, *results, console);
  }
  return register_by_landmarks(config, options, *ground, *results, console);
}

}  // namespace nav::app
