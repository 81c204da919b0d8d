// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/rail.hpp"

#include <QScrollBar>
#include <QVBoxLayout>
#include <algorithm>

namespace nav::app {

const std::array<const char*, kStepCount> kStepNames{
    "Patient", "Devices", "Calibration", "Registration", "Plan", "Navigate", "Review"};

QString mark_of(StepState state) {
  switch (state) {
    case StepState::kToDo:
      return QStringLiteral("○ to do");
    case StepState::kBusy:
      return QStringLiteral("… busy");
    case StepState::kDone:
      return QStringLiteral("✓ done");
    case StepState::kFailed:
      return QStringLiteral("✗ failed");
  }
  return {};
}

Rail::Rail(bool with_record, QWidget* parent) : QWidget(parent) {
  setObjectName(QStringLiteral("rail"));
  setAccessibleName(QStringLiteral("Rail"));
  // A window that is too low for all buttons scrolls them, so that none lies over another.
  auto* scroll = new QScrollArea(this);
  scroll->setObjectName(QStringLiteral("rail-scroll"));
  scroll->setAccessibleName(QStringLiteral("Steps"));
  scroll->setWidgetResizable(true);
  scroll->setFrameShape(QFrame::NoFrame);
  scroll->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
  auto* whole = new QVBoxLayout(this);
  whole->setContentsMargins(0, 0, 0, 0);
  whole->addWidget(scroll);
  auto* page = new QWidget;
  auto* column = new QVBoxLayout(page);
  column->setContentsMargins(8, 8, 8, 8);
  column->setSpacing(6);
  const auto button = [&](const QString& name, const QString& accessible) {
    auto* made = new QPushButton(page);
    made->setObjectName(name);
    made->setAccessibleName(accessible);
    made->setMinimumHeight(44);
    column->addWidget(made);
    return made;
  };
  for (int i = 0; i < kStepCount; ++i) {
    auto* step = button(QStringLiteral("step%1").arg(i + 1),
                        QStringLiteral("Step %1, %2").arg(i + 1).arg(kStepNames[index(i)]));
    step->setCheckable(true);
    step->setAutoExclusive(true);
    steps_[index(i)] = step;
    QObject::connect(step, &QPushButton::clicked, this, [this, i] {
      if (chosen) chosen(i);
    });
    label(i);
  }
  column->addStretch(1);
  record_ = button(QStringLiteral("record"), QStringLiteral("Record"));
  QObject::connect(record_, &QPushButton::clicked, this, [this] {
    if (record) record();
  });
  can_record(with_record);
  freeze_ = button(QStringLiteral("freeze"), QStringLiteral("Freeze"));
  snapshot_ = button(QStringLiteral("snapshot"), QStringLiteral("Snapshot"));
  snapshot_->setText(QStringLiteral("Snapshot  (S)"));
  QObject::connect(freeze_, &QPushButton::clicked, this, [this] {
    if (freeze) freeze();
  });
  QObject::connect(snapshot_, &QPushButton::clicked, this, [this] {
    if (snapshot) snapshot();
  });
  set_frozen(false);
  set_recording(false);
  scroll->setWidget(page);
  scroll_ = scroll;
}

int Rail::wanted_width() const {
  return std::max(kLeastWidth, scroll_->widget()->minimumSizeHint().width() +
                                   scroll_->verticalScrollBar()->sizeHint().width());
}

void Rail::label(int step) {
  steps_[index(step)]->setText(QStringLiteral("%1  %2\n     %3")
                                   .arg(step + 1)
                                   .arg(QLatin1String(kStepNames[index(step)]))
                                   .arg(mark_of(states_[index(step)])));
}

void Rail::set_step(int step, StepState state) {
  if (states_[index(step)] == state) return;
  states_[index(step)] = state;
  label(step);
}

void Rail::choose(int step) { steps_[index(step)]->setChecked(true); }

void Rail::set_recording(bool recording) {
  record_->setText(recording ? QStringLiteral("● Stop recording\n(Ctrl+R)")
                             : QStringLiteral("Record  (Ctrl+R)"));
}

void Rail::set_frozen(bool frozen) {
  freeze_->setText(frozen ? QStringLiteral("Go live  (Space)") : QStringLiteral("Freeze  (Space)"));
}

}  // namespace nav::app
