// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "io/json.hpp"
#include "nav/diagnostics.hpp"
#include "nav/result.hpp"
#include "nav/volume.hpp"
#include "registration/uncertainty/pose_uncertainty.hpp"

namespace nav::session {

/// Key of the pose in the JSON of 'sonde register'. The pose of a rejected registration has a key
/// of its own, so that no reader takes it by mistake.
inline constexpr const char* kAcceptedPose = "ct_from_reference_mm";
inline constexpr const char* kRefusedPose = "refused_ct_from_reference_mm";

/// SHA-256 of a CT's grid and voxels: what a registration belongs to.
std::string ct_digest(const Volume& ct);

/// The recording that a registration by images was made from, and how it was read.
struct RecordingRead {
  std::string name;                      ///< File name without the folder.
  std::optional<std::int64_t> frames{};  ///< All frames, usable or not; absent before the end.
  double first_s = 0;                    ///< First stamp.
  std::optional<double> last_s{};        ///< Last stamp; absent before the end.
  double temporal_offset_ms = 0;         ///< Image stamps minus pose stamps, as configured.
  /// Calibration: positions of the first pixel, the end of the first row and the end of the first
  /// column of the images on the probe, mm.
  std::array<Point<frames::Probe>, 3> corners{{{{0, 0, 0}}, {{0, 0, 0}}, {{0, 0, 0}}}};
};

/// `recording` in the JSON of 'sonde register'.
io::Json json_of(const RecordingRead& recording);

/// A registration that was accepted.
struct ReadRegistration {
  Transform<frames::Ct, frames::Reference> ct_from_reference;
  std::vector<std::string> warnings;       ///< Empty unless it was accepted with warnings.
  std::optional<RecordingRead> recording;  ///< Recording that it was made from; absent: of any.
  /// Covariance of the pose; absent: the file has none, because the images do not determine a
  /// direction or because the registration is of landmarks.
  std::optional<registration::PoseUncertainty> uncertainty = {};
  bool names_frame = true;  ///< False: of landmarks alone, which do not say whose frame it is.
  io::Json json{};          ///< The file.
};

/// Use of a registration, which it has to fit.
struct RegistrationUse {
  std::string reference_frame;  ///< The patient's, by its name in the recording.
  bool follows = false;         ///< The CT follows the tissue from there.
};

/// Names what a registration does not say: the patient's frame. \p path: its file.
std::vector<Finding> findings_of(const ReadRegistration& registration,
                                 const std::filesystem::path& path);

/// Reads the JSON that 'sonde register' wrote. Rejects a file that is not one, a registration that
/// was not accepted, one of another CT or frame, one that contradicts itself (a verdict that is
/// unknown or contradicts `accepted`, another verdict beside the registration, entries in
/// `reasons`, a refused pose, an error beyond the limits of registration::AcceptanceLimits or
/// beyond a limit in the file, a damaged recording or covariance), and a matrix that is not rigid;
/// one with the breath, whose pose is that of rest, unless the CT follows. A file without a verdict
/// has no warnings, one without a recording (of landmarks, or older) is of any. Computes the digest
/// of the CT, which takes a while.
Result<ReadRegistration> read_registration(const std::filesystem::path& path, const Volume& ct,
                                           const RegistrationUse& use);

/// Reads it for no CT and no recording in particular, so that nothing is compared with them.
Result<ReadRegistration> read_registration(const std::filesystem::path& path);

/// Rejects a registration of the recording that is read now, if that is read with another
/// calibration or offset: the pose depends on how the recording was read, and its images would lie
/// elsewhere. Another recording may be of another probe. \p path: file of the registration.
Result<void> check_recording(const RecordingRead& registered, const RecordingRead& now,
                             const std::filesystem::path& path);

}  // namespace nav::session
