// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "devices/ndi/ndi_forms.hpp"
#include "devices/ndi/ndi_setup.hpp"
#include "nav/result.hpp"
#include "nav/sample.hpp"
#include "nav/time.hpp"

namespace nav::devices {

/// One tool that is tracked; its stream has the name of the tool.
struct NdiStream {
  NdiTool tool;
  ToolRole role = ToolRole::kOther;
};

struct NdiOptions {
  std::vector<NdiStream> streams;  ///< 1 to 250.
  int baud = 115200;               ///< Serial only: one of ndi_baud_rates().
  /// First form that is tried; the tracker that does not know it is asked in the next one.
  NdiForm form = NdiForm::kBx2;
  Duration connect_timeout = std::chrono::seconds(2);    ///< TCP, > 0.
  Duration first_retry = std::chrono::seconds(1);        ///< > 0; doubles with every failure.
  Duration longest_retry = std::chrono::seconds(5);      ///< >= first_retry.
  Duration break_time = std::chrono::milliseconds(300);  ///< Serial: length of BREAK.
  Duration reset_wait = std::chrono::seconds(3);         ///< Serial: time for the answer to BREAK.
  Duration silence = std::chrono::milliseconds(500);     ///< Time without a reply that is reported.
  Duration lost = std::chrono::seconds(2);  ///< Silence that ends the connection, >= silence.
  Duration shortest_period = std::chrono::milliseconds(2);  ///< Between two questions.
  Duration idle_period = std::chrono::milliseconds(5);      ///< After a reply without news.
};
/// Rejects no streams, empty names and names that repeat, an unknown baud rate, two tools at one
/// place, and times out of range.
Result<void> validate(const NdiOptions& options);

/// "0.5 s", for messages.
std::string ndi_seconds(Duration duration);

}  // namespace nav::devices
