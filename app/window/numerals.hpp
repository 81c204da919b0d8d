// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QWidget>
#include <array>
#include <optional>
#include <string>

#include "nav/plan.hpp"

namespace nav::app {

/// The numbers of the needle, large. What is not valid is withdrawn: two dashes and the cause,
/// never an old or a grey number.
class Numerals final : public QWidget {
 public:
  explicit Numerals(QWidget* parent);

  /// Absent: withdrawn, for the cause.
  void show_numbers(const std::optional<NeedleGuidance>& guidance, const std::string& cause);
  /// Text of a numeral, "withdrawn", or empty: there is none of that name ("tip", "depth",
  /// "lateral", "angle").
  [[nodiscard]] QString value(const QString& name) const;
  [[nodiscard]] bool withdrawn() const { return withdrawn_; }

 private:
  void paintEvent(QPaintEvent* event) override;

  bool withdrawn_ = true;
  QString cause_;
  std::array<QString, 4> texts_;
};

}  // namespace nav::app
