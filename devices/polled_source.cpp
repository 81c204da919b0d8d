// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/polled_source.hpp"

#include <algorithm>
#include <array>

namespace nav::devices {
namespace {

constexpr std::size_t kMostReports = 256;

}  // namespace

PolledSource::PolledSource(const Clock& clock, Diagnostics& diagnostics, const char* reporter)
    : clock_(clock), diagnostics_(diagnostics), reporter_(reporter) {}

void PolledSource::stop() noexcept {
  stopped_ = true;
  wake_.signal();
}

Result<Sample> PolledSource::next(Deadline deadline) {
  Sample sample;
  for (;;) {
    if (stopped_) {
      close();
      return Error{ErrorCode::kCancelled, name() + ": stopped"};
    }
    if (take_ready(sample)) return sample;
    const Timestamp now = clock_.now();
    if (now >= wake_time()) advance(now);
    send_reports();
    if (take_ready(sample)) return sample;
    const Timestamp until = std::min(deadline, wake_time());
    const Timestamp before = clock_.now();
    std::array<Watched, 2> watched_now = {Watched{.fd = wake_.get(), .read = true}, watched()};
    wait_for(watched_now, until > before ? until - before : Duration(0));
    if (stopped_) continue;
    attend(watched_now[1].read, watched_now[1].write);
    send_reports();
    if (take_ready(sample)) return sample;
    if (clock_.now() >= deadline) {
      return Error{ErrorCode::kTimeout, name() + ": no sample by the deadline"};
    }
  }
}

bool PolledSource::take_ready(Sample& sample) {
  if (taken_ == ready_.size()) {
    ready_.clear();
    taken_ = 0;
    return false;
  }
  sample = std::move(ready_[taken_++]);
  return true;
}

void PolledSource::report(Severity severity, std::string message) {
  reports_.push_back({severity, std::move(message)});
}

void PolledSource::report_once(Severity severity, std::string_view key,
                               const std::string& message) {
  if (reported_.size() >= kMostReports || !reported_.emplace(key).second) return;
  report(severity, message);
}

std::string PolledSource::without_name(const std::string& message) const {
  const std::string begin = name() + ": ";
  return message.starts_with(begin) ? message.substr(begin.size()) : message;
}

void PolledSource::forget_report(std::string_view key) {
  if (const auto found = reported_.find(key); found != reported_.end()) reported_.erase(found);
}

void PolledSource::send_reports() {
  for (const Report& one : reports_) {
    diagnostics_.report(one.severity, reporter_, name() + ": " + one.message);
  }
  reports_.clear();
}

}  // namespace nav::devices
