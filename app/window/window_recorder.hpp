// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "app/options/session_config.hpp"
#include "io/json.hpp"
#include "session/live_session.hpp"
#include "session/session_recorder.hpp"

namespace nav::app {

/// State of the recording of a session, as the window shows it.
struct RecordingStatus {
  enum class Stage { kOff, kOn, kFailed };
  Stage stage = Stage::kOff;
  std::filesystem::path path{};      ///< Newest file; empty: nothing was recorded yet.
  std::optional<Timestamp> since{};  ///< Beginning of the recording; present while it goes on.
  std::uint64_t received = 0;        ///< Samples that came.
  std::uint64_t lost = 0;            ///< Samples that came and will not be in the file.
  std::string failure{};             ///< Cause why nothing is recorded; empty: none.
};

/// Records what the devices of a live session deliver, as often as the user asks, each time into a
/// file of its own. record() may be called by the threads of the devices; all else by one thread.
class WindowRecorder {
 public:
  /// Clock and diagnostics must outlive it.
  WindowRecorder(SessionConfig config, const Clock& clock, Diagnostics& diagnostics);
  /// Ends the recording.
  ~WindowRecorder();
  WindowRecorder(const WindowRecorder&) = delete;
  WindowRecorder& operator=(const WindowRecorder&) = delete;

  /// Queues a copy of a sample while a recording goes on. Thread-safe; never waits for the disk.
  void record(std::size_t device, const Sample& sample);
  /// Starts a recording into a file, which must not exist and whose name ends with .mcap. Nothing
  /// happens while one goes on. Errors name the file, and are kept for status().
  Result<void> start(const std::filesystem::path& path, const session::LiveSession& live);
  /// Ends the recording. What still waits is written on another thread.
  void stop();
  /// Waits until all files are complete. Idempotent. The error is the first one of all recordings.
  Result<void> finish();
  [[nodiscard]] RecordingStatus status() const;
  /// Account of each recording, in order, as `sonde live --json` gives it; after finish().
  [[nodiscard]] io::Json json() const;

 private:
  using Recorder = std::shared_ptr<session::SessionRecorder>;
  [[nodiscard]] Recorder current() const;
  void set_current(Recorder recorder);
  void keep(const Result<void>& done);

  SessionConfig config_;
  const Clock& clock_;
  Diagnostics& diagnostics_;
  mutable std::mutex mutex_;  ///< Guards current_.
  Recorder current_;          ///< Null: nothing is recorded.
  std::vector<Recorder> all_;
  std::optional<Timestamp> since_;
  std::optional<Error> start_failure_;  ///< Failure of the newest start().
  std::optional<Error> failure_;        ///< The first failure of all.
  std::vector<std::future<Result<void>>> ending_;
};

}  // namespace nav::app
