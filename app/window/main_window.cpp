// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/main_window.hpp"

#include <QApplication>
#include <QPainter>

#include "app/window/theme.hpp"

namespace nav::app {
namespace {

constexpr int kWatchdogMs = 30;
constexpr int kLeastWidth = 1280;
constexpr int kLeastHeight = 800;

QLabel* words_label(const QString& name, const QString& accessible, QWidget* parent) {
  auto* label = new QLabel(parent);
  label->setObjectName(name);
  label->setAccessibleName(accessible);
  label->setWordWrap(true);
  label->setTextFormat(Qt::PlainText);
  label->setAlignment(Qt::AlignLeft | Qt::AlignTop);
  label->setContentsMargins(10, 8, 10, 8);
  label->setAutoFillBackground(true);
  QPalette palette = label->palette();
  palette.setColor(QPalette::Window, QColor::fromRgb(theme::kWindowPanel));
  label->setPalette(palette);
  return label;
}

PerView<FlatWidget*> flat_widgets(QWidget* parent) {
  PerView<FlatWidget*> made{};
  const auto add = [&](ViewId id, const char* name, const char* title) {
    made[id] = new FlatWidget(id, QLatin1String(name), QLatin1String(title), parent);
  };
  made[ViewId::kUltrasound] = new UltrasoundWidget(
      ViewId::kUltrasound, QStringLiteral("ultrasound"), QStringLiteral("Ultrasound"), parent);
  add(ViewId::kCt, "ctplane", "CT along the plane");
  add(ViewId::kAxial, "axial", "Axial");
  add(ViewId::kCoronal, "coronal", "Coronal");
  add(ViewId::kSagittal, "sagittal", "Sagittal");
  add(ViewId::kNeedleFirst, "needle1", "Along the needle, 1");
  add(ViewId::kNeedleSecond, "needle2", "Along the needle, 2");
  add(ViewId::kBullsEye, "bullseye", "Bull's-eye");
  return made;
}

}  // namespace

MainWindow::MainWindow(const Options& options, const Clock& clock, Console& console,
                       WindowReport& report)
    : clock_(clock),
      title_(options.title),
      snapshot_folder_(options.snapshot_folder),
      has_devices_(options.loop.has_session &&
                   options.loop.config.source.kind == SessionConfig::SourceKind::kLive),
      rail_(new Rail(has_devices_, this)),
      scene_(new SceneWidget(QStringLiteral("view3d"), QStringLiteral("3D"), this)),
      flat_(flat_widgets(this)),
      numerals_(new Numerals(this)),
      status_(new StatusLines(this)),
      panel_(words_label(QStringLiteral("panel"), QStringLiteral("Panel of the step"), this)),
      keys_(words_label(QStringLiteral("keys"), QStringLiteral("Keys"), this)),
      loop_(options.loop, clock, console, report, {scene_, flat_, numerals_, status_}) {
  setObjectName(QStringLiteral("window"));
  setWindowTitle(title_);
  setStyleSheet(theme::style_sheet());
  setMinimumSize(1, 1);
  resize(kLeastWidth, kLeastHeight);
  keys_->setWordWrap(false);
  keys_->hide();
  rail_->chosen = [this](int step) { choose_step(step); };
  rail_->freeze = [this] {
    loop_.set_frozen(!loop_.frozen());
    rail_->set_frozen(loop_.frozen());
  };
  rail_->snapshot = [this] { take_snapshot(); };
  rail_->record = [this] { toggle_recording(); };
  for (const ViewId id : kFlatViews) {
    flat_[id]->enlarge = [this, id] { enlarge(id); };
  }
  add_actions();
  rail_->choose(step_);
  loop_.changed = [this] {
    update_steps();
    rail_->set_recording(loop_.recording().since.has_value());
    update_panel();
  };
  QObject::connect(&watchdog_, &QTimer::timeout, this, [this] {
    loop_.tick();
    update_steps();
  });
  watchdog_.start(kWatchdogMs);
  loop_.tick();
  update_panel();
  scene_->setFocus();
}

MainWindow::~MainWindow() { loop_.stop(); }

void MainWindow::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  painter.fillRect(rect(), QColor::fromRgb(theme::kWindowBackground));
}

void MainWindow::resizeEvent(QResizeEvent*) { arrange(); }

