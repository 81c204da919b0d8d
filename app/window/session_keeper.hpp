// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <deque>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "app/folder_lock.hpp"
#include "app/options/session_config.hpp"
#include "app/window/user_settings.hpp"

namespace nav::app {

/// Folder of the user's state: $XDG_STATE_HOME/sonde, else ~/.local/state/sonde; empty: neither
/// variable is set.
std::filesystem::path state_folder();

/// Writes the sessions of one window on a thread of its own: files that the user saves, and a
/// recovery file of unsaved changes. Each window has a folder of its own under windows/ in the
/// folder of the state, which it holds by a FolderLock; a folder whose lock can be taken belongs to
/// a process that has ended. Calls return at once; Hears are called on the keeper's thread.
class SessionKeeper {
 public:
  /// The end of an order to save.
  struct Saved {
    enum class End { kDone, kAsks, kFailed };
    End end;
    std::filesystem::path path;
    std::string words;  ///< One sentence. kAsks: the reason why the file is not replaced yet.
  };
  struct Hears {
    std::function<void(Saved)> saved;
    std::function<void(bool)> unsaved;  ///< The session differs from its file, or not any more.
    std::function<void(std::string)> offer;  ///< A window that ended left this; empty: none does.
    /// The session that was left, and the file that it belongs to, which may be empty.
    std::function<void(SessionConfig, std::filesystem::path)> restored;
    /// The recovery file, or the user's settings, cannot be written.
    std::function<void(std::string)> failed;
  };
  /// state: folder of the state; empty: there are no recovery files.
  SessionKeeper(std::filesystem::path state, Hears hears);
  ~SessionKeeper() { stop(true); }

  /// Writes a session as a file, whose paths are relative to it. A file that Sonde did not write,
  /// or that is another than this window has read or written last, is replaced only if the user
  /// says so.
  void save(SessionConfig config, std::filesystem::path path, bool replace);
  /// Looks at the session as it is now: writes the recovery file if it has changed. The first look
  /// after this window was opened, or after opened(), says what is unchanged. file: of the session;
  /// may be empty.
  void look(SessionConfig config, std::filesystem::path file);
  /// Another session was opened, from a file; empty: from none. changed: it differs from its file.
  void opened(std::filesystem::path file, bool changed);
  /// Writes the user's settings, see write_user_settings().
  void keep_settings(UserSettings settings, std::filesystem::path folder);
  /// Looks for what windows left that have ended, the newest first.
  void find();
  /// Takes over what was offered, together with its recovery file.
  void restore();
  /// Moves what was offered into discarded/ in the folder of the state.
  void discard();
  /// Ends all orders and joins the thread. with_recovery: the recovery file of unsaved changes
  /// stays for the next window. Idempotent.
  void stop(bool with_recovery);

 private:
  void run();
  void order(std::function<void()> job);
  void do_save(const SessionConfig& config, const std::filesystem::path& path, bool replace);
  void do_look(const SessionConfig& config, const std::filesystem::path& file);
  void do_find();
  void do_restore();
  void do_discard();
  /// Makes this window's folder when it is first needed.
  Result<void> make_own();
  void forget_own();
  void tell_unsaved(bool unsaved);

  /// A folder below windows/, held.
  struct Held {
    std::filesystem::path path;
    FolderLock lock;
  };
  std::filesystem::path state_;
  Hears hears_;
  std::optional<Held> own_, offered_;
  std::optional<std::string> unchanged_;  ///< Text of the session as it is in its file.
  std::string kept_;                      ///< Text in the recovery file; empty: none.
  std::string on_disk_;  ///< Bytes of the session's file as this window knows them.
  std::filesystem::path file_;
  bool restored_ = false;
  bool unsaved_ = false;
  bool failed_ = false;

  std::mutex mutex_;
  std::condition_variable more_;
  std::deque<std::function<void()>> jobs_;
  bool ends_ = false;
  std::thread thread_;
};

}  // namespace nav::app
