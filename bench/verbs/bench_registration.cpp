// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/verbs/bench_registration.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <unistd.h>

#include "bench/registration/bone_curve.hpp"
#include "bench/registration/shape_cohort.hpp"
#include "bench/registration/slice_curve.hpp"
#include "bench/verbs/bench.hpp"
#include "bench/verbs/bench_registration_json.hpp"
#include "bench/verbs/register_by_command.hpp"

namespace nav::bench {
namespace {

// Everything was tuned on the former and nothing on the latter; neither overlaps the seeds of the
// demo, the tests or the acceptance limits.
constexpr std::uint64_t kDevelopmentSeed = 501;
constexpr std::uint64_t kEvaluationSeed = 901;
// The search without a start pose was tuned on these, patients of sim::make_patient().
constexpr std::uint64_t kSkinSeed = 1;
constexpr int kQuickThreads = 2;

/// The bench with its options; parts that follow one another share their patients.
class RegistrationBench {
 public:
  RegistrationBench(const BenchRegistrationOptions& options, app::Console& console)
      : options_(options), console_(console), store_(options.model) {}

  Result<void> run();

 private:
  [[nodiscard]] bool wants(const std::string& part) const { return asks_for(options_.parts, part); }
  [[nodiscard]] CohortOptions cohort(std::uint64_t first_seed) const;
  CohortSummary judge(const std::string& title, std::uint64_t first_seed);
  /// Hands of a quick run: one.
  void choose(std::uint64_t first_seed, sim::HandPathKind quick_hand, SweepChoice& sweeps) const;
  Result<void> measure_faults(const std::string& seeds, std::uint64_t first_seed,
                              std::vector<FaultPoint>& kept);
  void measure_levels();
  Result<void> measure_starts();
  void measure_effort();
  void measure_bootstrap();
  Result<void> compare();
  Result<void> measure_motion();
  Result<void> measure_skin();
  Result<void> measure_live();
  Result<void> measure_shapes();
  Result<void> measure_bone();
  void write(const std::vector<Trial>& trials);
  [[nodiscard]] auto progress() const {
    return [this](double fraction) { console_.progress(fraction); };
  }
  /// Prints what was measured and keeps it in a member.
  template <class T, class Kept>
  Result<void> keep(Result<T> measured, Kept& kept) {
    if (!measured) return measured.error();
    console_.end();
    std::cout << to_text(*measured) << std::flush;
    kept = std::move(*measured);
    return {};
  }
  [[nodiscard]] io::Json json() const;

