// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "nav/result.hpp"
#include "nav/transform.hpp"
#include "registration/image_registration.hpp"

namespace nav::registration {

/// What a registration must show before anything is drawn with it. Every limit is inclusive.
struct AcceptanceLimits {
  double min_overlap = 0.6;               ///< Fraction of the ultrasound inside the CT, [0, 1].
  double min_z_score = 8;                 ///< Against random poses.
  double min_margin = 0.15;               ///< To another minimum, where one was found.
  double max_tre_rms_mm = 3;              ///< Predicted at the target, > 0.
  double max_split_disagreement_mm = 2;   ///< Odd against even pictures, > 0.
  double max_halves_disagreement_mm = 8;  ///< First against second half, > 0.
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

}  // namespace nav::registration
