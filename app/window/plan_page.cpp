// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/plan_page.hpp"

#include <QSignalBlocker>
#include <QVBoxLayout>
#include <algorithm>
#include <cmath>
#include <utility>

#include "app/window/flow_layout.hpp"
#include "app/window/theme.hpp"

namespace nav::app {
namespace {

constexpr int kPlanGap = 4;

QString mm_text(double mm) { return QStringLiteral("%1 mm").arg(mm, 0, 'f', 1); }

QString point_text(const std::optional<Point<frames::Ct>>& point) {
  if (!point) return QStringLiteral("not set");
  const Eigen::Vector3d& p = point->mm;
  const auto part = [](double mm, const char* positive, const char* negative) {
    return QStringLiteral("%1 %2")
        .arg(QLatin1String(mm < 0 ? negative : positive))
        .arg(std::abs(mm), 0, 'f', 1);
  };
  return part(p.x(), "L", "R") + QStringLiteral("  ") + part(p.y(), "P", "A") +
         QStringLiteral("  ") + part(p.z(), "S", "I");
}

}  // namespace

std::optional<NeedlePlan> PlanDraft::plan() const {
  if (!target || !entry) return std::nullopt;
  const NeedlePlan plan{*entry, *target, radius_mm, margin_mm};
  if (!validate(plan)) return std::nullopt;
  return plan;
}

PlanPage::PlanPage(QWidget* parent)
    : QWidget(parent),
      structures_(small_choice(QStringLiteral("plan-structures"),
                               QStringLiteral("Critical structures"), this)),
      words_(small_label({}, this)) {
  setObjectName(QStringLiteral("plan-page"));
  setAccessibleName(QStringLiteral("Plan"));
  words_->setObjectName(QStringLiteral("plan-words"));
  words_->setAccessibleName(QStringLiteral("Planned path"));
  words_->setTextFormat(Qt::RichText);
  const auto button = [this](const char* name, const char* text, const char* accessible) {
    return small_button(QLatin1String(name), QLatin1String(text), QLatin1String(accessible), this);
  };
  const auto number = [this](const char* name, const char* accessible, double low, double high,
                             double value) {
    auto* made = small_number(QLatin1String(name), QLatin1String(accessible), low, high, 1, this);
    set_quietly(*made, value);
    return made;
  };
  target_ = button("plan-target", "Target = cursor", "Target of the path at the cursor");
  entry_ = button("plan-entry", "Entry = cursor", "Entry of the path at the cursor");
  pick_target_ =
      button("plan-pick-target", "by a click", "The next click in a view sets the target");
  pick_entry_ = button("plan-pick-entry", "by a click", "The next click in a view sets the entry");
  pick_target_->setCheckable(true);
  pick_entry_->setCheckable(true);
  undo_ = button("plan-undo", "Undo", "Undo the last edit (Ctrl+Z)");
  redo_ = button("plan-redo", "Redo", "Redo the last edit (Ctrl+Shift+Z)");
  radius_ = number("plan-radius", "Radius of the target, mm", 0.1, 500, 5);
  margin_ = number("plan-margin", "Margin beyond the radius, mm", 0, 500, 5);
  size_ = number("plan-size", "Radius of a new structure, mm", 0.1, 500, 5);
  clearance_ = number("plan-clearance", "Distance to keep from a new structure, mm", 0, 100, 5);
  low_ = number("plan-low", "Lowest value of a new structure, HU", -32768, 32767, 200);
  high_ = number("plan-high", "Highest value of a new structure, HU", -32768, 32767, 3000);
  add_sphere_ = button("plan-add-sphere", "Sphere at cursor", "Add a sphere at the cursor");
  add_values_ = button("plan-add-values", "Values of the CT", "Add all voxels between two values");
  remove_ = button("plan-remove", "Remove", "Remove the chosen structure");

  auto* column = new QVBoxLayout(this);
  column->setContentsMargins(6, 6, 6, 6);
  column->setSpacing(kPlanGap);
  const auto row = [&](std::initializer_list<QWidget*> widgets) {
    auto* flow = new FlowLayout(kPlanGap);
    for (QWidget* widget : widgets) flow->addWidget(widget);
    column->addLayout(flow);
  };
  const auto named = [this](const char* text, QWidget* control) {
    return labelled(QLatin1String(text), control, this);
  };
  row({target_, pick_target_, undo_});
  row({entry_, pick_entry_, redo_});
  row({named("radius, mm", radius_), named("margin, mm", margin_)});
  column->addWidget(words_);
  column->addWidget(small_label(QStringLiteral("Critical structures"), this));
  row({structures_, remove_});
  row({add_sphere_, named("radius, mm", size_)});
  row({add_values_, named("from", low_), named("to", high_)});
  row({named("keep away, mm", clearance_)});
  column->addStretch(1);

  QObject::connect(target_, &QPushButton::clicked, this, [this] { from_cursor(Pick::kTarget); });
  QObject::connect(entry_, &QPushButton::clicked, this, [this] { from_cursor(Pick::kEntry); });
  for (auto [one, other] : {std::pair(pick_target_, pick_entry_), {pick_entry_, pick_target_}}) {
    QObject::connect(one, &QPushButton::toggled, this, [this, other = other](bool on) {
      if (on) other->setChecked(false);
      if (pick_changed) pick_changed();
    });
  }
  QObject::connect(undo_, &QPushButton::clicked, this, [this] { undo(); });
  QObject::connect(redo_, &QPushButton::clicked, this, [this] { redo(); });
  QObject::connect(radius_, &QDoubleSpinBox::valueChanged, this, [this](double mm) {
    PlanDraft next = draft();
    next.radius_mm = mm;
    change(std::move(next));
  });
  QObject::connect(margin_, &QDoubleSpinBox::valueChanged, this, [this](double mm) {
    PlanDraft next = draft();
    next.margin_mm = mm;
    change(std::move(next));
  });
  QObject::connect(add_sphere_, &QPushButton::clicked, this, [this] { add_structure(true); });
  QObject::connect(add_values_, &QPushButton::clicked, this, [this] { add_structure(false); });
  QObject::connect(remove_, &QPushButton::clicked, this, [this] { remove_structure(); });
  refresh();
}

void PlanPage::open(PlanDraft draft) {
  history_ = render::UndoHistory<PlanDraft>(std::move(draft));
  check_.reset();
  cancel();
  refresh();
}

PlanPage::Pick PlanPage::pick() const {
  return pick_target_->isChecked()  ? Pick::kTarget
         : pick_entry_->isChecked() ? Pick::kEntry
                                    : Pick::kNone;
}

bool PlanPage::cancel() {
  if (pick() == Pick::kNone) return false;
  pick_target_->setChecked(false);
  pick_entry_->setChecked(false);
  return true;
}

void PlanPage::picked(const Point<frames::Ct>& point) {
  const Pick part = pick();
  cancel();
  set(part, point);
}

void PlanPage::set(Pick part, const Point<frames::Ct>& point) {
  if (part == Pick::kNone) return;
  PlanDraft next = draft();
  (part == Pick::kTarget ? next.target : next.entry) = point;
  change(std::move(next));
}

void PlanPage::from_cursor(Pick part) {
  if (const auto point = cursor ? cursor() : std::nullopt) set(part, *point);
}

void PlanPage::add_structure(bool sphere) {
  PlanDraft next = draft();
  session::CriticalStructure made;
  made.clearance_mm = clearance_->value();
  if (sphere) {
    const auto point = cursor ? cursor() : std::nullopt;
    if (!point) return;
    made.sphere = session::CriticalStructure::Sphere{*point, size_->value()};
  } else {
    if (!(low_->value() < high_->value())) {
      words_->setText(QStringLiteral("The second value has to be above the first."));
      return;
    }
    made.values = session::CriticalStructure::Values{low_->value(), high_->value()};
  }
  // The first name that is free.
  for (int i = 1; made.name.empty(); ++i) {
    const std::string name = (sphere ? "sphere " : "values ") + std::to_string(i);
    const bool used =
        std::ranges::any_of(next.structures, [&](const auto& one) { return one.name == name; });
    if (!used) made.name = name;
  }
  next.structures.push_back(std::move(made));
  change(std::move(next));
  structures_->setCurrentIndex(structures_->count() - 1);
}

void PlanPage::remove_structure() {
  const int index = structures_->currentIndex();
  PlanDraft next = draft();
  if (index < 0 || index >= static_cast<int>(next.structures.size())) return;
  next.structures.erase(next.structures.begin() + index);
  change(std::move(next));
}

void PlanPage::change(PlanDraft draft) {
  history_.change(std::move(draft));
  check_.reset();
  refresh();
  if (edited) edited();
}

bool PlanPage::undo() {
  if (!history_.undo()) return false;
  check_.reset();
  refresh();
  if (edited) edited();
  return true;
}

bool PlanPage::redo() {
  if (!history_.redo()) return false;
  check_.reset();
  refresh();
  if (edited) edited();
  return true;
}

void PlanPage::show_check(const std::optional<session::PathCheck>& check) {
  check_ = check;
  refresh();
}

void PlanPage::refresh() {
  const PlanDraft& now = draft();
  set_quietly(*radius_, now.radius_mm);
  set_quietly(*margin_, now.margin_mm);
  undo_->setEnabled(history_.can_undo());
  redo_->setEnabled(history_.can_redo());
  {
    const QSignalBlocker quiet(structures_);
    const int before = structures_->currentIndex();
    structures_->clear();
    for (const auto& one : now.structures) structures_->addItem(theme::plain(one.name));
    structures_->setCurrentIndex(std::min(std::max(before, 0), structures_->count() - 1));
  }
  remove_->setEnabled(!now.structures.empty());
  QString text =
      QStringLiteral("target %1<br>entry %2").arg(point_text(now.target), point_text(now.entry));
  if (!now.plan() && now.target && now.entry) {
    text += QStringLiteral("<br>Entry and target have to be at least 1 mm apart.");
  } else if (!now.plan()) {
    text += QStringLiteral("<br>A path needs a target and an entry.");
  } else if (!check_) {
    text += QStringLiteral("<br>checking the path…");
  } else {
    text += QStringLiteral("<br>path %1, %2° to the axial plane")
                .arg(mm_text(check_->length_mm))
                .arg(check_->angle_to_axial_rad * 180 / M_PI, 0, 'f', 1);
    for (const auto& one : check_->clearances) {
      const QString distance =
          one.distance_mm
              ? mm_text(*one.distance_mm)
              : QStringLiteral("more than %1").arg(mm_text(session::kFarthestClearanceMm));
      const QString words =
          theme::plain(one.name).toHtmlEscaped() + QStringLiteral(": ") + distance;
      text +=
          one.too_near
              ? QStringLiteral("<br><span style='color:#ff8a80'>✗ %1, TOO NEAR</span>").arg(words)
              : QStringLiteral("<br>✓ %1").arg(words);
    }
  }
  words_->setText(text);
}

}  // namespace nav::app
