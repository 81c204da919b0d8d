// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/placement.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "io/ct.hpp"
#include "session/outside_ct.hpp"
#include "session/registration_file.hpp"

namespace nav::session {
namespace {

/// Reference to CT by the mean axes of the images. The axes stay if the mean axes cancel out.
Transform<frames::Ct, frames::Reference> centred(const Volume& ct, const SweepSurvey& sweep) {
  const Eigen::Matrix3d axes = mean_axes(sweep).value_or(Eigen::Matrix3d::Identity());
  // LPS: +x left, +y posterior, +z superior.
  const Eigen::Quaterniond turn(Eigen::Matrix3d(axes.transpose()));
  return {turn.normalized(), ct.grid().centre().mm - turn * sweep.centroid.mm};
}

/// Distance of the nearest image from the CT, mm; 0 if one meets it, infinite without images.
double nearest_of(const Volume& ct, const SweepSurvey& sweep,
                  const Transform<frames::Ct, frames::Reference>& ct_from_reference) {
  constexpr std::size_t kCorners = 4;
  double nearest_mm = std::numeric_limits<double>::infinity();
  std::array<Point<frames::Ct>, kCorners> image;
  for (std::size_t i = 0; i < sweep.corners.size(); ++i) {
    image[i % kCorners] = ct_from_reference * sweep.corners[i];
    if (i % kCorners == kCorners - 1) nearest_mm = std::min(nearest_mm, mm_outside(ct, image));
  }
  return nearest_mm;
}

std::string outside_text(double nearest_mm) {
  if (!(nearest_mm > 0 && std::isfinite(nearest_mm))) return "";
  return "the sweep lies outside the CT; its nearest image is " +
         std::to_string(std::lround(std::ceil(nearest_mm))) + " mm away";
}

}  // namespace

Result<std::shared_ptr<const Volume>> read_session_ct(const CtOptions& options,
                                                      Diagnostics& diagnostics,
                                                      bool expect_hounsfield_units) {
  auto ct = io::read_ct(options.path, diagnostics,
                        {.series_uid = options.series_uid,
                         .accept_unknown_orientation = options.accept_unknown_orientation,
                         .expect_hounsfield_units = expect_hounsfield_units});
  if (!ct) return ct.error();
  return std::make_shared<const Volume>(std::move(*ct));
}

Result<std::optional<Placement>> given_placement(const PlacementOptions& options, const Volume& ct,
                                                 const std::string& reference_frame) {
  if (!options.registration.empty()) {
    auto registered =
        read_registration(options.registration, ct, {reference_frame, options.follow});
    if (!registered) return registered.error();
    const Safety safety =
        registered->names_frame
            ? Safety{SafetyState::kValid, ""}
            : Safety{SafetyState::kDegraded,
                     "the registration does not name the patient's frame (register with "
                     "--reference-frame)"};
    return std::optional(
        Placement{.placement = {registered->ct_from_reference, safety},
                  .kind = "registered",
                  .statement = "The CT was registered: " + options.registration.string() + ".",
                  .warnings = std::move(registered->warnings),
                  .findings = findings_of(*registered, options.registration),
                  .uncertainty = options.follow ? std::nullopt : registered->uncertainty,
                  .registered_recording = std::move(registered->recording)});
  }
  if (!options.ct_from_reference) return std::optional<Placement>();
  auto declared = rigid_from_matrix<frames::Ct, frames::Reference>(*options.ct_from_reference);
  if (!declared) {
    return Error{declared.error().code,
                 "placement.ct_from_reference_mm: " + declared.error().message};
  }
  return std::optional(Placement{
      .placement = {*declared,
                    {SafetyState::kDegraded, "the CT is placed by declaration, not registered"}},
      .kind = "declared",
      .statement = "The CT is not registered: it lies where the user declared it to lie."});
}

Result<Placement> place_sweep(const PlacementOptions& options,
                              const std::optional<Placement>& given, const Volume& ct,
                              const SweepSurvey& sweep,
                              const std::optional<RecordingRead>& recording) {
  if (given && given->registered_recording && recording) {
    const auto fits =
        check_recording(*given->registered_recording, *recording, options.registration);
    if (!fits) return fits.error();
  }
  Placement found =
      given ? *given
            : Placement{.placement = {centred(ct, sweep),
                                      {SafetyState::kDegraded,
                                       "the CT is only centred on the sweep, not registered"}},
                        .kind = "centred",
                        .statement =
                            "The CT is not registered. No registration given: the "
                            "ultrasound is centred on the CT; the depth of its images "
                            "points to posterior, their lateral axis to the patient's "
                            "left."};
  found.outside = outside_text(nearest_of(ct, sweep, found.placement.ct_from_reference));
  return found;
}

Result<Placement> place_ct(const PlacementOptions& options, const Volume& ct,
                           const SweepSurvey& sweep, const std::optional<RecordingRead>& recording,
                           const std::string& reference_frame) {
  const auto given = given_placement(options, ct, reference_frame);
  if (!given) return given.error();
  return place_sweep(options, *given, ct, sweep, recording);
}

void OutsideWatch::add(const Volume& ct, const CtPlacement& placement, const TrackedImage& image) {
  if (nearest_mm_ && *nearest_mm_ <= 0) return;
  const SweepSurvey sweep = survey_of(image);
  const double mm = nearest_of(ct, sweep, placement.ct_from_reference);
  nearest_mm_ = std::min(nearest_mm_.value_or(mm), mm);
}

std::string OutsideWatch::warning() const { return outside_text(nearest_mm_.value_or(0)); }

}  // namespace nav::session
