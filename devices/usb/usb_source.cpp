// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/usb/usb_source.hpp"

#include <algorithm>
#include <exception>
#include <utility>

namespace nav::devices {

Result<void> validate(const UsbTimes& times) {
  const bool good = times.silence > Duration(0) && times.lost > times.silence &&
                    times.first_retry > Duration(0) && times.longest_retry >= times.first_retry;
  if (good) return {};
  return Error{ErrorCode::kUsage,
               "USB device: expected times above 0, a time of loss longer than that of silence, "
               "and a longest retry of at least the first"};
}

UsbSource::UsbSource(std::string name, const UsbTimes& times, UsbOpener open, const Clock& clock,
                     Diagnostics& diagnostics, const char* reporter)
    : ReopenedSource(std::move(name), {times.first_retry, times.longest_retry}, clock, diagnostics,
                     reporter),
      times_(times),
      open_(std::move(open)) {}

void UsbSource::advance(Timestamp now) {
  if (link_ == nullptr) return open(now);
  if (now >= step_due_) step_due_ = step(now);
  if (link_ == nullptr) return;  // The step has given it up.
  if (now - heard_ >= times_.lost) {
    const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(times_.lost).count();
    const char* const cause = streamed_ ? "silent" : "no_reply";
    return lose({cause, "nothing usable has come for " + std::to_string(ms) + " ms"});
  }
  if (streamed_ && now - heard_ >= times_.silence) set_state(SourceState::kSilent);
  plan();
}

/// Plans the next call of advance().
void UsbSource::plan() {
  const bool silent = state() == SourceState::kSilent || !streamed_;
  set_due(std::min(step_due_, heard_ + (silent ? times_.lost : times_.silence)));
}

void UsbSource::set_step(Timestamp due) {
  step_due_ = due;
  plan();
}

void UsbSource::open(Timestamp now) {
  auto opened = open_();
  if (!opened) return lose({"unavailable", without_name(opened.error().message)});
  link_ = *std::move(opened);
  begun_ = streamed_ = gone_ = false;
  failures_ = 0;
  heard_ = now;
  step_due_ = Timestamp::max();
  set_state(SourceState::kStarting);
  begin_if_open();
  plan();
}

/// Begins the setup once the link stands.
void UsbSource::begin_if_open() {
  if (begun_ || !link_->is_open()) return;
  begun_ = true;
  const Timestamp now = clock().now();
  step_due_ = now;
  begin(now);
  plan();
}

void UsbSource::attend(bool /*readable*/, bool /*writable*/) {
  if (link_ == nullptr) return;
  link_->attend();
  begin_if_open();
  while (link_ != nullptr) {
    const auto transfer = link_->take();
    if (!transfer) return;
    if (transfer->end == UsbEnd::kGone) {
      gone_ = true;
      const TcpFailure usual{"unplugged", "the device was unplugged; plug it in again"};
      return lose(link_->failure().value_or(usual));
    }
    if (transfer->end != UsbEnd::kDone) {
      if (!take_failure(*transfer)) return;
      continue;
    }
    if (transfer->endpoint != 0) failures_ = 0;
    if (transfer->bytes.empty()) {
      if (transfer->endpoint != 0) count("empty");
      continue;
    }
    count_bytes(transfer->bytes.size());
    take(*transfer, clock().now());
  }
}

/// False: the device was given up.
bool UsbSource::take_failure(const UsbTransfer& transfer) {
  const char* const cause = to_string(transfer.end);
  count(cause);
  if (transfer.endpoint == 0) {
    control_failed(transfer.end);
    return link_ != nullptr;
  }
  report_once(Severity::kWarning, std::string("a transfer ended with ") + cause);
  if (++failures_ < kMostFailures) return true;
  lose({cause, std::to_string(failures_) + " transfers in a row ended with " + cause +
                   "; check the cable and the hub"});
  return false;
}

void UsbSource::heard(Timestamp now) {
  heard_ = now;
  if (!std::exchange(streamed_, true)) connected();
  if (state() != SourceState::kStreaming) set_state(SourceState::kStreaming);
  plan();
}

void UsbSource::close() noexcept {
  constexpr Duration kLastWords = std::chrono::milliseconds(100);
  if (link_ == nullptr) return;
  try {
    if (begun_ && !gone_) {
      end();
      link_->drain(kLastWords);
    }
  } catch (const std::exception&) {
    // No memory for the last words: the device is closed without them.
  }
  link_.reset();
}

}  // namespace nav::devices
