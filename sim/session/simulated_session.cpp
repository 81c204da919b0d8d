// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/session/simulated_session.hpp"

#include <cmath>

#include "nav/check.hpp"
#include "sim/mount.hpp"
#include "sim/persistence.hpp"
#include "sim/random.hpp"
#include "sim/session/free_view.hpp"
#include "sim/session/needle_path.hpp"

namespace nav::sim {
namespace {

using Vec = Eigen::Vector3d;
using frames::Ct;
using frames::Image;
using frames::Probe;
using frames::Reference;
using frames::Tracker;

constexpr std::uint64_t kProbeBody = 0;
constexpr std::uint64_t kReferenceBody = 1;
constexpr std::uint64_t kNeedleBody = 2;
constexpr Timestamp kBegin{std::chrono::seconds(1)};
constexpr double kReadyMm = 30;  // Distance of the needle from the skin before an approach.
/// Time before the first and after the last image during which a tracker also streams.
constexpr Duration kTrackerLeadIn = std::chrono::milliseconds(500);

/// Pose of the reference on the skin, about a hand's breadth from the probe.
Transform<Ct, Reference> placed_reference(const Transform<Ct, Image>& middle, Random random) {
  const Vec at = (middle * Point<Image>{{0, -20, 0}}).mm + Vec(40, 0, 90) + random.offset(10);
  return {random_mount(random), at};
}

/// Mean position of the probe, in the middle of the sweep and in the approach, and of the needle's
/// hub, CT.
Vec middle_of_bodies(const Transform<Image, Probe>& image_from_probe,
                     const Transform<Ct, Image>& middle,
                     const std::optional<NeedleInsertion>& needle,
                     const std::optional<Transform<Ct, Image>>& approach) {
  Vec sum = (middle * image_from_probe).translation_mm();
  if (needle) sum += needle->ct_from_hub(kBegin).translation_mm();
  if (approach) sum += (*approach * image_from_probe).translation_mm();
  return sum / (1 + (needle ? 1 : 0) + (approach ? 1 : 0));
}

Transform<Tracker, Ct> place_tracker(TrackerKind kind, const Vec& middle_ct, Random random) {
  const Eigen::Quaterniond turn = random_mount(random);
  return {turn, sweet_spot_mm(kind) - turn * middle_ct};
}

std::vector<PhaseInterval> phases_of(const SimulatedSessionOptions& o) {
  const auto interval = [&o](Phase phase, Timestamp begin, double duration_s, int first) {
    const int last = static_cast<int>(duration_s * o.frame_rate_hz + 1e-9);
    return PhaseInterval{.phase = phase,
                         .begin = begin,
                         .end = begin + from_seconds(last / o.frame_rate_hz),
                         .first_frame = first,
                         .frame_count = last + 1};
  };
  std::vector<PhaseInterval> phases{interval(Phase::kSweep, kBegin, o.duration_s, 0)};
  if (o.approach) {
    const Timestamp begin = kBegin + from_seconds(o.duration_s + o.approach->pause_s);
    phases.push_back(
        interval(Phase::kApproach, begin, o.approach->duration_s, phases.front().frame_count));
  }
  return phases;
}

HandPathOptions path_options(const SimulatedSessionOptions& o) {
  HandPathOptions path = o.path;
  path.begin = kBegin;
  path.end = kBegin + from_seconds(o.duration_s);
  path.tremor.seed = hash_bits(o.seed, 0x68616e64, 0);
  return path;
}

BreathingOptions breathing_options(const SimulatedSessionOptions& o) {
  BreathingOptions breathing = o.breathing;
  breathing.seed = hash_bits(o.seed, 0x62726561, 0);
  return breathing;
}

/// Creates the deformation; null when there is none.
Result<std::shared_ptr<const SmoothWarp>> deformation_of(const SimulatedSessionOptions& o,
                                                         const Anatomy& patient) {
  if (o.deformation.largest_mm == 0) return std::shared_ptr<const SmoothWarp>();
  DeformationOptions deformation = o.deformation;
  deformation.seed = hash_bits(o.seed, 0x6465666f, 0);
  auto warp = make_deformation(deformation, patient.targets());
  if (!warp) return warp.error();
  return std::shared_ptr<const SmoothWarp>(std::make_shared<SmoothWarp>(std::move(*warp)));
}

/// Images of a session on the virtual clock.
class SessionFrames final : public ImageStream {
 public:
  SessionFrames(const SimulatedSession& session, const UltrasoundSimulator& simulator)
      : session_(session), simulator_(simulator), persistence_(simulator.probe().persistence) {}

