// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/simulate/simulated_recording.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "io/sequence_writer.hpp"

namespace nav::app {
namespace {

constexpr Duration kLongestGap = std::chrono::milliseconds(200);

/// All poses of one body, in the order of their stamps.
struct PoseTrack {
  std::vector<RawPose> poses;
  std::vector<sim::FaultRecord> faults;
};

PoseTrack collect(std::unique_ptr<sim::PoseStream> source, const sim::FaultPlan& plan,
                  std::uint64_t stream) {
  sim::FaultyPoseSource faulty(std::move(source), plan, stream);
  PoseTrack track;
  while (auto pose = faulty.next(Timestamp::max())) track.poses.push_back(*pose);
  std::ranges::stable_sort(track.poses, {}, &RawPose::acquired);
  track.faults = faulty.faults();
  return track;
}

template <class Body>
std::optional<Transform<frames::Tracker, Body>> good(const RawPose& pose) {
  if (pose.status != TrackingStatus::kOk) return std::nullopt;
  const auto rigid = rigid_from_matrix<frames::Tracker, Body>(pose.tracker_from_body);
  if (!rigid) return std::nullopt;
  return *rigid;
}

/// Pose of a body at a time, computed as a recorder does.
template <class Body>
io::NamedTransform pose_at(const PoseTrack& track, Timestamp time, const char* name) {
  io::NamedTransform out{name, Eigen::Matrix4d::Constant(std::nan("")), TrackingStatus::kInvalid};
  if (track.poses.empty()) return out;
  const auto after = std::ranges::lower_bound(track.poses, time, {}, &RawPose::acquired);
  const auto before = after == track.poses.begin() ? after : after - 1;
  if (after != track.poses.end() && before != after) {
    const auto a = good<Body>(*before);
    const auto b = good<Body>(*after);
    const Duration gap = after->acquired - before->acquired;
    if (a && b && gap > Duration::zero() && gap <= kLongestGap) {
      const double fraction = to_seconds(time - before->acquired) / to_seconds(gap);
      out.to_from_from = interpolate(*a, *b, std::clamp(fraction, 0.0, 1.0)).matrix();
      out.status = TrackingStatus::kOk;
      return out;
    }
  }
  const bool later = after != track.poses.end() && after->acquired - time < time - before->acquired;
  const RawPose& nearest = later ? *after : *before;
  out.to_from_from = nearest.tracker_from_body;
  // A pose with numbers that are not finite cannot be OK.
  const bool finite = nearest.tracker_from_body.allFinite();
  out.status =
      finite || nearest.status != TrackingStatus::kOk ? nearest.status : TrackingStatus::kInvalid;
  return out;
}

io::SequenceHeader header_of(const sim::ProbeModel& probe, bool compress) {
  io::SequenceHeader header;
  header.width = probe.columns;
  header.height = probe.rows;
  header.compressed = compress;
  header.fields["Comment"] = "simulated";
  return header;
}

io::SequenceImage file_frame(const UltrasoundImage& frame) {
  io::SequenceImage out;
  out.timestamp_s = to_seconds(frame.acquired);
  out.unfiltered_timestamp_s = out.timestamp_s;
  out.image_valid = !frame.pixels.empty();
  out.pixels.resize(frame.pixels.pixels().size());
  if (out.image_valid) {
    std::memcpy(out.pixels.data(), frame.pixels.pixels().data(), out.pixels.size());
  }
  return out;
}

}  // namespace

Eigen::Matrix4d image_from_pixels(const PixelGrid& grid) {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<2, 2>() = grid.mm_per_pixel;
  m(2, 2) = grid.mm_per_pixel.col(0).norm();
  m.block<2, 1>(0, 3) = grid.origin_mm;
  return m;
}

Result<SimulatedRecording> record(const sim::SimulatedSession& session,
                                  const std::filesystem::path& path, bool compress,
                                  const std::function<void(double)>& progress) {
  const auto& options = session.options();
  auto writer = io::SequenceWriter::create(path, header_of(options.probe, compress));
  if (!writer) return writer.error();
  const PoseTrack probe = collect(session.probe_poses(), options.pose_faults, 0);
  const PoseTrack reference = collect(session.reference_poses(), options.pose_faults, 1);
  const bool with_needle = session.needle().has_value();
  const PoseTrack needle =
      with_needle ? collect(session.needle_poses(), options.pose_faults, 2) : PoseTrack();
  sim::FaultyImageSource frames(session.frames(), options.frame_faults);
  SimulatedRecording recording{.probe_faults = probe.faults,
                               .reference_faults = reference.faults,
                               .needle_faults = needle.faults};
  for (;;) {
    const auto frame = frames.next(Timestamp::max());
    if (!frame) {
      if (frame.error().code == ErrorCode::kEndOfStream) break;
      return frame.error();
    }
    io::SequenceImage out = file_frame(*frame);
    io::set_transform(out, pose_at<frames::Probe>(probe, frame->acquired, "ProbeToTracker"));
    io::set_transform(out,
                      pose_at<frames::Reference>(reference, frame->acquired, "ReferenceToTracker"));
    io::set_transform(
        out, {"ImageToProbe", session.calibration().matrix() * image_from_pixels(frame->grid),
              TrackingStatus::kOk});
    if (with_needle) {
      io::set_transform(out, pose_at<sim::NeedleHub>(needle, frame->acquired, "NeedleToTracker"));
      io::set_transform(out, {"NeedleTipToNeedle", session.needle()->hub_from_needle().matrix(),
                              TrackingStatus::kOk});
    }
    if (const auto written = writer->append(out); !written) return written.error();
    recording.frames.push_back({frame->sequence, frame->acquired});
    progress(static_cast<double>(frame->sequence + 1) / session.frame_count());
  }
  recording.frame_faults = frames.faults();
  if (const auto finished = writer->finish(); !finished) return finished.error();
  return recording;
}

}  // namespace nav::app
