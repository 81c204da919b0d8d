// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/live/fault_runs.hpp"

#include <algorithm>
#include <iomanip>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <sstream>

#include "nav/diagnostics.hpp"
#include "session/navigator.hpp"
#include "sim/fault_plan.hpp"
#include "sim/motion/hand_path.hpp"
#include "sim/mount.hpp"
#include "sim/random.hpp"
#include "sim/trackers/sensor_pose_source.hpp"
#include "sim/trackers/tracker_kind.hpp"

namespace nav::bench {
namespace {

using std::chrono::milliseconds;

constexpr Duration kStep = milliseconds(5);
constexpr Timestamp kBegin{milliseconds(100)};
constexpr Duration kSettled = std::chrono::seconds(3);
constexpr Duration kBefore = milliseconds(600), kAfter = milliseconds(300);
constexpr double kWidthMm = 60, kDepthMm = 80;
constexpr int kPixels = 16;

/// Streams of a recording; their order is that of the seeds.
enum class FaultyStream { kProbe, kReference, kImages };
constexpr std::size_t kStreams = 3;

/// Faults of a tracked body that change poses but not their stamps.
enum class PoseAlteration { kNone, kJump, kStuck };

struct FaultCase {
  std::string name;
  std::array<sim::FaultPlan, kStreams> plans{};
  PoseAlteration alteration = PoseAlteration::kNone;
  FaultyStream altered = FaultyStream::kProbe;
  bool frozen_images = false;
};

/// The kinds of faults, in the order of the rows.
const std::vector<std::string>& fault_names() {
  static const std::vector<std::string> names{
      "none",
      "drop",
      "duplicate",
      "reorder",
      "future_stamp",
      "clock_step",
      "stall",
      "empty",
      "nan",
      "flip",
      "mirror",
      "denormalised",
      "everything",
      "probe_jump",
      "reference_jump",
      "probe_stuck",
      "small_clock_step",
      "frozen_image",
  };
  return names;
}

double& chance_of(sim::FaultPlan& plan, const std::string& name) {
  static const std::map<std::string, double sim::FaultPlan::*> members{
      {"drop", &sim::FaultPlan::drop},
      {"duplicate", &sim::FaultPlan::duplicate},
      {"reorder", &sim::FaultPlan::reorder},
      {"future_stamp", &sim::FaultPlan::future_stamp},
      {"clock_step", &sim::FaultPlan::clock_step},
      {"stall", &sim::FaultPlan::stall},
      {"empty", &sim::FaultPlan::empty},
      {"nan", &sim::FaultPlan::nan},
      {"flip", &sim::FaultPlan::flip},
      {"mirror", &sim::FaultPlan::mirror},
      {"denormalised", &sim::FaultPlan::denormalised}};
  return plan.*members.at(name);
}

FaultCase fault_case(const std::string& name, std::uint64_t seed, sim::Random& random) {
  FaultCase made{.name = name};
  const double chance = std::pow(10, random.uniform(-3, -1.7));
  const auto stream = static_cast<std::size_t>(random.uniform(0, kStreams - 1e-9));
  if (name == "none") return made;
  if (name == "everything") {
    made.plans.fill(sim::FaultPlan::everything(0.2 * chance, seed));
  } else if (name == "probe_jump" || name == "reference_jump") {
    made.alteration = PoseAlteration::kJump;
    made.altered = name == "probe_jump" ? FaultyStream::kProbe : FaultyStream::kReference;
  } else if (name == "probe_stuck") {
    made.alteration = PoseAlteration::kStuck;
  } else if (name == "small_clock_step") {
    // A clock that is set by less than what is seen at once.
    made.plans[stream].clock_step = 0.2 * chance;
    const int step_ms = static_cast<int>(random.uniform(20, 140));
    made.plans[stream].step = milliseconds(random.uniform(0, 1) < 0.5 ? -step_ms : step_ms);
  } else if (name == "frozen_image") {
    made.frozen_images = true;
  } else {
    sim::FaultPlan& plan = made.plans[stream];
    chance_of(plan, name) = chance;
    plan.step = milliseconds(random.uniform(0, 1) < 0.5 ? -900 : 150);
    plan.drop_samples = static_cast<int>(random.uniform(1, 30));
    plan.future = milliseconds(static_cast<int>(random.uniform(110, 1000)));
    plan.stall_length = milliseconds(static_cast<int>(random.uniform(80, 1500)));
    plan.norm = random.uniform(0, 1) < 0.5 ? random.uniform(0.8, 0.98) : random.uniform(1.02, 1.3);
  }
  for (sim::FaultPlan& plan : made.plans) plan.seed = seed;
  return made;
}

/// Poses of a body that jumps for some samples, or repeats an old pose with new stamps.
class AlteredPoses final : public sim::PoseStream {
 public:
  AlteredPoses(std::unique_ptr<sim::PoseStream> source, PoseAlteration how, sim::Random random)
      : source_(std::move(source)), how_(how), random_(random) {}
  Result<RawPose> next(Deadline deadline) override {
    auto pose = source_->next(deadline);
    if (!pose || how_ == PoseAlteration::kNone || pose->status != TrackingStatus::kOk) return pose;
    if (pose->received >= until_ && random_.uniform(0, 1) < 0.01) {
      const bool stuck = how_ == PoseAlteration::kStuck;
      until_ = pose->received + milliseconds(static_cast<int>(stuck ? random_.uniform(300, 3000)
                                                                    : random_.uniform(5, 90)));
      kept_ = pose->tracker_from_body;
      turn_ = Eigen::AngleAxisd(random_.uniform(0, 1.2), random_.direction());
      shift_mm_ = random_.uniform(15, 300) * random_.direction();
      return pose;
    }
    if (pose->received >= until_) return pose;
    altered_.push_back(pose->received);
    if (how_ == PoseAlteration::kStuck) {
      pose->tracker_from_body = kept_;
    } else {
      pose->tracker_from_body.topLeftCorner<3, 3>() *= turn_.toRotationMatrix();
      pose->tracker_from_body.topRightCorner<3, 1>() += shift_mm_;
    }
    return pose;
  }
  void stop() noexcept override { source_->stop(); }
  [[nodiscard]] const std::vector<Timestamp>& altered() const { return altered_; }

