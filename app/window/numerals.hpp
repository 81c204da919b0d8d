// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QWidget>
#include <array>
#include <optional>
#include <string>

#include "nav/plan.hpp"
#include "session/guidance_error.hpp"
#include "session/structure_distances.hpp"

namespace nav::app {

/// The numbers of the needle, large. What is not valid is withdrawn: two dashes and the cause,
/// never an old or a grey number.
class Numerals final : public QWidget {
 public:
  explicit Numerals(QWidget* parent);

  /// Absent guidance: withdrawn, for the cause. error: intervals of the numbers; absent: not known.
  /// nearest: distance of the tip from the nearest critical structure; absent: withdrawn.
  void show_numbers(const std::optional<NeedleGuidance>& guidance,
                    const std::optional<session::GuidanceError>& error, const std::string& cause,
                    const std::optional<session::NearestStructure>& nearest = {});
  /// The plan has critical structures: a fifth number is their distance.
  void expect_structures(bool expected);
  /// Text of a numeral ("tip", "depth", "lateral", "angle", "structure") or of its interval
  /// ("tip-error"): "withdrawn" without numbers, "unknown" without an interval, empty where there
  /// is none of that name. "structure" also: "none" without structures, "far" beyond the computed
  /// distances. "structure-state": "clear" or "too-near".
  [[nodiscard]] QString value(const QString& name) const;
  /// Sentences about the errors that are in the intervals, and those that are not.
  [[nodiscard]] QString explanation() const { return toolTip(); }
  [[nodiscard]] bool withdrawn() const { return withdrawn_; }
  /// True: a text was cut when the numbers were painted last.
  [[nodiscard]] bool clipped() const { return !fits_; }

 private:
  void paintEvent(QPaintEvent* event) override;
  void paint_foot(QPainter& painter, std::size_t i, const QRectF& at);

  static constexpr std::size_t kCount = 5;
  [[nodiscard]] std::size_t count() const { return with_structures_ ? kCount : kCount - 1; }
  void tell_nearest(const session::NearestStructure& nearest,
                    const std::optional<session::GuidanceError>& error,
                    std::array<QString, kCount>& texts, std::array<QString, kCount>& errors);

  bool withdrawn_ = true;
  bool with_structures_ = false;
  bool too_near_ = false;
  bool fits_ = true;
  QString cause_;
  QString nearest_words_;  ///< Name of the nearest structure, or why there is no number.
  std::array<QString, kCount> texts_;   ///< Empty: this one is withdrawn.
  std::array<QString, kCount> errors_;  ///< Half widths; empty: not known.
};

}  // namespace nav::app
