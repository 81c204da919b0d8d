// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "devices/ndi/ndi_poses.hpp"
#include "devices/ndi/ndi_reply.hpp"
#include "devices/ndi/ndi_setup.hpp"
#include "devices/ndi/ndi_transport.hpp"
#include "nav/diagnostics.hpp"
#include "nav/source.hpp"

namespace nav::devices {

/// One tool that is tracked; its stream has the name of the tool.
struct NdiStream {
  NdiTool tool;
  ToolRole role = ToolRole::kOther;
};

/// Command that asks for poses.
enum class NdiForm { kBx2, kBx, kTx };
/// "BX2", "BX" or "TX".
const char* to_string(NdiForm form);

struct NdiOptions {
  std::vector<NdiStream> streams;  ///< 1 to 250.
  int baud = 115200;               ///< Serial only: one of ndi_baud_rates().
  /// First form that is tried; the tracker that does not know it is asked in the next one.
  NdiForm form = NdiForm::kBx2;
  Duration connect_timeout = std::chrono::seconds(2);    ///< TCP, > 0.
  Duration first_retry = std::chrono::seconds(1);        ///< > 0; doubles with every failure.
  Duration longest_retry = std::chrono::seconds(5);      ///< >= first_retry.
  Duration break_time = std::chrono::milliseconds(300);  ///< Serial: length of BREAK.
  Duration reset_wait = std::chrono::seconds(3);         ///< Serial: time for the answer to BREAK.
  Duration silence = std::chrono::milliseconds(500);     ///< Time without a reply that is reported.
  Duration lost = std::chrono::seconds(2);  ///< Silence that ends the connection, >= silence.
  Duration shortest_period = std::chrono::milliseconds(2);  ///< Between two questions.
  Duration idle_period = std::chrono::milliseconds(5);      ///< After a reply without news.
};
/// Rejects no streams, empty names and names that repeat, an unknown baud rate, two tools at one
/// place, and times out of range.
Result<void> validate(const NdiOptions& options);

enum class NdiState { kWaiting, kConnecting, kResetting, kSetup, kTracking, kSilent, kStopped };

/// Account of a source.
struct NdiHealth {
  NdiState state = NdiState::kWaiting;
  std::string cause;              ///< Cause of the newest loss; empty: none yet.
  std::uint64_t connections = 0;  ///< That reached tracking.
  std::uint64_t silences = 0;
  std::uint64_t bytes = 0;
  std::uint64_t repeats = 0;     ///< Readings whose number did not advance; they were dropped.
  std::uint64_t undeclared = 0;  ///< Readings of tools that no stream names.
  std::map<std::string, std::uint64_t> bad_replies;  ///< Keys: NdiFault, "error_0C".
  std::map<std::string, std::uint64_t> losses;       ///< Keys: causes.
  NdiVersion version;
  NdiForm form = NdiForm::kBx2;          ///< In use.
  std::vector<std::string> tool_faults;  ///< One for each stream; empty: it can be tracked.
  std::vector<std::uint64_t> samples;    ///< One for each stream.
};

/// A tracker of NDI (Polaris, Vega, Aurora) by the combined API, on a serial port or TCP. It
/// connects and sets the tracker up in next(), and has no thread of its own: call next() from a
/// thread that does nothing else. A tool that cannot be used is reported and costs only itself. A
/// tracker that is silent, unplugged or reset is tried again after 1, 2, 4 and then every 5 s;
/// next() returns kTimeout meanwhile. Samples are poses:
///   - Status kOk, kOutOfVolume (also partly out), kOccluded (not seen), kInvalid.
///   - Sample::device_time: time of BX2, or counter / 60 Hz for a Polaris; otherwise absent.
///   - Sample::sequence: counter of the tracker where device_time is known, otherwise a count of
///   the
///     stream's samples: the counters of others advance by unknown steps.
///   - The times `acquired` are those of reception until a clock model has mapped device_time.
class NdiSource final : public Source {
 public:
  /// \p clock advances with real time; clock and diagnostics must outlive the source. Errors: those
  /// of validate().
  static Result<std::unique_ptr<NdiSource>> create(NdiOptions options,
                                                   std::unique_ptr<NdiTransport> transport,
                                                   const Clock& clock, Diagnostics& diagnostics);

  [[nodiscard]] const std::vector<StreamInfo>& streams() const override { return infos_; }
  Result<Sample> next(Deadline deadline) override;
  void stop() noexcept override;
  /// Thread-safe.
  [[nodiscard]] NdiHealth account() const;
  [[nodiscard]] SourceHealth health() const override;

 private:
  /// State of one stream.
  struct Tracked {
    std::optional<std::uint16_t> handle{};
    std::optional<std::uint32_t> number{};  ///< Newest.
    std::uint64_t count = 0;                ///< Samples since the beginning.
    bool unplugged = false;
  };
  struct Report {
    Severity severity;
    std::string message;
  };
  NdiSource(NdiOptions options, std::unique_ptr<NdiTransport> transport, const Clock& clock,
            Diagnostics& diagnostics);

  bool take_ready(Sample& sample);
  void set_state(NdiState state, Timestamp due);
  void advance(Timestamp now);
  void open(Timestamp now);
  void begin_setup(Timestamp now);
  void attend(bool readable, bool writable);
  void receive();
  void read_replies(Timestamp now);
  void take_reply(const NdiReply& reply, Timestamp now);
  void take_unasked(const NdiReply& reply);
  void take_setup_reply(const NdiReply& reply, Timestamp now);
  void go_on_with_setup(Timestamp now);
  void setup_done(Timestamp now);
  void take_tracking_reply(const NdiReply& reply, Timestamp now);
  void take_tracking_error(const NdiReply& reply, Timestamp now);
  [[nodiscard]] Result<void> read_poses(const NdiReply& reply);
  void take_readings(Timestamp now);
  void take_reading(std::size_t stream, const NdiToolReading& reading, Timestamp now);
  void look_for_plugged(Timestamp now);
  void ask(const std::string& command, Duration longest, Timestamp now);
  void send_rest();
  void ask_for_poses(Timestamp now);
  void no_reply(Timestamp now);
  void bad_reply(const std::string& cause, Timestamp now);
  void drain(Timestamp now);
  void repeat_question(Timestamp now);
  void lose(const TcpFailure& failure);
  void report_once(Severity severity, const std::string& message);
  void send_reports();
  [[nodiscard]] bool is_tracking() const;
  [[nodiscard]] std::optional<DeviceTime> time_of(const NdiToolReading& reading) const;

  NdiOptions options_;
  std::unique_ptr<NdiTransport> transport_;
  const Clock& clock_;
  Diagnostics& diagnostics_;
  std::vector<StreamInfo> infos_;
  WakeEvent wake_;
  std::atomic<bool> stopped_{false};

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
  bool counts_at_60_hz_ = false;
  NdiReadings readings_;
  std::vector<Tracked> tracked_;
  Duration retry_;
  std::string reported_loss_;
  std::vector<Sample> ready_;
  std::size_t taken_ = 0;
  std::vector<Report> reports_;
  std::map<std::string, bool> reported_;

  mutable std::mutex mutex_;  ///< Guards the health; never held while calling out.
  NdiHealth health_;
};

}  // namespace nav::devices