 private:
  std::unique_ptr<sim::PoseStream> source_;
  PoseAlteration how_;
  sim::Random random_;
  Timestamp until_ = Timestamp::min();
  Eigen::Matrix4d kept_ = Eigen::Matrix4d::Identity();
  Eigen::AngleAxisd turn_ = Eigen::AngleAxisd::Identity();
  Eigen::Vector3d shift_mm_ = Eigen::Vector3d::Zero();
  std::vector<Timestamp> altered_;
};

struct ImageTiming {
  Duration period, latency;
  Timestamp end;
};

/// Small images of noise. The sequence number gives the time at which an image was acquired; a
/// frozen scanner repeats the pixels with new stamps.
class NoiseImages final : public sim::ImageStream {
 public:
  NoiseImages(const ImageTiming& timing, bool freezes, sim::Random random)
      : timing_(timing), freezes_(freezes), random_(random) {}
  [[nodiscard]] Timestamp physical(std::uint64_t sequence) const {
    return kBegin + static_cast<std::int64_t>(sequence) * timing_.period;
  }
  Result<UltrasoundImage> next(Deadline deadline) override {
    const Timestamp acquired = physical(sequence_);
    if (acquired > timing_.end) return Error{ErrorCode::kEndOfStream, "end"};
    if (acquired + timing_.latency > deadline) return Error{ErrorCode::kTimeout, "later"};
    if (freezes_ && acquired >= until_ && random_.uniform(0, 1) < 0.02) {
      until_ = acquired + milliseconds(static_cast<int>(random_.uniform(100, 2000)));
    } else if (acquired >= until_) {
      content_ = sequence_;
    }
    if (content_ != sequence_) frozen_.push_back(sequence_);
    std::vector<std::uint8_t> pixels(std::size_t{kPixels} * kPixels);
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      pixels[i] = static_cast<std::uint8_t>(sim::hash_bits(content_, 7, i));
    }
    return UltrasoundImage{
        .acquired = acquired,
        .received = acquired + timing_.latency,
        .sequence = sequence_++,
        .pixels = Image2d<std::uint8_t>(kPixels, kPixels, std::move(pixels)),
        .grid = PixelGrid::centred(kPixels, kWidthMm / kPixels, kDepthMm / kPixels)};
  }
  void stop() noexcept override {}
  /// Sequence numbers of images whose pixels are older.
  [[nodiscard]] const std::vector<std::uint64_t>& frozen() const { return frozen_; }
  [[nodiscard]] std::uint64_t count() const { return sequence_; }

