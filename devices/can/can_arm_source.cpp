// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/can/can_arm_source.hpp"

#include <algorithm>
#include <array>
#include <cstring>

namespace nav::devices {
namespace {

constexpr int kMostQuestions = 3;
constexpr int kMostFramesAtOnce = 1000;

/// One question of the setup of an encoder.
struct SetupStep {
  CanObject object;
  bool writes = false;
  int bytes = 4;
};
constexpr std::array<SetupStep, 4> kSteps = {
    {{kDeviceType}, {kCountsPerTurn}, {kHeartbeatTime, true, 2}, {kPdo2Transmission, true, 1}}};

std::int64_t whole_ms(Duration time) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(time).count();
}

Error arm_usage(const std::string& what) {
  return {ErrorCode::kUsage, "CAN arm: expected " + what};
}

}  // namespace

Result<void> validate(const CanArmOptions& o) {
  using std::chrono::milliseconds;
  using std::chrono::seconds;
  if (o.body.empty()) return arm_usage("a name of the body, found none");
  if (o.period < milliseconds(1) || o.period > seconds(1)) {
    return arm_usage("a period of 1 ms to 1 s");
  }
  if (o.heartbeat < milliseconds(1) || o.heartbeat > seconds(60)) {
    return arm_usage("a heartbeat of 1 ms to 60 s");
  }
  if (o.lost <= o.heartbeat) return arm_usage("a time of loss longer than the heartbeat");
  if (o.reply <= Duration(0) || o.first_retry <= Duration(0) || o.longest_retry < o.first_retry) {
    return arm_usage("times above 0, and a longest retry of at least the first");
  }
  return validate(o.arm);
}

Result<std::unique_ptr<CanArmSource>> CanArmSource::create(CanArmOptions options, std::string name,
                                                           CanOpener open, const Clock& clock,
                                                           Diagnostics& diagnostics) {
  if (const auto ok = validate(options); !ok) return ok.error();
  return std::unique_ptr<CanArmSource>(
      new CanArmSource(std::move(options), std::move(name), std::move(open), clock, diagnostics));
}

CanOpener CanArmSource::on_interface(const std::string& interface, const ArmModel& arm) {
  // The last seven bits of an identifier are the number of the node.
  std::vector<CanFilter> filters;
  for (const ArmJoint& joint : arm.joints) {
    filters.push_back({.id = static_cast<std::uint32_t>(joint.node), .mask = 0x7F});
  }
  return [interface, filters] { return open_can(interface, filters); };
}

CanArmSource::CanArmSource(CanArmOptions options, std::string name, CanOpener open,
                           const Clock& clock, Diagnostics& diagnostics)
    : PolledSource(clock, diagnostics, "devices.can_arm"),
      open_(std::move(open)),
      options_(std::move(options)),
      name_(std::move(name)),
      due_(clock.now()),
      retry_(options_.first_retry, options_.longest_retry),
      nodes_(options_.arm.joints.size()),
      rest_seen_(!options_.arm.rest) {
  add_stream({options_.body, StreamKind::kPoses, options_.role});
  health_.at_rest_seen = rest_seen_;
}

CanArmHealth CanArmSource::account() const {
  const std::lock_guard lock(mutex_);
  CanArmHealth health = health_;
  if (is_stopped()) health.state = CanArmState::kStopped;
  return health;
}

SourceHealth CanArmSource::health() const {
  const CanArmHealth own = account();
  SourceHealth health{.cause = own.cause,
                      .reconnects = own.connections > 0 ? own.connections - 1 : 0,
                      .bytes = own.frames * kCanFrameBytes,
                      .bad_messages = own.bad};
  switch (own.state) {
    case CanArmState::kWaiting:
      health.state = SourceState::kWaiting;
      break;
    case CanArmState::kSetup:
      health.state = SourceState::kStarting;
      break;
    case CanArmState::kTracking:
      health.state = own.poses > 0 ? SourceState::kStreaming : SourceState::kStarting;
      if (!own.at_rest_seen && health.cause.empty()) health.cause = "rest_not_shown";
      break;
    case CanArmState::kStopped:
      health.state = SourceState::kEnded;
      break;
  }
  return health;
}

