// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "io/mcap/mcap_writer.hpp"
#include "io/mcap/sample_layout.hpp"
#include "nav/result.hpp"
#include "nav/sample.hpp"
#include "nav/source.hpp"

namespace nav::io::mcap {

/// Name of the metadata record that describes the session.
inline constexpr const char* kSessionMetadata = "sonde.session";
/// Key, in it and in every channel, with the id of the recording.
inline constexpr const char* kRecordingKey = "recording";

/// Most devices of a recording, and most streams of a device.
inline constexpr std::size_t kMaxDevices = 256;
inline constexpr std::size_t kMaxStreams = 1024;

struct RecorderOptions {
  WriterOptions writer{};
  /// Keys and values of the record "sonde.session": version, session text, digests, …
  TextMap session{};
  /// Id of the recording, which tells its parts from those of another recording inside it (as an
  /// attachment). Empty: a random one.
  std::string id{};
};

/// Numbers of a running recording.
struct RecorderCounts {
  std::uint64_t samples = 0;        ///< Accepted, those in the open chunk included.
  std::uint64_t bytes_written = 0;  ///< In the file.
  std::uint64_t chunks = 0;         ///< In the file.
};

/// Records the samples of several devices into one MCAP file, docs/recording.md. Thread-safe: one
/// mutex. A call may wait for the disk, so that live sources need a queue before it. After a failed
/// write every call returns the same error, and the file stays readable up to there. A file size
/// limit of the system is an error only in a program that ignores SIGXFSZ.
class DeviceRecorder {
 public:
  /// Creates the file. Errors: kIo when it exists or cannot be written; kUsage: bad options.
  static Result<std::unique_ptr<DeviceRecorder>> create(const std::filesystem::path& path,
                                                        RecorderOptions options = {});
  /// Ends the file if finish() was not called; what fails then is not reported.
  ~DeviceRecorder();
  DeviceRecorder(const DeviceRecorder&) = delete;
  DeviceRecorder& operator=(const DeviceRecorder&) = delete;

  /// Adds a device and returns its number. \p id: unique and not empty. \p streams: those of its
  /// source. Errors: kUsage for another id, more than kMaxDevices or kMaxStreams; kIo.
  Result<std::size_t> add_device(const std::string& id, const std::vector<StreamInfo>& streams);
  /// Records a sample of a device, and ends the open chunk when it is full. Preconditions: known
  /// device, and a stream of it, otherwise a Bug. Errors: kIo; kUsage for an image above 64 MiB or
  /// a text above 64 kB, which are left out and do not end the recording.
  Result<void> record(std::size_t device, const Sample& sample);
  /// Tells the time while no samples arrive, so that the open chunk reaches the file in time.
  Result<void> advance_to(Timestamp now);
  /// Writes the open chunk at once.
  Result<void> flush();
  /// Stores a file inside the recording.
  Result<void> attach(const std::string& name, const std::string& media_type, Timestamp now,
                      std::span<const std::byte> bytes);
  /// Stores keys and values under a name.
  Result<void> add_metadata(const std::string& name, TextMap values);
  /// Ends the file with its index and closes it. Idempotent; no other call may follow.
  Result<void> finish();

  /// The reason why nothing more is recorded; absent while all is well.
  [[nodiscard]] std::optional<Error> stopped() const;
  [[nodiscard]] RecorderCounts counts() const;
  [[nodiscard]] const std::string& id() const { return id_; }

 private:
  struct Stream {
    StreamInfo info;
    std::optional<std::uint16_t> channels[kSampleKinds];  ///< Numbered by kind of sample.
  };
  struct Device {
    std::string id;
    std::vector<Stream> streams;
  };

  DeviceRecorder(Writer writer, std::string id);
  Result<std::uint16_t> channel(std::size_t device, std::size_t stream, SampleKind kind);
  Result<std::uint16_t> schema(SampleKind kind);

  mutable std::mutex mutex_;  ///< Guards all that follows but id_.
  std::string id_;
  Writer writer_;
  std::optional<std::uint16_t> schemas_[kSampleKinds];  ///< Numbered by kind of sample.
  std::vector<Device> devices_;
  Buffer buffer_;
  bool finished_ = false;
};

/// Time of a message in the file, ns: that of the session clock, or 0 before its origin.
std::uint64_t log_time(Timestamp time);

}  // namespace nav::io::mcap
