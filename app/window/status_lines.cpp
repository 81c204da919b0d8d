// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/status_lines.hpp"

#include <QPainter>
#include <algorithm>
#include <cmath>

#include "app/window/theme.hpp"

namespace nav::app {
namespace {

constexpr int kStatusText = 14;
constexpr int kMostInputs = 3;
constexpr int kStatusLine = 22;

}  // namespace

StatusLines::StatusLines(QWidget* parent) : QWidget(parent) {
  setObjectName(QStringLiteral("status"));
  setAccessibleName(QStringLiteral("States of the inputs"));
  setAttribute(Qt::WA_OpaquePaintEvent);
}

int StatusLines::wanted_height() const {
  return (kMostInputs + 1) * theme::scaled(kStatusLine) + 4;
}

void StatusLines::show_inputs(const std::vector<InputStatus>& inputs, const QString& notice,
                              Timestamp now) {
  // An idle window paints nothing.
  const bool ages = std::ranges::any_of(
      inputs, [](const InputStatus& input) { return input.acquired.has_value(); });
  const bool stands = !ages && inputs.size() == inputs_.size() && notice == notice_;
  // Digits that change more often cannot be read.
  constexpr auto kPeriod = std::chrono::milliseconds(100);
  const bool same_states = std::ranges::equal(inputs, inputs_, [](const auto& a, const auto& b) {
    return a.safety.state == b.safety.state && a.safety.cause == b.safety.cause;
  });
  if (same_states && notice == notice_ && (stands || now - now_ < kPeriod)) return;
  if (notice != notice_) setToolTip(notice);
  inputs_ = inputs;
  notice_ = notice;
  now_ = now;
  update();
}

void StatusLines::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  painter.fillRect(rect(), QColor::fromRgb(theme::kWindowBackground));
  const QFont font = theme::font(kStatusText);
  painter.setFont(font);
  const QFontMetricsF metrics(font);
  const double digits = metrics.horizontalAdvance(QLatin1Char('0'));
  const int height_of_line = theme::scaled(kStatusLine);
  fits_ = true;
  int line = 0;
  const auto text_y = [&] { return line * height_of_line + 2 + metrics.ascent() + 1; };
  for (const InputStatus& input : inputs_) {
    const QColor colour = theme::colour_of_state(input.safety.state);
    theme::draw_state_shape(painter, QRectF(8, (line + 0.5) * height_of_line - 6, 12, 12),
                            input.safety.state);
    double x = 28;
    const auto column = [&](const QString& text, double width, const QColor& pen) {
      painter.setPen(pen);
      painter.drawText(QPointF(x, text_y()), text);
      x += std::max(width, metrics.horizontalAdvance(text) + digits);
    };
    const QColor plain = QColor::fromRgb(theme::kWindowText);
    column(theme::plain(input.name), 11 * digits, plain);
    column(theme::plain(to_string(input.safety.state)), 11 * digits, colour);
    column(
        input.acquired
            ? QStringLiteral("%1 ms old").arg(std::lround(1e3 * to_seconds(now_ - *input.acquired)))
            : QString(),
        13 * digits, plain);
    column(input.rate_hz ? QStringLiteral("%1 / s").arg(*input.rate_hz, 0, 'f', 1) : QString(),
           10 * digits, plain);
    column(input.rate_hz ? QStringLiteral("%1 dropped").arg(input.drops) : QString(), 13 * digits,
           plain);
    if (!input.safety.cause.empty()) {
      const QString cause = theme::plain(input.safety.cause);
      painter.setFont(theme::fitting_font(cause, kStatusText, width() - x - 4, false, &fits_));
      column(cause, 0, colour);
      painter.setFont(font);
    }
    ++line;
  }
  painter.setPen(QColor::fromRgb(theme::kWindowText));
  // All lines that are left.
  const QRectF rest(8, line * height_of_line, width() - 12, height() - line * height_of_line);
  QFont notice = font;
  const auto is_high = [&] {
    const QRectF box = QFontMetricsF(notice).boundingRect(rest, Qt::TextWordWrap, notice_);
    return box.height() > rest.height() || box.width() > rest.width();
  };
  constexpr int kLeastNotice = 9;
  while (notice.pixelSize() > kLeastNotice && is_high()) {
    notice.setPixelSize(notice.pixelSize() - 1);
  }
  if (is_high()) fits_ = false;
  painter.setFont(notice);
  painter.drawText(rest, Qt::TextWordWrap | Qt::AlignLeft | Qt::AlignTop, notice_);
}

}  // namespace nav::app
