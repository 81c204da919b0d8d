// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "nav/result.hpp"
#include "nav/transform.hpp"
#include "registration/image_registration.hpp"
#include "registration/landmarks.hpp"

namespace nav::registration {

/// What a registration must show before anything is drawn with it. Every limit is inclusive. The
/// defaults are frozen on simulated patients: 14 right pairs had scores above 18, costs below 0.28
/// and halves that agreed within 0.6 mm; 36 pairs with another patient of like anatomy had scores
/// below 15.6, costs above 0.40 and halves 1.0 to 4.5 mm apart. They say nothing yet about real
/// patients.
struct AcceptanceLimits {
  double min_overlap = 0.6;                 ///< Fraction of the ultrasound inside the CT, [0, 1].
  double min_z_score = 16;                  ///< Against random poses.
  double max_cost = 0.35;                   ///< Of the result on the finest level, (0, 1].
  double min_margin = 0.15;                 ///< To another minimum, where one was found.
  double max_tre_rms_mm = 2;                ///< Predicted at the target, > 0.
  double max_split_disagreement_mm = 1;     ///< Odd against even pictures, > 0.
  double max_halves_disagreement_mm = 1.5;  ///< First against second half, > 0.
};

/// A refusal that names the first limit out of its range.
Result<void> validate(const AcceptanceLimits& limits);

/// The verdict. reasons holds one sentence for each limit that was missed, with the limit and the
/// value found; empty exactly when accepted.
struct Decision {
  bool accepted;
  std::vector<std::string> reasons;
};

/// Judges a result for use at a target. A value that is not finite never passes. Limits out of
/// range are a Bug: validate() them first.
Decision decide(const ImageRegistrationResult& result, const AcceptanceLimits& limits,
                const Point<frames::Ct>& target);

/// What a registration by landmarks must show. Inclusive. A fit of swapped or misplaced pairs has
/// residuals of centimetres; skin markers and bony landmarks stay within a few millimetres.
struct LandmarkLimits {
  double max_fre_rms_mm = 5;  ///< Residual of the pairs, > 0.
  double max_tre_rms_mm = 2;  ///< Predicted at the target, > 0.
};

/// Predicted error at a target, mm RMS: from the given sigmas, or from the residuals where these
/// say that the sigmas were too small.
double predicted_tre_rms_mm(const LandmarkRegistration& fit, const Point<frames::Ct>& target);

/// Judges a fit for use at a target. A value that is not finite never passes.
Decision decide(const LandmarkRegistration& fit, const LandmarkLimits& limits,
                const Point<frames::Ct>& target);

}  // namespace nav::registration
