// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "nav/diagnostics.hpp"
#include "nav/result.hpp"
#include "nav/sweep.hpp"
#include "nav/transform.hpp"
#include "nav/volume.hpp"
#include "registration/similarity/patch_loss.hpp"
#include "registration/similarity/shadow_mask.hpp"
#include "registration/uncertainty/frame_bootstrap.hpp"
#include "registration/uncertainty/misfit.hpp"
#include "registration/uncertainty/pose_uncertainty.hpp"

namespace nav::registration {

/// Which of the squares that the mask allows become patches.
enum class PatchChoice {
  /// Those of highest contrast: seen from afar, but where speckle happens to agree among them.
  kContrast,
  /// Spread evenly: no such bias, which is what limits the accuracy of the finest level.
  kEven,
};

/// One step of the coarse-to-fine ladder.
struct LevelOptions {
  double sample_step_mm;  ///< Distance of neighbouring samples of a patch, > 0.
  int patch_side;         ///< Samples along each side of a square patch, 5 to 21, odd.
  int patches;            ///< Most patches used, >= 50.
  double frame_step_mm;   ///< Pictures are thinned to about this distance, > 0.
  PatchChoice choice = PatchChoice::kContrast;
  double texel_sigmas =
      0.7;  ///< How far the CT's texels are apart, in sigmas of 0.75 steps, (0, 2].
};

/// What makes ultrasound and CT alike.
enum class Similarity {
  kLc2,  ///< Each patch is an affine combination of the CT and its gradient along the beam.
  kNcc,  ///< Squared normalised cross-correlation of each patch with the CT.
  kMutualInformation,  ///< Of all samples' greys and HU (mutual_information.hpp).
};

/// Stable lower-case name: "lc2", "ncc", "mi".
const char* to_string(Similarity similarity);

/// What is refined on the finest level besides the pose (stretch.hpp).
enum class StretchModel {
  kNone,
  kSoundSpeed,  ///< One factor of depth: the tissue's speed of sound over the scanner's.
  kAffine,      ///< Six strains about the sweep's centroid.
};

/// Stable lower-case name: "none", "sound-speed", "affine".
const char* to_string(StretchModel model);

/// What a StretchModel found.
struct Stretch {
  double depth_scale = 1;                            ///< True depth over the picture's.
  Eigen::Matrix3d strain = Eigen::Matrix3d::Zero();  ///< Symmetric, Reference: p' = p + E(p − c).
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();  ///< c, Reference.
};

/// How to register a sweep to a CT. The defaults are meant for an abdominal sweep.
struct ImageRegistrationOptions {
  /// Coarse to fine; the first also ranks the starts. At least one. A level whose patches do not
  /// fit into the pictures is left out and reported; the last must fit.
  std::vector<LevelOptions> levels = {
      {5.0, 7, 250, 9.0}, {3.0, 9, 500, 6.0}, {1.2, 9, 7500, 1.0, PatchChoice::kEven}};
  ShadowMaskOptions mask;
  /// The limits of acceptance are those of LC²; what the others cost is not comparable.
  Similarity similarity = Similarity::kLc2;
  StretchModel stretch = StretchModel::kNone;
  /// Of the patches' terms in the finest solve; what is reported and judged is without it.
  RobustLoss loss{PatchLoss::kCauchy, 0.3};
  double ridge = 0.01;  ///< λ: noise of the CT channels in units of 100 HU, > 0.
  /// Patches where the CT differs by less than this, RMS, are left out of the finest solve: they
  /// say nothing, and what is noise of the CT there costs as much as structure. HU, >= 0.
  double min_ct_contrast_hu = 5;
  /// A pose is judged by those of the finest level that have most contrast, at least by so many, 20
  /// to 1000000.
  int least_judging = 200;
  int most_pictures = 0;  ///< Others, evenly along the way, are not looked at; 0: all are, >= 0.
  /// Pictures are averaged over blocks of pixels before anything else, as wide as the smoothing of
  /// the finest level allows.
  bool average_pixels = false;
  int max_iterations = 30;        ///< Of each solve on each level, >= 1.
  int starts = 600;               ///< Seeded starts searched where the plain solve fails, >= 0.
  double start_range_mm = 40;     ///< Half width of their box of translations, >= 0.
  double start_range_rad = 0.45;  ///< Half width of their box of rotation vectors, [0, pi].
  int z_score_poses = 60;         ///< Random poses that the result is compared with, >= 10.
  double bias_floor_mm = 0.07;    ///< Standard deviation that no sweep can undercut, >= 0.
  /// How well the probe's calibration is known, [0, 10]: see calibration_covariance(). 0: it is
  /// taken to be right, and what is predicted holds as long as it is. More than 0 needs kLc2.
  double calibration_sigma_mm = 0;
  BootstrapOptions bootstrap;  ///< Of its pictures, for the predicted error.
  int threads = 2;             ///< 1 to 64; the result does not depend on it.
  /// After so long no solve is begun or goes on: the best pose so far is assessed, and refused. >
  /// 0.
  double time_limit_s = std::numeric_limits<double>::infinity();
  std::uint64_t seed = 1;  ///< Of the starts and the random poses.
};

/// How much work a registration is worth.
enum class Effort {
  kQuick,  ///< A fifth of the usual time or less, a few tenths of a millimetre farther off.
  kUsual,
};

/// Stable lower-case name: "quick", "usual".
const char* to_string(Effort effort);

/// The usual options, or those of a quick registration: two levels, a few hundred patches of
/// eight pictures, samples 2.4 mm apart at best.
ImageRegistrationOptions with_effort(Effort effort);

/// A refusal that names the first option out of its range.
Result<void> validate(const ImageRegistrationOptions& options);

/// Why the last solve stopped.
enum class Termination {
  kConverged,
  kIterationLimit,  ///< Judged as any other, and warned of.
  kTimeLimit,       ///< What was found until then, and refused.
  kFailed,
};

/// Stable lower-case name, for reports.
const char* to_string(Termination termination);

/// What happened on one level, for the chosen candidate.
struct LevelReport {
  double sample_step_mm;
  int patches;
  int frames;      ///< Thinned pictures that patches came from.
  int candidates;  ///< Poses solved on this level.
  int iterations;
  double initial_cost;  ///< Mean weighted 1 − LC², [0, 1].
  double final_cost;
  double preparation_s;  ///< Wall time of channels and patches.
  double solve_s;        ///< Wall time of all candidates.
};

/// What costs alone say of a minimum that the solver found by derivatives.
struct BasinCheck {
  /// Least share by which the cost rises 1 mm away, of six shifts and six turns that move the
  /// sweep's edge by 1 mm; negative: it falls somewhere.
  double rise = 0;
  /// How far steps of 1 mm to ever lower costs lead, RMS over the sweep, mm; 0: nowhere.
  double shift_mm = 0;
};

/// How a part of the sweep agrees with the pose that all of it found.
struct RegionAgreement {
  int along;    ///< Third of the pictures, 0 the first.
  int deep;     ///< Third of the depth that patches lie at, 0 next to the probe.
  int patches;  ///< That the solve used there.
  double cost;  ///< Of them, [0, 1]; 0 is a perfect match.
  /// How far the middle of the region would go if all patches pulled as these do, one Newton step,
  /// mm; infinite where the pose is not determined.
  double pull_mm;
  Point<frames::Ct> centre;  ///< Mean of its patches at the pose.
};

/// The whole story of a solve. Whether to use it is decide()'s business (acceptance.hpp).
struct ImageRegistrationResult {
  Transform<frames::Ct, frames::Reference> ct_from_reference;
  Termination termination;
  std::string message;  ///< Why the solve stopped, in the solver's words.
  int iterations;       ///< Of the chosen candidate, all levels.
  /// Finest-level cost at the initial pose, [0, 1]; 0 is a perfect match. Of every fifth patch
  /// where the CT was prepared for few patches only.
  double initial_cost;
  /// Finest-level cost at the result, [0, 1]: of the patches of most contrast, without the loss. Of
  /// pictures so small that only the finest level fits: of all patches, with it, which is more.
  double final_cost;
  double overlap;  ///< Fraction of the usable ultrasound inside the CT, [0, 1].
  int patches;     ///< On the finest level.

