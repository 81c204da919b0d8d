// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/image_registration.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <sstream>
#include <utility>

#include "nav/index.hpp"
#include "nav/stopwatch.hpp"
#include "registration/assessment.hpp"
#include "registration/error_solver.hpp"
#include "registration/image_strain.hpp"
#include "registration/pose_solver.hpp"
#include "registration/prepared.hpp"
#include "registration/regions.hpp"
#include "registration/search/basin.hpp"
#include "registration/search/global_search.hpp"
#include "registration/similarity/ct_structure.hpp"
#include "registration/similarity/patch_channels.hpp"
#include "registration/similarity/sound_shift.hpp"
#include "registration/similarity/sweep_points.hpp"
#include "registration/uncertainty/image_bootstrap.hpp"
#include "registration/uncertainty/joint_uncertainty.hpp"
#include "registration/uncertainty/sandwich.hpp"

namespace nav::registration {
namespace {

// Number of distinct poses that continue to the next level, besides the plain one.
constexpr std::size_t kKeptCandidates = 3;
constexpr std::size_t kKeptOnFinest = 2;
// Poses this close are one candidate during the solve, and one minimum at the end.
constexpr double kSameCandidateMm = 1.0;
constexpr double kSameMinimumMm = 5.0;
// Relative cost change at which the final solve is finished: 0.03 mm with samples of 1.2 mm. The
// cost grows with the square of the error, and the error of fewer, coarser samples grows with the
// square of their step.
constexpr double kFineTolerance = 2e-5;
constexpr double kFineStepMm = 1.2;
// The finest level starts with every fourth patch, if that leaves enough.
constexpr std::size_t kFirstStride = 4;
constexpr std::size_t kLeastFirst = 300;
constexpr double kLeastCost = 1e-12;
// Largest step, relative to the finest samples' step, for which the gradients beside the pose are
// also used for the curvature.
constexpr double kSharedSteps = 0.5;
constexpr double kSolveProgress = 0.9;
// Fraction of the patches of the finest level that judge a pose: those of highest contrast. Over
// all patches a right pose costs 0.6 and a wrong one hardly more; over these patches they cost 0.2
// and 0.4. The fraction includes patches without CT structure; otherwise a pose where the CT has
// none would be the best.
constexpr double kJudgingShare = 0.12;
// Delays that a solve on the level before the finest begins with, s, and what they must change.
constexpr std::array<double, 5> kTriedDelaysS{-0.4, -0.2, 0, 0.2, 0.4};
constexpr double kWideDelayS = 10;
/// Standard deviation of the depth factor where the speed of sound is in doubt.
constexpr double kWideScale = 0.1;
constexpr double kLeastDelayMm = 1.5;
constexpr int kDelayIterations = 8;
// A probe that is pressed by as much moves the tissue near it by more than patches reach.
constexpr double kTriedPressedMm = 8;
// Costs that differ by less do not tell whether the speed of sound is that of the CT.
constexpr double kSoundInDoubt = 0.03;
// Fat of 10 to 30 mm under the skin shows all below it 0.6 to 1.9 mm too deep.
constexpr double kLayersMm = 0.8;
// Errors are believed if they lower the cost by more than chance does: twice what as many unknowns
// lower the sum of squares of independent patches by. Patches lie half over their neighbours.
constexpr double kPatchesPerIndependent = 4;
constexpr double kTellingPerError = 2;
// The deviation of a delay comes from few independent places: by chance, twice as much is found.
constexpr double kClearDeviations = 2.5;
constexpr double kClearlyLess = 0.9;

/// The CT of one level.
struct LevelCt {
  std::shared_ptr<const CtChannels> channels;
  std::shared_ptr<PatchChannels> near;  ///< If set, the channels have no texels.
};

/// The part of the CT that a level needs.
struct LevelReach {
  std::function<CtBox()> box;
  const PreparedLevel& level;
  const std::vector<Pose>& poses;  ///< Start poses of the solves; empty on the first level.
};
using ChannelsOf = std::function<Result<LevelCt>(const LevelReach& reach)>;

/// One level, ready to be evaluated.
struct Level {
  const PreparedLevel& prepared;
  LevelCt ct;
  double channels_s;
  SimilarityCost cost;
  [[nodiscard]] const PatchSet& patches() const { return prepared.patches; }
};

struct LevelSolve {
  double initial_cost, final_cost, seconds;
  int iterations, candidates;
};

/// The patches that judge a pose of the finest level.
PatchSet judging(const PreparedLevel& level, int least_judging) {
  const auto& all = level.patches.patches;
  const auto share = static_cast<std::size_t>(kJudgingShare * static_cast<double>(all.size()));
  const std::size_t count = std::max(share, as_size(least_judging));
  // Patches chosen by contrast are already this fraction.
  if (level.options.choice == PatchChoice::kContrast || count >= all.size()) return level.patches;
  std::vector<double> contrasts;
  contrasts.reserve(all.size());
  for (const Patch& patch : all) contrasts.push_back(patch.norm_grey);
  const auto last = contrasts.begin() + static_cast<std::ptrdiff_t>(count - 1);
  std::nth_element(contrasts.begin(), last, contrasts.end(), std::greater<>());
  const double least = *last;
  return subset(level.patches, [&](const Patch& patch) { return patch.norm_grey >= least; });
}

/// A pose that is followed through the levels.
struct Candidate {
  PoseSolution solution;
  bool plain;  ///< Descends from the initial pose alone: never dropped.
  std::vector<LevelSolve> history;
  ImageErrors errors = {};  ///< Found on the levels so far.
};

class Registrar {
 public:
  Registrar(const VoxelGrid& ct, ChannelsOf channels_of, const PreparedSweep& sweep,
            const Pose& initial, const ImageRegistrationOptions& options,
            const std::function<bool(double)>& progress)
      : ct_(ct),
        channels_of_(std::move(channels_of)),
        sweep_(sweep),
        initial_(initial),
        options_(options),
        progress_(progress),
        measure_(measure_of(options.similarity)),
        points_(sweep.points()),
        judging_(judging(sweep.levels().back(), options.least_judging)) {
    levels_.reserve(sweep.levels().size());
  }

