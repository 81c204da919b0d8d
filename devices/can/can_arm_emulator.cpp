// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/can/can_arm_emulator.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <sys/socket.h>

namespace nav::devices {
namespace {

constexpr Duration kNoHeartbeat = std::chrono::seconds(60);

/// False also for an interface that is down: its socket serves again when it is up.
bool ends_bus(const std::optional<TcpFailure>& failure) {
  return failure && std::strcmp(failure->cause, "interface_down") != 0;
}

}  // namespace

CanArmEmulator::CanArmEmulator(ArmModel arm, ArmMotion motion, std::uint16_t profile)
    : arm_(std::move(arm)),
      motion_(std::move(motion)),
      profile_(profile),
      nodes_(arm_.joints.size()) {}

std::unique_ptr<CanArmEmulator> CanArmEmulator::start(ArmModel arm, ArmMotion motion,
                                                      std::uint16_t profile) {
  std::unique_ptr<CanArmEmulator> emulator(
      new CanArmEmulator(std::move(arm), std::move(motion), profile));
  emulator->thread_ = std::thread([&it = *emulator] { it.run(); });
  return emulator;
}

Result<std::unique_ptr<CanArmEmulator>> CanArmEmulator::start_on(const std::string& interface,
                                                                 ArmModel arm, ArmMotion motion) {
  auto bus = open_can(interface, {{.id = 0, .mask = 0}});
  if (!bus) return bus.error();
  std::unique_ptr<CanArmEmulator> emulator(
      new CanArmEmulator(std::move(arm), std::move(motion), kEncoderProfile));
  emulator->bus_ = *std::move(bus);
  emulator->thread_ = std::thread([&it = *emulator] { it.run(); });
  return emulator;
}

CanArmEmulator::~CanArmEmulator() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  wake_.signal();
  thread_.join();
}

CanOpener CanArmEmulator::opener() {
  return [this]() -> Result<FileDescriptor> {
    const std::lock_guard lock(mutex_);
    if (!plugged_) return Error{ErrorCode::kNotFound, "the emulated bus is unplugged"};
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK | SOCK_CLOEXEC, 0, ends.data()) != 0) {
      return Error{ErrorCode::kUnavailable, "the emulated bus: no sockets are left"};
    }
    bus_ = FileDescriptor(ends[0]);
    wake_.signal();
    return FileDescriptor(ends[1]);
  };
}

void CanArmEmulator::run() {
  for (;;) {
    Duration longest = kNoHeartbeat;
    int fd = -1;
    {
      const std::lock_guard lock(mutex_);
      if (stopped_) return;
      while (bus_.is_open()) {
        const CanReceive got = receive_can(bus_);
        if (ends_bus(got.failure)) bus_.close();
        if (got.received) take(got.received->frame);
        if (!got.received && !got.malformed) break;
      }
      longest = send_due();
      fd = bus_.get();
    }
    std::array<Watched, 2> watched = {Watched{.fd = wake_.get(), .read = true},
                                      Watched{.fd = fd, .read = true}};
    wait_for(watched, longest);
    if (watched[0].read) wake_.clear();
  }
}

/// Sends the heartbeats and answers that are due; the time to the next one.
Duration CanArmEmulator::send_due() {
  const Timestamp now = clock_.now();
  Duration longest = kNoHeartbeat;
  std::erase_if(held_, [&](const Held& held) {
    if (now >= held.due) {
      send(held.frame);
    } else {
      longest = std::min(longest, held.due - now);
    }
    return now >= held.due;
  });
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    Node& node = nodes_[i];
    if (node.silent || node.heartbeat_ms == 0) continue;
    if (now >= node.next_heartbeat) {
      node.next_heartbeat = now + std::chrono::milliseconds(node.heartbeat_ms);
      send(can_heartbeat(arm_.joints[i].node, node.operational ? CanNodeState::kOperational
                                                               : CanNodeState::kPreOperational));
    }
    longest = std::min(longest, node.next_heartbeat - now);
  }
  return longest;
}