  Result<UltrasoundImage> next(Deadline deadline) override {
    constexpr const char* kName = "simulated probe: ";
    if (stopped_) return Error{ErrorCode::kCancelled, std::string(kName) + "stopped"};
    if (index_ >= session_.frame_count()) {
      return Error{ErrorCode::kEndOfStream, std::string(kName) + "the recording time has ended"};
    }
    const ImageTiming& timing = session_.options().image_timing;
    const ImageTruth truth = session_.truth(index_);
    const Timestamp received = truth.physical + timing.latency;
    if (received > deadline) {
      return Error{ErrorCode::kTimeout, std::string(kName) + "no image before the deadline"};
    }
    const bool shows_needle = session_.needle() && truth.physical >= session_.phases().back().begin;
    const NeedleShaft needle =
        shows_needle ? NeedleShaft(session_.needle()->shaft_ct(truth.physical)) : NeedleShaft();
    UltrasoundImage frame =
        simulator_.simulate(truth.ct_from_image, truth.physical + timing.stamp_offset,
                            static_cast<std::uint64_t>(index_), needle,
                            session_.undeformed() ? nullptr : truth.warp.get());
    frame.received = received;
    persistence_.apply(frame);
    ++index_;
    return frame;
  }
  void stop() noexcept override { stopped_ = true; }

