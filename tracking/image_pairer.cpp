// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tracking/image_pairer.hpp"

#include <algorithm>
#include <variant>

namespace nav::tracking {
namespace {

Error refuse(const std::string& what) { return Error{ErrorCode::kUsage, "pairing: " + what}; }

PoseGateOptions gate_of_patient(PoseGateOptions options) {
  options.patient = true;
  return options;
}

}  // namespace

const char* to_string(PoseAbsence absence) {
  switch (absence) {
    case PoseAbsence::kNotYet:
      return "no_pose_yet";
    case PoseAbsence::kTooOld:
      return "before_first_pose";
    case PoseAbsence::kNotTracked:
      return "not_tracked";
    case PoseAbsence::kGap:
      return "pose_gap";
  }
  return "unknown";
}

Result<void> validate(const PairingOptions& options) {
  using std::chrono::seconds;
  if (options.temporal_offset > seconds(10) || options.temporal_offset < -seconds(10)) {
    return refuse("expected a temporal offset within 10 s, found " +
                  std::to_string(to_seconds(options.temporal_offset)) + " s");
  }
  if (options.max_wait < Duration::zero()) return refuse("expected max_wait >= 0");
  if (options.max_pose_gap <= Duration::zero()) return refuse("expected max_pose_gap > 0");
  return validate(options.gate);
}

ImagePairer::ImagePairer(
    const std::optional<ProbeCalibration>& calibration,
    std::optional<Transform<frames::Reference, frames::Tracker>> fixed_reference_from_tracker,
    const PairingOptions& options, Diagnostics& diagnostics)
    : fixed_reference_from_tracker_(std::move(fixed_reference_from_tracker)),
      options_(options),
      max_wait_(options.max_wait),
      probe_(options.gate, options.max_pose_gap, diagnostics),
      reference_(gate_of_patient(options.gate), options.max_pose_gap, diagnostics),
      frame_clock_({.tolerance = options.gate.max_delay_change}),
      images_(diagnostics) {
  NAV_CHECK(validate(options).has_value());
  if (calibration) calibrations_.push_back(*calibration);
}

void ImagePairer::expect_period(Duration period) {
  max_wait_ = std::max<Duration>(options_.max_wait, 3 * period);
  const Duration gap = std::max<Duration>(options_.max_pose_gap, 2 * period);
  probe_.set_max_gap(gap);
  reference_.set_max_gap(gap);
}

void ImagePairer::add_frame(UltrasoundImage frame) {
  frame.acquired -= options_.temporal_offset;
  const DeviceTime stamp(DeviceClock::duration(frame.acquired.time_since_epoch().count()));
  const bool believed = !frame_clock_.add(stamp, frame.received).fault;
  const bool off = std::chrono::abs(frame_clock_.change()) > options_.gate.max_delay_change;
  waiting_.push_back({std::move(frame), believed, off});
}

std::optional<PairedImage> ImagePairer::settle(const Waiting& waiting, Timestamp now,
                                               bool end_of_stream) {
  const UltrasoundImage& frame = waiting.frame;
  const auto reject = [&](const std::string& cause) {
    return PairedImage{frame.sequence, std::nullopt, cause};
  };
  if (newest_frame_ && frame.acquired <= *newest_frame_) return reject("time_not_increasing");
  // A negative offset moves the acquisition times of images past their reception.
  const Duration moved = std::max<Duration>(-options_.temporal_offset, Duration::zero());
  if (frame.acquired - frame.received > options_.gate.max_future + moved) {
    return reject("time_in_future");
  }
  if (!waiting.clock_believed) return reject("clock_not_believed");
  if (frame.pixels.empty()) return reject("no_image");
  if (!validate(frame.grid)) return reject("invalid_pixel_grid");

  const ImageGeometry geometry = geometry_of(frame);
  const auto calibration =
      std::ranges::find_if(calibrations_, [&](const auto& one) { return one.fits(geometry); });
  without_calibration_.clear();
  if (calibration == calibrations_.end()) {
    without_calibration_ =
        "no calibration of the probe fits the images, which are now " + geometry.description();
    return reject("no_calibration");
  }

  // The pose of an image that is stamped early arrives as much later.
  const bool given_up = end_of_stream || now > frame.received + max_wait_ + moved;
  const auto probe = probe_.buffer().at(frame.acquired);
  if (const auto* absence = std::get_if<PoseAbsence>(&probe)) {
    if (*absence == PoseAbsence::kNotYet && !given_up) return std::nullopt;
    return reject(std::string("Probe.") + to_string(*absence));
  }
  const auto& tracker_from_probe = std::get<PoseAt<frames::Probe>>(probe);
  std::string doubt = sentence(tracker_from_probe.doubt, "the probe");
  if (doubt.empty() && frame.clock_unsure) {
    doubt = "the clock of the images is not known well yet";
  }
  if (doubt.empty() && waiting.clock_off) {
    doubt = "the times of the images are off: their clock drifts or was set";
  }
  std::optional<Timestamp> repeats;
  if (const auto repeated = images_.find(frame, tracker_from_probe.tracker_from_body)) {
    repeats = repeated->acquired;
    if (doubt.empty()) doubt = repeated->doubt;
  }
  if (!calibration->doubt.empty()) {
    doubt = calibration->doubt + (doubt.empty() ? "" : "; " + doubt);
  }
  if (fixed_reference_from_tracker_) {
    return PairedImage{
        frame.sequence,
        TrackedImage{frame,
                     *fixed_reference_from_tracker_ * tracker_from_probe.tracker_from_body *
                         calibration->probe_from_image,
                     tracker_from_probe.gap, doubt, repeats},
        ""};
  }
  const auto reference = reference_.buffer().at(frame.acquired);
  if (const auto* absence = std::get_if<PoseAbsence>(&reference)) {
    if (*absence == PoseAbsence::kNotYet && !given_up) return std::nullopt;
    return reject(std::string("Reference.") + to_string(*absence));
  }
  const auto& tracker_from_reference = std::get<PoseAt<frames::Reference>>(reference);
  return PairedImage{
      frame.sequence,
      TrackedImage{
          frame,
          tracker_from_reference.tracker_from_body.inverse() *
              tracker_from_probe.tracker_from_body * calibration->probe_from_image,
          std::max(tracker_from_probe.gap, tracker_from_reference.gap),
          doubt.empty() ? sentence(tracker_from_reference.doubt, "the patient reference") : doubt,
          repeats},
      ""};
}

std::vector<PairedImage> ImagePairer::take_ready(Timestamp now, bool end_of_stream) {
  std::vector<PairedImage> ready;
  while (!waiting_.empty()) {
    auto settled = settle(waiting_.front(), now, end_of_stream);
    if (!settled) break;  // Order is kept: later images wait behind this one.
    if (settled->tracked) newest_frame_ = waiting_.front().frame.acquired;
    ready.push_back(std::move(*settled));
    waiting_.pop_front();
  }
  return ready;
}

}  // namespace nav::tracking
