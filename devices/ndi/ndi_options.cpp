// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/ndi/ndi_options.hpp"

#include <algorithm>
#include <sstream>

namespace nav::devices {
namespace {

Error ndi_usage(const std::string& what) { return {ErrorCode::kUsage, "NDI: expected " + what}; }

Result<void> validate_streams(const std::vector<NdiStream>& streams) {
  constexpr std::size_t kMost = 250;
  if (streams.empty() || streams.size() > kMost) {
    return ndi_usage("1 to 250 tools, found " + std::to_string(streams.size()));
  }
  for (std::size_t i = 0; i < streams.size(); ++i) {
    const NdiTool& tool = streams[i].tool;
    if (tool.name.empty()) return ndi_usage("a name for every tool, found an empty one");
    for (std::size_t j = 0; j < i; ++j) {
      const NdiTool& other = streams[j].tool;
      if (tool.name == other.name) {
        return ndi_usage("names that differ, found " + tool.name + " twice");
      }
      if (tool.place && tool.place == other.place) {
        return ndi_usage("one tool at each port, found " + other.name + " and " + tool.name +
                         " at port " + std::to_string(tool.place->port));
      }
    }
  }
  return {};
}

}  // namespace

std::string ndi_seconds(Duration duration) {
  std::ostringstream text;
  text << to_seconds(duration) << " s";
  return text.str();
}

Result<void> validate(const NdiOptions& o) {
  if (std::ranges::count(ndi_baud_rates(), o.baud) == 0) {
    std::string rates;
    for (const int rate : ndi_baud_rates()) {
      rates.append(rates.empty() ? "" : ", ").append(std::to_string(rate));
    }
    return ndi_usage("a baud rate of " + rates + ", found " + std::to_string(o.baud));
  }
  for (const Duration time : {o.connect_timeout, o.first_retry, o.longest_retry, o.break_time,
                              o.reset_wait, o.silence, o.lost, o.shortest_period, o.idle_period}) {
    if (time <= Duration(0) || time > std::chrono::hours(1)) {
      return ndi_usage("times above 0 and up to one hour, found " + ndi_seconds(time));
    }
  }
  if (o.longest_retry < o.first_retry || o.lost < o.silence) {
    return ndi_usage("longest_retry >= first_retry and lost >= silence, found the opposite");
  }
  return validate_streams(o.streams);
}

}  // namespace nav::devices
