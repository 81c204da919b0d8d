// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QTimer>
#include <functional>
#include <future>
#include <optional>
#include <string>
#include <vector>

#include "app/window/main_window.hpp"
#include "app/window/script.hpp"

namespace nav::app {

/// Plays a script against the real window, through Qt's own events. A line that cannot be done ends
/// the script with its number and the cause.
class ScriptPlayer {
 public:
  struct Options {
    QString shots_folder{};  ///< Empty: 'shot' only counts.
  };
  /// All must outlive it. \p done: absent error when the script has ended.
  ScriptPlayer(std::vector<ScriptLine> lines, const Options& options, MainWindow& window,
               const Clock& clock, WindowReport& report,
               std::function<void(std::optional<Error>)> done);

 private:
  void step();
  /// True: the line is done; false: it waits.
  Result<bool> play(const ScriptLine& line);
  Result<bool> await(const ScriptLine& line);
  Result<bool> once_shown(Result<void> (ScriptPlayer::*act)(const ScriptLine&),
                          const ScriptLine& line);
  Result<void> click(const ScriptLine& line);
  Result<void> double_click(const ScriptLine& line);
  Result<void> hover(const ScriptLine& line);
  Result<void> list_controls(const std::string& path);
  Result<void> press(const std::string& key);
  Result<void> drag(const ScriptLine& line);
  Result<void> drag_bar(const ScriptLine& line);
  Result<void> stroke(const ScriptLine& line);
  Result<void> choose(const ScriptLine& line);
  Result<void> set(const ScriptLine& line);
  Result<void> type(const ScriptLine& line);
  Result<void> wheel(const ScriptLine& line);
  Result<void> shoot(const std::string& name);
  /// Ends the script: reports the shots.
  void end(std::optional<Error> failure);
  Result<QWidget*> control(const std::string& name);
  /// A control and a point in it: its middle, or the top of a bar for "histogram.NAME".
  struct Target {
    QWidget* widget;
    QPointF at;
  };
  Result<Target> target(const std::string& name);

  std::vector<ScriptLine> lines_;
  Options options_;
  MainWindow& window_;
  const Clock& clock_;
  WindowReport& report_;
  std::function<void(std::optional<Error>)> done_;
  std::size_t next_ = 0;
  std::vector<std::future<Result<io::Json>>> shots_;  ///< Written on threads of their own.
  std::optional<Timestamp> waiting_since_;
  QTimer timer_;
};

}  // namespace nav::app
