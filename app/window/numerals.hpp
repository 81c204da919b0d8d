// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QWidget>
#include <array>
#include <optional>
#include <string>

#include "nav/plan.hpp"
#include "session/guidance_error.hpp"

namespace nav::app {

/// The numbers of the needle, large. What is not valid is withdrawn: two dashes and the cause,
/// never an old or a grey number.
class Numerals final : public QWidget {
 public:
  explicit Numerals(QWidget* parent);

  /// Absent guidance: withdrawn, for the cause. error: intervals of the numbers; absent: not known.
  void show_numbers(const std::optional<NeedleGuidance>& guidance,
                    const std::optional<session::GuidanceError>& error, const std::string& cause);
  /// Text of a numeral ("tip", "depth", "lateral", "angle") or of its interval ("tip-error"):
  /// "withdrawn" without numbers, "unknown" without an interval, empty where there is none of that
  /// name.
  [[nodiscard]] QString value(const QString& name) const;
  /// Sentences about the errors that are in the intervals, and those that are not.
  [[nodiscard]] QString explanation() const { return toolTip(); }
  [[nodiscard]] bool withdrawn() const { return withdrawn_; }

 private:
  void paintEvent(QPaintEvent* event) override;
  void paint_foot(QPainter& painter, std::size_t i, const QRectF& at);

  bool withdrawn_ = true;
  QString cause_;
  std::array<QString, 4> texts_;
  std::array<QString, 4> errors_;  ///< Half widths; empty: not known.
};

}  // namespace nav::app