void MainWindow::add_actions() {
  for (int i = 0; i < kStepCount; ++i) {
    actions_.add({QStringLiteral("step%1").arg(i + 1),
                  QStringLiteral("step %1: %2")
                      .arg(i + 1)
                      .arg(QLatin1String(kStepNames[static_cast<std::size_t>(i)])),
                  QKeySequence(Qt::Key_F1 + i), [this, i] { choose_step(i); }});
  }
  const auto add = [this](const char* name, const char* title, QKeyCombination key,
                          std::function<void()> run) {
    actions_.add({QLatin1String(name), QLatin1String(title), QKeySequence(key), std::move(run)});
  };
  add("freeze", "freeze the views, or go live", QKeyCombination(Qt::Key_Space), rail_->freeze);
  add("snapshot", "save the window as a PNG file", QKeyCombination(Qt::Key_S),
      [this] { take_snapshot(); });
  add("record", "record the live devices, or end it",
      QKeyCombination(Qt::ControlModifier, Qt::Key_R), rail_->record);
  add("reset-camera", "first camera of the 3D view", QKeyCombination(Qt::Key_R),
      [this] { loop_.reset_camera(); });
  add("reset-slices", "first cursor, zoom and grey window of the slices",
      QKeyCombination(Qt::ShiftModifier, Qt::Key_R), [this] { loop_.reset_slices(); });
  add("layout-guidance", "layout: 3D, ultrasound, CT", QKeyCombination(Qt::Key_1),
      [this] { set_layout(WindowLayout::kGuidance); });
  add("layout-slices", "layout: axial, coronal, sagittal, 3D", QKeyCombination(Qt::Key_2),
      [this] { set_layout(WindowLayout::kSlices); });
  add("layout-needle", "layout: bull's-eye, slices along the needle, ultrasound",
      QKeyCombination(Qt::Key_3), [this] { set_layout(WindowLayout::kNeedle); });
  add("layout-single", "layout: the view under the mouse alone; again: back",
      QKeyCombination(Qt::Key_4), [this] { set_layout(WindowLayout::kSingle); });
  add("full-screen", "full screen without the rail; again: back", QKeyCombination(Qt::Key_F11),
      [this] { toggle_full_screen(); });
  add("keys", "list the keys", QKeyCombination(Qt::Key_Question), [this] { toggle_keys(); });
  add("cancel", "close what lies on top", QKeyCombination(Qt::Key_Escape), [this] { cancel(); });
  add("quit", "close the window", QKeyCombination(Qt::ControlModifier, Qt::Key_Q),
      [this] { close(); });
}

void MainWindow::arrange() {
  constexpr int kGap = 6;
  const int left = with_rail_ ? Rail::kWidth : 0;
  const int bottom = status_->wanted_height();
  rail_->setVisible(with_rail_);
  rail_->setGeometry(0, 0, Rail::kWidth, std::max(1, height() - bottom));
  status_->setGeometry(0, height() - bottom, width(), bottom);
  const QRect area(left, kGap, std::max(1, width() - left - kGap),
                   std::max(1, height() - bottom - kGap));
  const QSize keys = keys_->sizeHint().boundedTo(area.size());
  keys_->setGeometry(QRect(area.topLeft() + QPoint(40, 40), keys));
  const Arrangement made = arrange_views(layout_, single_, area);
  const QWidget* focused = QApplication::focusWidget();
  const bool view_has_focus = dynamic_cast<const ViewWidget*>(focused) != nullptr;
  const auto place = [](QWidget* widget, const std::optional<QRect>& at) {
    widget->setVisible(at.has_value());
    if (at) widget->setGeometry(*at);
  };
  place(scene_, made.views[ViewId::kScene]);
  for (const ViewId id : kFlatViews) place(flat_[id], made.views[id]);
  place(numerals_, made.numerals);
  place(panel_, made.panel);
  // Qt gives the focus of a view that is hidden to the next control: here, to another view.
  for (std::size_t i = 0; i < kViewCount && view_has_focus && focused->isHidden(); ++i) {
    if (!made.views.all[i]) continue;
    view(static_cast<ViewId>(i))->setFocus();
    break;
  }
  loop_.views_changed();
}

ViewWidget* MainWindow::view(ViewId id) const {
  return id == ViewId::kScene ? static_cast<ViewWidget*>(scene_) : flat_[id];
}

ViewId MainWindow::view_under_mouse() const {
  for (const ViewId id : kFlatViews) {
    if (flat_[id]->isVisible() && flat_[id]->underMouse()) return id;
  }
  if (!scene_->isHidden()) return ViewId::kScene;
  return layout_ == WindowLayout::kNeedle ? ViewId::kUltrasound : single_;
}

void MainWindow::enlarge(ViewId id) {
  if (layout_ == WindowLayout::kSingle) {
    layout_ = before_single_;
  } else {
    before_single_ = layout_;
    single_ = id;
    layout_ = WindowLayout::kSingle;
  }
  arrange();
}

void MainWindow::set_layout(WindowLayout layout) {
  if (layout == WindowLayout::kSingle) return enlarge(view_under_mouse());
  layout_ = layout;
  arrange();
}

void MainWindow::toggle_full_screen() {
  with_rail_ = !with_rail_;
  setWindowState(with_rail_ ? windowState() & ~Qt::WindowFullScreen
                            : windowState() | Qt::WindowFullScreen);
  arrange();
}

void MainWindow::toggle_keys() {
  QString text = QStringLiteral("Keys\n\n");
  for (const Action& action : actions_.all()) {
    text += action.key.toString() + QStringLiteral("\t") + action.title + QStringLiteral("\n");
  }
  keys_->setText(text);
  keys_->setVisible(!keys_->isVisible());
  arrange();
  keys_->raise();
}

void MainWindow::cancel() {
  if (keys_->isVisible()) {
    keys_->hide();
  } else if (!with_rail_) {
    toggle_full_screen();
  } else if (layout_ == WindowLayout::kSingle) {
    enlarge(single_);
  }
}

void MainWindow::choose_step(int step) {
  step_ = step;
  rail_->choose(step);
  update_panel();
}

QImage MainWindow::shot() { return grab().toImage().convertToFormat(QImage::Format_RGB32); }

}  // namespace nav::app
