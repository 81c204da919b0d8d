// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "io/mcap/device_recorder.hpp"
#include "nav/diagnostics.hpp"
#include "session/live_devices.hpp"

namespace nav::session {

/// Account of a recording, at a moment.
struct RecordingAccount {
  std::filesystem::path path;
  std::uint64_t received = 0;                      ///< Samples that came.
  std::uint64_t written = 0;                       ///< Samples that were handed to the file.
  std::uint64_t waiting = 0;                       ///< Samples in the queue.
  std::map<std::string, std::uint64_t> dropped{};  ///< Causes: queue_full, stopped, too_large.
  std::uint64_t chunks = 0;                        ///< In the file.
  std::uint64_t bytes = 0;                         ///< In the file.
  double sync_p99_ms = 0;  ///< Time to bring the file to the disk, of the newest 256 times.
  std::string stopped{};   ///< Cause why nothing more is recorded; empty: recording.

  [[nodiscard]] std::uint64_t lost() const;
  [[nodiscard]] bool balanced() const { return received == written + waiting + lost(); }
};

/// Records what devices deliver (docs/recording.md) on a thread of its own: a slow disk never holds
/// up a device. The queue is lossless up to a number of bytes; then samples are dropped, counted
/// and reported. A full disk ends the recording, not the session, and is announced when the space
/// lasts for less than five minutes. Thread-safe.
class SessionRecorder {
 public:
  struct Options {
    std::filesystem::path path;                         ///< Must not exist.
    std::size_t most_waiting = std::size_t{256} << 20;  ///< Bytes of the queue, >= 1 MiB.
    std::map<std::string, std::string> facts{};  ///< Facts of the session: version, calibration, …
  };

  /// Creates the file and starts the thread. \p clock and diagnostics must outlive it. Errors:
  /// those of io::mcap::DeviceRecorder::create().
  static Result<std::unique_ptr<SessionRecorder>> start(const Options& options, const Clock& clock,
                                                        Diagnostics& diagnostics);
  ~SessionRecorder();
  SessionRecorder(const SessionRecorder&) = delete;
  SessionRecorder& operator=(const SessionRecorder&) = delete;

  /// Before the first sample: the devices, in the order in which record() numbers them.
  Result<void> add_devices(const std::vector<LiveDevice>& devices);
  /// Stores keys and values, or a file, inside the recording: at once, and keys and values again at
  /// its end, so that damage to one place loses nothing.
  Result<void> add_facts(const std::string& name, const std::map<std::string, std::string>& facts);
  Result<void> attach(const std::filesystem::path& file);
  /// Queues a copy of the sample. Never waits for the disk.
  void record(std::size_t device, const Sample& sample);
  /// Writes what waits, and ends the file. Idempotent. The error is that of the first write that
  /// failed.
  Result<void> finish();
  /// May wait for the disk.
  [[nodiscard]] RecordingAccount account() const;
  /// The account without chunks, bytes and times of the file. Never waits for the disk.
  [[nodiscard]] RecordingAccount progress() const;

 private:
  struct Waiting {
    std::size_t device;
    std::size_t bytes;
    Sample sample;
  };
  SessionRecorder(const Options& options, const Clock& clock, Diagnostics& diagnostics,
                  std::unique_ptr<io::mcap::DeviceRecorder> file, int descriptor);
  void run();
  void write(const std::deque<Waiting>& samples);
  void bring_to_disk();
  void look_at_space();
  void stop_recording(const std::string& cause);

  Options options_;
  const Clock& clock_;
  Diagnostics& diagnostics_;
  std::unique_ptr<io::mcap::DeviceRecorder> file_;
  int descriptor_;  ///< Brings the file to the disk.
  // Used by the thread only.
  Timestamp begun_;
  Timestamp synced_;
  bool space_warned_ = false;

  mutable std::mutex mutex_;  ///< Guards the rest but the thread.
  std::condition_variable wake_;
  std::deque<Waiting> queue_;
  std::size_t waiting_bytes_ = 0;
  bool finishing_ = false;
  std::vector<std::pair<std::string, std::map<std::string, std::string>>> facts_;
  RecordingAccount account_;
  std::vector<float> sync_ms_;
  std::size_t syncs_ = 0;
  std::jthread thread_;
};

}  // namespace nav::session
