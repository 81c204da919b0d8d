// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tracking/stream_ledger.hpp"

namespace nav::tracking {
namespace {

std::uint64_t total(const std::map<std::string, std::uint64_t>& by_cause) {
  std::uint64_t sum = 0;
  for (const auto& [cause, count] : by_cause) sum += count;
  return sum;
}

}  // namespace

StreamLedger StreamLedger::followed_by(const StreamLedger& next) const {
  NAV_CHECK(delivered_ == next.received_, delivered_, next.received_);
  StreamLedger both = *this;
  both.delivered_ = next.delivered_;
  both.superseded_ += next.superseded_;
  for (const auto& [cause, count] : next.rejected_) both.rejected_[cause] += count;
  for (const auto& [cause, count] : next.dropped_) both.dropped_[cause] += count;
  return both;
}

std::uint64_t StreamLedger::rejected_total() const { return total(rejected_); }

std::uint64_t StreamLedger::dropped_total() const { return total(dropped_); }

std::uint64_t StreamLedger::waiting() const {
  const std::uint64_t accounted = delivered_ + superseded_ + rejected_total() + dropped_total();
  NAV_CHECK(accounted <= received_, accounted, received_);
  return received_ - accounted;
}

}  // namespace nav::tracking
