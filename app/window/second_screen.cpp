// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/second_screen.hpp"

#include <QGuiApplication>
#include <QPainter>
#include <QScreen>
#include <algorithm>
#include <utility>

#include "app/window/theme.hpp"

namespace nav::app {

SecondScreen::SecondScreen(QWidget* main, std::function<std::vector<Mirrored>()> shown)
    : QWidget(main, Qt::Window), shown_(std::move(shown)) {
  constexpr int kMirrorMs = 33;
  setObjectName(QStringLiteral("second-screen"));
  setAccessibleName(QStringLiteral("Second screen: views without controls"));
  setWindowTitle(QStringLiteral("Sonde – second screen"));
  setAttribute(Qt::WA_OpaquePaintEvent);
  setFocusPolicy(Qt::NoFocus);
  setAttribute(Qt::WA_ShowWithoutActivating);
  QObject::connect(&timer_, &QTimer::timeout, this, [this] {
    if (isVisible()) update();
  });
  timer_.start(kMirrorMs);
}

void SecondScreen::open() {
  constexpr QSize kBeside(960, 720);
  const QScreen* own = parentWidget()->screen();
  const auto screens = QGuiApplication::screens();
  const auto other =
      std::ranges::find_if(screens, [&](const QScreen* screen) { return screen != own; });
  if (other == screens.end()) {
    resize(kBeside);
    return show();
  }
  setGeometry((*other)->geometry());
  showFullScreen();
}

void SecondScreen::resizeEvent(QResizeEvent*) {
  if (changed) changed();
}

void SecondScreen::showEvent(QShowEvent*) {
  if (changed) changed();
}

void SecondScreen::hideEvent(QHideEvent*) {
  if (changed) changed();
}

/// The widgets, enlarged together to this window; each keeps the ratio of its sides.
void SecondScreen::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  painter.fillRect(rect(), QColor::fromRgb(theme::kWindowBackground));
  const std::vector<Mirrored> shown = shown_();
  QRect all;
  for (const Mirrored& one : shown) all = all.united(one.at);
  if (all.isEmpty()) return;
  const double factor = std::min(static_cast<double>(width()) / all.width(),
                                 static_cast<double>(height()) / all.height());
  painter.setRenderHint(QPainter::SmoothPixmapTransform);
  painter.translate((width() - factor * all.width()) / 2, (height() - factor * all.height()) / 2);
  painter.scale(factor, factor);
  for (const auto& [widget, at] : shown) {
    if (widget->size().isEmpty()) continue;
    // Without the buttons that lie over a view.
    QPixmap image(widget->size() * devicePixelRatioF());
    image.setDevicePixelRatio(devicePixelRatioF());
    widget->render(&image, QPoint(), QRegion(), QWidget::RenderFlags());
    const QSize size = widget->size().scaled(at.size(), Qt::KeepAspectRatio);
    const QPoint corner =
        at.topLeft() - all.topLeft() +
        QPoint((at.width() - size.width()) / 2, (at.height() - size.height()) / 2);
    painter.drawPixmap(QRect(corner, size), image);
  }
}

}  // namespace nav::app
