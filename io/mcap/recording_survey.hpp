// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/mcap/mcap_input.hpp"
#include "io/mcap/mcap_records.hpp"
#include "io/mcap/mcap_walk.hpp"
#include "io/mcap/sample_route.hpp"
#include "nav/result.hpp"
#include "nav/source.hpp"
#include "nav/time.hpp"

namespace nav::io::mcap {

/// A device in a recording.
struct RecordedDevice {
  std::string id;
  std::vector<StreamInfo> streams;
  std::vector<std::uint64_t> samples;  ///< Numbered by stream.
};

struct RecordingAccess {
  /// Read the whole file when it is opened, even if it has an intact index: then counts, times and
  /// warnings are those of what can be read. Otherwise the index is believed until it is read.
  bool read_all = false;
  /// False: the index is not used.
  bool use_index = true;
};

/// Contents of a recording without its samples.
struct RecordingContents {
  std::string id;  ///< Id of the recording; empty: nothing in the file names one.
  std::vector<RecordedDevice> devices;
  TextMap session;
  std::vector<Metadata> metadata;
  std::vector<AttachmentIndex> attachments;
  std::optional<Timestamp> first_time, last_time;
  bool is_finished = false;
  std::vector<std::string> warnings;
};

/// Surveys a recording: by its index, or in a pass over the whole file. Errors: kIo;
/// kMalformedData for a file in which nothing of a recording can be read.
Result<RecordingContents> survey(const std::shared_ptr<const Input>& input,
                                 const RecordingAccess& access);

/// Route of a channel of a summary, see route_of().
std::optional<SampleRoute> route_in(const Summary& summary, const Channel& channel,
                                    const std::string& recording_id);

}  // namespace nav::io::mcap
