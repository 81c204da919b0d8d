// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "devices/can/canopen.hpp"
#include "devices/can/encoder_arm.hpp"
#include "devices/polled_source.hpp"

namespace nav::devices {

struct CanArmOptions {
  std::string body = "Probe";  ///< Name of the stream: the body at the end of the arm.
  ToolRole role = ToolRole::kProbe;
  ArmModel arm;
  Duration period = std::chrono::milliseconds(5);       ///< Between two SYNC, 1 ms to 1 s.
  Duration reply = std::chrono::milliseconds(200);      ///< Time for an answer during setup, > 0.
  Duration heartbeat = std::chrono::milliseconds(100);  ///< Set at each encoder, 1 ms to 60 s.
  /// Time without a sign of an encoder after which the arm is lost, > heartbeat.
  Duration lost = std::chrono::milliseconds(300);
  Duration first_retry = std::chrono::seconds(1);    ///< > 0; doubles with every failure.
  Duration longest_retry = std::chrono::seconds(5);  ///< >= first_retry.
};
/// Rejects an empty name, an invalid arm, and times out of range.
Result<void> validate(const CanArmOptions& options);

enum class CanArmState { kWaiting, kSetup, kTracking, kStopped };

/// Account of a source.
struct CanArmHealth {
  CanArmState state = CanArmState::kWaiting;
  std::string cause;              ///< Cause of the newest loss; empty: none yet.
  std::uint64_t connections = 0;  ///< That reached tracking.
  std::uint64_t frames = 0;       ///< Received.
  std::uint64_t poses = 0;        ///< Delivered with a matrix.
  bool at_rest_seen = false;      ///< The arm was shown in its rest position, or has none.
  /// Counts by cause: "missing_joint" (a SYNC that not all encoders answered), "late", "send_full",
  /// "kernel_drops", "malformed", "emergency", "reboot", and those of can_error_causes().
  std::map<std::string, std::uint64_t> bad;
  std::map<std::string, std::uint64_t> losses;
};

/// Opens the bus; called for every attempt.
using CanOpener = std::function<Result<FileDescriptor>()>;

/// An arm whose joints have encoders on a CAN bus (CANopen, CiA 406). It is the master of its
/// encoders: it checks and sets up each one (type, counts per turn, heartbeat, position with every
/// SYNC), starts them, and sends SYNC, so that all joints are read at one instant. It has no thread
/// of its own: call next() from a thread that does nothing else. Samples are poses of the body in
/// the base of the arm:
///   - `acquired` is the time of SYNC, `received` that of the last joint, on the session clock.
///   - The encoders give no device time.
///   - kOk with the error of the model; kInvalid without a matrix while a joint is missing, an
///     encoder reports an error, or the arm was not yet shown in its rest position.
/// An encoder that restarts is set up again. A bus that is off, down or gone, and an encoder that
/// is silent, are tried again after 1, 2, 4 and then every 5 s; next() returns kTimeout meanwhile.
class CanArmSource final : public PolledSource {
 public:
  /// \p name: of the bus in messages, such as "can0". \p clock advances with real time; clock and
  /// diagnostics must outlive the source. Errors: those of validate().
  static Result<std::unique_ptr<CanArmSource>> create(CanArmOptions options, std::string name,
                                                      CanOpener open, const Clock& clock,
                                                      Diagnostics& diagnostics);
  /// Opens an interface of the kernel, for the frames of these encoders.
  static CanOpener on_interface(const std::string& interface, const ArmModel& arm);

  /// Thread-safe.
  [[nodiscard]] CanArmHealth account() const;
  [[nodiscard]] SourceHealth health() const override;

 private:
  /// Answers to one SYNC.
  struct Cycle {
    bool open = false;
    bool spoiled = false;  ///< An encoder answered twice: one answer is to an earlier SYNC.
    Timestamp sent{};
    std::size_t answers = 0;
    std::vector<std::optional<std::uint32_t>> counts;
  };
  struct Node {
    Timestamp heard{};
    bool faulty = false;  ///< It has reported an error that is not gone.
  };
  CanArmSource(CanArmOptions options, std::string name, CanOpener open, const Clock& clock,
               Diagnostics& diagnostics);

  [[nodiscard]] std::string name() const override { return name_; }
  [[nodiscard]] Timestamp wake_time() const override { return due_; }
  void advance(Timestamp now) override;
  [[nodiscard]] Watched watched() const override { return {.fd = bus_.get(), .read = true}; }
  void attend(bool readable, bool writable) override;
  void close() noexcept override { bus_.close(); }

  void open(Timestamp now);
  void begin_setup(Timestamp now);
  void ask(Timestamp now);
  void take_setup_reply(const SdoReply& reply, Timestamp now);
  void start_nodes(Timestamp now);
  void end_cycle(Timestamp now);
  void take(const CanReceived& received, Timestamp now);
  void take_errors(const CanFrame& frame);
  void take_heartbeat(std::size_t joint, CanNodeState state, Timestamp now);
  void take_emergency(std::size_t joint, const CanFrame& frame);
  void take_position(std::size_t joint, const CanFrame& frame, Timestamp received);
  void deliver_cycle(Timestamp received);
  void deliver_invalid(Timestamp received);
  bool send(const CanFrame& frame);
  void lose(const TcpFailure& failure);
  void count(const char* cause, std::uint64_t times = 1);
  void set_state(CanArmState state);
  [[nodiscard]] std::optional<std::size_t> joint_of(int node) const;
  [[nodiscard]] std::string node_text(std::size_t joint) const;

  CanOpener open_;
  CanArmOptions options_;
  std::string name_;

  // Used by next() only.
  FileDescriptor bus_;
  CanArmState state_ = CanArmState::kWaiting;
  Timestamp due_{};      ///< When advance() has something to do.
  Timestamp started_{};  ///< When the encoders were started.
  RetryTimes retry_;
  std::string reported_loss_;
  std::vector<Node> nodes_;
  std::size_t joint_ = 0;  ///< Set up now.
  std::size_t step_ = 0;
  int failures_ = 0;  ///< Questions of this step without an answer.
  Cycle cycle_;
  std::uint32_t dropped_ = 0;
  bool rest_seen_ = false;
  std::uint64_t sequence_ = 0;

  mutable std::mutex mutex_;  ///< Guards the health; never held while calling out.
  CanArmHealth health_;
};

}  // namespace nav::devices
