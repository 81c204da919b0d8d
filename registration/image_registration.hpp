// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "nav/diagnostics.hpp"
#include "nav/result.hpp"
#include "nav/sweep.hpp"
#include "nav/transform.hpp"
#include "nav/volume.hpp"
#include "registration/image_errors.hpp"
#include "registration/similarity/patch_loss.hpp"
#include "registration/similarity/shadow_mask.hpp"
#include "registration/uncertainty/image_bootstrap.hpp"
#include "registration/uncertainty/misfit.hpp"
#include "registration/uncertainty/pose_uncertainty.hpp"

namespace nav::registration {

/// Rule that chooses patches among the squares that the mask allows.
enum class PatchChoice {
  /// Squares of highest contrast. They are visible from afar, but are biased towards places where
  /// speckle happens to agree.
  kContrast,
  /// Squares spread evenly. They avoid this bias, which would limit the accuracy of the finest
  /// level.
  kEven,
};

/// One level of the coarse-to-fine registration.
struct LevelOptions {
  double sample_step_mm;  ///< Distance of neighbouring samples of a patch, > 0.
  int patch_side;         ///< Samples along each side of a square patch, 5 to 21, odd.
  int patches;            ///< Largest number of patches used, >= 50.
  double frame_step_mm;   ///< Ultrasound images are thinned to about this distance, > 0.
  PatchChoice choice = PatchChoice::kContrast;
  /// Distance of the CT's texels, in sigmas of 0.75 steps, (0, 2].
  double texel_sigmas = 0.7;
};

/// Similarity measure between the ultrasound and the CT.
enum class Similarity {
  kLc2,  ///< Each patch is an affine combination of the CT and its gradient along the beam.
  kNcc,  ///< Squared normalised cross-correlation of each patch with the CT.
  /// Mutual information of the greys and HU of all samples (mutual_information.hpp).
  kMutualInformation,
};

/// Stable lower-case name: "lc2", "ncc", "mi".
const char* to_string(Similarity similarity);

/// Scale factors that are estimated besides those that every registration estimates.
enum class ScaleModel {
  kNone,
  /// The depth factor (speed of sound of the tissue over that of the scanner) may be off by 10 %
  /// instead of scale_sigma: it is one of the errors that are estimated with the pose.
  kSoundSpeed,
  kAffine,  ///< Six strains about the sweep's centroid, on the finest level (image_strain.hpp).
};

/// Stable lower-case name: "none", "sound-speed", "affine".
const char* to_string(ScaleModel model);

/// The depth factor or strain that a ScaleModel found.
struct ImageScale {
  double depth_scale = 1;  ///< True depth over depth in the ultrasound image.
  Eigen::Matrix3d strain = Eigen::Matrix3d::Zero();  ///< Symmetric, Reference: p' = p + E(p − c).
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();  ///< c, Reference.
};

/// Options of the registration of a sweep to a CT. The defaults suit an abdominal sweep.
struct ImageRegistrationOptions {
  /// Levels from coarse to fine; the first also ranks the starts. At least one. If too few patches
  /// of a level fit into the ultrasound images, smaller ones are used. A level whose smallest
  /// patches do not fit is left out and reported; the last level must fit.
  std::vector<LevelOptions> levels = {
      {.sample_step_mm = 5.0, .patch_side = 7, .patches = 250, .frame_step_mm = 9.0},
      {.sample_step_mm = 3.0, .patch_side = 9, .patches = 500, .frame_step_mm = 6.0},
      {.sample_step_mm = 1.2,
       .patch_side = 9,
       .patches = 7500,
       .frame_step_mm = 1.0,
       .choice = PatchChoice::kEven}};
  ShadowMaskOptions mask;
  /// The limits of acceptance are for LC²; the costs of the other measures are not comparable.
  Similarity similarity = Similarity::kLc2;
  ScaleModel stretch = ScaleModel::kNone;
  /// Loss on the terms of the patches in the finest solve. The reported and judged costs are
  /// without it.
  RobustLoss loss{PatchLoss::kCauchy, 0.3};
  double ridge = 0.01;  ///< λ: noise of the CT channels in units of 100 HU, > 0.
  /// Patches with a CT contrast below this (RMS) are left out of the finest solve: they carry no
  /// information, cost as much time as the others and follow the noise of the CT. HU, >= 0.
  double min_ct_contrast_hu = 5;
  /// A pose is judged by the patches of highest contrast of the finest level, and by at least this
  /// many of them, 20 to 1000000.
  int least_judging = 200;
  /// Largest number of ultrasound images used, spread evenly along the path; 0: all, >= 0.
  int most_images = 0;
  /// Ultrasound images are averaged over blocks of pixels before anything else. The blocks are as
  /// wide as the smoothing of the finest level allows.
  bool average_pixels = false;
  int max_iterations = 30;     ///< Limit for each solve on each level, >= 1.
  int starts = 600;            ///< Seeded starts that are searched if the plain solve fails, >= 0.
  double start_range_mm = 40;  ///< Half width of the starts' box of translations, >= 0.
  double start_range_rad = 0.45;  ///< Half width of the starts' box of rotation vectors, [0, pi].
  int z_score_poses = 60;         ///< Random poses that the result is compared with, >= 10.
  double bias_floor_mm = 0.07;    ///< Standard deviation below which no sweep's error falls, >= 0.
  /// Uncertainty of the probe's calibration, [0, 10]: standard deviation of a shift along each axis
  /// of the images and, at 60 mm, of a rotation. 0: the calibration is taken to be exact, and the
  /// predicted error holds only if it is. kLc2 and kNcc alone.
  double calibration_sigma_mm = 0.5;
  /// Standard deviations of the delay between images and poses, s, and of the scale of their pixels
  /// or of the speed of sound, relative; they are estimated with the pose; 0: ruled out. [0, 1] and
  /// [0, 0.1]. kLc2 and kNcc alone.
  double delay_sigma_s = 0.2, scale_sigma = 0.02;
  /// Standard deviation of the distance by which the probe presses the tissue at its face away, mm,
  /// [0, 20]; 0: the tissue lies as in the CT. kLc2 and kNcc alone.
  double pressed_sigma_mm = 4;
  /// Take the speed of sound along each beam from the CT (sound_shift.hpp), if errors are
  /// estimated; false for a volume whose values are not HU.
  bool speed_from_ct = true;
  BootstrapOptions bootstrap;  ///< Resampling of the ultrasound images, for the predicted error.
  int threads = 2;             ///< 1 to 64; the result does not depend on it.
  /// Time limit, > 0. After it no solve begins or continues: the best pose so far is assessed and
  /// rejected.
  double time_limit_s = std::numeric_limits<double>::infinity();
  std::uint64_t seed = 1;  ///< Seed of the starts and the random poses.
};

/// Computing time that a registration may take.
enum class Effort {
  kQuick,  ///< At most a fifth of the usual time, and a few tenths of a millimetre less accurate.
  kUsual,
};

/// Stable lower-case name: "quick", "usual".
const char* to_string(Effort effort);

/// The usual options, or the options of a quick registration: two levels, a few hundred patches of
/// eight ultrasound images, and samples at least 2 mm apart.
ImageRegistrationOptions with_effort(Effort effort);

/// Returns an error that names the first option that is out of its range.
Result<void> validate(const ImageRegistrationOptions& options);

/// Why the last solve stopped.
enum class Termination {
  kConverged,
  kIterationLimit,  ///< Judged as any other result, with a warning.
  kTimeLimit,       ///< The best result until then, which is rejected.
  kFailed,
};

/// Stable lower-case name, for reports.
const char* to_string(Termination termination);

/// Report of one level, for the chosen candidate.
struct LevelReport {
  double sample_step_mm;
  int patches;
  int frames;      ///< Thinned ultrasound images that patches came from.
  int candidates;  ///< Poses solved on this level.
  int iterations;
  double initial_cost;  ///< Mean weighted 1 − LC², [0, 1].
  double final_cost;
  double preparation_s;  ///< Wall time to prepare the channels and patches.
  double solve_s;        ///< Wall time of the solves of all candidates.
};

/// A check, by costs alone, of a minimum that the solver found by derivatives.
struct BasinCheck {
  /// Smallest relative increase of the cost 1 mm away, over six shifts and six rotations that move
  /// the sweep's edge by 1 mm. Negative: the cost falls in some direction.
  double rise = 0;
  /// Distance that steps of 1 mm towards lower costs lead away, RMS over the sweep, mm; 0: no step
  /// lowers the cost.
  double shift_mm = 0;
};

/// Agreement of a part of the sweep with the pose found from all of it.
struct RegionAgreement {
  int along;    ///< Third of the ultrasound images, 0 is the first.
  int deep;     ///< Third of the depth range of the patches, 0 is next to the probe.
  int patches;  ///< Patches that the solve used in this region.
  double cost;  ///< Cost of these patches, [0, 1]; 0 is a perfect match.
  /// Distance from the pose to the minima of parabolas through the costs of these patches, one
  /// along each axis of Ct, mm. At most 2 mm along an axis; 0 along an axis with no minimum.
  double pull_mm;
  Point<frames::Ct> centre;  ///< Mean position of its patches at the pose.
};

/// The complete result of a solve. decide() says whether it may be used (acceptance.hpp).
struct ImageRegistrationResult {
  Transform<frames::Ct, frames::Reference> ct_from_reference;
  Termination termination;
  std::string message;  ///< Why the solve stopped, in the words of the solver.
  int iterations = 0;   ///< Iterations of the chosen candidate on all levels.
  /// Finest-level cost at the initial pose, [0, 1]; 0 is a perfect match. If the CT was prepared
  /// near the patches only, it is the cost of every third patch.
  double initial_cost = 0;
  /// Finest-level cost at the result, [0, 1]: of the patches of highest contrast, without the loss.
  /// If ultrasound images are so small that only the finest level fits, it is the cost of all
  /// patches with the loss, which is higher.
  double final_cost;
  /// Fraction of the usable ultrasound inside the CT and not in its air, [0, 1].
  double overlap;
  int patches;  ///< Patches on the finest level.