void CanArmSource::set_state(CanArmState state) {
  state_ = state;
  const std::lock_guard lock(mutex_);
  health_.state = state;
}

void CanArmSource::count(const char* cause, std::uint64_t times) {
  const std::lock_guard lock(mutex_);
  health_.bad[cause] += times;
}

std::optional<std::size_t> CanArmSource::joint_of(int node) const {
  const auto& joints = options_.arm.joints;
  const auto found =
      std::ranges::find_if(joints, [&](const ArmJoint& joint) { return joint.node == node; });
  if (found == joints.end()) return std::nullopt;
  return static_cast<std::size_t>(found - joints.begin());
}

std::string CanArmSource::node_text(std::size_t joint) const {
  return "the encoder of joint " + std::to_string(joint + 1) + " (node " +
         std::to_string(options_.arm.joints[joint].node) + ")";
}

/// Does what is due.
void CanArmSource::advance(Timestamp now) {
  switch (state_) {
    case CanArmState::kWaiting:
      return open(now);
    case CanArmState::kSetup:
      if (++failures_ < kMostQuestions) return ask(now);
      return lose({"no_reply", node_text(joint_) +
                                   " does not answer; check its power, its number and the bit "
                                   "rate of the bus"});
    case CanArmState::kTracking:
      for (std::size_t i = 0; i < nodes_.size(); ++i) {
        if (now - nodes_[i].heard < options_.lost) continue;
        return lose({"node_silent", node_text(i) + " gives no sign for " +
                                        std::to_string(whole_ms(options_.lost)) + " ms"});
      }
      return end_cycle(now);
    case CanArmState::kStopped:
      due_ = Timestamp::max();
      return;
  }
}

void CanArmSource::open(Timestamp now) {
  auto opened = open_();
  if (!opened) return lose({"unavailable", opened.error().message});
  bus_ = *std::move(opened);
  dropped_ = 0;
  begin_setup(now);
}

void CanArmSource::begin_setup(Timestamp now) {
  set_state(CanArmState::kSetup);
  cycle_ = {};
  joint_ = step_ = 0;
  failures_ = 0;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    nodes_[i].faulty = false;
    if (!send(can_nmt(NmtCommand::kPreOperational, options_.arm.joints[i].node))) break;
  }
  if (state_ == CanArmState::kSetup) ask(now);
}

/// Asks the question of the current step.
void CanArmSource::ask(Timestamp now) {
  const SetupStep& step = kSteps[step_];
  const int node = options_.arm.joints[joint_].node;
  due_ = now + options_.reply;
  if (!step.writes) {
    send(can_sdo_read(node, step.object));
    return;
  }
  const bool heartbeat = step.object == kHeartbeatTime;
  const auto value =
      heartbeat ? static_cast<std::uint32_t>(whole_ms(options_.heartbeat)) : std::uint32_t{1};
  send(can_sdo_write(node, step.object, value, step.bytes));
}

void CanArmSource::take_setup_reply(const SdoReply& reply, Timestamp now) {
  const SetupStep& step = kSteps[step_];
  if (reply.object != step.object) return;  // The answer to an earlier question.
  const ArmJoint& joint = options_.arm.joints[joint_];
  const bool counts = step.object == kCountsPerTurn;
  if (reply.is_abort && !(counts && reply.value == kSdoNoObject)) {
    return lose({"setup", node_text(joint_) + ": " + sdo_abort_sentence(reply.value)});
  }
  if (step.object == kDeviceType && (reply.value & 0xFFFF) != kEncoderProfile) {
    return lose({"setup", node_text(joint_) +
                              ": expected an encoder (CiA 406), found a device of "
                              "profile " +
                              std::to_string(reply.value & 0xFFFF)});
  }
  if (counts && !reply.is_abort && reply.value != joint.counts_per_turn) {
    return lose({"setup", node_text(joint_) + ": expected " +
                              std::to_string(joint.counts_per_turn) + " counts per turn, found " +
                              std::to_string(reply.value)});
  }
  failures_ = 0;
  if (++step_ == kSteps.size()) {
    step_ = 0;
    if (++joint_ == nodes_.size()) return start_nodes(now);
  }
  ask(now);
}

