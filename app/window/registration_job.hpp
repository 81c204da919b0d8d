// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QProcess>
#include <QStringList>
#include <QTimer>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/options/session_config.hpp"
#include "nav/result.hpp"

namespace nav::app {

/// Words of `sonde register` for a session: its recording against its CT. start: pose to begin
/// with; absent: none is known. target: point at which the error is judged; absent: the sweep's
/// centre. json: file of the result. kUsage: the session has no recording or no CT.
Result<std::vector<std::string>> register_words(const SessionConfig& config,
                                                const std::optional<Eigen::Matrix4d>& start,
                                                const std::optional<Eigen::Vector3d>& target,
                                                const std::filesystem::path& json);

/// Runs `sonde register` as a process of its own: Cancel ends it at once and leaves everything as
/// it was, because its result is written in one piece at the end. Window's thread, never blocked.
class RegistrationJob {
 public:
  RegistrationJob();
  ~RegistrationJob() { cancel(); }

  /// Starts it. Precondition: none runs.
  void start(const std::vector<std::string>& words);
  /// Ends it; `done` is not called. Idempotent.
  void cancel();
  [[nodiscard]] bool runs() const { return process_ != nullptr; }

  std::function<void(double share, const QString& stage)> progressed;
  /// The end: exit code, and the last sentence that the process said.
  std::function<void(int exit_code, const QString& words)> done;

 private:
  void read();
  void finish(int exit_code);

  QProcess* process_ = nullptr;
  QByteArray rest_;
  QString last_;
};

}  // namespace nav::app