  Result<ImageRegistrationResult> run();

 private:
  /// Prepares the next level, with the CT near the poses that the level before found.
  Result<void> add_level();
  void solve_starts(const Level& level);
  void solve_candidates(const Level& level, std::size_t keep);
  PoseSolution solve(const Level& level, const Candidate& candidate);
  PoseSolution solve_on(const Level& level, const PatchSet& patches, const Pose& start,
                        double tolerance);
  PoseSolution solve_where_structured(const Level& level, const Candidate& candidate);
  void add_initial(const Level& level);
  void try_delays(const Level& level, Candidate& candidate);
  void refine_tissue(Candidate& best, const ErrorSigmas& all);
  void refine_delay(Candidate& best);
  [[nodiscard]] PatchSet chosen_at(const Candidate& candidate) const;
  [[nodiscard]] LocalShape shape_at(const Candidate& candidate, const PatchSet& patches) const;
  double refine_errors(Candidate& best, const ErrorSigmas& sigmas, const PatchSet& chosen,
                       double telling = kTellingPerError);
  void add_patients_misfit(std::vector<Misfit>& misfits) const;
  /// Errors that are estimated with the pose.
  [[nodiscard]] ErrorSigmas sigmas() const {
    // A calibration rotates about its phantom, which need not lie in the middle of the images.
    const double shift_mm = options_.calibration_sigma_mm;
    return {.delay_s = options_.delay_sigma_s,
            .depth_scale = options_.stretch == ScaleModel::kSoundSpeed
                               ? std::max(kWideScale, options_.scale_sigma)
                               : options_.scale_sigma,
            .width_scale = options_.scale_sigma,
            .pressed_mm = options_.pressed_sigma_mm,
            .turn_rad = shift_mm / kRotationScaleMm,
            .shift_mm = std::sqrt(2.0) * shift_mm,
            .layers_mm = options_.speed_from_ct ? kLayersMm : 0};
  }
  [[nodiscard]] bool estimates_errors() const {
    return measure_.by_patch() != nullptr && !sigmas().vector().isZero(0);
  }
  /// Patches of the finest level where their echoes come from, once the speed of sound is known.
  [[nodiscard]] PatchSet sounded(PatchSet patches) const {
    if (sound_.empty()) return patches;
    for (Patch& patch : patches.patches) {
      patch.centre_mm -= static_cast<double>(sound_[patch.index]) * patch.beam;
    }
    return patches;
  }
  [[nodiscard]] PatchSet without(const ImageErrors& errors, const PatchSet& patches) const {
    return corrected(sounded(patches), errors, sweep_.motions(), sweep_.path());
  }
  [[nodiscard]] bool finest(const Level& level) const {
    return &level.prepared == &sweep_.levels().back();
  }
  /// The cost that a solve on these patches minimises: with the loss on the finest level.
  [[nodiscard]] SimilarityCost solved_cost(const Level& level, const PatchSet& patches) const {
    return level.cost.on(patches).robust(finest(level) ? options_.loss : RobustLoss{});
  }
  [[nodiscard]] PatchSet structured(const Level& level, const Pose& pose,
                                    const PatchSet& patches) const;
  void drop_duplicates(std::size_t keep);
  bool lost(const Candidate& best, const Candidate& other);
  [[nodiscard]] std::optional<double> margin(const Candidate& best) const;
  [[nodiscard]] double initial_cost(const Level& level) const;
  [[nodiscard]] ImageRegistrationResult report(const Candidate& best);
  [[nodiscard]] JointCovariance joint_covariance_of(const Candidate& best, const LocalShape& shape,
                                                    const PatchSet& patches) const;
  void strain(Candidate& best);
  bool keep_going();
  /// True if the time limit is exceeded; the caller then stops early.
  bool late() {
    hurried_ = hurried_ || seconds_since(start_) > options_.time_limit_s;
    return hurried_;
  }
  SolveLimits limits(double tolerance) {
    return {late() ? 0 : options_.max_iterations, tolerance, [this] { return late(); }};
  }
  [[nodiscard]] Error cancelled() const {
    return {ErrorCode::kCancelled, "image registration: cancelled by the caller"};
  }

