// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tracking/frame_ledger.hpp"

namespace nav::tracking {

std::uint64_t FrameLedger::rejected_total() const {
  std::uint64_t total = 0;
  for (const auto& [cause, count] : rejected_) total += count;
  return total;
}

std::uint64_t FrameLedger::waiting() const {
  const std::uint64_t accounted = shown_ + superseded_ + rejected_total();
  NAV_CHECK(accounted <= received_, accounted, received_);
  return received_ - accounted;
}

}  // namespace nav::tracking
