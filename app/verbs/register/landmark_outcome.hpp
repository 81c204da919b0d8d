// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/console.hpp"
#include "app/report.hpp"
#include "nav/transform.hpp"
#include "registration/landmarks/landmarks.hpp"

namespace nav::app {

/// A pair that does not belong to the fit.
struct RejectedLandmark {
  std::string name;
  double distance_mm;  ///< From the fit of the others.
};

/// Two pairs whose points may have been taken for each other: swapped, they fit as well.
struct SwappedLandmarks {
  std::string one, other;
  double fre_rms_mm;  ///< Of all pairs when these are swapped, within the limit of the residual.
  Transform<frames::Ct, frames::Reference> ct_from_reference;  ///< Then.
};

/// What 'sonde register --landmarks' found.
struct LandmarkOutcome {
  registration::LandmarkRegistration fit;  ///< Of the pairs that agree.
  std::vector<RejectedLandmark> rejected;
  double gate_sigmas;       ///< A pair farther from the fit is rejected, in its sigmas.
  bool shaped;              ///< The errors' axes were given and used.
  std::string no_majority;  ///< Why no pairs were singled out although they disagree; else empty:
                            ///< the fit is then that of all pairs and never accepted.
  std::vector<SwappedLandmarks> swapped = {};  ///< Of up to kMostSwapped pairs with a majority.
  /// Residual of the pairs with one frame mirrored, RMS, where it is within the limit: they lie
  /// nearly in one plane, and do not tell left from right.
  std::optional<double> mirrored_fre_rms_mm = {};
};

/// Longer lists have too many others to fit when two are swapped.
inline constexpr std::size_t kMostSwapped = 60;

/// Fits the pairs of a file that agree with each other (robust_landmarks.hpp), refined with the
/// axes of their errors where the file has them; warns of every rejected pair. Without sigmas in
/// the file a pair may be 5 mm off, the limit of the residual. Errors name the file.
Result<LandmarkOutcome> register_landmark_file(const std::filesystem::path& path,
                                               Diagnostics& diagnostics);

/// Whether the outcome may be used at a target. Warns where three pairs alone are used, which fit
/// any wrong point somehow, where more fit as well mirrored, and where two that are swapped move
/// the target beyond the limit of its error.
registration::Decision decide(const LandmarkOutcome& outcome, const Point<frames::Ct>& target);

/// docs/json.md, registration by landmarks. ct: adds the error over it; null: there is none.
io::Json json_of(const LandmarkOutcome& outcome, const registration::Decision& decision,
                 const Point<frames::Ct>& target, const Volume* ct);

}  // namespace nav::app