 private:
  const SimulatedSession& session_;
  const UltrasoundSimulator& simulator_;
  Persistence persistence_;
  int index_ = 0;
  bool stopped_ = false;
};

}  // namespace

SimulatedSessionOptions demonstrated_procedure(std::uint64_t seed) {
  SimulatedSessionOptions session;
  session.seed = seed;
  session.path.kind = HandPathKind::kTilt;
  session.path.length_mm = 80;
  session.path.angle_rad = 1.1;
  session.path.tremor.drift_mm = 0.2;
  session.path.tremor.drift_rad = 0.002;
  session.approach.emplace();
  return session;
}

void set_errors(ErrorLevel level, SimulatedSessionOptions& options) {
  const LevelErrors errors = errors_of(level);
  set_image_errors(errors, options.probe);
  options.path.unevenness = errors.unevenness;
  options.pressure_mm = options.probe.stand_off_mm > 0 ? 0 : errors.pressure_mm;
  options.tracker = TrackerKind::kIdeal;
  options.tracker_noise_mm = errors.tracker_mm;
  options.calibration_mm = errors.calibration_mm;
  options.calibration_rad = errors.calibration_rad;
  options.image_timing.stamp_offset = from_seconds(1e-3 * errors.delay_ms);
  options.image_timing.latency =
      std::max(options.image_timing.latency, options.image_timing.stamp_offset);
}

Result<void> validate(const SimulatedSessionOptions& o) {
  const auto reject = [](const char* what) {
    return Error{ErrorCode::kUsage, std::string("simulated session: expected ") + what};
  };
  if (!(o.duration_s > 0 && o.duration_s <= 3600)) return reject("a duration of 0 to 3600 s");
  if (!(o.frame_rate_hz > 0 && o.frame_rate_hz <= 1000))
    return reject("0 to 1000 images per second");
  if (!(o.duration_s * o.frame_rate_hz >= 1)) return reject("at least two images");
  if (o.approach) {
    if (!(o.approach->pause_s > 0 && o.approach->pause_s <= 60)) {
      return reject("a pause of 0 to 60 s before the approach");
    }
    if (!(o.approach->duration_s > 0 && o.approach->duration_s <= 3600)) {
      return reject("an approach of 0 to 3600 s");
    }
    if (!(o.approach->duration_s * o.frame_rate_hz >= 1)) {
      return reject("at least two images of the approach");
    }
  }
  if (!(o.pressure_mm >= 0 && o.pressure_mm <= kMostPressureMm)) {
    return reject("a pressure of 0 to 12 mm");
  }
  if (!(o.tracker_noise_mm >= 0 && o.tracker_noise_mm <= 5)) {
    return reject("a tracker noise of 0 to 5 mm");
  }
  if (!(o.calibration_mm >= 0 && o.calibration_mm <= 20 && o.calibration_rad >= 0 &&
        o.calibration_rad <= 0.2)) {
    return reject("a calibration error of 0 to 20 mm and 0 to 0.2 rad");
  }
  // An image cannot arrive before its time stamp.
  if (o.image_timing.latency < std::max(o.image_timing.stamp_offset, Duration(0))) {
    return reject("an image latency >= 0 and >= the stamp offset");
  }
  for (const Result<void>& part :
       {validate(path_options(o)), validate(o.probe), validate(o.timing), validate(o.breathing),
        validate(o.deformation), validate(o.pose_faults), validate(o.frame_faults)}) {
    if (!part) return part.error();
  }
  return o.needle ? validate(*o.needle) : Result<void>();
}

Result<SimulatedSession> SimulatedSession::create(const SimulatedSessionOptions& options) {
  if (const auto ok = validate(options); !ok) return ok.error();
  if (!options.contrast) {
    return Error{ErrorCode::kUsage, "simulated session: expected a contrast, found none"};
  }
  const auto patient = make_patient(options.family, {options.seed, *options.contrast});
  if (!patient) return patient.error();
  return create(options, *patient);
}

Result<SimulatedSession> SimulatedSession::create(const SimulatedSessionOptions& options,
                                                  const Patient& patient) {
  if (const auto ok = validate(options); !ok) return ok.error();
  if (options.standard_view) {
    const auto& standard = patient.views.front().ct_from_image;
    const auto view = settled(*patient.anatomy, standard, press_mm(options.probe));
    if (view) return about(options, patient, *view);
  }
  const auto middle = free_view(*patient.anatomy, press_mm(options.probe));
  if (!middle) return middle.error();
  return about(options, patient, *middle);
}

Result<SimulatedSession> SimulatedSession::about(const SimulatedSessionOptions& options,
                                                 const Patient& patient,
                                                 const Transform<Ct, Image>& middle) {
  const Anatomy& anatomy = *patient.anatomy;
  const auto deformation = deformation_of(options, anatomy);
  if (!deformation) return deformation.error();
  if (!options.needle && !options.approach) {
    return SimulatedSession(options, patient.anatomy, middle, *deformation, {}, {});
  }
  const auto plan = options.approach && patient.plan ? Result<NeedlePlan>(*patient.plan)
                                                     : needle_path(anatomy, middle, options.probe);
  if (!plan) return plan.error();
  std::optional<Transform<Ct, Image>> approach;
  if (options.approach) {
    const auto view = approach_view(anatomy, *plan, options.probe);
    if (!view) return view.error();
    approach = *view;
  }
  const PhaseInterval last = phases_of(options).back();
  NeedleInsertionOptions inserted = options.needle.value_or(NeedleInsertionOptions());
  if (!options.needle) inserted.outside_mm = kReadyMm;
  const auto needle = NeedleInsertion::create(*plan, inserted, last.begin, last.end);
  if (!needle) return needle.error();
  return SimulatedSession(options, patient.anatomy, middle, *deformation, *needle, approach);
}

SimulatedSession::SimulatedSession(const SimulatedSessionOptions& options,
                                   std::shared_ptr<const Anatomy> patient,
                                   const Transform<Ct, Image>& middle,
                                   std::shared_ptr<const SmoothWarp> deformation,
                                   const std::optional<NeedleInsertion>& needle,
                                   const std::optional<Transform<Ct, Image>>& approach)
    : options_(options),
      phases_(phases_of(options)),
      patient_(std::move(patient)),
      breathing_(breathing_options(options)),
      deformation_(std::move(deformation)),
      path_(*patient_, middle, path_options(options)),
      ultrasound_(patient_, options.probe, options.seed),
      sensor_(with_noise(make_sensor(options.tracker, hash_bits(options.seed, 0x74726b, 0)),
                         options.tracker_noise_mm, hash_bits(options.seed, 0x6e6f697365, 0))),
      ct_from_reference_(placed_reference(middle, Random(options.seed, 0x726566))),
      probe_from_image_(mount_probe(Random(options.seed, 0x6d6f756e74))),
      tracker_from_ct_(place_tracker(
          options.tracker, middle_of_bodies(probe_from_image_.inverse(), middle, needle, approach),
          Random(options.seed, 0x63616d))),
      needle_(needle) {
  if (approach) path_.hold(*approach, phases_.back().begin);
}

Transform<Probe, Image> SimulatedSession::calibration() const {
  if (!(options_.calibration_mm > 0) && !(options_.calibration_rad > 0)) return probe_from_image_;
  Random random(options_.seed, 0x63616c69);
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(options_.calibration_rad, random.direction()));
  return probe_from_image_ *
         Transform<Image, Image>(turn, options_.calibration_mm * random.direction());
}