  /// Uncertainty about the sweep's centroid; includes the largest misfit that is not chance.
  /// Meaningless unless covariance_valid.
  PoseUncertainty uncertainty;
  bool covariance_valid;           ///< False: the sweep does not determine one of the directions.
  std::string covariance_fault{};  ///< Which direction and why; empty if valid.

  double z_score;  ///< (mean cost of random poses − cost) / their standard deviation, first level.
  /// (cost of the best other minimum − cost) / cost; another minimum is more than 5 mm away. It is
  /// computed on the finest level that the other minimum was followed to: a minimum that costs 1.4
  /// times as much is given up. Absent if no start ended in another minimum.
  std::optional<double> margin{};
  /// RMS over the sweep between the poses that odd and even ultrasound images would each move to,
  /// one Newton step from the result, mm; infinite if split_fault says why it is not known.
  double split_disagreement_mm = 0;
  double halves_disagreement_mm = 0;  ///< Disagreement between the first and the second half.

  std::vector<LevelReport> levels{};  ///< Coarse to fine.
  double total_s = 0;                 ///< Wall time of the whole call.
  ImageScale stretch = {};            ///< Identity unless the options ask for it.
  /// Errors of the system that were estimated with the pose, and their standard deviations
  /// (ImageErrors::vector()); 0: not estimated. The images of the sweep are drawn without them.
  ImageErrors errors = {};
  ErrorVector error_deviations = ErrorVector::Zero();
  /// Standard deviations of the errors before the registration; 0: not estimated.
  ErrorVector error_sigmas = ErrorVector::Zero();
  /// The two covariances that uncertainty takes the larger of, in every direction
  /// (image_bootstrap.hpp): by clusters of patches alone, and by resampled ultrasound images.
  PoseUncertainty clusters = {};
  ImageBootstrap bootstrap = {};
  int used_patches = 0;  ///< Patches in which the CT has structure, of all patches.
  BasinCheck basin = {};
  /// Thirds along the sweep and in depth (regions.hpp).
  std::vector<RegionAgreement> regions = {};
  std::vector<Misfit> misfits = {};  ///< Other faults that may be present (misfit.hpp).
  /// Why a disagreement is not known: what was expected and what was found; empty if it is known.
  std::string split_fault = {}, halves_fault = {};
  /// The result before the pose was solved with a delay; null: it was not. A delay may make a wrong
  /// pose fit better, so decide() judges both.
  std::shared_ptr<const ImageRegistrationResult> without_delay = {};

  /// Expected RMS error at a point of the CT, mm; infinite if the covariance is not valid.
  [[nodiscard]] double tre_rms_mm(const Point<frames::Ct>& target) const;
};

/// Refines a start pose by maximising LC² (Wein et al. 2008, 2013): each small in-plane patch of
/// the sweep is explained by an affine combination of the CT and of its gradient along the beam.
/// The coefficients are eliminated (variable projection, Kaufman 1975) and Ceres solves for the
/// pose. If the plain solve from the initial pose is not clearly right, seeded starts around the
/// initial pose compete with it. The same inputs give the same bytes for any thread count.
/// progress: called on the calling thread with the fraction done in [0, 1]; false cancels.
/// Errors: kUsage (options), kMalformedData (sweep geometry), kRefused (no usable patch, or a sweep
/// outside the CT), kNumerical (cost not finite), kCancelled.
Result<ImageRegistrationResult> register_sweep(
    const Volume& ct, const Sweep& sweep, const Transform<frames::Ct, frames::Reference>& initial,
    const ImageRegistrationOptions& options, Diagnostics& diagnostics,
    const std::function<bool(double fraction)>& progress = {});

}  // namespace nav::registration