void CanArmSource::start_nodes(Timestamp now) {
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    nodes_[i].heard = now;
    if (send(can_nmt(NmtCommand::kStart, options_.arm.joints[i].node))) continue;
    if (state_ == CanArmState::kSetup) lose({"send_full", "the bus takes no frames"});
    return;
  }
  set_state(CanArmState::kTracking);
  started_ = now;
  reported_loss_.clear();
  {
    const std::lock_guard lock(mutex_);
    ++health_.connections;
  }
  report(Severity::kInfo, "tracking by " + std::to_string(nodes_.size()) + " encoders");
  cycle_.counts.assign(nodes_.size(), std::nullopt);
  due_ = now;
}

/// Ends the cycle of a SYNC, and begins the next. After one that was not answered in full there is
/// a pause of one period, in which late answers are told from those to the next SYNC.
void CanArmSource::end_cycle(Timestamp now) {
  due_ += options_.period;
  if (due_ <= now) due_ = now + options_.period;
  if (cycle_.open) {
    cycle_.open = false;
    if (cycle_.answers < nodes_.size() || cycle_.spoiled) {
      if (cycle_.answers < nodes_.size()) count("missing_joint");
      for (std::size_t i = 0; i < nodes_.size(); ++i) {
        if (!cycle_.counts[i]) report_once(Severity::kWarning, node_text(i) + " misses SYNC");
      }
      return deliver_invalid(now);
    }
  }
  if (!send(can_sync())) return;
  cycle_ = {};
  cycle_.open = true;
  cycle_.sent = now;
  cycle_.counts.assign(nodes_.size(), std::nullopt);
}

void CanArmSource::attend(bool readable, bool /*writable*/) {
  if (!readable) return;
  for (int i = 0; i < kMostFramesAtOnce && bus_.is_open(); ++i) {
    const CanReceive got = receive_can(bus_);
    if (got.failure) return lose(*got.failure);
    if (got.malformed) count("malformed");
    if (got.received) take(*got.received, clock().now());
    if (!got.received && !got.malformed) return;
  }
}

void CanArmSource::take(const CanReceived& received, Timestamp now) {
  {
    const std::lock_guard lock(mutex_);
    ++health_.frames;
  }
  if (received.dropped != dropped_) {
    // A counter of 32 bits that wraps.
    count("kernel_drops", received.dropped - dropped_);
    dropped_ = received.dropped;
    report_once(Severity::kWarning, "the queue of the socket was full; frames were lost");
  }
  const CanFrame& frame = received.frame;
  if (frame.error) return take_errors(frame);
  const CanOpenMessage message = classify_canopen(frame);
  const auto joint = joint_of(message.node);
  if (!joint) return;
  nodes_[*joint].heard = now;
  switch (message.kind) {
    case CanOpenKind::kSdoReply:
      if (state_ != CanArmState::kSetup || *joint != joint_) return;
      if (const auto reply = read_sdo_reply(frame)) {
        take_setup_reply(*reply, now);
      } else {
        count("malformed");
      }
      return;
    case CanOpenKind::kHeartbeat:
      return take_heartbeat(*joint, read_heartbeat(frame), now);
    case CanOpenKind::kEmergency:
      return take_emergency(*joint, frame);
    case CanOpenKind::kPdo2:
      return take_position(*joint, frame, now - received.age);
    default:
      return;
  }
}

void CanArmSource::take_errors(const CanFrame& frame) {
  for (const char* cause : can_error_causes(frame)) {
    count(cause);
    if (std::strcmp(cause, "bus_off") == 0) {
      return lose({"bus_off",
                   "the controller left the bus (bus-off): check the cable, its termination and "
                   "the bit rate"});
    }
    report_once(Severity::kWarning, std::string("the controller reports ") + cause);
  }
}

