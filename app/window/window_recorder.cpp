// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/window_recorder.hpp"

#include <utility>

#include "app/verbs/device_report.hpp"

namespace nav::app {

WindowRecorder::WindowRecorder(SessionConfig config, const Clock& clock, Diagnostics& diagnostics)
    : config_(std::move(config)), clock_(clock), diagnostics_(diagnostics) {}

WindowRecorder::~WindowRecorder() { (void)finish(); }

WindowRecorder::Recorder WindowRecorder::current() const {
  const std::lock_guard lock(mutex_);
  return current_;
}

void WindowRecorder::set_current(Recorder recorder) {
  const std::lock_guard lock(mutex_);
  current_ = std::move(recorder);
}

void WindowRecorder::record(std::size_t device, const Sample& sample) {
  if (const Recorder recorder = current()) recorder->record(device, sample);
}

void WindowRecorder::keep(const Result<void>& done) {
  if (!done && !failure_) failure_ = done.error();
}

Result<void> WindowRecorder::start(const std::filesystem::path& path,
                                   const session::LiveSession& live) {
  if (current()) return {};
  config_.output.record = path;
  start_failure_.reset();
  const auto started = [&]() -> Result<Recorder> {
    auto made = start_recording(config_, clock_, diagnostics_);
    if (!made) return made.error();
    if (auto ok = describe(config_, live, **made); !ok) return ok.error();
    return Recorder(*std::move(made));
  }();
  if (!started) {
    start_failure_ = started.error();
    if (!failure_) failure_ = started.error();
    return started.error();
  }
  all_.push_back(*started);
  since_ = clock_.now();
  set_current(*started);
  return {};
}

void WindowRecorder::stop() {
  Recorder ended = current();
  if (!ended) return;
  set_current(nullptr);
  since_.reset();
  ending_.push_back(
      std::async(std::launch::async, [ended = std::move(ended)] { return ended->finish(); }));
}

Result<void> WindowRecorder::finish() {
  stop();
  for (auto& end : ending_) keep(end.get());
  ending_.clear();
  if (failure_) return *failure_;
  return {};
}

RecordingStatus WindowRecorder::status() const {
  RecordingStatus status;
  using Stage = RecordingStatus::Stage;
  if (!all_.empty()) {
    const session::RecordingAccount account = all_.back()->progress();
    status.path = account.path;
    status.received = account.received;
    status.lost = account.lost();
    status.failure = account.stopped;
  }
  if (start_failure_) status.failure = start_failure_->message;
  status.since = since_;
  status.stage = !status.failure.empty() ? Stage::kFailed : since_ ? Stage::kOn : Stage::kOff;
  return status;
}

io::Json WindowRecorder::json() const {
  io::Json list = io::Json::array();
  for (const Recorder& one : all_) list.push_back(json_of(one.get()));
  return list;
}

}  // namespace nav::app