  /// About the sweep's centroid, the largest misfit that is no chance included; meaningless unless
  /// valid.
  PoseUncertainty uncertainty;
  bool covariance_valid;         ///< False: a direction is not determined by the sweep.
  std::string covariance_fault;  ///< Which and why; empty when valid.

  double z_score;  ///< (mean cost of random poses − cost) / their standard deviation, first level.
  /// (cost of the best other minimum − cost) / cost; other: more than 5 mm away. On the finest
  /// level that the other was followed to: one that costs 1.4 times as much is given up.
  /// Absent when no start ended in another minimum.
  std::optional<double> margin;
  /// RMS over the sweep between the poses that odd and even pictures would each move to, one Newton
  /// step from the result, mm; infinite where split_fault says why it is not known.
  double split_disagreement_mm;
  double halves_disagreement_mm;  ///< The same between the first and the second half.

  std::vector<LevelReport> levels;  ///< Coarse to fine.
  double total_s;                   ///< Wall time of the whole call.
  Stretch stretch = {};             ///< Identity unless the options ask for it.
  /// What uncertainty is the larger of, in every direction (frame_bootstrap.hpp): by clusters of
  /// patches alone, and by pictures drawn anew.
  PoseUncertainty clusters = {};
  FrameBootstrap bootstrap = {};
  int used_patches = 0;  ///< Of patches, those where the CT has structure.
  BasinCheck basin = {};
  std::vector<RegionAgreement> regions = {};  ///< Along the sweep and deep (regions.hpp).
  std::vector<Misfit> misfits = {};           ///< What else may be wrong (misfit.hpp).
  /// Why the disagreements are not known: what was expected and what was found; empty where they
  /// are.
  std::string split_fault = {}, halves_fault = {};

  /// Expected RMS error at a point of the CT, mm; infinite while the covariance is not valid.
  [[nodiscard]] double tre_rms_mm(const Point<frames::Ct>& target) const;
};

/// Refines a start pose by maximising LC² (Wein et al. 2008, 2013): each small in-plane patch of
/// the sweep is explained by an affine combination of the CT and of its gradient along the beam.
/// The coefficients are eliminated (variable projection, Kaufman 1975) and Ceres solves for the
/// pose. A portfolio of seeded starts around the initial pose competes with the plain solve from
/// it where that is not clearly right. Same inputs give the same bytes for any thread count.
/// progress: called from the calling thread with the fraction done in [0, 1]; false cancels.
/// Errors: kUsage (options), kMalformedData (sweep geometry), kRefused (no usable patch, sweep
/// outside the CT), kNumerical (cost not finite), kCancelled.
Result<ImageRegistrationResult> register_sweep(
    const Volume& ct, const Sweep& sweep, const Transform<frames::Ct, frames::Reference>& initial,
    const ImageRegistrationOptions& options, Diagnostics& diagnostics,
    const std::function<bool(double fraction)>& progress = {});

}  // namespace nav::registration
