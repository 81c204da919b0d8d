// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/session_keeper.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <unistd.h>
#include <utility>
#include <vector>

#include "io/atomic_file.hpp"
#include "io/own_mark.hpp"

namespace nav::app {
namespace {

constexpr const char* kRecoveryFile = "session.toml";
/// Holds the name of the file that the session belongs to.
constexpr const char* kBelongsTo = "belongs-to.txt";
constexpr std::uint64_t kMostBytes = 64 << 20;

std::string age_in_words(std::filesystem::file_time_type written) {
  using std::chrono::duration_cast;
  using std::chrono::minutes;
  const auto age = std::filesystem::file_time_type::clock::now() - written;
  const auto whole = duration_cast<minutes>(age).count();
  if (whole < 1) return "less than a minute ago";
  if (whole < 120) return std::to_string(whole) + " minutes ago";
  if (whole < 2 * 24 * 60) return std::to_string(whole / 60) + " hours ago";
  return std::to_string(whole / (24 * 60)) + " days ago";
}

/// Folders that windows left, the one with the newest recovery file first.
std::vector<std::filesystem::path> folders_below(const std::filesystem::path& windows) {
  std::vector<std::pair<std::filesystem::file_time_type, std::filesystem::path>> found;
  std::error_code failed;
  for (std::filesystem::directory_iterator it(windows, failed), end; !failed && it != end;
       it.increment(failed)) {
    std::error_code none;
    if (!it->is_directory(none)) continue;
    found.emplace_back(std::filesystem::last_write_time(it->path() / kRecoveryFile, none),
                       it->path());
  }
  std::ranges::sort(found, std::greater<>());
  std::vector<std::filesystem::path> paths;
  for (auto& [time, path] : found) paths.push_back(std::move(path));
  return paths;
}

std::filesystem::path belongs_to(const std::filesystem::path& folder) {
  const auto text = io::read_file(folder / kBelongsTo, 1 << 16);
  return text ? std::filesystem::path(*text) : std::filesystem::path();
}

/// A name below a folder that no other process uses.
std::filesystem::path new_name(const std::filesystem::path& folder, const std::string& suffix) {
  const auto now = std::chrono::system_clock::now().time_since_epoch().count();
  return folder / (std::to_string(now) + "-" + std::to_string(::getpid()) + suffix);
}

}  // namespace

std::filesystem::path state_folder() {
  const char* given = std::getenv("XDG_STATE_HOME");
  if (given != nullptr && std::filesystem::path(given).is_absolute()) {
    return std::filesystem::path(given) / "sonde";
  }
  const char* home = std::getenv("HOME");
  if (home == nullptr || *home == '\0') return {};
  return std::filesystem::path(home) / ".local" / "state" / "sonde";
}

SessionKeeper::SessionKeeper(std::filesystem::path state, Hears hears)
    : state_(std::move(state)), hears_(std::move(hears)), thread_([this] { run(); }) {}

void SessionKeeper::order(std::function<void()> job) {
  const std::lock_guard lock(mutex_);
  if (ends_) return;
  jobs_.push_back(std::move(job));
  more_.notify_one();
}

void SessionKeeper::run() {
  while (true) {
    std::function<void()> job;
    {
      std::unique_lock lock(mutex_);
      more_.wait(lock, [this] { return ends_ || !jobs_.empty(); });
      if (jobs_.empty()) return;
      job = std::move(jobs_.front());
      jobs_.pop_front();
    }
    job();
  }
}

void SessionKeeper::stop(bool with_recovery) {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
    more_.notify_one();
  }
  if (!thread_.joinable()) return;
  thread_.join();
  if (!with_recovery || !unsaved_) forget_own();
  own_.reset();
  offered_.reset();
}

void SessionKeeper::save(SessionConfig config, std::filesystem::path path, bool replace) {
  order([this, config = std::move(config), path = std::move(path), replace] {
    do_save(config, path, replace);
  });
}

void SessionKeeper::look(SessionConfig config, std::filesystem::path file) {
  order([this, config = std::move(config), file = std::move(file)] { do_look(config, file); });
}

void SessionKeeper::opened(std::filesystem::path file, bool changed) {
  order([this, file = std::move(file), changed] {
    unchanged_.reset();
    restored_ = changed;
    on_disk_.clear();
    file_ = file;
    if (const auto text = io::read_file(file, kMostBytes); text && !file.empty()) {
      on_disk_ = *text;
    }
  });
}

void SessionKeeper::keep_settings(UserSettings settings, std::filesystem::path folder) {
  order([this, settings, folder = std::move(folder)] {
    if (const auto kept = write_user_settings(settings, folder); !kept) {
      hears_.failed("The settings of the window cannot be kept: " + kept.error().message);
    }
  });
}

void SessionKeeper::find() {
  order([this] { do_find(); });
}

void SessionKeeper::restore() {
  order([this] { do_restore(); });
}

void SessionKeeper::discard() {
  order([this] { do_discard(); });
}

