// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/main_window.hpp"

#include <QApplication>
#include <QLayout>
#include <QPainter>
#include <algorithm>
#include <utility>

#include "app/window/theme.hpp"

namespace nav::app {
namespace {

constexpr int kWatchdogMs = 30;
/// Time between two looks for unsaved changes: a recovery file is about as old at most.
constexpr int kLookMs = 2000;
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
      report_(report),
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
      second_(new SecondScreen(this, [this] { return second_views(); })),
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
      cutaway_(new CutawayPage(this)),
      step_page_(new StepPage(panel_, this)),
      session_page_(new SessionPage(this)),
      recovery_(new RecoveryBar(this)),
      devices_(new DevicesPage(this)),
      patient_(new PatientPage(this)),
      registration_page_(new RegistrationPage(this)),
      plan_(new PlanPage(this)),
      registration_(*registration_page_, registration_hears()),
      config_(options.loop.has_session ? options.loop.config : SessionConfig()),
      session_file_(options.session_file),
      user_(options.user),
      settings_folder_(options.settings_folder),
      keeper_(options.state_folder, keeper_hears()) {
  setObjectName(QStringLiteral("window"));
  show_title();
  setStyleSheet(theme::style_sheet());
  if (user_.text_scale != 1) set_text_scale(user_.text_scale);
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
              QStringLiteral("Panel of the step"), step_page_);
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
  add_steps();
  step_page_->add(1, devices_);
  devices_->chosen = [this] { arrange_second_screen(); };
  second_->changed = [this] { arrange_second_screen(); };
  step_page_->add(kStepCount - 1, session_page_);
  session_page_->set_path(QString::fromStdString(session_file_.string()));
  session_page_->save = [this] { save_session(false); };
  session_page_->replace = [this] { save_session(true); };
  recovery_->restore = [this] { answer_recovery(true); };
  recovery_->discard = [this] { answer_recovery(false); };
  tools_->pressed = [this](int page) { choose_tool(static_cast<Tool>(page)); };
  add_actions();
  rail_->choose(step_);
  loop_.changed = [this] {
    update_steps();
    rail_->set_recording(loop_.recording().since.has_value());
    show_job();
    update_panel();
  };
  loop_.pressed = [this](const session::PressedButton& press) { obey(press); };
  QObject::connect(&watchdog_, &QTimer::timeout, this, [this] { tick(); });
  watchdog_.start(kWatchdogMs);
  QObject::connect(&looks_, &QTimer::timeout, this, [this] { look_at_session(); });
  looks_.start(kLookMs);
  keeper_.opened(session_file_, false);
  keeper_.find();
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
  // The last changes are in the recovery file, if it stays.
  if (keeps_recovery_) look_at_session();
  keeper_.stop(keeps_recovery_);
  registration_.stop();
  checkers_.clear();
  loop_.stop();
  predicates_.stop();
}

void MainWindow::tick() {
  loop_.tick();
  update_steps();
  // Texts that grew need more space.
  if (rail_->wanted_width() != rail_width_) arrange();
  if (opening_ && loop_.job().stage == JobNews::Stage::kFailed) {
    opening_.reset();
    show_job();
  }
  const SharedMoment& newest = loop_.newest();
  if (!newest) return;
  if (std::exchange(shown_session_, newest->session) != newest->session) begin_session(*newest);
  predicates_.follow(newest->predicates);
  keep_rejected(*newest);
}

void MainWindow::open_panels(const Moment& moment) {
  if (moment.scene->predicates) {
    transfer_->close();
  } else {
    transfer_->open(moment.scene->transfer, moment.counts);
  }
  cutaway_->open(cutaway_settings_of(*moment.scene));
  if (!moment.stored) return;
  // A stored volume has no live image: its slices and its histogram are shown.
  set_layout(WindowLayout::kSlices);
  if (moment.predicates) choose_tool(Tool::kPredicates);
}

void MainWindow::push_edits() { loop_.set_edits(std::make_shared<const SceneEdits>(edits_)); }

void MainWindow::choose_tool(Tool tool) {
  plan_->cancel();
  tools_->choose(static_cast<int>(tool));
  while (tool != Tool::kPredicates && predicates_.page().cancel()) {
  }
  show_handles();
  arrange();
}

void MainWindow::undo(bool forth) {
  if (tool() == Tool::kPredicates) {
    (void)(forth ? predicates_.page().redo() : predicates_.page().undo());
  } else if (tool() == Tool::kTransfer) {
    (void)(forth ? transfer_->redo() : transfer_->undo());
  } else if (tool() == Tool::kCutaway) {
    (void)(forth ? cutaway_->redo() : cutaway_->undo());
  } else if (step_ == 3) {
    (void)(forth ? registration_.redo() : registration_.undo());
  } else if (step_ == 4) {
    (void)(forth ? plan_->redo() : plan_->undo());
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
  add("save", "save the session", QKeyCombination(Qt::ControlModifier, Qt::Key_S),
      [this] { save_session(false); });
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
  add("undo", "undo an edit of the open panel or step",
      QKeyCombination(Qt::ControlModifier, Qt::Key_Z), [this] { undo(false); });
  add("redo", "redo an edit of the open panel or step",
      QKeyCombination(Qt::ControlModifier | Qt::ShiftModifier, Qt::Key_Z), [this] { undo(true); });
  struct Keys {
    Qt::KeyboardModifiers with;
    Qt::Key key;
  };
  const auto nudge = [this](const char* name, const char* title, const Keys& keys,
                            const RegistrationPage::Nudge& movement) {
    const QKeySequence key(QKeyCombination(keys.with, keys.key));
    actions_.add({QLatin1String(name), QLatin1String(title), key, [this, movement] {
                    if (step_ == 3) registration_.nudge(movement);
                  }});
  };
  using V = Eigen::Vector3d;
  const V none = V::Zero();
  const auto ctrl = Qt::ControlModifier;
  const auto both = Qt::ControlModifier | Qt::ShiftModifier;
  nudge("nudge-left", "by eye: CT to the patient's left", {ctrl, Qt::Key_Right},
        {V::UnitX(), none});
  nudge("nudge-right", "by eye: CT to the patient's right", {ctrl, Qt::Key_Left},
        {-V::UnitX(), none});
  nudge("nudge-superior", "by eye: CT to the head", {ctrl, Qt::Key_Up}, {V::UnitZ(), none});
  nudge("nudge-inferior", "by eye: CT to the feet", {ctrl, Qt::Key_Down}, {-V::UnitZ(), none});
  nudge("nudge-anterior", "by eye: CT to the front", {ctrl, Qt::Key_PageUp}, {-V::UnitY(), none});
  nudge("nudge-posterior", "by eye: CT to the back", {ctrl, Qt::Key_PageDown}, {V::UnitY(), none});
  nudge("turn-yaw-up", "by eye: turn the CT about the axis to the head", {both, Qt::Key_Right},
        {none, V::UnitZ()});
  nudge("turn-yaw-down", "by eye: turn it back", {both, Qt::Key_Left}, {none, -V::UnitZ()});
  nudge("turn-pitch-up", "by eye: turn the CT about the left axis", {both, Qt::Key_Up},
        {none, V::UnitX()});
  nudge("turn-pitch-down", "by eye: turn it back", {both, Qt::Key_Down}, {none, -V::UnitX()});
  nudge("turn-roll-up", "by eye: turn the CT about the posterior axis", {both, Qt::Key_PageUp},
        {none, V::UnitY()});
  nudge("turn-roll-down", "by eye: turn it back", {both, Qt::Key_PageDown}, {none, -V::UnitY()});
  add("full-screen", "full screen without the rail; again: back", QKeyCombination(Qt::Key_F11),
      [this] { toggle_full_screen(); });
  add("larger-texts", "texts and their controls larger, up to 2 times",
      QKeyCombination(Qt::ControlModifier, Qt::Key_Plus), [this] { scale_texts(0.25); });
  add("smaller-texts", "smaller again", QKeyCombination(Qt::ControlModifier, Qt::Key_Minus),
      [this] { scale_texts(-0.25); });
  add("second-screen", "second window for another screen; again: closes it",
      QKeyCombination(Qt::ControlModifier, Qt::Key_D), [this] { toggle_second_screen(); });
  add("keys", "list the keys", QKeyCombination(Qt::Key_Question), [this] { toggle_keys(); });
  add("cancel", "close what lies on top", QKeyCombination(Qt::Key_Escape), [this] { cancel(); });
  add("quit", "close the window", QKeyCombination(Qt::ControlModifier, Qt::Key_Q),
      [this] { close(); });
}

void MainWindow::arrange() {
  constexpr int kGap = 6;
  rail_width_ = rail_->wanted_width();
  const int left = with_rail_ ? rail_width_ : 0;
  const int bottom = status_->wanted_height();
  rail_->setVisible(with_rail_);
  rail_->setGeometry(0, 0, rail_width_, std::max(1, height() - bottom));
  status_->setGeometry(0, height() - bottom, width(), bottom);
  const int across = std::max(1, width() - left - kGap);
  const bool offers = !recovery_->isHidden();
  const int top =
      offers ? recovery_->layout()->heightForWidth(std::max(across, recovery_->minimumWidth())) : 0;
  recovery_->setGeometry(left, kGap, across, std::max(1, top));
  const QRect area(left, kGap + (offers ? top + kGap : 0), across,
                   std::max(1, height() - bottom - kGap - (offers ? top + kGap : 0)));
  const QSize keys = keys_->sizeHint().boundedTo(area.size());
  keys_->setGeometry(QRect(area.topLeft() + QPoint(40, 40), keys));
  std::optional<int> tool_width;
  if (tool() != Tool::kStep || step_page_->has_controls(step_)) {
    tool_width_ = tools_->wanted_width();
    tool_width = std::max(kToolWidth, tool_width_);
  }
  const Arrangement made =
      arrange_views(layout_, single_, area, tool_width, theme::scaled(kNumeralsHeight));
  const QWidget* focused = QApplication::focusWidget();
  const bool view_has_focus = dynamic_cast<const ViewWidget*>(focused) != nullptr;
  const auto place = [](QWidget* widget, const std::optional<QRect>& at) {
    widget->setVisible(at.has_value());
    if (at) widget->setGeometry(*at);
  };
  place(scene_, made.views[ViewId::kScene]);
  scene_->place_sides();
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
  arrange_second_screen();
}

/// Views that are hidden here are drawn in the size that they have on the second screen.
void MainWindow::arrange_second_screen() {
  on_second_.reset();
  PerView<bool> mirrored{};
  if (second_->isVisible()) {
    for (const std::string& name : devices_->views()) {
      for (std::size_t i = 0; i < kViewCount; ++i) {
        const auto id = static_cast<ViewId>(i);
        const bool in = name == "slices" ? is_orthogonal(id)
                                         : view(id)->objectName() == QLatin1String(name.c_str());
        mirrored[id] = mirrored[id] || in;
      }
    }
    if (std::ranges::count(mirrored.all, true) > 0) {
      on_second_ = arrange_second(mirrored, second_->rect(), theme::scaled(kNumeralsHeight));
    }
  }
  for (std::size_t i = 0; on_second_ && i < kViewCount; ++i) {
    ViewWidget* one = view(static_cast<ViewId>(i));
    const auto& at = on_second_->views.all[i];
    if (at && one->isHidden()) one->resize(at->size());
  }
  loop_.set_mirrored(mirrored);
}

std::vector<SecondScreen::Mirrored> MainWindow::second_views() const {
  std::vector<SecondScreen::Mirrored> shown{
      {numerals_, on_second_ ? on_second_->numerals : numerals_->geometry()}};
  for (std::size_t i = 0; i < kViewCount; ++i) {
    ViewWidget* one = view(static_cast<ViewId>(i));
    const auto& chosen = on_second_ ? on_second_->views.all[i] : std::optional<QRect>();
    if (chosen) {
      shown.push_back({one, *chosen});
    } else if (!on_second_ && !one->isHidden()) {
      shown.push_back({one, one->geometry()});
    }
  }
  return shown;
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

void MainWindow::set_text_scale(double scale) {
  user_.text_scale = std::clamp(scale, UserSettings::kLeastTextScale, UserSettings::kMostTextScale);
  theme::set_text_scale(user_.text_scale);
  setStyleSheet(theme::style_sheet());
}

void MainWindow::scale_texts(double change) {
  set_text_scale(user_.text_scale + change);
  keeper_.keep_settings(user_, settings_folder_);
  arrange();
  for (QWidget* widget : findChildren<QWidget*>()) widget->update();
}

void MainWindow::toggle_second_screen() {
  if (second_->isVisible()) {
    second_->hide();
  } else {
    second_->open();
  }
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
  } else if (plan_->cancel()) {
    // The next click sets nothing.
  } else if (step_ == 3 && tool() == Tool::kStep && registration_page_->by_eye()) {
    registration_page_->set_by_eye(false);
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
  step_page_->choose(step);
  show_handles();
  if (tool() != Tool::kStep) {
    choose_tool(Tool::kStep);
  } else {
    arrange();
  }
  update_panel();
}

void MainWindow::show_control(QWidget* control) {
  if (control == nullptr) return arrange();
  tools_->show_control(control);
}

QImage MainWindow::shot() { return grab().toImage().convertToFormat(QImage::Format_RGB32); }

}  // namespace nav::app
