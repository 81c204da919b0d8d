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

QString listed(const std::vector<std::string>& names) {
  QString text;
  for (const std::string& name : names) {
    text += (text.isEmpty() ? QString() : QStringLiteral(", ")) + theme::plain(name);
  }
  return text.isEmpty() ? QStringLiteral("none") : text;
}

QString explained(const std::optional<session::GuidanceError>& error) {
  if (!error || error->with.empty()) {
    return QStringLiteral(
        "The errors of the numbers are not known: the session has neither the covariance of a "
        "registration nor the tracker's own figure.");
  }
  return QStringLiteral(
             "± holds the true number with 95 %, for these errors: %1.\nThese errors are not in "
             "it: %2.")
      .arg(listed(error->with), listed(error->without));
}

}  // namespace

Numerals::Numerals(QWidget* parent) : QWidget(parent) {
  setObjectName(QStringLiteral("numerals"));
  setAccessibleName(QStringLiteral("Numbers of the needle"));
  setAttribute(Qt::WA_OpaquePaintEvent);
}

void Numerals::show_numbers(const std::optional<NeedleGuidance>& guidance,
                            const std::optional<session::GuidanceError>& error,
                            const std::string& cause) {
  const QString why = theme::plain(cause);
  std::array<QString, 4> texts, errors;
  constexpr double kDegrees = 180 / M_PI;
  if (guidance) {
    const std::array<double, 4> values{guidance->tip_to_target_mm, guidance->along_axis_mm,
                                       guidance->lateral_mm,
                                       guidance->angle_to_plan_rad * kDegrees};
    for (std::size_t i = 0; i < texts.size(); ++i) {
      texts[i] = QString::asprintf("%.1f", values[i]);
    }
  }
  if (guidance && error) {
    const std::array<std::optional<double>, 4> widths{error->tip_to_target_mm, error->along_axis_mm,
                                                      error->lateral_mm, error->angle_to_plan_rad};
    for (std::size_t i = 0; i < errors.size(); ++i) {
      // Rounded up: an interval never looks better than it is.
      const double unit = i == 3 ? kDegrees : 1;
      if (widths[i]) errors[i] = QString::asprintf("%.1f", std::ceil(10 * unit * *widths[i]) / 10);
    }
  }
  if (withdrawn_ == !guidance && texts == texts_ && errors == errors_ &&
      (guidance || why == cause_)) {
    return;
  }
  withdrawn_ = !guidance;
  texts_ = texts;
  errors_ = errors;
  cause_ = why;
  setToolTip(guidance ? explained(error) : QStringLiteral("The numbers are withdrawn: ") + why);
  update();
}

QString Numerals::value(const QString& name) const {
  constexpr QLatin1String kError("-error");
  for (std::size_t i = 0; i < texts_.size(); ++i) {
    const QLatin1String own(kNumerals[i].name);
    if (name == own) return withdrawn_ ? QStringLiteral("withdrawn") : texts_[i];
    if (name == own + kError) {
      if (withdrawn_) return QStringLiteral("withdrawn");
      return errors_[i].isEmpty() ? QStringLiteral("unknown") : errors_[i];
    }
  }
  return {};
}

/// Unit and interval below the digits.
void Numerals::paint_foot(QPainter& painter, std::size_t i, const QRectF& at) {
  const QString unit = QString::fromUtf8(kNumerals[i].unit);
  const bool known = !errors_[i].isEmpty();
  const QString text = known ? QStringLiteral("± %1 %2 (95 %)").arg(errors_[i], unit)
                             : unit + QStringLiteral("  ± not known");
  int pixels = known ? 20 : 15;
  // Never cut.
  while (pixels > 9 && QFontMetricsF(theme::font(pixels)).horizontalAdvance(text) > at.width()) {
    --pixels;
  }
  painter.setFont(theme::font(pixels));
  painter.setPen(QColor::fromRgb(known ? theme::kWindowText : theme::kWindowFaint));
  painter.drawText(at, Qt::AlignCenter, text);
}

void Numerals::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  painter.fillRect(rect(), QColor::fromRgb(theme::kWindowPanel));
  const double cell = width() / 4.0;
  const double title_height = 24;
  const double foot_height = withdrawn_ ? 40 : 32;
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
    if (!withdrawn_) paint_foot(painter, i, QRectF(x, height() - foot_height, cell, foot_height));
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
