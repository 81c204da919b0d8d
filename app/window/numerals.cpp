// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/numerals.hpp"

#include <QPainter>
#include <algorithm>
#include <cmath>
#include <utility>

#include "app/window/theme.hpp"

namespace nav::app {
namespace {

struct NumeralName {
  const char* name;
  const char* title;
  const char* unit;
};
constexpr std::array<NumeralName, 5> kNumerals{{{"tip", "tip to target", "mm"},
                                                {"depth", "depth to go", "mm"},
                                                {"lateral", "lateral", "mm"},
                                                {"angle", "angle to plan", "°"},
                                                {"structure", "to structure", "mm"}}};
constexpr std::size_t kStructure = 4;
/// Colour of the distance from a structure that is nearer than the plan allows.
constexpr QRgb kTooNear = 0xffff8a80;
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

void Numerals::expect_structures(bool expected) {
  if (expected == with_structures_) return;
  with_structures_ = expected;
  update();
}

/// Digits, interval and words of the distance from the nearest structure.
void Numerals::tell_nearest(const session::NearestStructure& nearest,
                            const std::optional<session::GuidanceError>& error,
                            std::array<QString, kCount>& texts,
                            std::array<QString, kCount>& errors) {
  using State = session::NearestStructure::State;
  switch (nearest.state) {
    case State::kNone:
      nearest_words_ = QStringLiteral("no structure");
      return;
    case State::kPending:
      nearest_words_ = QStringLiteral("being computed");
      return;
    case State::kUnknown:
      nearest_words_ = QStringLiteral("not known here");
      return;
    case State::kFar:
      texts[kStructure] = QStringLiteral("> %1").arg(session::kFarthestClearanceMm, 0, 'f', 0);
      nearest_words_ = QStringLiteral("to structure");
      return;
    case State::kKnown:
      break;
  }
  texts[kStructure] = QString::asprintf("%.1f", nearest.distance_mm);
  too_near_ = !nearest.too_near.empty();
  nearest_words_ = too_near_ ? QStringLiteral("TOO NEAR: ") + theme::plain(nearest.too_near)
                             : QStringLiteral("to ") + theme::plain(nearest.name);
  if (error && error->tip_mm) {
    errors[kStructure] = QString::asprintf("%.1f", std::ceil(10 * *error->tip_mm) / 10);
  }
}

void Numerals::show_numbers(const std::optional<NeedleGuidance>& guidance,
                            const std::optional<session::GuidanceError>& error,
                            const std::string& cause,
                            const std::optional<session::NearestStructure>& nearest) {
  const QString why = theme::plain(cause);
  std::array<QString, kCount> texts, errors;
  constexpr double kDegrees = 180 / M_PI;
  if (guidance) {
    const std::array<double, 4> values{guidance->tip_to_target_mm, guidance->along_axis_mm,
                                       guidance->lateral_mm,
                                       guidance->angle_to_plan_rad * kDegrees};
    for (std::size_t i = 0; i < values.size(); ++i) {
      texts[i] = QString::asprintf("%.1f", values[i]);
    }
  }
  if (guidance && error) {
    const std::array<std::optional<double>, 4> widths{error->tip_to_target_mm, error->along_axis_mm,
                                                      error->lateral_mm, error->angle_to_plan_rad};
    for (std::size_t i = 0; i < widths.size(); ++i) {
      // Rounded up: an interval never looks better than it is.
      const double unit = i == 3 ? kDegrees : 1;
      if (widths[i]) errors[i] = QString::asprintf("%.1f", std::ceil(10 * unit * *widths[i]) / 10);
    }
  }
  const QString words_before = std::exchange(nearest_words_, QString());
  too_near_ = false;
  if (guidance && nearest) tell_nearest(*nearest, error, texts, errors);
  if (withdrawn_ == !guidance && texts == texts_ && errors == errors_ &&
      nearest_words_ == words_before && (guidance || why == cause_)) {
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
  if (name == QLatin1String("structure-state")) {
    return texts_[kStructure].isEmpty() ? QStringLiteral("withdrawn")
           : too_near_                  ? QStringLiteral("too-near")
                                        : QStringLiteral("clear");
  }
  for (std::size_t i = 0; i < texts_.size(); ++i) {
    const QLatin1String own(kNumerals[i].name);
    const bool structure = i == kStructure;
    if (name == own) {
      if (structure && !with_structures_) return QStringLiteral("none");
      if (withdrawn_ || texts_[i].isEmpty()) return QStringLiteral("withdrawn");
      return texts_[i].startsWith(QLatin1Char('>')) ? QStringLiteral("far") : texts_[i];
    }
    if (name == own + kError) {
      if (withdrawn_ || texts_[i].isEmpty()) return QStringLiteral("withdrawn");
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
  painter.setFont(theme::fitting_font(text, known ? 20 : 15, at.width(), false, &fits_));
  painter.setPen(QColor::fromRgb(known ? theme::kWindowText : theme::kWindowFaint));
  painter.drawText(at, Qt::AlignCenter, text);
}

void Numerals::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  painter.fillRect(rect(), QColor::fromRgb(theme::kWindowPanel));
  fits_ = true;
  const double cell = width() / static_cast<double>(count());
  const double title_height = theme::scaled(24);
  const double foot_height = theme::scaled(withdrawn_ ? 40 : 32);
  const double middle = height() - title_height - foot_height;
  const QRectF digits(0, title_height, cell, middle);
  const QColor dashes = theme::colour_of_state(SafetyState::kDegraded);
  // Never cut: "-999.9" has to fit into a cell.
  QFont large = theme::font(kDigitPixels, true);
  large.setPixelSize(std::clamp(static_cast<int>(middle), 9, large.pixelSize()));
  while (large.pixelSize() > 12 &&
         QFontMetricsF(large).horizontalAdvance(QStringLiteral("-999.9")) > cell) {
    large.setPixelSize(large.pixelSize() - 1);
  }
  for (std::size_t i = 0; i < count(); ++i) {
    const double x = static_cast<double>(i) * cell;
    const bool red = i == kStructure && too_near_;
    const QString title = i == kStructure && !nearest_words_.isEmpty()
                              ? nearest_words_
                              : QString::fromUtf8(kNumerals[i].title);
    painter.setFont(theme::fitting_font(title, 15, cell - 16, red, &fits_));
    painter.setPen(QColor::fromRgb(red ? kTooNear : theme::kWindowFaint));
    painter.drawText(QRectF(x, 4, cell, title_height), Qt::AlignCenter, title);
    const bool shown = !withdrawn_ && !texts_[i].isEmpty();
    if (shown)
      paint_foot(painter, i, QRectF(x + 8, height() - foot_height, cell - 16, foot_height));
    painter.setFont(large);
    painter.setPen(!shown ? dashes : red ? QColor::fromRgb(kTooNear) : QColor(Qt::white));
    painter.drawText(digits.translated(x, 0), Qt::AlignCenter,
                     shown ? texts_[i] : QStringLiteral("– –"));
  }
  if (withdrawn_) {
    const QString words = QStringLiteral("withdrawn: ") + cause_;
    // Two lines.
    painter.setFont(theme::fitting_font(words, 14, 1.8 * (width() - 16), false, &fits_));
    painter.setPen(QColor::fromRgb(theme::kWindowText));
    painter.drawText(QRectF(8, height() - foot_height, width() - 16, foot_height),
                     Qt::AlignCenter | Qt::TextWordWrap, words);
  }
}

}  // namespace nav::app