  const VoxelGrid& ct_;
  ChannelsOf channels_of_;
  const PreparedSweep& sweep_;
  const Pose& initial_;
  const ImageRegistrationOptions& options_;
  const std::function<bool(double)>& progress_;
  const SimilarityMeasure& measure_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  const SweepPoints& points_;
  std::vector<Level> levels_;  // Only the levels begun so far.
  std::vector<Candidate> candidates_;
  PatchSet judging_;          // Patches of the finest level.
  std::vector<float> sound_;  // Shifts on the finest level (sound_shift.hpp), once they are known.
  // Half of what the pose depends on the speed of sound, if the images do not tell which fits.
  double sound_doubt_mm_ = 0;
  std::optional<double> lost_margin_;
  ImageScale stretch_;
  std::optional<Candidate> before_errors_;  // The chosen one, if errors were then estimated.
  std::optional<Candidate> undelayed_;      // The chosen one, if a delay was then estimated.
  double fraction_ = 0;
  bool cancelled_ = false;
  bool hurried_ = false;
  int non_finite_ = 0;
};

bool Registrar::keep_going() {
  if (!cancelled_ && progress_ && !progress_(fraction_)) cancelled_ = true;
  return !cancelled_;
}

/// First level: the plain solve, and a search if the plain solve is not clearly right.
void Registrar::solve_starts(const Level& level) {
  const auto start = std::chrono::steady_clock::now();
  const SearchOptions box{.starts = options_.starts,
                          .range_mm = options_.start_range_mm,
                          .range_rad = options_.start_range_rad,
                          .max_iterations = options_.max_iterations,
                          .seed = options_.seed,
                          .threads = options_.threads};
  for (Found& found : search(
           level.cost, initial_, points_, box, [this] { return keep_going() && !late(); },
           non_finite_)) {
    const PoseSolution& solution = found.solution;
    const LevelSolve solve{.initial_cost = solution.initial_cost,
                           .final_cost = solution.final_cost,
                           .seconds = 0,
                           .iterations = solution.iterations,
                           .candidates = 0};
    candidates_.push_back({std::move(found.solution), found.plain, {solve}});
  }
  for (Candidate& candidate : candidates_) {
    candidate.history.back().seconds = seconds_since(start);
    candidate.history.back().candidates = static_cast<int>(candidates_.size());
  }
  drop_duplicates(kKeptCandidates);
}

/// Patches that can distinguish nearby poses. A measure of all samples uses all.
PatchSet Registrar::structured(const Level& level, const Pose& pose,
                               const PatchSet& patches) const {
  if (measure_.by_patch() == nullptr) return patches;
  // The level before, if it has channels of its own.
  const Level* before = &level != &levels_.front() ? &level - 1 : nullptr;
  const bool smoother = before != nullptr && before->ct.near == nullptr;
  return with_ct_structure(*level.ct.channels, patches, pose, options_.min_ct_contrast_hu,
                           level.ct.near.get(), smoother ? before->ct.channels.get() : nullptr);
}

PoseSolution Registrar::solve(const Level& level, const Candidate& candidate) {
  if (finest(level) && sweep_.levels().size() > 1) return solve_where_structured(level, candidate);
  return solve_on(level, without(candidate.errors, level.patches()), candidate.solution.pose,
                  kCoarseTolerance);
}

PoseSolution Registrar::solve_on(const Level& level, const PatchSet& patches, const Pose& start,
                                 double tolerance) {
  return solve_pose(solved_cost(level, patches), start, points_.centroid, limits(tolerance),
                    [this] { return keep_going(); });
}

/// Solves with the patches in which the CT has structure, and judges with the patches of highest
/// ultrasound contrast.
PoseSolution Registrar::solve_where_structured(const Level& level, const Candidate& candidate) {
  const Pose& start = candidate.solution.pose;
  const PatchSet patches = without(candidate.errors, level.patches());
  // A part of the patches covers most of the distance; all patches then need only a step or two.
  std::size_t index = 0;
  std::optional<PoseSolution> near;
  if (patches.patches.size() / kFirstStride >= kLeastFirst) {
    const PatchSet some = structured(
        level, start, subset(patches, [&](const Patch&) { return index++ % kFirstStride == 0; }));
    if (some.patches.size() >= kLeastFirst) near = solve_on(level, some, start, kCoarseTolerance);
  }
  const Pose& from = near ? near->pose : start;
  const double coarser = level.prepared.options.sample_step_mm / kFineStepMm;
  PoseSolution solution = solve_on(level, structured(level, from, patches), from,
                                   kFineTolerance * std::pow(coarser, measure_.tolerance_power()));
  if (near) solution.iterations += near->iterations;
  const PatchSet judging = without(candidate.errors, judging_);
  const SimilarityCost judge = level.cost.on(judging);
  const CostTerms before = judge.cost(start);
  const CostTerms after = judge.cost(solution.pose);
  solution.initial_cost = before.cost;
  solution.final_cost = after.cost;
  solution.non_finite = std::max({solution.non_finite, before.non_finite, after.non_finite});
  return solution;
}

/// The initial pose competes on every level, not only as a start of the coarsest: a coarse level
/// may lead away from it. Without seeded starts it is followed alone in any case.
void Registrar::add_initial(const Level& level) {
  const auto cost_at = [&](const Pose& pose) { return level.cost.cost(pose).cost; };
  double least = 1;
  for (const Candidate& candidate : candidates_) {
    if (distance_mm(points_, candidate.solution.pose, initial_) < kSameCandidateMm) return;
    least = std::min(least, cost_at(candidate.solution.pose));
  }
  const double cost = cost_at(initial_);
  if (cost > kLostRatio * least) return;
  const LevelSolve solve{
      .initial_cost = cost, .final_cost = cost, .seconds = 0, .iterations = 0, .candidates = 0};
  PoseSolution solution = candidates_.front().solution;
  solution.pose = initial_;
  candidates_.push_back(
      {std::move(solution), true, std::vector<LevelSolve>(levels_.size() - 1, solve)});
}

/// Looks for a delay that is longer than a solve from no delay finds: a long one moves the images
/// by more than the patches of the finest level reach.
void Registrar::try_delays(const Level& level, Candidate& candidate) {
  if (!estimates_errors() || options_.delay_sigma_s <= 0) return;
  double fastest_mm_s = 0;
  for (const ImageMotion& motion : sweep_.motions()) {
    fastest_mm_s = std::max(fastest_mm_s, motion.velocity_mm_s.norm());
  }
  if (fastest_mm_s * kTriedDelaysS.back() < kLeastDelayMm) return;
  const ErrorSigmas delay_only{.delay_s = kWideDelayS, .depth_scale = 0, .width_scale = 0};
  SolveLimits few = limits(kCoarseTolerance);
  few.max_iterations = std::min(few.max_iterations, kDelayIterations);
  std::optional<ErrorSolution> best;
  for (const double delay_s : kTriedDelaysS) {
    if (!keep_going() || late()) return;
    ErrorSolution found =
        solve_errors(solved_cost(level, level.patches()), candidate.solution.pose,
                     {.delay_s = delay_s}, points_.centroid, delay_only, sweep_.motions(),
                     sweep_.path(), limits(kCoarseTolerance), [this] { return keep_going(); });
    non_finite_ = std::max(non_finite_, found.pose.non_finite);
    if (!best || found.pose.final_cost < best->pose.final_cost) best = std::move(found);
  }
  if (!best || best->pose.final_cost > kClearlyLess * candidate.solution.final_cost) return;
  candidate.solution.pose = best->pose.pose;
  candidate.solution.final_cost = best->pose.final_cost;
  candidate.errors = best->errors;
}

/// Patches of a level as recorded that have an index among the chosen, every stride-th of them.
PatchSet as_recorded(const PatchSet& all, const PatchSet& chosen, std::size_t stride = 1) {
  std::vector<bool> used(all.patches.size(), false);
  for (std::size_t i = 0; i < chosen.patches.size(); i += stride) {
    used[chosen.patches[i].index] = true;
  }
  return subset(all, [&](const Patch& patch) { return used[patch.index]; });
}

/// Number of independent patches that as many overlapping ones stand for.
double independent_of(const PatchSet& patches) {
  return static_cast<double>(patches.patches.size()) / kPatchesPerIndependent;
}

/// Patches of the finest level with structure in the CT at a pose.
PatchSet Registrar::chosen_at(const Candidate& candidate) const {
  const Level& level = levels_.back();
  return structured(level, candidate.solution.pose, without(candidate.errors, level.patches()));
}

/// Shape of the cost of the finest level's patches at a pose.
LocalShape Registrar::shape_at(const Candidate& candidate, const PatchSet& patches) const {
  const Level& level = levels_.back();
  const Pose& pose = candidate.solution.pose;
  return local_shape(solved_cost(level, patches), pose, pose * points_.centroid,
                     kCurvatureSteps * level.prepared.options.sample_step_mm);
}

/// Refines the chosen pose together with the errors of the system: first with a part of the chosen
/// patches, which covers most of the distance. Keeps the pose as it was if each error explains less
/// than \p telling times what chance does. Returns the cost of the patches with that of the errors'
/// prior.
double Registrar::refine_errors(Candidate& best, const ErrorSigmas& sigmas, const PatchSet& chosen,
                                double telling) {
  constexpr double kUnknown = std::numeric_limits<double>::infinity();
  const Level& level = levels_.back();
  if (chosen.patches.size() < kMinPatches) return kUnknown;
  double with_prior = kUnknown;
  const double coarser = level.prepared.options.sample_step_mm / kFineStepMm;
  const bool many = chosen.patches.size() / kFirstStride >= kLeastFirst;
  const Candidate before = best;
  for (const std::size_t stride : {kFirstStride, std::size_t{1}}) {
    if (stride > 1 && !many) continue;
    if (!keep_going() || late()) return kUnknown;
    const PatchSet patches = as_recorded(level.patches(), chosen, stride);
    const double tolerance = stride > 1 ? kCoarseTolerance : kFineTolerance * std::pow(coarser, 4);
    const auto from = [&](const ImageErrors& errors) {
      return solve_errors(solved_cost(level, sounded(patches)), best.solution.pose, errors,
                          points_.centroid, sigmas, sweep_.motions(), sweep_.path(),
                          limits(tolerance), [this] { return keep_going(); });
    };
    ErrorSolution found = from(best.errors);
    if (stride > 1 && sigmas.pressed_mm > 0 && best.errors.pressed_mm == 0) {
      ImageErrors pressed = best.errors;
      pressed.pressed_mm = kTriedPressedMm;
      ErrorSolution other = from(pressed);
      if (other.pose.final_cost < found.pose.final_cost) found = std::move(other);
    }
    non_finite_ = std::max(non_finite_, found.pose.non_finite);
    with_prior = found.pose.final_cost;
    found.pose.iterations += best.solution.iterations;
    found.pose.initial_cost = best.solution.initial_cost;
    best.solution = std::move(found.pose);
    best.errors = found.errors;
  }
  const auto cost_of = [&](const Candidate& candidate) {
    const PatchSet moved = without(candidate.errors, as_recorded(level.patches(), chosen));
    return solved_cost(level, moved).cost(candidate.solution.pose).cost;
  };
  const double after = cost_of(best);
  const auto estimated = static_cast<double>((sigmas.vector().array() > 0).count());
  if (!((cost_of(before) - after) * independent_of(chosen) > telling * estimated * after)) {
    best.solution.pose = before.solution.pose;
    best.errors = before.errors;
    with_prior = cost_of(before);
  } else if (!before_errors_) {
    before_errors_ = before;
  }
  const PatchSet judging = without(best.errors, judging_);
  best.solution.final_cost = level.cost.on(judging).cost(best.solution.pose).cost;
  best.history.back().iterations = best.solution.iterations;
  best.history.back().final_cost = best.solution.final_cost;
  return with_prior;
}

/// Refines the pose together with the delay of the images. Along an almost even path a delay lowers
/// the cost by hardly more than chance does, but left out it stays in the pose as a whole; along an
/// even path it looks like a shift of the pose. It is kept if it is clearly more than its
/// deviation.
void Registrar::refine_delay(Candidate& best) {
  const ErrorSigmas delay{.delay_s = sigmas().delay_s, .depth_scale = 0, .width_scale = 0};
  Candidate delayed = best;
  std::optional<Candidate> before = before_errors_;
  refine_errors(delayed, delay, chosen_at(delayed), 0);
  if (delayed.errors.delay_s == best.errors.delay_s) return;
  const PatchSet patches = chosen_at(delayed);
  const JointCovariance joint = joint_covariance_of(delayed, shape_at(delayed, patches), patches);
  const double deviation_s = std::sqrt(std::max(joint.errors(0, 0), 0.0));
  if (joint.pose.valid && std::abs(delayed.errors.delay_s) > kClearDeviations * deviation_s) {
    undelayed_ = std::exchange(best, std::move(delayed));
  } else {
    before_errors_ = std::move(before);
  }
}

/// Refines what the probe presses away and the scale of the depth, with one speed of sound and with
/// the speed along each beam from the CT; keeps what fits better. It is looked for before the
/// errors of the system, and before motion and deformation of the patient: it must not be taken for
/// them.
void Registrar::refine_tissue(Candidate& best, const ErrorSigmas& all) {
  const ErrorSigmas tissue{
      .delay_s = 0, .depth_scale = all.depth_scale, .width_scale = 0, .pressed_mm = all.pressed_mm};
  const PatchSet chosen = chosen_at(best);
  Candidate layered = best;
  const double one_speed = refine_errors(best, tissue, chosen);
  const Level& whole = levels_.front();
  if (options_.speed_from_ct && whole.ct.near == nullptr && !late()) {
    sound_ = sound_shifts_mm(*whole.ct.channels, levels_.back().patches(), layered.solution.pose);
    // The pose belongs to these speeds, whether or not errors are then found with it.
    layered.solution.pose =
        solve_on(levels_.back(),
                 without(layered.errors, as_recorded(levels_.back().patches(), chosen)),
                 layered.solution.pose, kCoarseTolerance)
            .pose;
    const double by_ct = refine_errors(layered, tissue, chosen);
    if (std::abs(by_ct - one_speed) < kSoundInDoubt * one_speed) {
      const auto apart =
          layered.solution.pose * points_.centroid - best.solution.pose * points_.centroid;
      sound_doubt_mm_ = 0.5 * apart.v.norm();
    }
    // Tissue has its own speeds: one speed for all must fit better by more than chance.
    const double independent = independent_of(chosen);
    if (by_ct * independent < (independent + kTellingPerError) * one_speed) {
      best = std::move(layered);
    } else {
      sound_.clear();
    }
  }
  before_errors_.reset();
}

void Registrar::solve_candidates(const Level& level, std::size_t keep) {
  const auto start = std::chrono::steady_clock::now();
  add_initial(level);
  for (Candidate& candidate : candidates_) {
    if (cancelled_) return;
    candidate.solution = solve(level, candidate);
    const PoseSolution& solution = candidate.solution;
    non_finite_ = std::max(non_finite_, solution.non_finite);
    candidate.history.push_back({.initial_cost = solution.initial_cost,
                                 .final_cost = solution.final_cost,
                                 .seconds = 0,
                                 .iterations = solution.iterations,
                                 .candidates = 0});
  }
  for (Candidate& candidate : candidates_) {
    candidate.history.back().seconds = seconds_since(start);
    candidate.history.back().candidates = static_cast<int>(candidates_.size());
  }
  drop_duplicates(keep);
}

/// Sorts the candidates, best first. Keeps at most \p keep distinct ones, and the plain one unless
/// it has lost. Records the margin to those that are dropped.
void Registrar::drop_duplicates(std::size_t keep) {
  std::stable_sort(candidates_.begin(), candidates_.end(), [](const auto& a, const auto& b) {
    return a.solution.final_cost < b.solution.final_cost;
  });
  std::vector<Candidate> kept;
  std::size_t others = 0;
  for (Candidate& candidate : candidates_) {
    const auto same = std::find_if(kept.begin(), kept.end(), [&](const Candidate& k) {
      return distance_mm(points_, k.solution.pose, candidate.solution.pose) < kSameCandidateMm;
    });
    if (same != kept.end()) {
      same->plain |= candidate.plain;
    } else if (!kept.empty() && lost(kept.front(), candidate)) {
      continue;
    } else if (candidate.plain || others < keep) {
      if (!candidate.plain) ++others;
      kept.push_back(std::move(candidate));
    }
  }
  candidates_ = std::move(kept);
}

/// True if another minimum need not be followed; records the smallest margin of those.
bool Registrar::lost(const Candidate& best, const Candidate& other) {
  if (distance_mm(points_, best.solution.pose, other.solution.pose) <= kSameMinimumMm) return false;
  const double ratio = other.solution.final_cost / std::max(best.solution.final_cost, kLeastCost);
  if (ratio < kLostRatio) return false;
  lost_margin_ = std::min(lost_margin_.value_or(ratio - 1), ratio - 1);
  return true;
}

std::optional<double> Registrar::margin(const Candidate& best) const {
  std::optional<double> margin = lost_margin_;
  for (const Candidate& other : candidates_) {
    if (distance_mm(points_, other.solution.pose, best.solution.pose) <= kSameMinimumMm) continue;
    const double one = (other.solution.final_cost - best.solution.final_cost) /
                       std::max(best.solution.final_cost, kLeastCost);
    margin = std::min(margin.value_or(one), one);
  }
  return margin;
}

/// Refines the chosen pose together with a strain of the tissue.
void Registrar::strain(Candidate& best) {
  const int iterations = best.solution.iterations;
  const Level& level = levels_.back();
  const PatchSet patches = chosen_at(best);
  const SolveLimits until{.max_iterations = options_.max_iterations,
                          .late = [this] { return late(); }};
  StrainSolution found = solve_strain(solved_cost(level, patches), best.solution.pose,
                                      points_.centroid, until, [this] { return keep_going(); });
  non_finite_ = std::max(non_finite_, found.pose.non_finite);
  found.pose.iterations += iterations;
  found.pose.final_cost = level.cost.on(strained(without(best.errors, judging_), found.stretch))
                              .cost(found.pose.pose)
                              .cost;
  best.solution = std::move(found.pose);
  best.history.back().iterations = best.solution.iterations;
  best.history.back().final_cost = best.solution.final_cost;
  stretch_ = found.stretch;
}

/// Finest-level cost at the initial pose: of a third of the patches if the CT there would have to
/// be prepared for this purpose only.
double Registrar::initial_cost(const Level& level) const {
  constexpr std::size_t kStride = 3;
  if (level.ct.near == nullptr) return level.cost.on(judging_).cost(initial_).cost;
  std::size_t index = 0;
  const PatchSet some = subset(judging_, [&](const Patch&) { return index++ % kStride == 0; });
  return level.cost.on(some).cost(initial_).cost;
}

/// Covariance of the chosen pose whatever the errors of the system are. patches: those of the
/// shape, corrected.
JointCovariance Registrar::joint_covariance_of(const Candidate& best, const LocalShape& shape,
                                               const PatchSet& patches) const {
  const Pose& pose = best.solution.pose;
  if (!estimates_errors()) {
    return {sandwich_covariance(shape, patches, pose, options_.bias_floor_mm)};
  }
  const PatchSet recorded = sounded(as_recorded(levels_.back().patches(), patches));
  return joint_covariance(shape, recorded, best.errors, pose, sigmas(), sweep_.motions(),
                          sweep_.path(), options_.bias_floor_mm);
}

/// Motion of the patient and deformed tissue, as seen from the pose before the errors of the system
/// were estimated: these may explain a part of them, and would hide it.
void Registrar::add_patients_misfit(std::vector<Misfit>& misfits) const {
  if (!before_errors_) return;
  const PatchSet patches = chosen_at(*before_errors_);
  const auto plain = find_misfits(shape_at(*before_errors_, patches), patches,
                                  before_errors_->solution.pose, sweep_.motions());
  const Misfit* cause = likeliest_of(plain, kTellingMm);
  if (cause == nullptr) return;
  if (cause->cause != MisfitCause::kMotion && cause->cause != MisfitCause::kBend) return;
  for (Misfit& misfit : misfits) {
    if (misfit.cause == cause->cause && misfit.excess_mm() < cause->excess_mm()) misfit = *cause;
  }
}

ImageRegistrationResult Registrar::report(const Candidate& best) {
  const Level& finest = levels_.back();
  const Pose& pose = best.solution.pose;
  const PatchSet patches = strained(chosen_at(best), stretch_);
  const SimilarityCost solved = solved_cost(finest, patches);
  const Point<frames::Ct> centre = pose * points_.centroid;
  const double sample_step_mm = finest.prepared.options.sample_step_mm;
  // With coarse samples the poses of the basin check are close enough for the curvature too.
  const bool shared = kAroundMm <= kSharedSteps * sample_step_mm;
  const CostsAround around = costs_around(solved, points_, pose, shared);
  const LocalShape shape =
      shared ? local_shape(solved, centre, around)
             : local_shape(solved, pose, centre, kCurvatureSteps * sample_step_mm);
  const JointCovariance joint = joint_covariance_of(best, shape, patches);
  const SandwichCovariance& covariance = joint.pose;
  ImageBootstrap bootstrap = image_bootstrap(shape, options_.bootstrap);
  const LevelCt& first = levels_.front().ct;
  ImageRegistrationResult result{
      .ct_from_reference = pose,
      .termination = best.solution.termination,
      .message = best.solution.message,
      .final_cost = best.solution.final_cost,
      .overlap = overlap(ct_, points_, pose, first.near ? nullptr : first.channels.get()),
      .patches = static_cast<int>(finest.patches().patches.size()),
      .uncertainty = with_bootstrap(covariance, bootstrap, options_.bias_floor_mm),
      .covariance_valid = covariance.valid,
      .covariance_fault = covariance.fault,
      .z_score =
          z_score(levels_.front().cost, points_, pose, options_.z_score_poses, options_.seed + 1),
      .margin = margin(best)};
  result.clusters = covariance.uncertainty;
  result.errors = best.errors;
  result.error_deviations = joint.errors.diagonal().cwiseMax(0).cwiseSqrt();
  if (estimates_errors()) result.error_sigmas = sigmas().vector();
  result.misfits = find_misfits(shape, patches, pose, sweep_.motions(), best.errors);
  if (estimates_errors()) {
    set_intervals(joint.errors, sigmas(), result.misfits);
    add_patients_misfit(result.misfits);
  }
  result.uncertainty.widen(telling_excess_mm(result.misfits));
  result.uncertainty.widen(sound_doubt_mm_);
  result.bootstrap = std::move(bootstrap);
  result.stretch = stretch_;
  if (options_.stretch == ScaleModel::kSoundSpeed) {
    result.stretch.depth_scale = best.errors.depth_scale;
  }
  result.used_patches = static_cast<int>(patches.patches.size());
  result.basin = check_basin(around, solved, points_);
  result.regions = region_agreement(around, solved);
  const Disagreement split = disagreement(shape, patches, points_, pose, Halves::kOddEven);
  const Disagreement halves = disagreement(shape, patches, points_, pose, Halves::kFirstSecond);
  result.split_disagreement_mm = split.rms_mm;
  result.split_fault = split.fault;
  result.halves_disagreement_mm = halves.rms_mm;
  result.halves_fault = halves.fault;
  for (std::size_t i = 0; i < levels_.size(); ++i) {
    const Level& level = levels_[i];
    const LevelSolve& solve = best.history[i];
    result.iterations += solve.iterations;
    result.levels.push_back({.sample_step_mm = level.prepared.options.sample_step_mm,
                             .patches = static_cast<int>(level.patches().patches.size()),
                             .frames = level.patches().frames,
                             .candidates = solve.candidates,
                             .iterations = solve.iterations,
                             .initial_cost = solve.initial_cost,
                             .final_cost = solve.final_cost,
                             .preparation_s = level.prepared.seconds + level.channels_s,
                             .solve_s = solve.seconds});
  }
  result.initial_cost = initial_cost(finest);  // Last, because it may need other parts of the CT.
  result.total_s = seconds_since(start_);
  return result;
}

Result<void> Registrar::add_level() {
  const auto start = std::chrono::steady_clock::now();
  const PreparedLevel& prepared = sweep_.levels()[levels_.size()];
  std::vector<Pose> poses;
  for (const Candidate& candidate : candidates_) poses.push_back(candidate.solution.pose);
  const auto box = [&] {
    if (levels_.empty()) return reachable_box(sweep_, initial_, options_);
    // The initial pose is judged as well.
    std::vector<Pose> judged{initial_};
    judged.insert(judged.end(), poses.begin(), poses.end());
    return box_around(points_, judged, kNearTravelMm);
  };
  auto ct = channels_of_({box, prepared, poses});
  if (!ct) return ct.error();
  const SimilarityCost cost =
      SimilarityCost(*ct->channels, prepared.patches, options_.ridge, options_.threads, measure_)
          .where(ct->near.get());
  levels_.push_back({prepared, *std::move(ct), seconds_since(start), cost});
  return {};
}

Result<ImageRegistrationResult> Registrar::run() {
  const std::size_t count = sweep_.levels().size();
  for (std::size_t i = 0; i < count; ++i) {
    if (!keep_going()) return cancelled();
    if (auto ok = add_level(); !ok) return ok.error();
    if (i == 0) {
      solve_starts(levels_[i]);
    } else {
      const bool before_finest = i + 2 == count;
      solve_candidates(levels_[i], before_finest ? kKeptOnFinest : kKeptCandidates);
      if (before_finest) {
        for (Candidate& candidate : candidates_) try_delays(levels_[i], candidate);
      }
    }
    if (cancelled_) return cancelled();
    fraction_ = kSolveProgress * static_cast<double>(i + 1) / static_cast<double>(count);
  }
  if (!keep_going()) return cancelled();
  const auto best = std::min_element(candidates_.begin(), candidates_.end(),
                                     [](const Candidate& a, const Candidate& b) {
                                       return a.solution.final_cost < b.solution.final_cost;
                                     });
  if (estimates_errors() && options_.stretch == ScaleModel::kSoundSpeed && !late()) {
    // An error that is in doubt is looked for alone first: it has to explain less than all
    // together.
    refine_errors(*best, {.delay_s = 0, .depth_scale = sigmas().depth_scale, .width_scale = 0},
                  chosen_at(*best));
  }
  if (estimates_errors() && !late()) {
    if (options_.pressed_sigma_mm > 0 || options_.speed_from_ct) refine_tissue(*best, sigmas());
    if (sigmas().delay_s > 0 && !late()) refine_delay(*best);
    if (!late()) refine_errors(*best, sigmas(), chosen_at(*best));
    if (undelayed_ && !late()) refine_errors(*undelayed_, sigmas(), chosen_at(*undelayed_));
  }
  if (options_.stretch == ScaleModel::kAffine && !late()) strain(*best);
  if (cancelled_) return cancelled();
  if (hurried_) best->solution.termination = Termination::kTimeLimit;
  if (non_finite_ > 0) {
    return Error{ErrorCode::kNumerical,
                 "image registration: expected a finite similarity of every "
                 "patch, found " +
                     std::to_string(non_finite_) + " that were not"};
  }
  std::shared_ptr<const ImageRegistrationResult> without_delay;
  if (undelayed_) {
    without_delay = std::make_shared<const ImageRegistrationResult>(report(*undelayed_));
  }
  ImageRegistrationResult result = report(*best);
  result.without_delay = std::move(without_delay);
  fraction_ = 1;
  if (!keep_going()) return cancelled();
  return result;
}

/// The CT near each patch; null if the boxes for several start poses would have too many texels:
/// each pose needs other boxes, while the boxes of a single pose together have fewer texels than
/// the whole CT.
Result<std::shared_ptr<PatchChannels>> few_texels(const Volume& ct, const LevelReach& reach) {
  constexpr double kShare = 0.5;  // A texel in many small boxes takes about twice as long.
  const PatchSet& patches = reach.level.patches;
  auto near = PatchChannels::create(ct, sigma_of(reach.level.options.sample_step_mm),
                                    reach.level.options.texel_sigmas, patches.patches.size());
  if (!near) return near.error();
  const CtChannels& whole = near->whole();
  if (reach.poses.size() > 1) {
    const GridPose pose = grid_pose(whole, reach.poses.front());
    double texels = 0;
    for (std::size_t i = 0; i < patches.patches.size(); ++i) {
      texels += near->texels_for(place(patches, i, pose));
    }
    texels *= static_cast<double>(reach.poses.size() + 1);  // The initial pose is needed too.
    if (texels > kShare * whole.size[0] * whole.size[1] * whole.size[2]) return {nullptr};
  }
  return std::make_shared<PatchChannels>(*std::move(near));
}

}  // namespace

Result<ImageRegistrationResult> register_prepared(
    const PreparedCt& ct, const PreparedSweep& sweep,
    const Transform<frames::Ct, frames::Reference>& initial,
    const ImageRegistrationOptions& options, const std::function<bool(double fraction)>& progress) {
  if (const auto ok = validate(options); !ok) return ok.error();
  NAV_CHECK(ct.sample_steps_mm() == sweep.sample_steps_mm(), ct.name());
  NAV_CHECK(ct.levels().size() == options.levels.size(), options.levels.size());
  const auto channels_of = [&](const LevelReach& reach) -> Result<LevelCt> {
    return LevelCt{ct.levels()[reach.level.index], nullptr};
  };
  return Registrar(ct.grid(), channels_of, sweep, initial, options, progress).run();
}

Result<ImageRegistrationResult> register_prepared(
    const Volume& ct, const PreparedSweep& sweep,
    const Transform<frames::Ct, frames::Reference>& initial,
    const ImageRegistrationOptions& options, const std::function<bool(double fraction)>& progress) {
  if (const auto ok = validate(options); !ok) return ok.error();
  const auto channels_of = [&](const LevelReach& reach) -> Result<LevelCt> {
    const LevelOptions& level = reach.level.options;
    const double sigma_mm = sigma_of(level.sample_step_mm);
    // A measure of all samples and the strain read the channels of the level directly.
    const bool any_ct = measure_of(options.similarity).by_patch() != nullptr &&
                        options.stretch != ScaleModel::kAffine;
    if (any_ct && !reach.poses.empty()) {
      auto near = few_texels(ct, reach);
      if (!near) return near.error();
      if (*near) return LevelCt{{*near, &(*near)->whole()}, *near};
    }
    auto made = make_ct_channels(ct, reach.box(), sigma_mm, level.texel_sigmas);
    if (!made) return made.error();
    return LevelCt{std::make_shared<const CtChannels>(*std::move(made)), nullptr};
  };
  return Registrar(ct.grid(), channels_of, sweep, initial, options, progress).run();
}

Result<ImageRegistrationResult> register_sweep(
    const Volume& ct, const Sweep& sweep, const Transform<frames::Ct, frames::Reference>& initial,
    const ImageRegistrationOptions& options, Diagnostics& diagnostics,
    const std::function<bool(double fraction)>& progress) {
  const auto start = std::chrono::steady_clock::now();
  const auto prepared =
      PreparedSweep::create(sweep, options, diagnostics, [&] { return !progress || progress(0); });
  if (!prepared) return prepared.error();
  auto result = register_prepared(ct, *prepared, initial, options, progress);
  if (result) result->total_s = seconds_since(start);
  return result;
}

}  // namespace nav::registration
