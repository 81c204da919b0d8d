// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/mcap/mcap_input.hpp"
#include "io/mcap/mcap_records.hpp"
#include "io/mcap/recording_survey.hpp"
#include "nav/result.hpp"
#include "nav/sample.hpp"
#include "nav/source.hpp"
#include "nav/time.hpp"

namespace nav::io::mcap {

/// The samples of one device of a recording in the order in which they were recorded, as a source
/// for replay: it never waits, and gives kTimeout while the next sample is later than the deadline.
/// Not thread-safe but for stop().
class RecordedDeviceSource : public Source {
 public:
  /// One sentence on what could not be read so far; empty when nothing is amiss. What concerns
  /// another device is named too where the file does not say whose it was.
  [[nodiscard]] virtual std::string damage() const = 0;
};

/// A sample and the number of its device.
struct DeviceSample {
  std::size_t device = 0;
  Sample sample;
};

/// All devices of a recording in order of arrival (Sample::received); at the same time the device
/// with the lower number is first. Samples of one device keep their order. Not thread-safe.
class MergedRecording {
 public:
  explicit MergedRecording(std::vector<std::unique_ptr<RecordedDeviceSource>> sources);
  /// The next sample; kEndOfStream after the last one. Other errors: kIo.
  Result<DeviceSample> next();
  /// One sentence for each part that is damaged, without repetitions.
  [[nodiscard]] std::vector<std::string> damage() const;

 private:
  std::vector<std::unique_ptr<RecordedDeviceSource>> sources_;
  std::vector<std::optional<Sample>> waiting_;
  std::vector<bool> ended_;
};

/// A recording of a DeviceRecorder, open for reading. Every source reads the file by itself, in
/// constant memory. Not thread-safe; sources of the same recording can be used by several threads.
class DeviceRecording {
 public:
  /// Errors: kNotFound, kIo; kMalformedData for a file in which nothing of a recording can be read.
  static Result<DeviceRecording> open(const std::filesystem::path& path,
                                      const RecordingAccess& access = {});
  static Result<DeviceRecording> open(std::shared_ptr<const Input> input,
                                      const RecordingAccess& access = {});

  /// The devices in the order in which they were added. A device, or a stream between others, of
  /// which nothing can be read is missing, or has an empty name.
  [[nodiscard]] const std::vector<RecordedDevice>& devices() const { return contents_.devices; }
  /// Number of a device by its id.
  [[nodiscard]] std::optional<std::size_t> find(const std::string& id) const;
  /// A new source at the first sample of the device.
  [[nodiscard]] Result<std::unique_ptr<RecordedDeviceSource>> source(std::size_t device) const;
  /// A new reader at the first sample of all.
  [[nodiscard]] Result<MergedRecording> merged() const;

  /// Values of the record "sonde.session"; empty when it cannot be read.
  [[nodiscard]] const TextMap& session() const { return contents_.session; }
  /// The other metadata records whose checksum holds.
  [[nodiscard]] const std::vector<Metadata>& metadata() const { return contents_.metadata; }
  /// The attachments whose checksum holds.
  [[nodiscard]] const std::vector<AttachmentIndex>& attachments() const {
    return contents_.attachments;
  }
  /// Bytes of an attachment. Errors: kIo; kUnsupportedData above \p max_bytes.
  [[nodiscard]] Result<std::vector<std::byte>> read(const AttachmentIndex& attachment,
                                                    std::uint64_t max_bytes) const;

  [[nodiscard]] const std::string& name() const { return input_->name(); }
  /// Id of the recording.
  [[nodiscard]] const std::string& id() const { return contents_.id; }
  /// True when the file ends with an intact index: the recorder finished it.
  [[nodiscard]] bool is_finished() const { return contents_.is_finished; }
  [[nodiscard]] std::uint64_t samples() const;
  /// Earliest and latest arrival; absent without samples.
  [[nodiscard]] std::optional<Timestamp> first_time() const { return contents_.first_time; }
  [[nodiscard]] std::optional<Timestamp> last_time() const { return contents_.last_time; }
  [[nodiscard]] Duration duration() const;
  /// One sentence each; empty when nothing is amiss as far as was read.
  [[nodiscard]] const std::vector<std::string>& warnings() const { return contents_.warnings; }

 private:
  DeviceRecording() = default;

  std::shared_ptr<const Input> input_;
  RecordingAccess access_;
  RecordingContents contents_;
};

}  // namespace nav::io::mcap
