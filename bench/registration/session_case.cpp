// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/registration/session_case.hpp"

#include "bench/registration/cohort.hpp"
#include "sim/ct_scanner.hpp"

namespace nav::bench {

Result<SessionCase> make_session_case(sim::SimulatedSessionOptions options) {
  const auto patient = sim::make_patient(options.family, {options.seed, *options.contrast});
  if (!patient) return patient.error();
  const sim::AcousticModel model = options.probe.model;
  options.probe = patient->views.front().probe;
  options.probe.model = model;
  options.standard_view = true;
  const auto session = sim::SimulatedSession::create(options, *patient);
  if (!session) return session.error();
  sim::CtOptions scan;
  scan.seed = options.seed;
  auto ct = sim::scan_ct(session->patient(), scan);
  if (!ct) return ct.error();
  std::vector<TrackedImage> frames;
  std::vector<registration::Pose> following_truth;
  const auto images = session->frames();
  const registration::Pose truth = session->ct_from_reference();
  for (int i = 0; i < session->frame_count(); ++i) {
    auto frame = images->next(Timestamp::max());
    if (!frame) return frame.error();
    const sim::ImageTruth now = session->truth(i);
    const auto reference_from_image = truth.inverse() * now.ct_from_image;
    frames.push_back({std::move(*frame), reference_from_image, Duration{0}});
    following_truth.push_back(now.rest.ct_from_image * reference_from_image.inverse());
  }
  auto sweep = Sweep::create(std::move(frames), "simulated");
  if (!sweep) return sweep.error();
  const std::vector<Point<frames::Ct>> targets = session->patient().targets();
  std::vector<Point<frames::Ct>> lying = targets;
  if (const auto deformation = session->deformation()) {
    for (auto& target : lying) target.mm = deformation->apply(target.mm);
  }
  return SessionCase{.ct = std::move(*ct),
                     .sweep = std::move(*sweep),
                     .truth = truth,
                     .targets = targets,
                     .lying = std::move(lying),
                     .following_truth = std::move(following_truth)};
}

double error_mm(const SessionCase& one, const registration::Pose& found) {
  return target_error_mm(found, one.truth, one.targets, one.lying);
}

}  // namespace nav::bench