void CanArmSource::take_heartbeat(std::size_t joint, CanNodeState state, Timestamp now) {
  if (state_ != CanArmState::kTracking || state == CanNodeState::kOperational) return;
  // The heartbeat of the state before may still be on its way.
  const bool just_started = now - started_ < 2 * options_.heartbeat;
  if (just_started && state != CanNodeState::kBooting) return;
  count("reboot");
  report(Severity::kWarning, node_text(joint) + " has restarted; all are set up again");
  begin_setup(now);
}

void CanArmSource::take_emergency(std::size_t joint, const CanFrame& frame) {
  const auto emergency = read_emergency(frame);
  if (!emergency) return count("malformed");
  nodes_[joint].faulty = emergency->code != 0;
  if (emergency->code != 0) count("emergency");
  report_once(emergency->code != 0 ? Severity::kWarning : Severity::kInfo,
              node_text(joint) + ": " + emergency_sentence(*emergency));
}

void CanArmSource::take_position(std::size_t joint, const CanFrame& frame, Timestamp received) {
  if (state_ != CanArmState::kTracking) return;
  const auto counts = read_position(frame);
  if (!counts) return count("malformed");
  if (!cycle_.open) return count("late");
  if (cycle_.counts[joint]) {
    cycle_.spoiled = true;
    return count("late");
  }
  cycle_.counts[joint] = *counts;
  if (++cycle_.answers < nodes_.size() || cycle_.spoiled) return;
  cycle_.open = false;
  deliver_cycle(received);
}

void CanArmSource::deliver_cycle(Timestamp received) {
  std::vector<double> angles;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    angles.push_back(joint_angle_rad(options_.arm.joints[i], *cycle_.counts[i]));
  }
  if (!rest_seen_) {
    if (const auto off = off_rest(options_.arm, angles)) {
      report_once(Severity::kWarning, "rest", "no pose yet: " + *off);
      return deliver_invalid(received);
    }
    rest_seen_ = true;
    report(Severity::kInfo, "the arm is in its rest position");
  }
  if (std::ranges::any_of(nodes_, [](const Node& node) { return node.faulty; })) {
    return deliver_invalid(received);
  }
  const ArmPose pose = arm_pose(options_.arm, angles);
  PoseSample sample;
  sample.tracker_error_mm = pose.error_mm;
  sample.pose.acquired = cycle_.sent;
  sample.pose.received = std::max(received, cycle_.sent);
  sample.pose.status = TrackingStatus::kOk;
  sample.pose.tracker_from_body = pose.base_from_body;
  {
    const std::lock_guard lock(mutex_);
    ++health_.poses;
    health_.at_rest_seen = true;
  }
  retry_.reset();
  const Timestamp arrived = sample.pose.received;
  deliver({.sequence = sequence_++, .received = arrived, .what = std::move(sample)});
}

/// The pose of this SYNC is not known.
void CanArmSource::deliver_invalid(Timestamp received) {
  PoseSample sample;
  sample.pose.acquired = cycle_.sent;
  sample.pose.received = std::max(received, cycle_.sent);
  sample.pose.status = TrackingStatus::kInvalid;
  const Timestamp arrived = sample.pose.received;
  deliver({.sequence = sequence_++, .received = arrived, .what = std::move(sample)});
}

/// False: the frame was not taken.
bool CanArmSource::send(const CanFrame& frame) {
  const CanSend sent = send_can(bus_, frame);
  if (sent.failure) {
    lose(*sent.failure);
    return false;
  }
  if (sent.full) {
    count("send_full");
    report_once(
        Severity::kWarning,
        "the queue of the interface is full; is another node on the bus, at this bit rate?");
  }
  return !sent.full;
}

void CanArmSource::lose(const TcpFailure& failure) {
  bus_.close();
  cycle_ = {};
  const bool was_tracking = state_ == CanArmState::kTracking;
  {
    const std::lock_guard lock(mutex_);
    health_.cause = failure.cause;
    ++health_.losses[failure.cause];
  }
  if (was_tracking || reported_loss_ != failure.message) {
    reported_loss_ = failure.message;
    report(Severity::kWarning, failure.message + "; it is tried again");
  }
  if (was_tracking) forget_reports();
  set_state(CanArmState::kWaiting);
  due_ = clock().now() + retry_.take();
}

}  // namespace nav::devices
