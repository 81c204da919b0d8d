// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/main_window.hpp"

#include <QApplication>
#include <QPainter>
#include <utility>

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
      tools_(new ToolDeck(this)),
      panel_(words_label(QStringLiteral("panel"), QStringLiteral("Panel of the step"), this)),
      keys_(words_label(QStringLiteral("keys"), QStringLiteral("Keys"), this)),
      loop_(options.loop, clock, console, report, {scene_, flat_, numerals_, status_}),
      predicates_(flat_, options.loop.config.output.threads,
                  {.ready =
                       [this](std::shared_ptr<const render::PredicateVolume> volume) {
                         edits_.predicates = std::move(volume);
                         push_edits();
                       },
                   .show_ultrasound = [this](bool shown) { loop_.show_ultrasound_slices(shown); },
                   .wake =
                       [this] {
                         QMetaObject::invokeMethod(
                             this, [this] { predicates_.take(); }, Qt::QueuedConnection);
                       }},
                  this),
      transfer_(new TransferPage(this)),
      cutaway_(new CutawayPage(this)) {
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
  tools_->add(QStringLiteral("tool-step"), QStringLiteral("Step"),
              QStringLiteral("Panel of the step"), panel_);
  tools_->add(QStringLiteral("tool-predicates"), QStringLiteral("Predicates"),
              QStringLiteral("Predicate histogram (P)"), &predicates_.page());
  tools_->add(QStringLiteral("tool-transfer"), QStringLiteral("Colours"),
              QStringLiteral("Transfer function of the CT (T)"), transfer_);
  tools_->add(QStringLiteral("tool-cutaway"), QStringLiteral("Cutaway"),
              QStringLiteral("Cutaway and shading (C)"), cutaway_);
  transfer_->edited = [this](const std::optional<render::TransferFunction>& function) {
    edits_.transfer = function;
    push_edits();
  };
  cutaway_->edited = [this](const std::optional<CutawaySettings>& settings) {
    edits_.cutaway.reset();
    edits_.emphasis.reset();
    edits_.style.reset();
    if (settings) {
      edits_.cutaway = settings->cutaway;
      edits_.emphasis = settings->emphasis;
      edits_.style = settings->style;
    }
    push_edits();
  };
  tools_->pressed = [this](int page) { choose_tool(static_cast<Tool>(page)); };
  add_actions();
  rail_->choose(step_);
  loop_.changed = [this] {
    update_steps();
    rail_->set_recording(loop_.recording().since.has_value());
    update_panel();
  };
  QObject::connect(&watchdog_, &QTimer::timeout, this, [this] { tick(); });
  watchdog_.start(kWatchdogMs);
  loop_.tick();
  update_panel();
  scene_->setFocus();
}

MainWindow::~MainWindow() { stop(); }

void MainWindow::start() {
  loop_.start();
  predicates_.start();
}

void MainWindow::stop() {
  loop_.stop();
  predicates_.stop();
}

void MainWindow::tick() {
  loop_.tick();
  update_steps();
  const SharedMoment& newest = loop_.newest();
  if (!newest) return;
  predicates_.follow(newest->predicates);
  if (!std::exchange(opened_, true)) open_panels(*newest);
}

void MainWindow::open_panels(const Moment& moment) {
  if (!moment.scene->predicates) transfer_->open(moment.scene->transfer, moment.counts);
  cutaway_->open(cutaway_settings_of(*moment.scene));
  if (!moment.stored) return;
  // A stored volume has no live image: its slices and its histogram are shown.
  set_layout(WindowLayout::kSlices);
  choose_tool(Tool::kPredicates);
}

void MainWindow::push_edits() { loop_.set_edits(std::make_shared<const SceneEdits>(edits_)); }

void MainWindow::choose_tool(Tool tool) {
  tools_->choose(static_cast<int>(tool));
  while (tool != Tool::kPredicates && predicates_.page().cancel()) {
  }
  arrange();
}

void MainWindow::undo(bool forth) {
  if (tool() == Tool::kPredicates) {
    (void)(forth ? predicates_.page().redo() : predicates_.page().undo());
  } else if (tool() == Tool::kTransfer) {
    (void)(forth ? transfer_->redo() : transfer_->undo());
  } else if (tool() == Tool::kCutaway) {
    (void)(forth ? cutaway_->redo() : cutaway_->undo());
  }
}

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
  const auto tool_key = [this](Tool wanted) {
    return [this, wanted] { choose_tool(tool() == wanted ? Tool::kStep : wanted); };
  };
  add("predicates", "predicate histogram of the 3D ultrasound; again: panel of the step",
      QKeyCombination(Qt::Key_P), tool_key(Tool::kPredicates));
  add("transfer", "transfer function of the CT; again: panel of the step",
      QKeyCombination(Qt::Key_T), tool_key(Tool::kTransfer));
  add("cutaway", "cutaway and shading; again: panel of the step", QKeyCombination(Qt::Key_C),
      tool_key(Tool::kCutaway));
  add("undo", "undo an edit of the open panel", QKeyCombination(Qt::ControlModifier, Qt::Key_Z),
      [this] { undo(false); });
  add("redo", "redo an edit of the open panel",
      QKeyCombination(Qt::ControlModifier | Qt::ShiftModifier, Qt::Key_Z), [this] { undo(true); });
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
  const Arrangement made = arrange_views(layout_, single_, area, tool() != Tool::kStep);
  const QWidget* focused = QApplication::focusWidget();
  const bool view_has_focus = dynamic_cast<const ViewWidget*>(focused) != nullptr;
  const auto place = [](QWidget* widget, const std::optional<QRect>& at) {
    widget->setVisible(at.has_value());
    if (at) widget->setGeometry(*at);
  };
  place(scene_, made.views[ViewId::kScene]);
  for (const ViewId id : kFlatViews) place(flat_[id], made.views[id]);
  place(numerals_, made.numerals);
  place(tools_, made.panel);
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
  } else if (predicates_.page().cancel()) {
    // A brush, or the choice of a second bar, has ended.
  } else if (!with_rail_) {
    toggle_full_screen();
  } else if (layout_ == WindowLayout::kSingle) {
    enlarge(single_);
  }
}

void MainWindow::choose_step(int step) {
  step_ = step;
  rail_->choose(step);
  if (tool() != Tool::kStep) choose_tool(Tool::kStep);
  update_panel();
}

QImage MainWindow::shot() { return grab().toImage().convertToFormat(QImage::Format_RGB32); }

}  // namespace nav::app
