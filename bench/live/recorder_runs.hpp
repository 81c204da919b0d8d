// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "nav/result.hpp"

namespace nav::bench {

/// Recording of 60 images of 820 × 616 and of the poses of three bodies at 400 Hz a second.
struct RecorderRun {
  bool memory_backed = false;  ///< The file lay in memory, so that no disk was measured.
  double mb_per_second = 0;    ///< Megabytes (10^6) of pixels per second at full speed.
  double seconds = 0;          ///< Length of the run at the true pace.
  /// Processor time of that run as a share of one core: the copies of the samples and what makes
  /// them included.
  double core_share = 0;
  std::uint64_t samples = 0;  ///< Samples of both runs.
  std::uint64_t lost = 0;     ///< Samples that came and are not in the files.
  bool balanced = false;      ///< received = written + waiting + lost, at the end of both.
};

/// \p seconds: length of the run at the true pace, in (0, 3600]. Files lie in memory where the
/// system offers it, otherwise in the folder for temporary files, and are removed.
Result<RecorderRun> measure_recorder(double seconds);
std::string to_text(const RecorderRun& run);

}  // namespace nav::bench
