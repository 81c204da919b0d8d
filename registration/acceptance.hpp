// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include "nav/result.hpp"
#include "nav/transform.hpp"
#include "registration/image_registration.hpp"
#include "registration/landmarks/landmarks.hpp"

namespace nav::registration {

/// Limits that a registration must meet before anything is drawn with it. Every limit is inclusive.
/// The defaults come from simulated patients at all levels of errors ('sonde bench registration',
/// docs/adr/0007-limits-that-accept-a-registration.md). They say nothing yet about real patients.
struct AcceptanceLimits {
  double min_overlap = 0.6;  ///< Fraction of the ultrasound inside the CT, [0, 1].
  /// Probability that the target error exceeds 3 mm (error_probability.hpp), (0, 1].
  double max_error_probability = 0.03;
  double min_z_score = 0;  ///< Score against random poses, on the first level.
  /// Number of distinct positions of the probe, BootstrapOptions::block_mm apart. Ultrasound images
  /// from fewer positions match elsewhere nearly as well, and resampling them does not show the
  /// error that they share.
  int min_places = kLeastPlaces;
  double max_cost = 0.45;                   ///< Cost of the result on the finest level, (0, 1].
  double min_margin = 0.1;                  ///< Margin to another minimum, if one was found.
  double max_tre_rms_mm = 2;                ///< Predicted error at the target, > 0.
  double max_split_disagreement_mm = 1.5;   ///< Odd against even ultrasound images, > 0.
  double max_halves_disagreement_mm = 2.5;  ///< First against second half, > 0.
  /// Distance to lower costs nearby, found without derivatives, > 0.
  double max_basin_shift_mm = 1.5;
  /// Strain, or depth factor minus 1, that was refined together with the pose, > 0. Ultrasound
  /// images are shown as they came, and 1 % of 100 mm is a millimetre.
  double max_scale = 0.01;
  /// Misfit beyond noise, by MisfitCause, mm, > 0, of causes that were not estimated with the pose.
  /// On the development seeds it is at most 0.35, 0.34, 0.5, 0.79 and 0.91 when nothing is wrong.
  /// It is at least 0.86 when pixels are 1.5 % off, and at least 1.4 when the patient breathes.
  std::array<double, kMisfitCauses> max_misfit_mm = {0.6, 0.7, 0.65, 1.2, 1.5};
  /// Misfit, likewise, of delay, pixel size and calibration that were estimated with the pose. They
  /// then hardly displace it, but the images are drawn as far from their place, and what is tracked
  /// beside them is off. mm, > 0.
  std::array<double, 3> max_corrected_mm = {4, 2.5, 1};
  /// Largest error of the system that was estimated with the pose, in standard deviations of what
  /// was known of it before, > 0. In the CT of another patient, errors far beyond make images fit.
  double max_error_sigmas = 3;
};

/// Returns an error that names the first limit that is out of its range.
Result<void> validate(const AcceptanceLimits& limits);

/// The limits for a registration with this effort. A quick registration is not judged by the
/// probability, which was not fitted to it, but by a score of at least 4.5, a margin of at least
/// 0.15 and a cost of at most 0.25, and has wider limits for a delay and for the calibration where
/// these are not estimated. Coarse samples match more easily: on the development seeds right
/// results cost at most 0.245 and another patient's CT costs at least 0.276. The few images of a
/// quick registration show less about a delay and the calibration: these misfits reach 0.70 and
/// 0.86 mm when nothing is wrong.
AcceptanceLimits limits_for(Effort effort);

/// Values from which an accepted result is accepted with a warning: a result between this value and
/// its limit. A warning value beyond its limit has no effect. The values of cost, score,
/// disagreements and predicted error were chosen on the development seeds, which are all simulated
/// patients; there, 4 to 8 % of the accepted results get a warning
/// (docs/registration-experiments.md). The other values are ones that no result there came near.
inline constexpr AcceptanceLimits kWarningLimits{
    .min_overlap = 0.8,
    .max_error_probability = 0.01,
    .min_z_score = 0,
    .max_cost = 0.4,
    .min_margin = 0.3,
    .max_tre_rms_mm = 1.5,
    .max_split_disagreement_mm = 0.75,
    .max_halves_disagreement_mm = 1.25,
    .max_basin_shift_mm = 0.5,
    .max_scale = 0.008,
    .max_misfit_mm = kTellingMm,
    .max_corrected_mm = {kTellingMm[0], kTellingMm[1], kTellingMm[2]},
    .max_error_sigmas = 2.5};

enum class Verdict { kAccept, kWarn, kReject };
/// Stable lower-case name: `accept`, `warn`, `refuse`.
const char* to_string(Verdict verdict);
/// Text for the user: "accepted", "accepted with warnings", "refused".
const char* in_words(Verdict verdict);

/// The verdict. reasons holds one sentence for each limit that was missed, with the limit and the
/// value found; it is empty exactly when the result is accepted.
struct Decision {
  bool accepted;
  std::vector<std::string> reasons;
  /// One sentence for each value between its warning value and its limit, and one for a solve that
  /// ended at its iteration limit. Only accepted results have warnings.
  std::vector<std::string> warnings = {};