 private:
  ImageTiming timing_;
  bool freezes_;
  sim::Random random_;
  std::uint64_t sequence_ = 0, content_ = 0;
  Timestamp until_ = Timestamp::min();
  std::vector<std::uint64_t> frozen_;
};

/// True motion of probe and patient.
struct TrueMotion {
  sim::HandPath hand;
  Transform<frames::Probe, frames::Image> probe_from_image;
  Transform<frames::Tracker, frames::Ct> tracker_from_ct;
  Transform<frames::Ct, frames::Reference> ct_from_reference;
  double breath_hz = 0.25;

  /// The reference lies on a chest that moves by 2 mm.
  [[nodiscard]] Transform<frames::Tracker, frames::Reference> reference(Timestamp time) const {
    const double turn = 2 * std::numbers::pi * breath_hz * to_seconds(time);
    const Transform<frames::Ct, frames::Ct> breath(Eigen::Quaterniond::Identity(),
                                                   Eigen::Vector3d(0, 2 * std::sin(turn), 0));
    return tracker_from_ct * breath * ct_from_reference;
  }
  [[nodiscard]] Transform<frames::Tracker, frames::Probe> probe(Timestamp time) const {
    return tracker_from_ct * hand.at(time) * probe_from_image.inverse();
  }
  [[nodiscard]] Transform<frames::Reference, frames::Image> image(Timestamp time) const {
    return reference(time).inverse() * probe(time) * probe_from_image;
  }
};

TrueMotion true_motion(std::uint64_t seed, sim::TrackerKind kind, double seconds,
                       sim::Random& random) {
  static constexpr sim::HandPathKind kPaths[] = {sim::HandPathKind::kSweep, sim::HandPathKind::kFan,
                                                 sim::HandPathKind::kRock,
                                                 sim::HandPathKind::kTilt};
  sim::HandPathOptions path;
  path.kind = kPaths[static_cast<std::size_t>(random.uniform(0, 4 - 1e-9))];
  path.length_mm = random.uniform(40, 200);
  path.angle_rad = random.uniform(0.3, 1.4);
  path.begin = Timestamp(from_seconds(random.uniform(0.5, 3)));
  path.end = path.begin + from_seconds(random.uniform(2, seconds - 3));
  path.tremor.drift_mm = random.uniform(0.2, 2);
  path.tremor.seed = seed;
  const Eigen::Quaterniond turn = sim::random_mount(random);
  const Eigen::Vector3d at = sim::sweet_spot_mm(kind);
  return {.hand = sim::HandPath({sim::random_mount(random), random.offset(30)}, path),
          .probe_from_image = sim::mount_probe(sim::Random(seed, 3)),
          .tracker_from_ct = {turn, at},
          .ct_from_reference = {sim::random_mount(random), random.offset(90)},
          .breath_hz = random.uniform(0.15, 0.4)};
}

double worst_corner_mm(const Transform<frames::Reference, frames::Image>& shown,
                       const Transform<frames::Reference, frames::Image>& truth) {
  double worst = 0;
  for (const double x : {-0.5 * kWidthMm, 0.5 * kWidthMm}) {
    for (const double y : {0.0, kDepthMm}) {
      const Point<frames::Image> corner{{x, y, 0}};
      worst = std::max(worst, ((shown * corner).mm - (truth * corner).mm).norm());
    }
  }
  return worst;
}

/// One recording: its streams, and what the navigator shows of it.
class FaultRun {
 public:
  FaultRun(const FaultCase& faults, std::uint64_t seed, double seconds, sim::Random random)
      : end_(from_seconds(seconds)),
        plans_(faults.plans),
        kind_(static_cast<sim::TrackerKind>(static_cast<int>(random.uniform(1, 4 - 1e-9)))),
        motion_(true_motion(seed, kind_, seconds, random)),
        navigator_(ProbeCalibration{motion_.probe_from_image}, std::nullopt, {}, diagnostics_) {
    sim::TrackerTiming timing;
    timing.rate_hz = random.uniform(20, 100);
    pose_period_ = from_seconds(1 / timing.rate_hz);
    image_period_ = from_seconds(1 / random.uniform(10, 40));
    timing.latency = milliseconds(static_cast<int>(random.uniform(5, 60)));
    timing.jitter = milliseconds(static_cast<int>(random.uniform(0, 10)));
    timing.drift_ppm = random.uniform(-100, 100);
    timing.loss_begins = random.uniform(0, 1) < 0.3 ? 0.002 : 0;
    const auto sensor = sim::make_sensor(kind_, seed);
    const auto poses = [&](auto truth, FaultyStream stream, AlteredPoses*& altered) {
      const auto number = static_cast<std::uint64_t>(stream);
      sim::SensorStream body{.truth = std::move(truth),
                             .sensor = sensor,
                             .timing = timing,
                             .begin = kBegin,
                             .end = end_,
                             .body = number,
                             .seed = seed};
      const bool is_altered = faults.altered == stream;
      auto made = std::make_unique<AlteredPoses>(
          std::make_unique<sim::SensorPoseSource>(body),
          is_altered ? faults.alteration : PoseAlteration::kNone, sim::Random(seed, 20 + number));
      altered = made.get();
      return std::make_unique<sim::FaultyPoseSource>(
          std::move(made), faults.plans[static_cast<std::size_t>(stream)], number);
    };
    probe_ = poses([this](Timestamp t) { return motion_.probe(t).matrix(); }, FaultyStream::kProbe,
                   altered_[0]);
    reference_ = poses([this](Timestamp t) { return motion_.reference(t).matrix(); },
                       FaultyStream::kReference, altered_[1]);
    auto images = std::make_unique<NoiseImages>(
        ImageTiming{.period = image_period_,
                    .latency = milliseconds(static_cast<int>(random.uniform(10, 90))),
                    .end = end_},
        faults.frozen_images, sim::Random(seed, 30));
    noise_ = images.get();
    images_ = std::make_unique<sim::FaultyImageSource>(
        std::move(images), faults.plans[static_cast<std::size_t>(FaultyStream::kImages)], 2);
  }