  const BenchRegistrationOptions& options_;
  app::Console& console_;
  CaseStore store_;
  std::ofstream trials_;
  std::optional<CohortSummary> development_, evaluation_;
  std::vector<FaultPoint> development_faults_, evaluation_faults_;
  std::vector<LevelSummary> levels_;
  std::vector<StartPoint> starts_;
  std::vector<EffortPoint> curve_;
  BootstrapCurve bootstrap_;
  std::vector<SkinCurvePoint> skin_;
  std::vector<MotionPoint> motion_;
  LiveCurve live_;
  std::vector<BoneTrial> shapes_;
  std::vector<BoneFinding> bones_;
  std::optional<PeerComparison> peer_;
};

/// The quick cohort takes all paths, but not for each patient, and fewer distances.
CohortOptions RegistrationBench::cohort(std::uint64_t first_seed) const {
  CohortOptions options = default_cohort(options_.effort);
  options.first_seed = first_seed;
  options.threads = options_.quick ? kQuickThreads : 1;
  if (options_.quick) {
    options.patients = 4;
    options.path_stride = 2;
    options.local_mm = {5, 10};
    options.global_mm = {10, 20, 40};
    options.hopeless_stride = 3;
    options.hopeless_local = false;
    options.keep = first_seed == kDevelopmentSeed;  // The other parts use them.
  }
  if (options_.patients > 0) options.patients = options_.patients;
  return options;
}

CohortSummary RegistrationBench::judge(const std::string& title, std::uint64_t first_seed) {
  console_.begin(title);
  const auto result = run_cohort(cohort(first_seed), store_, progress(),
                                 [&](const auto& trials) { write(trials); });
  console_.end();
  const auto summary = summarise(result);
  std::cout << to_text(summary, title) << std::flush;
  return summary;
}

void RegistrationBench::choose(std::uint64_t first_seed, sim::HandPathKind quick_hand,
                               SweepChoice& sweeps) const {
  sweeps.first_seed = first_seed;
  sweeps.model = options_.model;
  sweeps.effort = options_.effort;
  if (options_.quick) {
    sweeps.patients = 1;
    sweeps.paths = {SweepPath::kSlide};
    sweeps.hands = {quick_hand};
    sweeps.duration_s = 4;
    sweeps.keep = first_seed == kDevelopmentSeed;  // The other parts use it.
  }
  if (options_.patients > 0) sweeps.patients = options_.patients;
}

Result<void> RegistrationBench::measure_faults(const std::string& seeds, std::uint64_t first_seed,
                                               std::vector<FaultPoint>& kept) {
  console_.begin("faults, " + seeds + " seeds");
  FaultCurveOptions faults;
  choose(first_seed, sim::HandPathKind::kSweep, faults.sweeps);
  const auto trials = run_faults(faults, store_, progress());
  if (!trials) return trials.error();
  console_.end();
  kept = count_faults(*trials);
  std::cout << to_text(kept, seeds + " seeds") << std::flush;
  return {};
}

/// Every level of errors on the same patients and paths, the ribs included.
void RegistrationBench::measure_levels() {
  for (const ErrorLevel level : kErrorLevels) {
    const std::string title = std::string("errors: ") + to_string(level);
    CohortOptions options = cohort(kDevelopmentSeed);
    options.paths.push_back(SweepPath::kRibs);
    options.local_mm = {};
    options.global_mm = {5, 20, 40};
    options.hopeless_local = false;
    options.hopeless_stride = 2;
    if (options_.quick) {
      options.patients = 1;
      options.path_stride = 3;
      options.global_mm = {5};
    }
    options.keep = false;
    // A calibration states its own error: of one axis.
    options.global.calibration_sigma_mm = errors_of(level).calibration_mm / std::sqrt(3.0);
    CaseStore store(options_.model, level);
    console_.begin(title);
    const auto result =
        run_cohort(options, store, progress(), [&](const auto& trials) { write(trials); });
    console_.end();
    levels_.push_back({level, summarise(result)});
    std::cout << to_text(levels_.back().summary, title) << std::flush;
  }
}

Result<void> RegistrationBench::measure_starts() {
  console_.begin("from several starts");
  StartCurveOptions starts;
  choose(kDevelopmentSeed, sim::HandPathKind::kRock, starts.sweeps);
  if (options_.quick) starts.starts_mm = {3, 6, 9};
  const auto sweeps = run_starts(starts, store_, progress());
  if (!sweeps) return sweeps.error();
  return keep(Result(count_starts(*sweeps)), starts_);
}

void RegistrationBench::measure_effort() {
  console_.begin("run time against error");
  EffortOptions effort;
  effort.first_seed = kDevelopmentSeed;
  effort.local = default_cohort().local;
  if (options_.quick) {
    effort.threads = kQuickThreads;
    effort.patients = 1;
    effort.paths = {SweepPath::kSubcostal, SweepPath::kSlide};
    effort.patch_shares = {0.25, 1, 4};
    effort.image_strides = {4, 2};
    effort.iterations = {2};
    effort.sample_steps_mm = {1.6};
    effort.quick_shares = {1};
  }
  curve_ = bench::measure_effort(effort, store_, progress());
  console_.end();
  console_.begin("thick slices");
  SliceOptions slices;
  slices.first_seed = kDevelopmentSeed;
  slices.local = effort.local;
  if (options_.quick) {
    slices.patients = 2;
    slices.thickness_mm = {2, 5};
    slices.keep = true;  // The other parts use them.
  }
  const auto by_thickness = measure_slices(slices, store_, progress());
  curve_.insert(curve_.end(), by_thickness.begin(), by_thickness.end());
  console_.end();
  std::cout << to_text(curve_) << std::flush;
}

void RegistrationBench::measure_bootstrap() {
  console_.begin("resampled images");
  BootstrapCurveOptions bootstrap;
  bootstrap.first_seed = kDevelopmentSeed;
  if (options_.quick) {
    bootstrap.patients = 1;
    bootstrap.paths = {SweepPath::kSubcostal};
    bootstrap.solved = 20;
  }
  if (options_.patients > 0) bootstrap.patients = options_.patients;
  bootstrap_ = bench::measure_bootstrap(bootstrap, store_, progress());
  console_.end();
  std::cout << to_text(bootstrap_) << std::flush;
}

Result<void> RegistrationBench::compare() {
  console_.begin("beside elastix");
  PeerOptions options;
  options.first_seed = kDevelopmentSeed;
  if (options_.quick) {
    options.patients = 1;
    options.starts_mm = {5};
    options.repeats = 1;
    options.efforts = {{100, 2000, 1}, {150, 2000, 1}};
  }
  if (options_.patients > 0) options.patients = options_.patients;
  std::string folder = (std::filesystem::temp_directory_path() / "sonde-elastix-XXXXXX").string();
  if (mkdtemp(folder.data()) == nullptr) {
    return Error{ErrorCode::kIo, folder + ": expected to make a folder for elastix"};
  }
  options.by_command = [&](const Sweep& sweep, const std::filesystem::path& ct, const CtPose& start,
                           registration::Effort effort) {
    return register_by_command(sweep, ct, start, effort, folder);
  };
  auto compared = compare_with_elastix(options, store_, find_elastix(), folder, progress());
  std::error_code ignored;
  std::filesystem::remove_all(folder, ignored);
  return keep(std::move(compared), peer_);
}

Result<void> RegistrationBench::measure_motion() {
  console_.begin("patients who breathe");
  MotionCurveOptions options;
  options.first_seed = kDevelopmentSeed;
  options.model = options_.model;
  if (options_.quick) {
    options.patients = 1;
    options.duration_s = 8;
    options.kinds = {sim::BreathingKind::kSmooth};
    options.image_strides = {2, 1};
    options.harmonics = {1};
  }
  if (options_.patients > 0) options.patients = options_.patients;
  return keep(bench::measure_motion(options, progress()), motion_);
}

Result<void> RegistrationBench::measure_live() {
  console_.begin("following patients who breathe");
  LiveCurveOptions options;
  options.first_seed = kDevelopmentSeed;
  options.model = options_.model;
  if (options_.quick) {
    options.patients = 2;
    options.duration_s = 5;
    options.kinds = {sim::BreathingKind::kRigid};
    options.windows = {1, 3};
    options.patches = {300};
  }
  if (options_.patients > 0) options.patients = options_.patients;
  return keep(bench::measure_live(options, progress()), live_);
}

Result<void> RegistrationBench::measure_skin() {
  console_.begin("without a start pose");
  SkinCurveOptions options;
  options.first_seed = kSkinSeed;
  options.model = options_.model;
  if (options_.quick) {
    options.patients = 1;
    options.paths = {sim::HandPathKind::kTilt};
    options.tried = {100, registration::SkinSearchOptions().tried + 0.0};
    options.spacings_mm = {};
    options.turns = {};
  }
  if (options_.patients > 0) options.patients = options_.patients;
  return keep(bench::measure_skin(options, progress()), skin_);
}

Result<void> RegistrationBench::measure_shapes() {
  console_.begin("points on surfaces");
  BoneCohortOptions options;
  options.first_seed = kDevelopmentSeed;
  options.runs = 8;
  if (options_.quick) {
    options.bones = kBoneKinds;
    options.runs = 1;
  }
  return keep(run_bones(options, progress()), shapes_);
}

Result<void> RegistrationBench::measure_bone() {
  console_.begin("bone in images");
  BoneCurveOptions options;
  options.first_seed = kDevelopmentSeed;
  if (options_.quick) {
    options.sweeps = 1;
    options.images = 12;
    options.levels = {ErrorLevel::kGood};
  }
  return keep(measure_bones(options, progress()), bones_);
}

/// At once: a long run can be looked at while it lasts.
void RegistrationBench::write(const std::vector<Trial>& trials) {
  if (trials_.is_open()) trials_ << to_csv(trials) << std::flush;
}

io::Json RegistrationBench::json() const {
  io::Json json;
  json["verb"] = "bench registration";
  json["version"] = SONDE_VERSION;
  json["quick"] = options_.quick;
  json["simulated"] = true;
  json["effort"] = registration::to_string(options_.effort);
  json["model"] = options_.model == sim::AcousticModel::kRays ? "rays" : "scatterers";
  const auto& headline = evaluation_ ? evaluation_ : development_;
  json["summary"] = headline ? json_of(*headline) : io::Json::object();
  io::Json& summary = json["summary"];
  const auto ratios = peer_ ? peer_->ratios : std::nullopt;
  summary["cpu_ratio_elastix"] = ratios ? app::json_number(ratios->cpu) : io::Json(nullptr);
  summary["solve_cpu_ratio_elastix"] = ratios ? app::json_number(ratios->solve) : io::Json(nullptr);
  summary["end_to_end_cpu_ratio_elastix"] =
      ratios ? app::json_number(ratios->end_to_end) : io::Json(nullptr);
  summary["peer_ours"] = ratios ? io::Json(ratios->ours) : io::Json(nullptr);
  summary["peer_theirs"] = ratios ? io::Json(ratios->theirs) : io::Json(nullptr);
  const std::string reason = peer_ ? peer_->reason : "not asked for";
  summary["cpu_ratio_elastix_reason"] = ratios ? io::Json(nullptr) : io::Json(reason);
  add_totals(evaluation_faults_.empty() ? development_faults_ : evaluation_faults_, summary);
  const bool evaluated = evaluation_ || !evaluation_faults_.empty();
  json["summary_seeds"] = evaluated ? "evaluation" : "development";
  if (development_) json["development"] = json_of(*development_);
  json["faults"] = json_of(development_faults_, "development");
  for (const io::Json& row : json_of(evaluation_faults_, "evaluation"))
    json["faults"].push_back(row);
  json["levels"] = json_of(levels_);
  json["starts"] = json_of(starts_);
  json["curve"] = json_of(curve_);
  json["bootstrap"] = json_of(bootstrap_);
  json["skin"] = json_of(skin_);
  json["motion"] = json_of(motion_);
  json["live"] = json_of(live_);
  json["shapes"] = json_of(shapes_);
  json["bone"] = json_of(bones_);
  json["peer"] = peer_ ? json_of(*peer_) : io::Json::array();
  return json;
}

Result<void> RegistrationBench::run() {
  std::cout << "Simulated patients only: nothing here is clinical accuracy.\n";
  if (options_.trials) {
    trials_.open(*options_.trials);
    trials_ << csv_header();
  }
  if (wants("cohort")) {
    development_ = judge("development seeds", kDevelopmentSeed);
    if (options_.evaluate) evaluation_ = judge("evaluation seeds", kEvaluationSeed);
  }
  if (wants("faults")) {
    if (auto ok = measure_faults("development", kDevelopmentSeed, development_faults_); !ok) {
      return ok;
    }
    if (options_.evaluate) {
      if (auto ok = measure_faults("evaluation", kEvaluationSeed, evaluation_faults_); !ok) {
        return ok;
      }
    }
  }
  if (wants("levels")) measure_levels();
  if (wants("starts")) {
    if (auto ok = measure_starts(); !ok) return ok;
  }
  if (wants("curve")) measure_effort();
  if (wants("bootstrap")) measure_bootstrap();
  if (wants("skin")) {
    if (auto ok = measure_skin(); !ok) return ok;
  }
  if (wants("motion")) {
    if (auto ok = measure_motion(); !ok) return ok;
  }
  if (wants("live")) {
    if (auto ok = measure_live(); !ok) return ok;
  }
  if (wants("shapes")) {
    if (auto ok = measure_shapes(); !ok) return ok;
  }
  if (wants("bone")) {
    if (auto ok = measure_bone(); !ok) return ok;
  }
  if (wants("peer")) {
    if (auto ok = compare(); !ok) return ok;
  }
  if (options_.trials && !trials_) {
    return Error{ErrorCode::kIo, *options_.trials + ": expected to write the trials"};
  }
  if (!options_.json) return {};
  return app::write_json(json(), *options_.json);
}

}  // namespace

Result<void> run_bench_registration(const BenchRegistrationOptions& options,
                                    app::Console& console) {
  return RegistrationBench(options, console).run();
}

}  // namespace nav::bench
