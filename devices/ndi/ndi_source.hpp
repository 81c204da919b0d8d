// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "devices/ndi/ndi_health.hpp"
#include "devices/ndi/ndi_options.hpp"
#include "devices/ndi/ndi_poses.hpp"
#include "devices/ndi/ndi_reply.hpp"
#include "devices/ndi/ndi_setup.hpp"
#include "devices/ndi/ndi_tracks.hpp"
#include "devices/ndi/ndi_transport.hpp"
#include "devices/polled_source.hpp"

namespace nav::devices {

/// A tracker of NDI (Polaris, Vega, Aurora) by the combined API, on a serial port or TCP. It
/// connects and sets the tracker up in next(), and has no thread of its own: call next() from a
/// thread that does nothing else. A tool that cannot be used is reported and costs only itself. A
/// tracker that is silent, unplugged or reset is tried again after 1, 2, 4 and then every 5 s;
/// next() returns kTimeout meanwhile. Samples are poses:
///   - Status kOk, kOutOfVolume (also partly out), kOccluded (not seen), kInvalid.
///   - Sample::device_time: time of BX2, or counter / 60 Hz for a Polaris; otherwise absent.
///   - Sample::sequence: counter of the tracker with a device_time, otherwise a count of samples.
///   - The times `acquired` are those of reception until a clock model has mapped device_time.
class NdiSource final : public PolledSource {
 public:
  /// \p clock advances with real time; clock and diagnostics must outlive the source. Errors: those
  /// of validate().
  static Result<std::unique_ptr<NdiSource>> create(NdiOptions options,
                                                   std::unique_ptr<NdiTransport> transport,
                                                   const Clock& clock, Diagnostics& diagnostics);

  /// Thread-safe.
  [[nodiscard]] NdiHealth account() const;
  [[nodiscard]] SourceHealth health() const override;

 private:
  NdiSource(NdiOptions options, std::unique_ptr<NdiTransport> transport, const Clock& clock,
            Diagnostics& diagnostics);

  [[nodiscard]] std::string name() const override { return transport_->name(); }
  [[nodiscard]] Timestamp wake_time() const override { return due_; }
  void advance(Timestamp now) override;
  [[nodiscard]] Watched watched() const override;
  void attend(bool readable, bool writable) override;
  void close() noexcept override { transport_->close(); }

  void set_state(NdiState state, Timestamp due);
  void open(Timestamp now);
  void begin_setup(Timestamp now);
  void receive();
  void read_replies(Timestamp now);
  void take_reply(const NdiReply& reply, Timestamp now);
  void take_unasked(const NdiReply& reply);
  void take_setup_reply(const NdiReply& reply, Timestamp now);
  void go_on_with_setup(Timestamp now);
  void setup_done(Timestamp now);
  void take_tracking_reply(const NdiReply& reply, Timestamp now);
  void take_tracking_error(const NdiReply& reply, Timestamp now);
  void take_readings(Timestamp now);
  void look_for_plugged(Timestamp now);
  void ask(const std::string& command, Duration longest, Timestamp now);
  void send_rest();
  void ask_for_poses(Timestamp now);
  void no_reply(Timestamp now);
  void bad_reply(const std::string& cause, Timestamp now);
  void drain(Timestamp now);
  void repeat_question(Timestamp now);
  void lose(const TcpFailure& failure);
  [[nodiscard]] bool is_tracking() const;

  NdiOptions options_;
  std::unique_ptr<NdiTransport> transport_;

  // Used by next() only.
  NdiState state_ = NdiState::kWaiting;
  Timestamp due_{};        ///< When advance() has something to do.
  bool asked_ = false;     ///< A reply is awaited.
  bool draining_ = false;  ///< Bytes are thrown away until the line is quiet.
  Timestamp drain_end_{};
  bool break_on_ = false;
  int switch_to_baud_ = 0;  ///< Rate that the line changes to at due_; 0: none.
  int baud_ = 0;            ///< Rate to raise to; lowered after a rate at which nothing came.
  bool raised_ = false;     ///< The rate was raised, and no reply has come since.
  int failures_ = 0;        ///< Lost replies to the current question.
  Duration longest_{};      ///< Time for the current reply.
  std::string question_;
  std::size_t sent_ = 0;  ///< Bytes of the question that were sent.
  Timestamp asked_at_{};
  Timestamp answered_{};  ///< Newest intact reply.
  Timestamp look_again_{};
  std::vector<std::byte> buffer_;
  std::size_t filled_ = 0;
  std::optional<NdiSetup> setup_;
  NdiForm form_;
  NdiReadings readings_;
  NdiTracks tracks_;
  RetryTimes retry_;
  std::string reported_loss_;

  mutable std::mutex mutex_;  ///< Guards the health; never held while calling out.
  NdiHealth health_;
};

}  // namespace nav::devices
