// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/view_widget.hpp"

#include <QPainter>
#include <algorithm>
#include <chrono>
#include <cmath>

#include "app/window/theme.hpp"
#include "nav/stopwatch.hpp"

namespace nav::app {
namespace {

constexpr int kSmallText = 14;
constexpr int kMargin = 6;

}  // namespace

ViewWidget::ViewWidget(const QString& name, const QString& title, QWidget* parent)
    : QWidget(parent), title_(title) {
  setObjectName(name);
  setAccessibleName(title);
  setAttribute(Qt::WA_OpaquePaintEvent);
  setFocusPolicy(Qt::StrongFocus);
}

void ViewWidget::set_view_image(ViewImage view_image) {
  view_image.image.setDevicePixelRatio(devicePixelRatioF());
  view_image_ = std::move(view_image);
  fresh_ = true;
  update();
}

void ViewWidget::clear_image() {
  if (!view_image_) return;
  view_image_.reset();
  fresh_ = false;
  update();
}

void ViewWidget::set_judgement(const ViewJudgement& judgement, const std::string& kind) {
  const auto shown = [](const ViewJudgement& j) {
    return std::tuple(j.safety.state, j.safety.cause, j.about, j.covered, j.headline, j.late);
  };
  const QString word = theme::plain(kind);
  const bool changed = shown(judgement) != shown(judgement_) || word != kind_;
  judgement_ = judgement;
  kind_ = word;
  if (changed) update();
}

void ViewWidget::set_frozen(std::optional<double> seconds) {
  const auto tenths = [](const std::optional<double>& s) { return s ? std::lround(*s * 10) : -1; };
  const bool changed = tenths(seconds) != tenths(frozen_s_);
  frozen_s_ = seconds;
  if (changed) update();
}

PixelSize ViewWidget::pixel_size() const {
  const double ratio = devicePixelRatioF();
  return {std::clamp(static_cast<int>(std::lround(width() * ratio)), 1, 16384),
          std::clamp(static_cast<int>(std::lround(height() * ratio)), 1, 16384)};
}

void ViewWidget::resizeEvent(QResizeEvent*) {
  if (resized) resized();
}

void ViewWidget::set_mode(const QString& mode) {
  mode_ = mode;
  setCursor(mode.isEmpty() ? Qt::ArrowCursor : Qt::CrossCursor);
  update();
}

void ViewWidget::paintEvent(QPaintEvent*) {
  const auto start = std::chrono::steady_clock::now();
  QPainter painter(this);
  if (view_image_ && !judgement_.covered) {
    const QSizeF size = view_image_->image.deviceIndependentSize();
    if (std::abs(size.width() - width()) < 1 && std::abs(size.height() - height()) < 1) {
      painter.drawImage(0, 0, view_image_->image);
    } else {
      // Until the image of the new size comes.
      painter.fillRect(rect(), QColor::fromRgb(theme::kWindowBackground));
      const QSizeF fitted = size.scaled(QSizeF(QWidget::size()), Qt::KeepAspectRatio);
      painter.drawImage(
          QRectF({(width() - fitted.width()) / 2, (height() - fitted.height()) / 2}, fitted),
          view_image_->image);
    }
    paint_marks(painter, *view_image_);
  } else if (judgement_.covered) {
    paint_cover(painter);
  } else {
    // Until the first image of the view comes.
    painter.fillRect(rect(), QColor::fromRgb(theme::kWindowBackground));
  }
  paint_words(painter);
  // A frame of a view's own colour does not tell the state; shape and word do.
  const double frame = own_colour_ ? 4 : 2;
  painter.setPen(QPen(
      own_colour_ ? QColor::fromRgb(*own_colour_) : theme::colour_of_state(judgement_.safety.state),
      frame, Qt::SolidLine, Qt::SquareCap, Qt::MiterJoin));
  painter.setBrush(Qt::NoBrush);
  painter.setRenderHint(QPainter::Antialiasing, false);
  painter.drawRect(QRectF(rect()).adjusted(frame / 2, frame / 2, -frame / 2, -frame / 2));
  painter.end();
  if (fresh_ && view_image_ && painted) {
    fresh_ = false;
    painted(*view_image_, 1e3 * seconds_since(start));
  }
}

/// Height of the lines of title, kind and state, as paint_words() places them.
double ViewWidget::header_height() const {
  const QFontMetricsF bold(theme::font(kSmallText, true));
  const QFontMetricsF plain(theme::font(kSmallText));
  double right = kMargin + bold.horizontalAdvance(title_) + 12;
  int lines = 1;
  if (!kind_.isEmpty()) {
    const double kind_width = bold.horizontalAdvance(kind_) + 12;
    if (right + 4 + kind_width <= width() - kMargin) {
      right += 4 + kind_width;
    } else {
      ++lines;
      right = std::max(right, kMargin + kind_width);
    }
  }
  const QString state = theme::plain(judgement_.about.empty() ? "" : judgement_.about + " ") +
                        theme::plain(to_string(judgement_.safety.state));
  if (width() - kMargin - plain.horizontalAdvance(state) - 32 <= right) ++lines;
  return kMargin + lines * (plain.height() + 6);
}

/// Nothing of the old image is left: it could be taken for the present one.
void ViewWidget::paint_cover(QPainter& painter) {
  painter.fillRect(rect(), QColor::fromRgb(theme::kWindowBackground));
  painter.fillRect(rect(), QBrush(QColor(0x2a, 0x32, 0x3a), Qt::BDiagPattern));
  const QColor colour = theme::colour_of_state(judgement_.safety.state);
  // Below the lines of title and state.
  const double header = header_height();
  const int space = static_cast<int>((height() - header) / 3);
  const int large = std::clamp(std::min(width() / 16, space), 10, 40);
  const double shape = large;
  const double above = height() / 2.0 - 2.2 * large;
  // In a low view the shape at the upper right is enough.
  if (above > header) {
    theme::draw_state_shape(painter, QRectF(width() / 2.0 - shape / 2, above, shape, shape),
                            judgement_.safety.state);
  }
  painter.setPen(colour);
  const QString headline = theme::plain(judgement_.headline);
  QFont head = theme::fitting_font(headline, large, width() - 2 * kMargin, true);
  // The size of this text follows the view, not the other texts.
  head.setPixelSize(std::min(head.pixelSize(), large));
  painter.setFont(head);
  const QRectF upper(kMargin, std::max(header, height() / 2.0 - large), width() - 2 * kMargin,
                     1.3 * large);
  painter.drawText(upper, Qt::AlignCenter, headline);
  painter.setPen(QColor::fromRgb(theme::kWindowText));
  const QRectF rest(2 * kMargin, upper.bottom(), width() - 4 * kMargin,
                    height() - upper.bottom() - kMargin);
  const QString cause = theme::plain(judgement_.safety.cause);
  QFont words = theme::font(kSmallText + 2);
  constexpr int kLeastCause = 10;
  const auto is_high = [&] {
    return QFontMetricsF(words).boundingRect(rest, Qt::TextWordWrap, cause).height() >
           rest.height();
  };
  while (words.pixelSize() > kLeastCause && is_high()) words.setPixelSize(words.pixelSize() - 1);
  painter.setFont(words);
  painter.drawText(rest, Qt::AlignHCenter | Qt::AlignTop | Qt::TextWordWrap, cause);
}

void ViewWidget::paint_words(QPainter& painter) {
  const QFont small = theme::font(kSmallText);
  const QColor text = QColor::fromRgb(theme::kWindowText);
  double right = theme::draw_tag(painter, kMargin, kMargin, title_, theme::font(kSmallText, true),
                                 own_colour_ ? QColor::fromRgb(*own_colour_) : text);
  const QFontMetricsF metrics(small);
  // In a narrow view below the title: SIMULATED is never cut.
  double below = kMargin;
  if (!kind_.isEmpty()) {
    const QFont bold = theme::fitting_font(kind_, kSmallText, width() - 2 * kMargin - 12, true);
    const double kind_width = QFontMetricsF(bold).horizontalAdvance(kind_) + 12;
    const bool beside = right + 4 + kind_width <= width() - kMargin;
    if (!beside) below += metrics.height() + 6;
    const double end = theme::draw_tag(painter, beside ? right + 4 : kMargin, below, kind_, bold,
                                       QColor::fromRgb(theme::kWindowAccent));
    right = std::max(right, end);
  }
  // State: shape and word, at the upper right.
  const QString about = theme::plain(judgement_.about.empty() ? "" : judgement_.about + " ");
  const QString word = frozen_s_ ? QStringLiteral("frozen")
                                 : about + theme::plain(to_string(judgement_.safety.state));
  const double word_width = metrics.horizontalAdvance(word) + 12;
  const double x = width() - kMargin - word_width;
  const double line = metrics.height() + 4;
  // Below the title, where there is no space beside it.
  const double state_y = x - 20 > right ? kMargin : below + line + 2;
  painter.fillRect(QRectF(x - 20, state_y, 20, line), QColor(0x10, 0x14, 0x18, 0xd8));
  theme::draw_state_shape(painter, QRectF(x - 16, state_y + line / 2 - 6, 12, 12),
                          judgement_.safety.state);
  theme::draw_tag(painter, x, state_y, word, small,
                  theme::colour_of_state(judgement_.safety.state));
  double y = state_y + line + 2;
  if (frozen_s_) {
    theme::draw_tag(painter, kMargin, y, QStringLiteral("FROZEN %1 s").arg(*frozen_s_, 0, 'f', 1),
                    theme::font(26, true), text);
    y += 40;
  }
  if (judgement_.covered) return;
  if (!mode_.isEmpty()) {
    theme::draw_tag(painter, kMargin, y, mode_, theme::font(kSmallText + 2, true),
                    QColor::fromRgb(theme::kWindowAccent));
    y += line + 6;
  }
  if (judgement_.late) {
    theme::draw_tag(painter, kMargin, y,
                    QStringLiteral("LATE %1 ms").arg(std::lround(judgement_.age_ms)),
                    theme::font(kSmallText, true), theme::colour_of_state(SafetyState::kDegraded));
  }
  if (judgement_.safety.state == SafetyState::kDegraded) {
    painter.setFont(small);
    const QString cause = theme::plain(judgement_.safety.cause);
    // Beside the letters of the directions, which stand in the middle of the edges.
    const double widest = std::min(width() - 2.0 * kMargin, std::max(200.0, 0.42 * width()));
    const QRectF most(0, 0, widest - 12, height());
    const QRectF box = QFontMetricsF(small).boundingRect(most, Qt::TextWordWrap, cause);
    const QRectF at(kMargin, y, box.width() + 12, box.height() + 4);
    painter.fillRect(at, QColor(0x10, 0x14, 0x18, 0xd8));
    painter.setPen(theme::colour_of_state(SafetyState::kDegraded));
    painter.drawText(at.adjusted(6, 2, 0, 0), Qt::TextWordWrap, cause);
  }
}

}  // namespace nav::app