  void add_to(FaultRuns& row) {
    const auto note = [this](const tracking::PairedImage& image) {
      if (!image.tracked) withheld_.insert(image.sequence);
    };
    for (Timestamp now = kBegin; now <= end_ + std::chrono::seconds(1); now += kStep) {
      deliver(now);
      navigator_.settle(now, false, note);
      judge(navigator_.refresh(now), row);
    }
    navigator_.settle(end_ + std::chrono::seconds(1), true, note);
    navigator_.finish();
    NAV_CHECK(navigator_.ledger().balanced());
    count_good(row);
    ++row.recordings;
    row.images += noise_->count();
    row.valid += valid_.size();
  }

 private:
  void deliver(Timestamp now) {
    const auto add = [&](sim::FaultyPoseSource& source, ToolRole role) {
      while (auto pose = source.next(now)) {
        if (pose->status != TrackingStatus::kOk) faults_.push_back(pose->received);
        navigator_.add_pose(role, *pose);
      }
    };
    add(*probe_, ToolRole::kProbe);
    add(*reference_, ToolRole::kReference);
    while (auto frame = images_->next(now)) navigator_.add_image(*std::move(frame));
  }

  void judge(const session::Epoch& epoch, FaultRuns& row) {
    if (!epoch.frame) return;
    const std::uint64_t sequence = epoch.frame->frame.sequence;
    if (epoch.ultrasound.state != SafetyState::kValid) {
      // An image that comes too late is old, whatever its pose.
      if (epoch.frame_is_new && epoch.ultrasound.state != SafetyState::kStale) {
        withheld_.insert(sequence);
      }
      return;
    }
    if (!valid_.insert(sequence).second) return;
    const double off_mm = worst_corner_mm(epoch.frame->reference_from_image,
                                          motion_.image(noise_->physical(sequence)));
    row.worst_mm = std::max(row.worst_mm, off_mm);
    if (off_mm > kWrongMm) ++row.wrong;
  }

  void count_good(FaultRuns& row) {
    add_faults(probe_->faults(), FaultyStream::kProbe);
    add_faults(reference_->faults(), FaultyStream::kReference);
    add_faults(images_->faults(), FaultyStream::kImages);
    for (const AlteredPoses* altered : altered_) {
      faults_.insert(faults_.end(), altered->altered().begin(), altered->altered().end());
    }
    for (const std::uint64_t frozen : noise_->frozen()) {
      faults_.push_back(noise_->physical(frozen));
    }
    std::sort(faults_.begin(), faults_.end());
    for (std::uint64_t i = 0; i < noise_->count(); ++i) {
      const Timestamp time = noise_->physical(i);
      if (time < kBegin + kSettled || time > end_ - kAfter) continue;
      const auto near = std::lower_bound(faults_.begin(), faults_.end(), time - kBefore);
      if (near != faults_.end() && *near <= time + kAfter) continue;
      ++row.good;
      if (withheld_.contains(i) && !valid_.contains(i)) ++row.withheld;
    }
  }

