// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/run.hpp"

#include <sstream>

namespace nav::render::features {

Result<void> check_memory(const std::string& what, std::size_t voxels, double bytes_per_voxel,
                          std::size_t limit) {
  const double needed = static_cast<double>(voxels) * bytes_per_voxel;
  if (needed <= static_cast<double>(limit)) return {};
  constexpr double kMegabyte = 1e6;
  std::ostringstream text;
  text << what << ": expected a need of at most " << static_cast<double>(limit) / kMegabyte
       << " MB, found " << needed / kMegabyte << " MB (" << voxels << " voxels of "
       << bytes_per_voxel << " bytes)";
  return Error{ErrorCode::kUnsupportedData, text.str()};
}

Error cancelled(const std::string& what) { return {ErrorCode::kCancelled, what + ": cancelled"}; }

}  // namespace nav::render::features
