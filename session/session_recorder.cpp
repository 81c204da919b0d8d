// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/session_recorder.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <fcntl.h>
#include <fstream>
#include <iterator>
#include <unistd.h>
#include <utility>

namespace nav::session {
namespace {

constexpr auto kLook = std::chrono::milliseconds(50);
constexpr auto kSyncPeriod = std::chrono::seconds(1);
constexpr double kWarnSeconds = 300;
constexpr std::size_t kKeptSyncs = 256;
constexpr const char* kReporterName = "recording";

/// Bytes that a sample takes in the queue.
std::size_t bytes_of(const Sample& sample) {
  std::size_t bytes = sizeof(Sample);
  if (const auto* image = std::get_if<UltrasoundImage>(&sample.what)) {
    bytes += image->pixels.pixels().size() + image->colours.pixels().size_bytes();
  } else if (const auto* missing = std::get_if<MissingImage>(&sample.what)) {
    bytes += missing->cause.size() + missing->message.size();
  }
  return bytes;
}

}  // namespace

std::uint64_t RecordingAccount::lost() const {
  std::uint64_t all = 0;
  for (const auto& [cause, count] : dropped) all += count;
  return all;
}

Result<std::unique_ptr<SessionRecorder>> SessionRecorder::start(const Options& options,
                                                                const Clock& clock,
                                                                Diagnostics& diagnostics) {
  NAV_CHECK(options.most_waiting >= std::size_t{1} << 20, options.most_waiting);
  io::mcap::RecorderOptions file_options;
  file_options.session = options.facts;
  auto file = io::mcap::DeviceRecorder::create(options.path, std::move(file_options));
  if (!file) return file.error();
  const int descriptor = ::open(options.path.c_str(), O_RDONLY | O_CLOEXEC);
  return std::unique_ptr<SessionRecorder>(
      new SessionRecorder(options, clock, diagnostics, *std::move(file), descriptor));
}

SessionRecorder::SessionRecorder(const Options& options, const Clock& clock,
                                 Diagnostics& diagnostics,
                                 std::unique_ptr<io::mcap::DeviceRecorder> file, int descriptor)
    : options_(options),
      clock_(clock),
      diagnostics_(diagnostics),
      file_(std::move(file)),
      descriptor_(descriptor),
      begun_(clock.now()),
      synced_(clock.now()) {
  account_.path = options.path;
  thread_ = std::jthread([this] { run(); });
}

SessionRecorder::~SessionRecorder() {
  (void)finish();
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<void> SessionRecorder::add_devices(const std::vector<LiveDevice>& devices) {
  for (const LiveDevice& device : devices) {
    const auto added = file_->add_device(device.options.id, device.source->streams());
    if (!added) return added.error();
  }
  return {};
}

Result<void> SessionRecorder::add_facts(const std::string& name,
                                        const std::map<std::string, std::string>& facts) {
  {
    const std::lock_guard lock(mutex_);
    facts_.emplace_back(name, facts);
  }
  return file_->add_metadata(name, facts);
}

Result<void> SessionRecorder::attach(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (!stream) return Error{ErrorCode::kIo, file.string() + ": could not be read"};
  return file_->attach(file.filename().string(), "application/octet-stream", clock_.now(),
                       std::as_bytes(std::span(text)));
}

void SessionRecorder::record(std::size_t device, const Sample& sample) {
  const std::size_t bytes = bytes_of(sample);
  bool first_drop = false;
  {
    const std::lock_guard lock(mutex_);
    ++account_.received;
    if (!account_.stopped.empty() || finishing_) {
      ++account_.dropped["stopped"];
      return;
    }
    if (waiting_bytes_ + bytes > options_.most_waiting) {
      first_drop = account_.dropped["queue_full"]++ == 0;
    } else {
      waiting_bytes_ += bytes;
      queue_.push_back({device, bytes, sample});
    }
  }
  if (first_drop) {
    diagnostics_.report(
        Severity::kError, kReporterName,
        options_.path.string() + ": the disk is slower than the devices: samples are lost");
  }
  wake_.notify_one();
}

/// The root of the thread: nothing leaves it but the account.
void SessionRecorder::run() {
  try {
    for (;;) {
      std::deque<Waiting> samples;
      bool last = false;
      {
        std::unique_lock lock(mutex_);
        wake_.wait_for(lock, kLook, [&] { return finishing_ || !queue_.empty(); });
        samples.swap(queue_);
        last = finishing_;
      }
      write(samples);
      if (const auto ok = file_->advance_to(clock_.now()); !ok) stop_recording(ok.error().message);
      if (clock_.now() - synced_ >= kSyncPeriod || last) bring_to_disk();
      if (last) return;
    }
  } catch (const std::exception& error) {
    stop_recording(std::string("internal error: ") + error.what());
  }
}

void SessionRecorder::write(const std::deque<Waiting>& samples) {
  for (const Waiting& one : samples) {
    const auto recorded = file_->record(one.device, one.sample);
    const bool ended = file_->stopped().has_value();
    if (ended) stop_recording(recorded ? file_->stopped()->message : recorded.error().message);
    const std::lock_guard lock(mutex_);
    waiting_bytes_ -= one.bytes;
    if (recorded) {
      ++account_.written;
    } else {
      ++account_.dropped[ended ? "stopped" : "too_large"];
    }
  }
}

void SessionRecorder::stop_recording(const std::string& cause) {
  {
    const std::lock_guard lock(mutex_);
    if (!account_.stopped.empty()) return;
    account_.stopped = cause;
  }
  diagnostics_.report(Severity::kError, kReporterName, "nothing more is recorded: " + cause);
}

/// Makes what was written survive a loss of power.
void SessionRecorder::bring_to_disk() {
  const Timestamp before = clock_.now();
  if (descriptor_ >= 0) (void)::fdatasync(descriptor_);
  synced_ = clock_.now();
  {
    const std::lock_guard lock(mutex_);
    const auto ms = static_cast<float>(1e3 * to_seconds(synced_ - before));
    if (sync_ms_.size() < kKeptSyncs) {
      sync_ms_.push_back(ms);
    } else {
      sync_ms_[syncs_ % kKeptSyncs] = ms;
    }
    ++syncs_;
  }
  look_at_space();
}

void SessionRecorder::look_at_space() {
  const double seconds = to_seconds(clock_.now() - begun_);
  if (space_warned_ || seconds < 5 || file_->stopped()) return;
  std::error_code failed;
  const auto space =
      std::filesystem::space(std::filesystem::absolute(options_.path).parent_path(), failed);
  if (failed) return;
  const double rate = static_cast<double>(file_->counts().bytes_written) / seconds;
  const double left = static_cast<double>(space.available) / std::max(rate, 1.0);
  if (left >= kWarnSeconds) return;
  space_warned_ = true;
  diagnostics_.report(Severity::kWarning, kReporterName,
                      options_.path.string() + ": the disk is full in about " +
                          std::to_string(std::lround(left)) + " s");
}

Result<void> SessionRecorder::finish() {
  {
    const std::lock_guard lock(mutex_);
    finishing_ = true;
  }
  wake_.notify_one();
  if (thread_.joinable()) {
    thread_.join();
    for (const auto& [name, facts] : facts_) (void)file_->add_metadata(name, facts);
    if (const auto ended = file_->finish(); !ended) stop_recording(ended.error().message);
    std::error_code status;
    if (!std::filesystem::exists(options_.path, status)) {
      stop_recording(options_.path.string() + ": the file was removed while it was recorded");
    }
  }
  const std::lock_guard lock(mutex_);
  if (account_.stopped.empty()) return {};
  return Error{ErrorCode::kIo, account_.stopped};
}

RecordingAccount SessionRecorder::progress() const {
  const std::lock_guard lock(mutex_);
  RecordingAccount account = account_;
  account.waiting = account.received - account.written - account.lost();
  return account;
}

RecordingAccount SessionRecorder::account() const {
  // First: the file may wait for the disk, and record() must not wait for that.
  const auto counts = file_->counts();
  RecordingAccount account = progress();
  account.bytes = counts.bytes_written;
  account.chunks = counts.chunks;
  const std::lock_guard lock(mutex_);
  if (!sync_ms_.empty()) {
    std::vector<float> sorted = sync_ms_;
    std::sort(sorted.begin(), sorted.end());
    account.sync_p99_ms = static_cast<double>(
        sorted[static_cast<std::size_t>(0.99 * static_cast<double>(sorted.size() - 1) + 0.5)]);
  }
  return account;
}

}  // namespace nav::session
