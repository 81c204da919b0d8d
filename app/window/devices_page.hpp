// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QPushButton>
#include <QWidget>
#include <array>
#include <functional>
#include <string>
#include <vector>

namespace nav::app {

/// Controls of the step Devices: the views of the second screen.
class DevicesPage final : public QWidget {
 public:
  explicit DevicesPage(QWidget* parent);

  /// Chosen views by name, as WindowState::second_views has them; empty: those of the window.
  [[nodiscard]] std::vector<std::string> views() const;
  /// Chooses views without telling chosen.
  void set_views(const std::vector<std::string>& views);
  /// Called when the user has chosen others.
  std::function<void()> chosen;

 private:
  std::array<QPushButton*, 4> buttons_;
};

}  // namespace nav::app
