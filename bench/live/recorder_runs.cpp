// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/live/recorder_runs.hpp"

#include <chrono>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <memory>
#include <sstream>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

#include "bench/measure.hpp"
#include "nav/diagnostics.hpp"
#include "nav/time.hpp"
#include "session/session_recorder.hpp"
#include "sim/random.hpp"

namespace nav::bench {
namespace {

constexpr int kColumns = 820, kRows = 616;
constexpr int kBodies = 3;
constexpr double kImageHz = 60, kPoseHz = 400;
constexpr const char* kSharedMemory = "/dev/shm";

/// Says which streams there are; its samples are made below.
class NamedStreams final : public Source {
 public:
  [[nodiscard]] const std::vector<StreamInfo>& streams() const override { return streams_; }
  Result<Sample> next(Deadline) override {
    return Error{ErrorCode::kEndOfStream, "the samples are made elsewhere"};
  }
  void stop() noexcept override {}

 private:
  std::vector<StreamInfo> streams_{{"Image", StreamKind::kImages},
                                   {"Probe", StreamKind::kPoses, ToolRole::kProbe},
                                   {"Reference", StreamKind::kPoses, ToolRole::kReference},
                                   {"Needle", StreamKind::kPoses, ToolRole::kNeedle}};
};

/// A file that is removed at the end.
class Scratch {
 public:
  explicit Scratch(bool& memory_backed) {
    std::error_code failed;
    memory_backed = ::access(kSharedMemory, W_OK) == 0;
    const std::filesystem::path folder =
        memory_backed ? kSharedMemory : std::filesystem::temp_directory_path(failed);
    path_ = folder / ("sonde-bench-" + std::to_string(::getpid()) + ".mcap");
    std::filesystem::remove(path_, failed);
  }
  ~Scratch() {
    std::error_code failed;
    std::filesystem::remove(path_, failed);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Samples in the order of their times: images at 60 Hz, poses at 400 Hz.
class Load {
 public:
  Load() {
    sim::Random random(1, 1);
    std::vector<std::uint8_t> pixels(std::size_t{kColumns} * kRows);
    for (auto& pixel : pixels) pixel = static_cast<std::uint8_t>(random.uniform(0, 256));
    image_.pixels = Image2d<std::uint8_t>(kColumns, kRows, std::move(pixels));
    image_.grid = PixelGrid::centred(kColumns, 0.1, 0.1);
    pose_.pose.status = TrackingStatus::kOk;
    pose_.pose.tracker_from_body = Eigen::Matrix4d::Identity();
  }
  /// Hands over the samples of the time from the start to \p until_s that were not yet.
  void give(double until_s, session::SessionRecorder& recorder) {
    for (;;) {
      const double image_s = static_cast<double>(images_) / kImageHz;
      const double pose_s = static_cast<double>(poses_) / kPoseHz;
      if (std::min(image_s, pose_s) > until_s) return;
      Sample sample;
      if (image_s <= pose_s) {
        sample.sequence = images_++;
        sample.received = Timestamp(from_seconds(image_s));
        image_.acquired = image_.received = sample.received;
        sample.what = image_;
        recorder.record(0, sample);
        continue;
      }
      sample.sequence = poses_++;
      sample.received = Timestamp(from_seconds(pose_s));
      pose_.pose.acquired = pose_.pose.received = sample.received;
      sample.what = pose_;
      for (std::size_t body = 1; body <= kBodies; ++body) {
        sample.stream = body;
        recorder.record(0, sample);
      }
    }
  }

 private:
  UltrasoundImage image_;
  PoseSample pose_;
  std::uint64_t images_ = 0, poses_ = 0;
};

/// Records by \p feed, and adds what came and what was lost.
template <class Feed>
Result<void> record(RecorderRun& run, const Feed& feed) {
  const Scratch file(run.memory_backed);
  const MonotonicClock clock;
  CollectingDiagnostics diagnostics;
  auto recorder = session::SessionRecorder::start({.path = file.path()}, clock, diagnostics);
  if (!recorder) return recorder.error();
  const auto source = std::make_shared<NamedStreams>();
  if (auto ok = (*recorder)->add_devices({{{.id = "scanner"}, source}}); !ok) return ok;
  feed(**recorder);
  if (auto ok = (*recorder)->finish(); !ok) return ok;
  const session::RecordingAccount account = (*recorder)->account();
  run.samples += account.received;
  run.lost += account.lost();
  run.balanced = run.balanced && account.balanced() && account.waiting == 0;
  return {};
}

}  // namespace

Result<RecorderRun> measure_recorder(double seconds) {
  if (!(seconds > 0 && seconds <= 3600)) {
    return Error{ErrorCode::kUsage,
                 "recorder: expected more than 0 to 3600 s, found " + std::to_string(seconds)};
  }
  RecorderRun run{.seconds = seconds, .balanced = true};
  const MonotonicClock clock;
  // At full speed: about 20 s of the load, 600 MB, or less for a short run.
  const double fast_s = std::min(20.0, 2 * seconds);
  const Timestamp begun = clock.now();
  const auto fast = record(run, [&](session::SessionRecorder& recorder) {
    constexpr std::uint64_t kMostWaiting = 400;
    constexpr double kStepS = 0.1;
    Load load;
    for (double t = 0; t < fast_s; t += kStepS) {
      load.give(t, recorder);
      while (recorder.progress().waiting > kMostWaiting) {
        std::this_thread::sleep_for(std::chrono::microseconds(200));
      }
    }
  });
  if (!fast) return fast.error();
  const double image_bytes = double{kColumns} * kRows;
  run.mb_per_second = 1e-6 * image_bytes * kImageHz * fast_s / to_seconds(clock.now() - begun);
  const double before_s = process_time_s();
  const auto paced = record(run, [&](session::SessionRecorder& recorder) {
    Load load;
    const Timestamp start = clock.now();
    for (double t = 0; t < seconds; t = to_seconds(clock.now() - start)) {
      load.give(t, recorder);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  if (!paced) return paced.error();
  run.core_share = (process_time_s() - before_s) / seconds;
  return run;
}

std::string to_text(const RecorderRun& run) {
  std::ostringstream text;
  text << "recorder: 60 images of 820 x 616 and 3 x 400 poses a second, "
       << (run.memory_backed ? "in memory" : "on the disk of temporary files") << '\n'
       << std::fixed << std::setprecision(0) << "at full speed " << run.mb_per_second
       << " MB/s of pixels; at the true pace for " << run.seconds << " s " << std::setprecision(1)
       << 100 * run.core_share << " % of a core; " << run.samples << " samples, " << run.lost
       << " lost, " << (run.balanced ? "ledger balanced" : "ledger NOT balanced") << '\n';
  return text.str();
}

}  // namespace nav::bench