void CanArmEmulator::send(const CanFrame& frame) {
  if (bus_.is_open() && ends_bus(send_can(bus_, frame).failure)) bus_.close();
}

void CanArmEmulator::take(const CanFrame& frame) {
  const CanOpenMessage message = classify_canopen(frame);
  if (message.kind == CanOpenKind::kSync) return take_sync();
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (nodes_[i].silent) continue;
    const int number = arm_.joints[i].node;
    if (message.kind == CanOpenKind::kNmt && frame.size >= 2) {
      if (frame.data[1] != 0 && frame.data[1] != number) continue;
      nodes_[i].operational = frame.data[0] == static_cast<std::uint8_t>(NmtCommand::kStart);
    } else if (message.kind == CanOpenKind::kSdoRequest && message.node == number) {
      if (const auto request = read_sdo_request(frame)) take_request(i, *request);
    }
  }
}

void CanArmEmulator::take_request(std::size_t joint, const SdoRequest& request) {
  Node& node = nodes_[joint];
  SdoReply reply{.object = request.object};
  if (request.object == kHeartbeatTime && request.writes) {
    node.heartbeat_ms = request.value;
    node.next_heartbeat = clock_.now();
  } else if (request.object == kPdo2Transmission && request.writes) {
    node.with_sync = request.value == 1;
  } else if (request.object == kDeviceType && !request.writes) {
    reply.value = profile_;
  } else if (request.object == kCountsPerTurn && !request.writes) {
    reply.value = arm_.joints[joint].counts_per_turn;
  } else {
    reply.is_abort = true;
    reply.value = kSdoNoObject;
  }
  send(can_sdo_reply(arm_.joints[joint].node, reply, request.writes));
}

void CanArmEmulator::take_sync() {
  const std::vector<double> angles = motion_(syncs_++);
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    Node& node = nodes_[i];
    if (node.silent || !node.operational || !node.with_sync) continue;
    if (node.misses > 0) {
      --node.misses;
      continue;
    }
    const ArmJoint& joint = arm_.joints[i];
    const CanFrame frame = can_position(joint.node, joint_counts(joint, angles[i]));
    if (node.delays > 0) {
      --node.delays;
      held_.push_back({clock_.now() + node.delay, frame});
    } else {
      send(frame);
    }
  }
}

void CanArmEmulator::miss(std::size_t joint, int syncs) {
  const std::lock_guard lock(mutex_);
  nodes_[joint].misses = syncs;
}

void CanArmEmulator::delay(std::size_t joint, int syncs, Duration time) {
  const std::lock_guard lock(mutex_);
  nodes_[joint].delays = syncs;
  nodes_[joint].delay = time;
}

void CanArmEmulator::silence(std::size_t joint) {
  const std::lock_guard lock(mutex_);
  nodes_[joint].silent = true;
}

void CanArmEmulator::revive() {
  const std::lock_guard lock(mutex_);
  for (Node& node : nodes_) node.silent = false;
}

void CanArmEmulator::reboot(std::size_t joint) {
  const std::lock_guard lock(mutex_);
  nodes_[joint] = {};
  send(can_heartbeat(arm_.joints[joint].node, CanNodeState::kBooting));
}

void CanArmEmulator::emergency(std::size_t joint, const CanEmergency& emergency) {
  inject(can_emergency(arm_.joints[joint].node, emergency));
}

void CanArmEmulator::inject(const CanFrame& frame) {
  const std::lock_guard lock(mutex_);
  send(frame);
}

void CanArmEmulator::inject_bytes(const std::vector<std::byte>& bytes) {
  const std::lock_guard lock(mutex_);
  (void)!::send(bus_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL);
}

void CanArmEmulator::unplug() {
  {
    const std::lock_guard lock(mutex_);
    plugged_ = false;
    bus_.close();
  }
  wake_.signal();
}

void CanArmEmulator::replug() {
  const std::lock_guard lock(mutex_);
  plugged_ = true;
}

std::uint64_t CanArmEmulator::syncs() const {
  const std::lock_guard lock(mutex_);
  return syncs_;
}

}  // namespace nav::devices
