// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/usb/polhemus_source.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <set>
#include <utility>

namespace nav::devices {
namespace {

using std::chrono::milliseconds;

/// Bytes of a transfer: one packet of high speed, so that each ends as soon as its packet is there.
constexpr std::size_t kLibertyPacket = 512;
constexpr int kLibertyQueued = 8;
/// Without bytes for so long the device has stopped its output.
constexpr Duration kSetupQuiet = milliseconds(100);
constexpr Duration kLongestStopping = milliseconds(1500);
/// Time for errors in the answer to the setup.
constexpr Duration kSetupAnswer = milliseconds(150);

/// Signed distance of two counters that wrap.
std::int32_t distance(std::uint32_t to, std::uint32_t from) {
  return static_cast<std::int32_t>(to - from);
}

std::optional<std::string> repeated(const std::vector<PolhemusBody>& bodies) {
  std::set<std::string> names;
  std::set<int> stations;
  for (const PolhemusBody& body : bodies) {
    if (!names.insert(body.name).second) {
      return "a name of its own for each body, found '" + body.name + "' twice";
    }
    if (!stations.insert(body.station).second) {
      return "a station of its own for each body, found " + std::to_string(body.station) + " twice";
    }
  }
  return std::nullopt;
}

}  // namespace

Result<void> validate(const PolhemusOptions& options) {
  const auto reject = [](const std::string& what) {
    return Error{ErrorCode::kUsage, "Polhemus tracker: expected " + what};
  };
  if (options.bodies.empty()) return reject("at least one body, found none");
  for (const PolhemusBody& body : options.bodies) {
    if (body.name.empty()) return reject("a name of each body, found none");
    if (body.station < 1 || body.station > kMostPolhemusStations) {
      return reject("a station of 1 to 16, found " + std::to_string(body.station));
    }
  }
  if (const auto what = repeated(options.bodies)) return reject(*what);
  double squares = 0;
  for (const double one : options.hemisphere) squares += one * one;
  if (!(squares > 0) || !std::isfinite(squares)) {
    return reject("a hemisphere of three numbers that are not all 0");
  }
  if (options.distortion_limit < 0) {
    return reject("a distortion limit of at least 0, found " +
                  std::to_string(options.distortion_limit));
  }
  return validate(options.times);
}

Result<std::unique_ptr<PolhemusSource>> PolhemusSource::create(PolhemusOptions options,
                                                               std::string name, UsbOpener open,
                                                               const Clock& clock,
                                                               Diagnostics& diagnostics) {
  if (const auto ok = validate(options); !ok) return ok.error();
  return std::unique_ptr<PolhemusSource>(
      new PolhemusSource(std::move(options), std::move(name), std::move(open), clock, diagnostics));
}

PolhemusSource::PolhemusSource(PolhemusOptions options, std::string name, UsbOpener open,
                               const Clock& clock, Diagnostics& diagnostics)
    : UsbSource(std::move(name), options.times, std::move(open), clock, diagnostics,
                "devices.polhemus"),
      options_(std::move(options)),
      given_(options_.bodies.size()) {
  for (const PolhemusBody& body : options_.bodies) {
    add_stream({body.name, StreamKind::kPoses, body.role});
  }
}

void PolhemusSource::send(const std::string& command) {
  const auto bytes = std::as_bytes(std::span(command));
  link().write(kLibertyOut, {bytes.begin(), bytes.end()});
}

void PolhemusSource::begin(Timestamp now) {
  newest_.reset();
  link().keep_reading(kLibertyIn, kLibertyPacket, kLibertyQueued);
  begin_stopping(now);
}

/// Ends an output of before, which may be in inches, and waits until nothing comes any more.
void PolhemusSource::begin_stopping(Timestamp now) {
  phase_ = Phase::kStopping;
  candidate_.reset();
  stopping_since_ = quiet_since_ = now;
  send(kPolhemusStop);
  set_step(now + kSetupQuiet);
}

Timestamp PolhemusSource::step(Timestamp now) {
  switch (phase_) {
    case Phase::kStopping:
      if (now - stopping_since_ >= kLongestStopping) {
        lose({"setup", "the device does not stop its output; switch it off and on"});
        return Timestamp::max();
      }
      if (now - quiet_since_ < kSetupQuiet) return quiet_since_ + kSetupQuiet;
      parser_.restart();
      for (const std::string& command : polhemus_setup(options_.hemisphere)) send(command);
      phase_ = Phase::kSetup;
      return now + kSetupAnswer;
    case Phase::kSetup:
      parser_.restart();
      phase_ = Phase::kTracking;
      send(kPolhemusContinuous);
      expect(now);
      return Timestamp::max();
    case Phase::kTracking:
      break;
  }
  return Timestamp::max();
}

void PolhemusSource::end() {
  if (phase_ != Phase::kStopping) send(kPolhemusSingle);
}

void PolhemusSource::take(const UsbTransfer& transfer, Timestamp received) {
  if (transfer.endpoint != kLibertyIn) return;
  if (phase_ == Phase::kStopping) {
    quiet_since_ = received;
    return;
  }
  parser_.take(transfer.bytes, [&](const PolhemusNews& news) { take_news(news, received); });
}

void PolhemusSource::take_news(const PolhemusNews& news, Timestamp received) {
  if (!has_link() || phase_ == Phase::kStopping)
    return;  // Given up, or set up again, by a message.
  switch (news.kind) {
    case PolhemusNews::Kind::kBad:
      if (phase_ == Phase::kTracking) count(news.cause);
      return;
    case PolhemusNews::Kind::kReply: {
      const auto error = polhemus_error(news.error);
      if (!error) return;
      const std::string command = std::isgraph(static_cast<unsigned char>(news.command)) != 0
                                      ? std::string("'") + news.command + "'"
                                      : std::to_string(static_cast<unsigned char>(news.command));
      if (phase_ == Phase::kSetup) {
        return lose({"setup", "the device rejects command " + command + " with " + *error});
      }
      count("device_error");
      return report_once(Severity::kWarning,
                         "the device answers command " + command + " with " + *error);
    }
    case PolhemusNews::Kind::kRecord:
      if (phase_ == Phase::kTracking) take_record(news.record, received);
      return;
  }
}

/// Begins to count frames with this one.
void PolhemusSource::restart_frames(const PolhemusRecord& record) {
  device_ms_ = record.time_ms;
  ++sequence_;
  newest_ = Newest{record.frame, record.time_ms};
}

/// Compares count and clock of a record with those before it. False: it is left out, because it
/// does not follow them and nothing has confirmed it, or because the device has restarted.
bool PolhemusSource::follows(const PolhemusRecord& record, Timestamp received) {
  // Frames come every 4 ms or less often (240 Hz at most); some seconds of them may be lost by the
  // computer, and a second may pass while no sensor is plugged in.
  constexpr std::int32_t kMostAdvance = 2400;
  constexpr std::int64_t kFastestMs = 4, kSlowestMs = 1000, kSlackMs = 50;
  const auto plausible = [&](const Newest& before) {
    const std::int64_t frames = distance(record.frame, before.frame);
    const std::int64_t ms = distance(record.time_ms, before.time_ms);
    return frames >= 0 && frames <= kMostAdvance && ms >= kFastestMs * frames - kSlackMs &&
           ms <= kSlowestMs * frames + kSlackMs;
  };
  if (!newest_) {
    restart_frames(record);
    return true;
  }
  if (plausible(*newest_)) {
    const std::int32_t frames = distance(record.frame, newest_->frame);
    if (frames > 1) count("lost_frames", static_cast<std::uint64_t>(frames - 1));
    device_ms_ += distance(record.time_ms, newest_->time_ms);
    sequence_ += static_cast<std::uint64_t>(frames);
    newest_ = Newest{record.frame, record.time_ms};
    candidate_.reset();
    return true;
  }
  if (!candidate_ || !plausible(*candidate_)) {
    candidate_ = Newest{record.frame, record.time_ms};
    count("frame_number");
    return false;
  }
  candidate_.reset();
  if (distance(record.time_ms, newest_->time_ms) < 0 &&
      distance(record.frame, newest_->frame) < 0) {
    count("restart");
    report(Severity::kWarning, "the device has restarted; it is set up again");
    newest_.reset();
    begin_stopping(received);
    return false;
  }
  restart_frames(record);
  return true;
}

void PolhemusSource::take_record(const PolhemusRecord& record, Timestamp received) {
  const auto body = std::ranges::find(options_.bodies, record.station,
                                      [](const auto& one) { return one.station; });
  if (!follows(record, received)) return;
  heard(received);
  if (body == options_.bodies.end()) {
    const std::string station = std::to_string(record.station);
    return report_once(Severity::kInfo, "station " + station,
                       "station " + station + " sends, but belongs to none of the bodies");
  }
  const auto stream = static_cast<std::size_t>(body - options_.bodies.begin());
  if (given_[stream] == sequence_) return count_repeat();
  given_[stream] = sequence_;
  deliver({.stream = stream,
           .sequence = sequence_,
           .received = received,
           .device_time = DeviceTime(milliseconds(device_ms_)),
           .what = pose_of(record, received)});
}

PoseSample PolhemusSource::pose_of(const PolhemusRecord& record, Timestamp received) {
  constexpr double kMmPerCm = 10;
  PoseSample sample;
  sample.pose.acquired = sample.pose.received = received;
  sample.pose.status = TrackingStatus::kInvalid;
  const std::string station = "station " + std::to_string(record.station);
  if (const auto error = polhemus_error(record.error)) {
    count("device_error");
    report_once(Severity::kWarning, station + " reports " + *error);
    return sample;
  }
  if (const char* const trouble = polhemus_trouble(record)) {
    count(trouble);
    report_once(Severity::kWarning, station + trouble,
                station + " gives numbers that are no pose (" + trouble + ")");
    return sample;
  }
  const auto& [w, x, y, z] = record.rotation_wxyz;
  const Eigen::Quaterniond turn = Eigen::Quaterniond(w, x, y, z).normalized();
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = turn.toRotationMatrix();
  for (int i = 0; i < 3; ++i) {
    matrix(i, 3) = kMmPerCm * record.position_cm[static_cast<std::size_t>(i)];
  }
  sample.pose.tracker_from_body = matrix;
  sample.pose.status = TrackingStatus::kOk;
  if (std::abs(std::int64_t{record.distortion}) > options_.distortion_limit) {
    sample.pose.status = TrackingStatus::kUnknown;
    count("distortion");
    report_once(Severity::kWarning, station + "distortion",
                station + " reports a distortion of " + std::to_string(record.distortion) +
                    ", expected at most " + std::to_string(options_.distortion_limit) +
                    " (distortion_limit); keep metal away from source and sensor");
  }
  return sample;
}

}  // namespace nav::devices