  /// Adds the times at which faults of a stream last. A clock that was set is known again two
  /// seconds later.
  void add_faults(const std::vector<sim::FaultRecord>& records, FaultyStream stream) {
    const sim::FaultPlan& plan = plans_[static_cast<std::size_t>(stream)];
    const Duration period = stream == FaultyStream::kImages ? image_period_ : pose_period_;
    for (const sim::FaultRecord& record : records) {
      Duration lasts{0};
      if (record.kind == sim::FaultKind::kDrop) lasts = plan.drop_samples * period;
      if (record.kind == sim::FaultKind::kStall) lasts = plan.stall_length;
      if (record.kind == sim::FaultKind::kClockStep) {
        lasts = plan.step_samples * period + std::chrono::seconds(2);
      }
      for (Duration at{0}; at <= lasts; at += kBefore) faults_.push_back(record.received + at);
      faults_.push_back(record.received + lasts);
    }
  }

  Timestamp end_;
  std::array<sim::FaultPlan, kStreams> plans_;
  Duration image_period_{}, pose_period_{};
  sim::TrackerKind kind_;
  TrueMotion motion_;
  CollectingDiagnostics diagnostics_;
  session::Navigator navigator_;
  std::unique_ptr<sim::FaultyPoseSource> probe_, reference_;
  std::array<AlteredPoses*, 2> altered_{};
  NoiseImages* noise_ = nullptr;
  std::unique_ptr<sim::FaultyImageSource> images_;
  std::set<std::uint64_t> valid_, withheld_;
  std::vector<Timestamp> faults_;
};

}  // namespace

Result<std::vector<FaultRuns>> measure_fault_runs(const FaultRunsOptions& options,
                                                  const std::function<void(double)>& progress) {
  if (options.recordings < 1) {
    return Error{ErrorCode::kUsage,
                 "recordings: expected 1 or more, found " + std::to_string(options.recordings)};
  }
  if (!(options.seconds >= 5 && options.seconds <= 600)) {
    return Error{ErrorCode::kUsage,
                 "seconds: expected 5 to 600, found " + std::to_string(options.seconds)};
  }
  std::vector<FaultRuns> rows;
  for (const std::string& name : fault_names()) rows.push_back({.fault = name});
  for (int i = 0; i < options.recordings; ++i) {
    FaultRuns& row = rows[static_cast<std::size_t>(i) % rows.size()];
    const std::uint64_t seed = sim::hash_bits(options.seed, 0, static_cast<std::uint64_t>(i));
    sim::Random random(seed, 1);
    const FaultCase faults = fault_case(row.fault, seed, random);
    FaultRun(faults, seed, options.seconds, random).add_to(row);
    progress(static_cast<double>(i + 1) / options.recordings);
  }
  return rows;
}

FaultRuns sum_of(const std::vector<FaultRuns>& rows) {
  FaultRuns sum{.fault = "all"};
  for (const FaultRuns& row : rows) {
    sum.recordings += row.recordings;
    sum.images += row.images;
    sum.valid += row.valid;
    sum.wrong += row.wrong;
    sum.worst_mm = std::max(sum.worst_mm, row.worst_mm);
    sum.good += row.good;
    sum.withheld += row.withheld;
  }
  return sum;
}

std::string to_text(const std::vector<FaultRuns>& rows) {
  std::ostringstream text;
  text << "faults: images shown as valid that are more than " << kWrongMm
       << " mm off, and good images withheld\n"
       << "fault           recordings   images    valid  wrong  worst mm     good  withheld\n";
  const auto add = [&](const FaultRuns& row) {
    text << std::left << std::setw(16) << row.fault << std::right << std::setw(10) << row.recordings
         << std::setw(9) << row.images << std::setw(9) << row.valid << std::setw(7) << row.wrong
         << std::setw(10) << std::fixed << std::setprecision(1) << row.worst_mm << std::setw(9)
         << row.good << std::setw(10) << row.withheld << '\n';
  };
  for (const FaultRuns& row : rows) add(row);
  add(sum_of(rows));
  return text.str();
}

}  // namespace nav::bench
