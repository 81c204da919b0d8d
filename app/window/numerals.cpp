// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/numerals.hpp"

#include <QPainter>
#include <cmath>

#include "app/window/theme.hpp"

namespace nav::app {
namespace {

struct NumeralName {
  const char* name;
  const char* title;
  const char* unit;
};
constexpr std::array<NumeralName, 4> kNumerals{{{"tip", "tip to target", "mm"},
                                                {"depth", "depth to go", "mm"},
                                                {"lateral", "lateral", "mm"},
                                                {"angle", "angle to plan", "°"}}};
/// Height of the digits' font: capitals of 44 pixels where the screen's resolution is unknown.
constexpr int kDigitPixels = 60;

}  // namespace

Numerals::Numerals(QWidget* parent) : QWidget(parent) {
  setObjectName(QStringLiteral("numerals"));
  setAccessibleName(QStringLiteral("Numbers of the needle"));
  setAttribute(Qt::WA_OpaquePaintEvent);
}

void Numerals::show_numbers(const std::optional<NeedleGuidance>& guidance,
                            const std::string& cause) {
  const QString why = theme::plain(cause);
  std::array<QString, 4> texts;
  if (guidance) {
    const std::array<double, 4> values{guidance->tip_to_target_mm, guidance->along_axis_mm,
                                       guidance->lateral_mm,
                                       guidance->angle_to_plan_rad * 180 / M_PI};
    for (std::size_t i = 0; i < texts.size(); ++i) {
      texts[i] = QString::asprintf("%.1f", values[i]);
    }
  }
  if (withdrawn_ == !guidance && texts == texts_ && (guidance || why == cause_)) return;
  withdrawn_ = !guidance;
  texts_ = texts;
  cause_ = why;
  update();
}

QString Numerals::value(const QString& name) const {
  for (std::size_t i = 0; i < texts_.size(); ++i) {
    if (name == QLatin1String(kNumerals[i].name)) {
      return withdrawn_ ? QStringLiteral("withdrawn") : texts_[i];
    }
  }
  return {};
}

void Numerals::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  painter.fillRect(rect(), QColor::fromRgb(theme::kWindowPanel));
  const double cell = width() / 4.0;
  const double title_height = 24;
  const double foot_height = withdrawn_ ? 40 : 24;
  const double middle = height() - title_height - foot_height;
  const QRectF digits(0, title_height, cell, middle);
  int pixels = std::min<int>(kDigitPixels, static_cast<int>(middle));
  // Never cut: "-999.9" has to fit into a cell.
  const QString widest = QStringLiteral("-999.9");
  while (pixels > 12 && QFontMetricsF(theme::font(pixels, true)).horizontalAdvance(widest) > cell) {
    --pixels;
  }
  for (std::size_t i = 0; i < texts_.size(); ++i) {
    const double x = static_cast<double>(i) * cell;
    painter.setFont(theme::font(15));
    painter.setPen(QColor::fromRgb(theme::kWindowFaint));
    painter.drawText(QRectF(x, 4, cell, title_height), Qt::AlignCenter,
                     QString::fromUtf8(kNumerals[i].title));
    if (!withdrawn_) {
      painter.drawText(QRectF(x, height() - foot_height, cell, foot_height), Qt::AlignCenter,
                       QString::fromUtf8(kNumerals[i].unit));
    }
    painter.setFont(theme::font(pixels, true));
    painter.setPen(withdrawn_ ? theme::colour_of_state(SafetyState::kDegraded) : QColor(Qt::white));
    painter.drawText(digits.translated(x, 0), Qt::AlignCenter,
                     withdrawn_ ? QStringLiteral("– –") : texts_[i]);
  }
  if (withdrawn_) {
    painter.setFont(theme::font(14));
    painter.setPen(QColor::fromRgb(theme::kWindowText));
    painter.drawText(QRectF(8, height() - foot_height, width() - 16, foot_height),
                     Qt::AlignCenter | Qt::TextWordWrap, QStringLiteral("withdrawn: ") + cause_);
  }
}

}  // namespace nav::app
