// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "nav/volume.hpp"
#include "session/navigator.hpp"
#include "session/options.hpp"
#include "session/recorded_session.hpp"

namespace nav::session {

/// The CT that a session names, read with the session's options; errors are those of io::read_ct.
/// \p expect_hounsfield_units: as in io::CtOptions.
Result<std::shared_ptr<const Volume>> read_session_ct(const CtOptions& options,
                                                      Diagnostics& diagnostics,
                                                      bool expect_hounsfield_units = true);

/// Position of a recording's CT and the reason for it.
struct Placement {
  CtPlacement placement;
  std::string kind;                        ///< "registered", "declared", "centred".
  std::string statement;                   ///< One sentence for the report.
  std::vector<std::string> warnings = {};  ///< Warnings of an accepted registration.
  std::vector<Finding> findings = {};      ///< Contradictions, and missing parts.
  /// One sentence with the distance if no image of the sweep meets the CT; else empty.
  std::string outside = {};
  /// Covariance of a registration; absent: not known, or the CT follows the tissue, whose error it
  /// does not hold.
  std::optional<registration::PoseUncertainty> uncertainty = {};
  /// Recording of the registration; absent: of any.
  std::optional<RecordingRead> registered_recording = {};
};

/// Placement by a registration file or a declared matrix, in this order; absent: neither is given,
/// so the images decide. Only a registration is valid. Reads the registration file, which computes
/// the digest of the CT.
Result<std::optional<Placement>> given_placement(const PlacementOptions& options, const Volume& ct,
                                                 const std::string& reference_frame);

/// Placement of a recording's images. \p given: the result of given_placement(), whose registration
/// has to fit \p recording, which is what is known of the recording; absent: nothing. Without a
/// given placement, the centre rule puts the sweep's centre at the CT's centre, the images' depth
/// towards posterior and their lateral axis towards the patient's left; this is degraded.
Result<Placement> place_sweep(const PlacementOptions& options,
                              const std::optional<Placement>& given, const Volume& ct,
                              const SweepSurvey& sweep,
                              const std::optional<RecordingRead>& recording);

/// given_placement() and place_sweep() in one.
Result<Placement> place_ct(const PlacementOptions& options, const Volume& ct,
                           const SweepSurvey& sweep, const std::optional<RecordingRead>& recording,
                           const std::string& reference_frame);

/// Tells how far images stay outside the CT, from the images so far. Not thread-safe.
class OutsideWatch {
 public:
  void add(const Volume& ct, const CtPlacement& placement, const TrackedImage& image);
  /// One sentence with the distance of the nearest image while none has met the CT; else empty.
  [[nodiscard]] std::string warning() const;

 private:
  std::optional<double> nearest_mm_;
};

}  // namespace nav::session