  /// Adds a reason and rejects the result.
  void reject(std::string reason);
  [[nodiscard]] Verdict verdict() const {
    if (!accepted) return Verdict::kReject;
    return warnings.empty() ? Verdict::kAccept : Verdict::kWarn;
  }
};

/// Collects the values that miss their limit or come near it. A NaN misses every limit; an infinite
/// value misses every at_most().
class Judge {
 public:
  Judge() = default;
  /// Continues from an earlier decision.
  explicit Judge(Decision before)
      : reasons_(std::move(before.reasons)), warnings_(std::move(before.warnings)) {}

  void at_least(const std::string& what, double found, double limit, double warning);
  /// \p unit includes its leading space.
  void at_most(const std::string& what, double found, double limit, double warning,
               const std::string& unit);
  void reject(std::string reason) { reasons_.push_back(std::move(reason)); }
  void warn(std::string warning) { warnings_.push_back(std::move(warning)); }
  [[nodiscard]] bool rejected() const { return !reasons_.empty(); }
  [[nodiscard]] bool warned() const { return !warnings_.empty(); }
  [[nodiscard]] Decision decision() &&;

 private:
  void warn(const std::string& what, double found, const std::string& beyond, double limit,
            double warning, const std::string& unit);
  std::vector<std::string> reasons_, warnings_;
};

/// Judges a result for use at a target. A value that is not finite never passes. Limits out of
/// range are a Bug: validate() them first. Warnings do not change what is rejected.
Decision decide(const ImageRegistrationResult& result, const AcceptanceLimits& limits,
                const Point<frames::Ct>& target, const AcceptanceLimits& warnings = kWarningLimits);

/// The most likely cause among the misfits of a result beyond their limits (likeliest_of()), which
/// decide() names. Points into the result; null if no misfit is beyond its limit.
const Misfit* likeliest_misfit(const ImageRegistrationResult& result,
                               const AcceptanceLimits& limits);

/// Limits that a registration by landmarks must meet. Inclusive. A fit of swapped or misplaced
/// pairs has residuals of centimetres; skin markers and bony landmarks stay within a few
/// millimetres.
struct LandmarkLimits {
  double max_fre_rms_mm = 5;  ///< Residual of the pairs, > 0.
  double max_tre_rms_mm = 2;  ///< Predicted at the target, > 0.
};
inline constexpr LandmarkLimits kLandmarkWarnings{.max_fre_rms_mm = 3, .max_tre_rms_mm = 1};

/// Predicted error at a target, mm RMS: computed from the given sigmas, or from the residuals if
/// these show that the sigmas were too small.
double predicted_tre_rms_mm(const LandmarkRegistration& fit, const Point<frames::Ct>& target);

/// Judges a fit for use at a target. A value that is not finite never passes.
Decision decide(const LandmarkRegistration& fit, const LandmarkLimits& limits,
                const Point<frames::Ct>& target,
                const LandmarkLimits& warnings = kLandmarkWarnings);

}  // namespace nav::registration
