// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "app/window/moment.hpp"
#include "io/json.hpp"

namespace nav::app {

/// Measurements of the window by itself. Window's thread; times are of the window's clock.
class WindowReport {
 public:
  void latency(double ms) { latency_ms_.push_back(ms); }
  void input_to_paint(double ms) { input_to_paint_ms_.push_back(ms); }
  void handler(double ms) { handler_ms_.push_back(ms); }
  /// Any time in which the window's thread did not answer.
  void block(double ms) { longest_block_ms_ = std::max(longest_block_ms_, ms); }
  void paint(double ms) { paint_ms_.push_back(ms); }
  void convert(double ms) { convert_ms_.push_back(ms); }
  void draw(const std::string& view, double ms) { draw_ms_[view].push_back(ms); }
  void withdrawn(double after_ms) { withdrawn_ms_.push_back(after_ms); }
  void covered(double after_ms) { covered_ms_.push_back(after_ms); }
  void refresh(bool agrees) {
    ++refreshes_;
    if (!agrees) ++epochs_disagree_;
  }
  [[nodiscard]] std::uint64_t refreshes() const { return refreshes_; }
  [[nodiscard]] std::uint64_t epochs_disagree() const { return epochs_disagree_; }
  /// A change of an input's state.
  void state(double t_s, const InputStatus& input);
  void shot(io::Json shot) { shots_.push_back(std::move(shot)); }
  /// cancel_ms: time that Cancel took; absent: it was not cancelled.
  void job(const std::string& name, double seconds, bool cancelled,
           std::optional<double> cancel_ms = {});

  /// The report; keys that other parts know are still null.
  [[nodiscard]] io::Json json() const;

 private:
  struct StateChange {
    double t_s;
    std::string input, state, cause;
  };
  std::vector<double> latency_ms_, input_to_paint_ms_, handler_ms_, paint_ms_, convert_ms_,
      withdrawn_ms_, covered_ms_;
  std::map<std::string, std::vector<double>> draw_ms_;
  double longest_block_ms_ = 0;
  std::uint64_t refreshes_ = 0;
  std::uint64_t epochs_disagree_ = 0;
  std::vector<StateChange> states_;
  std::map<std::string, std::string> state_now_;
  io::Json shots_ = io::Json::array();
  io::Json jobs_ = io::Json::array();
};

}  // namespace nav::app
