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

/// What a registration must show before anything is drawn with it. Every limit is inclusive. The
/// defaults are frozen on the development seeds of 'sonde bench registration', simulated patients
/// all of them: 20 right results cost at most 0.24 and their halves agreed within 0.8 mm but for
/// one of 2.3 mm; results with another patient of like anatomy cost at least 0.42, other hopeless
/// ones 0.38 and more. They say nothing yet about real patients, whom the cost will rather refuse.
struct AcceptanceLimits {
  double min_overlap = 0.6;  ///< Fraction of the ultrasound inside the CT, [0, 1].
  double min_z_score = 4.5;  ///< Against random poses, first level.
  /// That pictures were taken at, BootstrapOptions::block_mm apart: those of fewer match elsewhere
  /// nearly as well, and what they have in common no draw of them shows.
  int min_places = kLeastPlaces;
  double max_cost = 0.33;                   ///< Of the result on the finest level, (0, 1].
  double min_margin = 0.15;                 ///< To another minimum, where one was found.
  double max_tre_rms_mm = 2;                ///< Predicted at the target, > 0.
  double max_split_disagreement_mm = 1;     ///< Odd against even pictures, > 0.
  double max_halves_disagreement_mm = 2.5;  ///< First against second half, > 0.
  double max_basin_shift_mm = 1.5;          ///< To lower costs nearby without derivatives, > 0.
  /// Strain or depth factor off one that was refined beside the pose, > 0: pictures are shown as
  /// they came, and 1 % of 100 mm is a millimetre.
  double max_stretch = 0.01;
  /// Beyond noise, by MisfitCause, mm, > 0. On the development seeds at most 0.35, 0.34, 0.5, 0.79
  /// and 0.91 where nothing is wrong; 0.86 and more where pixels are 1.5 % off, 1.1 and more where
  /// pictures are 100 ms late and the pose was accepted, 1.4 and more where the patient breathes.
  std::array<double, kMisfitCauses> max_misfit_mm = {0.6, 0.7, 0.65, 1.2, 1.5};
};

/// A refusal that names the first limit out of its range.
Result<void> validate(const AcceptanceLimits& limits);

/// The limits for a registration by such an effort: the defaults, but for a quick one a cost of at
/// most 0.25. Coarse samples match more easily: on the development seeds right ones cost at most
/// 0.245, another patient's CT at least 0.276. Its few pictures disagree more, and tell less of a
/// delay and of the calibration: up to 0.70 and 0.86 mm where nothing is wrong.
AcceptanceLimits limits_for(Effort effort);

/// From where on a result that is accepted is accepted with a warning: between here and its limit;
/// a warning beyond its limit never comes. Those of cost, score, disagreements and predicted error
/// were chosen on the development seeds, simulated patients all of them, where 4 to 8 % of the
/// accepted results are warned of (docs/experiments/registration.md); the others say what nothing
/// there came near.
inline constexpr AcceptanceLimits kWarningLimits{.min_overlap = 0.8,
                                                 .min_z_score = 5,
                                                 .max_cost = 0.28,
                                                 .min_margin = 0.3,
                                                 .max_tre_rms_mm = 0.5,
                                                 .max_split_disagreement_mm = 0.5,
                                                 .max_halves_disagreement_mm = 1.25,
                                                 .max_basin_shift_mm = 0.5,
                                                 .max_stretch = 0.008,
                                                 .max_misfit_mm = kTellingMm};

enum class Verdict { kAccept, kWarn, kRefuse };
/// "accept", "warn", "refuse".
const char* to_string(Verdict verdict);
/// For the user: "accepted", "accepted with warnings", "refused".
const char* in_words(Verdict verdict);

/// The verdict. reasons holds one sentence for each limit that was missed, with the limit and the
/// value found; empty exactly when accepted.
struct Decision {
  bool accepted;
  std::vector<std::string> reasons;
  /// One sentence for each value between its warning and its limit, and for a solve that ended at
  /// its iteration limit; of accepted results only.
  std::vector<std::string> warnings = {};

  /// One more reason.
  void refuse(std::string reason);
  [[nodiscard]] Verdict verdict() const {
    if (!accepted) return Verdict::kRefuse;
    return warnings.empty() ? Verdict::kAccept : Verdict::kWarn;
  }
};

/// Collects what misses its limit and what comes near it. A value that is NaN misses every limit,
/// one that is infinite every at_most().
class Judge {
 public:
  Judge() = default;
  /// Goes on where another has ended.
  explicit Judge(Decision before)
      : reasons_(std::move(before.reasons)), warnings_(std::move(before.warnings)) {}

  void at_least(const std::string& what, double found, double limit, double warning);
  /// unit: with its space.
  void at_most(const std::string& what, double found, double limit, double warning,
               const std::string& unit);
  void refuse(std::string reason) { reasons_.push_back(std::move(reason)); }
  void warn(std::string warning) { warnings_.push_back(std::move(warning)); }
  [[nodiscard]] Decision decision() &&;

 private:
  void warn(const std::string& what, double found, const std::string& beyond, double limit,
            double warning, const std::string& unit);
  std::vector<std::string> reasons_, warnings_;
};

/// Judges a result for use at a target. A value that is not finite never passes. Limits out of
/// range are a Bug: validate() them first. Warnings change nothing of what is refused.
Decision decide(const ImageRegistrationResult& result, const AcceptanceLimits& limits,
                const Point<frames::Ct>& target, const AcceptanceLimits& warnings = kWarningLimits);

/// The misfit beyond its limit that decide() names, what is most likely wrong: the one of fewest
/// numbers that explains two fifths of what any of them does. A delay looks like a motion too, and
/// wrong pixels like a bend. One of the result's; null where none is beyond its limit.
const Misfit* likeliest_misfit(const ImageRegistrationResult& result,
                               const AcceptanceLimits& limits);

/// What a registration by landmarks must show. Inclusive. A fit of swapped or misplaced pairs has
/// residuals of centimetres; skin markers and bony landmarks stay within a few millimetres.
struct LandmarkLimits {
  double max_fre_rms_mm = 5;  ///< Residual of the pairs, > 0.
  double max_tre_rms_mm = 2;  ///< Predicted at the target, > 0.
};
inline constexpr LandmarkLimits kLandmarkWarnings{.max_fre_rms_mm = 3, .max_tre_rms_mm = 1};

/// Predicted error at a target, mm RMS: from the given sigmas, or from the residuals where these
/// say that the sigmas were too small.
double predicted_tre_rms_mm(const LandmarkRegistration& fit, const Point<frames::Ct>& target);

/// Judges a fit for use at a target. A value that is not finite never passes.
Decision decide(const LandmarkRegistration& fit, const LandmarkLimits& limits,
                const Point<frames::Ct>& target,
                const LandmarkLimits& warnings = kLandmarkWarnings);

}  // namespace nav::registration
