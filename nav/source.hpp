// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "nav/result.hpp"
#include "nav/sample.hpp"

namespace nav {

enum class StreamKind { kImages, kPoses };

/// One stream of a source: images, or the poses of one tool.
struct StreamInfo {
  std::string name;  ///< The tool's name or id in the source, or the name of the image stream.
  StreamKind kind = StreamKind::kPoses;
  ToolRole role = ToolRole::kOther;  ///< Poses only.
};

/// Everything that delivers samples: a recording, the simulator, a device. One source has one or
/// more streams. A source owns at most one thread and joins it in stop().
class Source {
 public:
  virtual ~Source() = default;
  /// The streams; constant from construction on.
  [[nodiscard]] virtual const std::vector<StreamInfo>& streams() const = 0;
  /// Next sample in order of arrival, over all streams. kTimeout at the deadline, kEndOfStream
  /// after the last sample, kCancelled after stop(). Any other error ends the source. One caller at
  /// a time.
  virtual Result<Sample> next(Deadline deadline) = 0;
  /// Ends a waiting next(). Idempotent; may be called from another thread.
  virtual void stop() noexcept = 0;
};

}  // namespace nav
