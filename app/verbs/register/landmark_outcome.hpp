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
#include "nav/volume.hpp"
#include "registration/landmarks/landmark_scale.hpp"
#include "registration/landmarks/landmarks.hpp"

namespace nav::app {

/// Pair that is not used in the fit.
struct RejectedLandmark {
  std::string name;
  double distance_mm;  ///< Distance from the fit of the other pairs.
};

/// Two pairs whose points may have been confused: swapped, they also fit within the limit.
struct SwappedLandmarks {
  std::string one, other;
  double fre_rms_mm;  ///< Residual of all pairs after the swap, within the limit.
  Transform<frames::Ct, frames::Reference> ct_from_reference;  ///< Pose after the swap.
};

/// Result of 'sonde register --landmarks'.
struct LandmarkOutcome {
  registration::LandmarkRegistration fit;  ///< Fit of the pairs that agree.
  std::vector<RejectedLandmark> rejected{};
  double gate_sigmas;  ///< Pairs farther than this from the fit, in their sigmas, are rejected.
  bool shaped;         ///< The file has the axes of the errors, and they were used.
  /// Reason why no majority of pairs agrees; empty when there is one. Without a majority the fit
  /// uses all pairs and is never accepted.
  std::string no_majority;
  std::vector<SwappedLandmarks> swapped = {};  ///< Empty without a majority, or above kMostSwapped.
  /// RMS residual of the pairs with one frame mirrored; present when it is within the limit. The
  /// pairs then lie nearly in one plane and cannot tell left from right.
  std::optional<double> mirrored_fre_rms_mm = {};
  /// A wrong scale by which all pairs agree. No pair is rejected then, the fit uses all and is
  /// never accepted.
  std::optional<registration::LandmarkScale> scale = {};
};

/// Largest number of pairs for which swaps are tested. In longer lists the other pairs outweigh two
/// that are swapped.
inline constexpr std::size_t kMostSwapped = 60;

/// Fits the pairs of a file, or of two Markups files (\p ct_points: that of the CT; else empty),
/// that agree with each other (robust_landmarks.hpp). If the file has the axes of the errors, the
/// fit is refined with them. Warns of every rejected pair. If the file has no sigmas, a pair may be
/// off by 5 mm, the limit of the residual. ct: rejects files with a point more than 5 mm outside
/// it, which the message names; may be null. Errors name the file.
Result<LandmarkOutcome> register_landmark_file(const std::filesystem::path& path,
                                               const std::filesystem::path& ct_points,
                                               const Volume* ct, Diagnostics& diagnostics);

/// Decides if the outcome may be used at a target. Warns when only three pairs are used, because
/// three pairs fit even a wrong point; when the pairs also fit mirrored; and when a swap of two
/// pairs moves the target beyond the limit of its error.
registration::Decision decide(const LandmarkOutcome& outcome, const Point<frames::Ct>& target);

/// JSON of a registration by landmarks (docs/json.md). ct: adds the predicted error over the CT;
/// may be null.
io::Json json_of(const LandmarkOutcome& outcome, const registration::Decision& decision,
                 const Point<frames::Ct>& target, const Volume* ct);

/// CT of a registration, by its name in the report; null: there was none.
struct ReportedCt {
  const Volume* ct;
  std::string name;
};
/// Contents of report.json of a registration by landmarks, which session::read_registration()
/// reads. reference_frame: empty where it is not known. Computes the digest of the CT.
io::Json landmark_report(const LandmarkOutcome& outcome, const registration::Decision& decision,
                         const Point<frames::Ct>& target, const ReportedCt& ct,
                         const std::string& reference_frame);

}  // namespace nav::app