void SessionKeeper::do_save(const SessionConfig& config, const std::filesystem::path& path,
                            bool replace) {
  const auto fail = [&](const std::string& words) {
    hears_.saved({Saved::End::kFailed, path, words});
  };
  const auto toml = to_toml(config, std::filesystem::absolute(path).parent_path());
  const auto whole = to_toml(config);
  if (!toml) return fail(toml.error().message);
  if (!whole) return fail(whole.error().message);
  std::error_code failed;
  if (std::filesystem::exists(path, failed) && !replace) {
    if (!std::filesystem::is_regular_file(path, failed)) {
      return fail(path.string() + ": expected a file, found something else");
    }
    const auto own = io::is_own_file(path);
    if (!own) return fail(own.error().message);
    const auto now = io::read_file(path, kMostBytes);
    std::string reason;
    if (!*own) {
      reason = "Sonde did not write it, or it was changed by hand: its comments would be lost";
    } else if (!now || *now != on_disk_ || path != file_) {
      reason = "it is a session that this window has not read";
    }
    if (!reason.empty()) {
      return hears_.saved(
          {Saved::End::kAsks, path, path.string() + " exists, and " + reason + ". Replace it?"});
    }
  }
  const std::string text = io::with_mark(*toml);
  if (const auto written = io::write_file(path, std::string_view(text)); !written) {
    return fail(written.error().message);
  }
  on_disk_ = text;
  file_ = path;
  unchanged_ = *whole;
  restored_ = false;
  forget_own();
  tell_unsaved(false);
  hears_.saved({Saved::End::kDone, path, "Saved: " + path.string()});
}

void SessionKeeper::tell_unsaved(bool unsaved) {
  if (std::exchange(unsaved_, unsaved) != unsaved) hears_.unsaved(unsaved);
}

void SessionKeeper::do_look(const SessionConfig& config, const std::filesystem::path& file) {
  // Paths in the recovery file are absolute: it lies in another folder.
  const auto text = to_toml(config);
  if (!text) return;
  if (!unchanged_) unchanged_ = restored_ ? std::string() : *text;
  const bool changed = *text != *unchanged_;
  tell_unsaved(changed);
  if (!changed) {
    if (!kept_.empty()) forget_own();
    return;
  }
  if (state_.empty() || *text == kept_) return;
  const auto keep = [&]() -> Result<void> {
    if (auto made = make_own(); !made) return made;
    const std::filesystem::path whole = file.empty() ? file : std::filesystem::absolute(file);
    const std::string marked = io::with_mark(*text);
    if (auto ok = io::write_file(own_->path / kBelongsTo, std::string_view(whole.string())); !ok) {
      return ok;
    }
    return io::write_file(own_->path / kRecoveryFile, std::string_view(marked));
  };
  const auto kept = keep();
  if (kept) kept_ = *text;
  if (!kept && !std::exchange(failed_, true)) {
    hears_.failed("Unsaved changes cannot be kept for recovery: " + kept.error().message);
  }
}

Result<void> SessionKeeper::make_own() {
  // Another window that looks for what was left may take a folder before it is held.
  constexpr int kTries = 3;
  std::optional<Error> last;
  for (int i = 0; i < kTries && !own_; ++i) {
    const std::filesystem::path path = new_name(state_ / "windows", "");
    std::error_code failed;
    std::filesystem::create_directories(path, failed);
    if (failed) {
      return Error{ErrorCode::kIo, path.string() + ": cannot be created: " + failed.message()};
    }
    auto lock = FolderLock::take(path);
    if (lock) {
      own_.emplace(Held{path, *std::move(lock)});
    } else {
      last = lock.error();
    }
  }
  if (!own_) return *last;
  return {};
}

void SessionKeeper::forget_own() {
  kept_.clear();
  if (!own_) return;
  std::error_code failed;
  std::filesystem::remove_all(own_->path, failed);
  own_.reset();
}

void SessionKeeper::do_find() {
  if (state_.empty() || offered_) return;
  for (const std::filesystem::path& path : folders_below(state_ / "windows")) {
    if (own_ && own_->path == path) continue;
    auto lock = FolderLock::take(path);
    if (!lock) continue;  // A window that is open has it, here or on another host.
    std::error_code failed;
    const auto written = std::filesystem::last_write_time(path / kRecoveryFile, failed);
    if (failed) {
      std::filesystem::remove_all(path, failed);
      continue;
    }
    offered_.emplace(Held{path, *std::move(lock)});
    const std::filesystem::path file = belongs_to(path);
    return hears_.offer("A window that ended " + age_in_words(written) +
                        " left unsaved changes of " +
                        (file.empty() ? std::string("a session without a file") : file.string()) +
                        ". Restore opens them here; Discard moves them into " +
                        (state_ / "discarded").string() + ".");
  }
  hears_.offer({});
}

void SessionKeeper::do_restore() {
  if (!offered_) return;
  auto config = read_session_config(offered_->path / kRecoveryFile);
  if (!config) {
    return hears_.offer(config.error().message + ". Discard moves it into " +
                        (state_ / "discarded").string() + ".");
  }
  const std::filesystem::path file = belongs_to(offered_->path);
  // Its recovery file becomes this window's: it is on the disk all the while.
  forget_own();
  own_ = std::exchange(offered_, std::nullopt);
  config->file = file;
  unsaved_ = true;
  hears_.restored(*std::move(config), file);
  hears_.unsaved(true);
  do_find();
}

void SessionKeeper::do_discard() {
  if (!offered_) return;
  std::error_code failed;
  std::filesystem::create_directories(state_ / "discarded", failed);
  std::filesystem::rename(offered_->path / kRecoveryFile, new_name(state_ / "discarded", ".toml"),
                          failed);
  if (failed) return hears_.offer("The changes stay where they are: " + failed.message());
  std::filesystem::remove_all(offered_->path, failed);
  offered_.reset();
  do_find();
}

}  // namespace nav::app
