// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "app/window/eye_handles.hpp"
#include "app/window/moment.hpp"
#include "app/window/registration_job.hpp"
#include "app/window/registration_page.hpp"
#include "app/window/session_thread.hpp"
#include "render/undo_history.hpp"

namespace nav::app {

/// A registration that waits for the user's verdict.
struct RegistrationCandidate {
  std::string method{};  ///< "landmarks", "sweep" or "eye"; "in use": the one before.
  std::string words{};   ///< Verdict, predicted error at the target, causes.
  /// Placement once it is accepted; absent: its limits reject it.
  std::optional<session::Placement> placement{};
  std::filesystem::path file{};  ///< JSON of the registration; empty: by eye.
};

/// Does what the step Registration asks for: landmarks, the sweep, by eye, and the user's verdict.
/// Nothing is used until the user accepts it; meanwhile the CT lies where the candidate puts it, as
/// degraded. Window's thread; fits and files are the work of another.
class RegistrationDesk {
 public:
  struct Hears {
    std::function<SharedMoment()> moment;
    std::function<SessionConfig()> config;
    std::function<std::optional<Point<frames::Ct>>()> cursor;
    /// Shows a placement of the CT.
    std::function<void(const session::Placement&)> place;
    /// The user's verdict about a candidate, or the rejection of the registration "in use".
    std::function<void(const RegistrationCandidate&, bool accepted)> judged;
    std::function<void(bool on)> by_eye;  ///< The CT is placed by eye, or no longer.
    std::function<std::filesystem::path(const char* suffix)> file;  ///< A new file for results.
    std::function<void(const JobNews&, double seconds, double cancel_ms)> job;
  };
  RegistrationDesk(RegistrationPage& page, Hears hears);
  ~RegistrationDesk() { stop(); }
  void stop();

  /// Another session: nothing of the one before stays.
  void reset();
  void nudge(const RegistrationPage::Nudge& nudge);
  /// Moves the CT by eye as the user drags it; a drag between begin and end is one step of undo.
  void move(const EyeMovement& movement);
  void drag(bool begins);
  bool undo();
  bool redo();
  /// "none", "running", "waiting", "refused", "accepted" or "rejected".
  [[nodiscard]] std::string state() const { return state_; }
  [[nodiscard]] std::size_t landmarks() const { return landmarks_.size(); }

 private:
  struct Landmark {
    std::string name;
    std::optional<Point<frames::Ct>> ct{};
    std::optional<Point<frames::Reference>> reference{};
  };
  void add_point();
  void touch();
  void remove();
  void fit();
  void sweep();
  void cancel();
  void by_eye(bool on);
  void show_eye();
  void show_before(bool before);
  void judge(bool accepts);
  void show_landmarks();
  void take(RegistrationCandidate candidate);
  /// Reads a registration and hands it to take(), on a thread of its own.
  void read(const std::string& method, std::function<Result<std::string>()> make,
            const std::filesystem::path& file);
  /// Shows a candidate's placement as degraded.
  void preview(const session::Placement& placement);
  [[nodiscard]] std::optional<Point<frames::Ct>> target() const;

  RegistrationPage& page_;
  Hears hears_;
  RegistrationJob job_;
  std::vector<Landmark> landmarks_;
  std::optional<RegistrationCandidate> candidate_;
  std::optional<session::Placement> before_;  ///< Placement in use before the candidate.
  render::UndoHistory<std::optional<Transform<frames::Ct, frames::Reference>>> eye_;
  std::string state_ = "none";
  std::optional<std::chrono::steady_clock::time_point> begun_;
  std::uint64_t session_ = 0;  ///< Counts reset(): results of older sessions are dropped.
  std::vector<std::jthread> workers_;
};

}  // namespace nav::app
