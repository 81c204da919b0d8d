// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/registration_page.hpp"

#include <QGridLayout>
#include <QSignalBlocker>
#include <QVBoxLayout>
#include <algorithm>
#include <array>

#include "app/window/flow_layout.hpp"

namespace nav::app {
namespace {

constexpr int kRegistrationGap = 4;

}  // namespace

RegistrationPage::RegistrationPage(QWidget* parent)
    : QWidget(parent),
      landmarks_(small_choice(QStringLiteral("landmarks"), QStringLiteral("Landmarks"), this)),
      eye_(new QCheckBox(QStringLiteral("by eye"), this)),
      step_(small_number(QStringLiteral("eye-step"), QStringLiteral("Step, mm or degrees"), 0.1, 50,
                         1, this)),
      overlay_(
          small_choice(QStringLiteral("overlay"), QStringLiteral("CT over the ultrasound"), this)),
      share_(small_slider(Qt::Horizontal, QStringLiteral("overlay-share"),
                          QStringLiteral("Share of the CT"), this)),
      words_(small_label({}, this)) {
  setObjectName(QStringLiteral("registration-page"));
  setAccessibleName(QStringLiteral("Registration"));
  words_->setObjectName(QStringLiteral("registration-words"));
  words_->setAccessibleName(QStringLiteral("Result of the registration"));
  eye_->setObjectName(QStringLiteral("eye"));
  eye_->setAccessibleName(QStringLiteral("Shift and turn the CT by eye"));
  const auto button = [this](const char* name, const char* text, const char* accessible,
                             std::function<void()> RegistrationPage::*call) {
    auto* made =
        small_button(QLatin1String(name), QString::fromUtf8(text), QLatin1String(accessible), this);
    if (call != nullptr) {
      QObject::connect(made, &QPushButton::clicked, this, [this, call] {
        if (this->*call) (this->*call)();
      });
    }
    return made;
  };
  auto* column = new QVBoxLayout(this);
  column->setContentsMargins(6, 6, 6, 6);
  column->setSpacing(kRegistrationGap);
  auto* first = new FlowLayout(kRegistrationGap);
  first->addWidget(landmarks_);
  first->addWidget(button("landmark-point", "Point = cursor", "Landmark in the CT at the cursor",
                          &RegistrationPage::point));
  first->addWidget(button("landmark-touch", "Touch", "The needle's tip touches the landmark",
                          &RegistrationPage::touch));
  column->addLayout(first);
  auto* second = new FlowLayout(kRegistrationGap);
  second->addWidget(
      button("landmark-remove", "Remove", "Remove the chosen landmark", &RegistrationPage::remove));
  second->addWidget(
      button("landmark-fit", "Fit landmarks", "Register by the landmarks", &RegistrationPage::fit));
  sweep_ = button("register-sweep", "By the sweep", "Register by the images of the recording",
                  &RegistrationPage::sweep);
  cancel_ = button("register-cancel", "Cancel", "End the registration and leave all as it was",
                   &RegistrationPage::cancel);
  second->addWidget(sweep_);
  second->addWidget(cancel_);
  column->addLayout(second);
  column->addWidget(eye_rows());
  column->addWidget(words_);
  auto* verdict = new FlowLayout(kRegistrationGap);
  accept_ = button("registration-accept", "Accept…", "Use this registration", nullptr);
  reject_ = button("registration-reject", "Reject…", "Do not use this registration", nullptr);
  confirm_ = button("registration-confirm", "Yes", "Confirm", nullptr);
  no_ = button("registration-no", "No", "Do nothing", nullptr);
  before_ = button("registration-before", "Before", "Show the position before", nullptr);
  before_->setCheckable(true);
  for (QPushButton* one : {accept_, reject_, confirm_, no_, before_}) verdict->addWidget(one);
  column->addLayout(verdict);
  column->addStretch(1);
  QObject::connect(accept_, &QPushButton::clicked, this, [this] { ask(true); });
  QObject::connect(reject_, &QPushButton::clicked, this, [this] { ask(false); });
  QObject::connect(no_, &QPushButton::clicked, this, [this] {
    confirm_->hide();
    no_->hide();
  });
  QObject::connect(confirm_, &QPushButton::clicked, this, [this] {
    confirm_->hide();
    no_->hide();
    auto& call = accepts_ ? accept : reject;
    if (call) call();
  });
  QObject::connect(before_, &QPushButton::toggled, this, [this](bool on) {
    if (this->before) this->before(on);
  });
  set_running(false);
  set_waiting(false, false);
  set_undo(false, false);
}

/// Rows that shift and turn the CT, and the overlay to compare by.
QWidget* RegistrationPage::eye_rows() {
  auto* rows = new QWidget(this);
  auto* lines = new QVBoxLayout(rows);
  lines->setContentsMargins(0, 0, 0, 0);
  lines->setSpacing(kRegistrationGap);
  set_quietly(*step_, 1);
  undo_ = small_button(QStringLiteral("eye-undo"), QStringLiteral("Undo"),
                       QStringLiteral("Undo the last movement (Ctrl+Z)"), this);
  redo_ = small_button(QStringLiteral("eye-redo"), QStringLiteral("Redo"),
                       QStringLiteral("Redo the last movement (Ctrl+Shift+Z)"), this);
  auto* upper = new FlowLayout(kRegistrationGap);
  upper->addWidget(eye_);
  upper->addWidget(labelled(QStringLiteral("step, mm or °"), step_, this));
  upper->addWidget(undo_);
  upper->addWidget(redo_);
  lines->addLayout(upper);
  auto* grid = new QGridLayout;
  grid->setSpacing(kRegistrationGap);
  struct Move {
    const char *name, *text, *accessible;
    Nudge nudge;
  };
  using V = Eigen::Vector3d;
  const V none = V::Zero();
  const std::array<Move, 12> moves{
      {{"eye-left", "L", "Shift the CT to the patient's left", {V::UnitX(), none}},
       {"eye-right", "R", "Shift the CT to the patient's right", {-V::UnitX(), none}},
       {"eye-anterior", "A", "Shift the CT to the front", {-V::UnitY(), none}},
       {"eye-posterior", "P", "Shift the CT to the back", {V::UnitY(), none}},
       {"eye-superior", "S", "Shift the CT to the head", {V::UnitZ(), none}},
       {"eye-inferior", "I", "Shift the CT to the feet", {-V::UnitZ(), none}},
       {"eye-pitch-up", "x +", "Turn the CT about the left axis", {none, V::UnitX()}},
       {"eye-pitch-down", "x -", "Turn the CT back about the left axis", {none, -V::UnitX()}},
       {"eye-roll-up", "y +", "Turn the CT about the posterior axis", {none, V::UnitY()}},
       {"eye-roll-down", "y -", "Turn the CT back about the posterior axis", {none, -V::UnitY()}},
       {"eye-yaw-up", "z +", "Turn the CT about the axis to the head", {none, V::UnitZ()}},
       {"eye-yaw-down",
        "z -",
        "Turn the CT back about the axis to the head",
        {none, -V::UnitZ()}}}};
  for (std::size_t i = 0; i < moves.size(); ++i) {
    auto* made = small_button(QLatin1String(moves[i].name), QLatin1String(moves[i].text),
                              QLatin1String(moves[i].accessible), this);
    grid->addWidget(made, static_cast<int>(i) / 6, static_cast<int>(i) % 6);
    QObject::connect(made, &QPushButton::clicked, this, [this, nudge = moves[i].nudge] {
      if (nudged) nudged(nudge);
    });
  }
  overlay_->addItems({QStringLiteral("no overlay"), QStringLiteral("blend"),
                      QStringLiteral("checkerboard"), QStringLiteral("wipe")});
  set_quietly(*share_, 0.5);
  lines->addLayout(grid);
  auto* lower = new FlowLayout(kRegistrationGap);
  lower->addWidget(overlay_);
  lower->addWidget(share_);
  lines->addLayout(lower);
  const auto tell = [this] {
    if (overlay_changed) overlay_changed(overlay());
  };
  QObject::connect(overlay_, &QComboBox::activated, this, tell);
  QObject::connect(share_, &QSlider::valueChanged, this, tell);
  QObject::connect(eye_, &QCheckBox::toggled, this, [this](bool on) {
    if (by_eye_changed) by_eye_changed(on);
  });
  QObject::connect(undo_, &QPushButton::clicked, this, [this] {
    if (undo) undo();
  });
  QObject::connect(redo_, &QPushButton::clicked, this, [this] {
    if (redo) redo();
  });
  return rows;
}

CtOverlay RegistrationPage::overlay() const {
  return {.mode = static_cast<CtOverlay::Mode>(std::max(0, overlay_->currentIndex())),
          .share = share_of(*share_)};
}

void RegistrationPage::show_landmarks(const QStringList& names) {
  const QSignalBlocker quiet(landmarks_);
  const int chosen = landmarks_->currentIndex();
  const bool more = names.size() > landmarks_->count();
  landmarks_->clear();
  landmarks_->addItems(names);
  const int last = static_cast<int>(names.size()) - 1;
  landmarks_->setCurrentIndex(more ? last : std::min(std::max(chosen, 0), last));
}

void RegistrationPage::set_running(bool runs) {
  sweep_->setEnabled(!runs);
  cancel_->setEnabled(runs);
}

void RegistrationPage::set_waiting(bool waits, bool acceptable) {
  accept_->setEnabled(waits && acceptable);
  before_->setEnabled(waits);
  if (!waits) before_->setChecked(false);
  confirm_->hide();
  no_->hide();
}

void RegistrationPage::set_undo(bool can_undo, bool can_redo) {
  undo_->setEnabled(can_undo);
  redo_->setEnabled(can_redo);
}

/// One press is not enough: the second button stands elsewhere.
void RegistrationPage::ask(bool accepts) {
  accepts_ = accepts;
  confirm_->setText(accepts ? QStringLiteral("Yes, accept") : QStringLiteral("Yes, reject"));
  confirm_->show();
  no_->show();
}

}  // namespace nav::app
