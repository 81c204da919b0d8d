// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "app/window/feed.hpp"
#include "app/window/mailbox.hpp"
#include "app/window/moment.hpp"
#include "io/json.hpp"

namespace nav::app {

/// A fault that is switched on for a time: "cover-marker" or "hold-images".
struct FaultOrder {
  std::string name;
  Duration time;
};

/// A file to record into; absent: the recording ends.
using RecordOrder = std::optional<std::filesystem::path>;

/// Distances from the critical structures of the window's plan.
struct StructureOrder {
  std::uint64_t number = 0;  ///< Counts the changes of plan and structures.
  std::shared_ptr<const session::StructureDistances> distances{};  ///< Null: being computed.
};

/// How far a session has come, for the steps of the window.
struct SessionNews {
  enum class Stage { kLoading, kRunning, kFailed };
  Stage stage = Stage::kLoading;
  std::string words{};  ///< The work in progress, or the failure.
  std::vector<std::pair<std::string, std::string>> facts = {};  ///< Feed::facts().
};

/// A job in the background, for the last line of the window and for the report.
struct JobNews {
  enum class Stage { kNone, kRunning, kDone, kFailed, kCancelled };
  Stage stage = Stage::kNone;
  std::string name{};             ///< "open", "register".
  std::string words{};            ///< The work in progress, the result, or the failure.
  std::optional<double> share{};  ///< 0 to 1; absent: not known.
};

/// Opens and plays a session on a thread of its own, and hands over its moments. Reads all files:
/// the window's thread reads none.
class SessionThread {
 public:
  /// Called on the session's thread.
  struct Hears {
    std::function<void(SharedMoment)> moment;
    std::function<void(SessionNews)> news;
    std::function<void(RecordingStatus)> recording;  ///< Twice a second while it records.
    std::function<void(JobNews)> job;                ///< Opening of another session.
    std::function<void(session::PressedButton)> pressed;
  };
  /// The clock and the console must outlive it.
  SessionThread(SessionConfig config, bool loop, const Clock& clock, Console& console, Hears hears);
  ~SessionThread() { stop(); }

  /// Opens the configuration and plays it.
  void start();
  /// Opens another session on a thread of its own. The one that plays stays until it is complete,
  /// and also when it cannot be opened; `job` hears which. The newest order counts. Starts the
  /// thread if need be.
  void open(SessionConfig config);
  /// The session that is being opened is not used. Returns at once.
  void cancel_opening();
  /// Joins the threads. Idempotent.
  void stop();
  /// Replaces the plan, or the placement of the CT, of the session that plays.
  void set_plan(const NeedlePlan& plan) { plans_.put(plan); }
  void set_placement(session::Placement placement) { placements_.put(std::move(placement)); }
  void set_structures(StructureOrder order) { structure_orders_.put(std::move(order)); }
  void order(FaultOrder fault) { faults_.put(std::move(fault)); }
  /// Starts or ends a recording, which `recording` hears. The newest order counts.
  void record(RecordOrder order) { records_.put(std::move(order)); }
  /// Stops playing for a time, as a session that hangs.
  void hang(Duration time) { hang_ns_ = time.count(); }
  /// Account of the images; after stop().
  [[nodiscard]] const io::Json& ledger() const { return ledger_; }
  /// Accounts of the recordings; after stop().
  [[nodiscard]] const io::Json& recordings() const { return recordings_; }
  /// Buttons that were pressed; after stop().
  [[nodiscard]] const io::Json& presses() const { return presses_; }
  /// The first recording that failed, else a device that failed or gave nothing; after stop().
  [[nodiscard]] const Result<void>& recorded() const { return recorded_; }

 private:
  /// A session that is open. The feed refers to the configuration.
  struct Opened {
    std::unique_ptr<const SessionConfig> config;
    std::unique_ptr<Feed> feed;
  };
  [[nodiscard]] Result<Opened> opened(const SessionConfig& config);
  void run(const std::stop_token& stop, bool from_config);
  void begin_thread(bool from_config);
  void close(Feed& feed);
  [[nodiscard]] std::optional<Opened> play(Feed& feed, const std::stop_token& stop);
  [[nodiscard]] bool obey_user(Feed& feed);
  [[nodiscard]] std::shared_ptr<Moment> moment_of(Feed& feed, session::Epoch epoch, Timestamp now);
  void look_at_streams(Feed& feed, Timestamp now);
  void obey(Feed& feed);
  void obey_records(Feed& feed);
  void tell(SessionNews::Stage stage, std::string words, Feed* feed = nullptr);

  SessionConfig config_;  ///< The session that plays; session's thread.
  bool loop_;
  const Clock& clock_;
  Console& console_;
  Hears hears_;
  Mailbox<FaultOrder> faults_;
  Mailbox<RecordOrder> records_;
  Mailbox<NeedlePlan> plans_;
  Mailbox<session::Placement> placements_;
  Mailbox<StructureOrder> structure_orders_;
  StructureOrder structures_;  ///< Session's thread.
  Mailbox<Opened> next_;
  std::atomic<std::uint64_t> ticket_{0};  ///< Counts the orders to open a session.
  std::vector<std::jthread> openers_;     ///< Window's thread.
  std::uint64_t session_ = 0;
  std::atomic<Duration::rep> hang_ns_{0};
  std::uint64_t number_ = 0;
  struct StreamLook {
    std::optional<double> images_hz, needle_hz;
    std::uint64_t images_dropped = 0, needle_dropped = 0;
  } look_;
  std::optional<Timestamp> looked_;
  std::shared_ptr<const render::ValueCounts> counts_;
  std::optional<Timestamp> told_;  ///< Time of the newest status of the recording.
  io::Json ledger_;
  io::Json recordings_ = io::Json::array();
  io::Json presses_ = io::Json::array();
  Result<void> recorded_;
  std::jthread thread_;
};

}  // namespace nav::app