Transform<Tracker, Probe> SimulatedSession::tracker_from_probe(Timestamp time) const {
  return tracker_from_ct_ * path_.at(time) * probe_from_image_.inverse();
}

Transform<Tracker, Reference> SimulatedSession::tracker_from_reference() const {
  return tracker_from_ct_ * ct_from_reference_;
}

Transform<Tracker, NeedleHub> SimulatedSession::tracker_from_hub(Timestamp time) const {
  NAV_CHECK(needle_.has_value());
  return tracker_from_ct_ * needle_->ct_from_hub(time);
}

int SimulatedSession::frame_count() const {
  return phases_.back().first_frame + phases_.back().frame_count;
}

Timestamp SimulatedSession::frame_time(int index) const {
  NAV_CHECK(index >= 0 && index < frame_count(), index, frame_count());
  const PhaseInterval& phase =
      index < phases_.back().first_frame ? phases_.front() : phases_.back();
  return phase.begin + from_seconds((index - phase.first_frame) / options_.frame_rate_hz);
}

bool SimulatedSession::undeformed() const {
  return deformation_ == nullptr && breathing_.options().kind == BreathingKind::kNone &&
         !(options_.pressure_mm > 0);
}

std::shared_ptr<const Warp> SimulatedSession::warp(Timestamp time) const {
  const bool breathes = breathing_.options().kind != BreathingKind::kNone;
  std::shared_ptr<const Warp> moved = breathes || deformation_ == nullptr
                                          ? breathing_.warp(time)
                                          : std::shared_ptr<const Warp>(deformation_);
  if (breathes && deformation_ != nullptr) {
    moved = std::make_shared<ComposedWarp>(deformation_, std::move(moved));
  }
  if (!(options_.pressure_mm > 0)) return moved;
  return std::make_shared<ComposedWarp>(
      std::move(moved), pressed_by(path_.at(time), options_.probe, options_.pressure_mm));
}

ImageTruth SimulatedSession::truth(int index) const {
  const Timestamp time = frame_time(index);
  const auto pose = path_.at(time);
  std::shared_ptr<const Warp> moved = warp(time);
  const RestView rest =
      rest_view(*moved, pose, ultrasound_.grid(), options_.probe.columns, options_.probe.rows);
  ImageTruth truth{.physical = time,
                   .ct_from_image = pose,
                   .rest = rest,
                   .breathing = breathing_.state(time),
                   .warp = std::move(moved)};
  if (needle_) truth.needle = needle_->truth(time);
  return truth;
}

SensorStream SimulatedSession::stream(std::uint64_t body) const {
  SensorStream stream;
  stream.sensor = sensor_;
  stream.timing = options_.timing;
  stream.begin = kBegin - kTrackerLeadIn;
  stream.end = phases_.back().end + kTrackerLeadIn;
  stream.body = body;
  stream.seed = options_.seed;
  return stream;
}

std::unique_ptr<PoseStream> SimulatedSession::probe_poses() const {
  SensorStream probe = stream(kProbeBody);
  probe.truth = [this](Timestamp time) { return tracker_from_probe(time).matrix(); };
  return std::make_unique<SensorPoseSource>(probe);
}

std::unique_ptr<PoseStream> SimulatedSession::reference_poses() const {
  SensorStream reference = stream(kReferenceBody);
  reference.truth = [this](Timestamp) { return tracker_from_reference().matrix(); };
  // An arm holds one body; the patient is fixed to the arm's base.
  if (options_.tracker == TrackerKind::kArm) reference.sensor = make_sensor(TrackerKind::kIdeal, 0);
  return std::make_unique<SensorPoseSource>(reference);
}

std::unique_ptr<PoseStream> SimulatedSession::needle_poses() const {
  NAV_CHECK(needle_.has_value());
  SensorStream needle = stream(kNeedleBody);
  needle.truth = [this](Timestamp time) { return tracker_from_hub(time).matrix(); };
  if (options_.tracker == TrackerKind::kArm) {
    needle.sensor =
        with_noise(make_sensor(options_.tracker, hash_bits(options_.seed, 0x74726b, kNeedleBody)),
                   options_.tracker_noise_mm, hash_bits(options_.seed, 0x6e6f697365, kNeedleBody));
  }
  return std::make_unique<SensorPoseSource>(needle);
}

std::unique_ptr<ImageStream> SimulatedSession::frames() const {
  return std::make_unique<SessionFrames>(*this, ultrasound_);
}

}  // namespace nav::sim
