// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/predicate_page.hpp"

#include <QHBoxLayout>
#include <QSignalBlocker>
#include <QVBoxLayout>
#include <algorithm>
#include <array>
#include <cmath>

#include "app/window/flow_layout.hpp"
#include "app/window/theme.hpp"
#include "render/predicates/registry.hpp"

namespace nav::app {
namespace {

using render::features::Paint;

constexpr int kPageGap = 4;
constexpr double kDegPerRad = 180 / M_PI;
constexpr int kParameterDecimals = 3;

bool is_angle(const render::PredicateParameter& parameter) {
  return parameter.name.ends_with("_rad");
}

/// Unit of the number field, in units of the parameter.
double unit_of(const render::PredicateParameter& parameter) {
  return is_angle(parameter) ? 1 / kDegPerRad : 1;
}

QString label_of(const render::EditableParameter& one) {
  std::string name = one.parameter.name;
  if (is_angle(one.parameter)) name = name.substr(0, name.size() - 4) + "_deg";
  return theme::plain(one.kind + " " + name).replace(QLatin1Char('_'), QLatin1Char(' '));
}

bool same_controls(const std::vector<render::EditableParameter>& a,
                   const std::vector<render::EditableParameter>& b) {
  return std::ranges::equal(a, b, [](const auto& x, const auto& y) {
    return x.kind == y.kind && x.parameter.name == y.parameter.name;
  });
}

FlowLayout* flow_of(QWidget* row) {
  auto* layout = new FlowLayout(kPageGap);
  row->setLayout(layout);
  return layout;
}

}  // namespace

PredicatePage::PredicatePage(render::PredicateEditor& editor, QWidget* parent)
    : QWidget(parent),
      editor_(editor),
      bars_(new HistogramBars(this)),
      presets_(
          small_choice(QStringLiteral("predicate-preset"), QStringLiteral("Predicate set"), this)),
      add_(small_choice(QStringLiteral("predicate-add"), QStringLiteral("Add a predicate"), this)),
      undo_(small_button(QStringLiteral("predicate-undo"), QStringLiteral("Undo"),
                         QStringLiteral("Undo the last edit (Ctrl+Z)"), this)),
      redo_(small_button(QStringLiteral("predicate-redo"), QStringLiteral("Redo"),
                         QStringLiteral("Redo the last edit (Ctrl+Shift+Z)"), this)),
      remove_(small_button(QStringLiteral("predicate-remove"), QStringLiteral("Remove"),
                           QStringLiteral("Remove the chosen predicate"), this)),
      not_(small_button(QStringLiteral("predicate-not"), QStringLiteral("NOT"),
                        QStringLiteral("Negate the chosen predicate"), this)),
      and_(small_button(QStringLiteral("predicate-and"), QStringLiteral("AND"),
                        QStringLiteral("Combine with the bar that is clicked next: both"), this)),
      or_(small_button(QStringLiteral("predicate-or"), QStringLiteral("OR"),
                       QStringLiteral("Combine with the bar that is clicked next: any"), this)),
      hue_(
          small_slider(Qt::Vertical, QStringLiteral("predicate-hue"), QStringLiteral("Hue"), this)),
      saturation_(small_slider(Qt::Vertical, QStringLiteral("predicate-saturation"),
                               QStringLiteral("Saturation"), this)),
      parameters_(new QScrollArea(this)),
      message_(small_label(QString(), this)),
      clear_(small_button(QStringLiteral("scribble-clear"), QStringLiteral("Clear"),
                          QStringLiteral("Forget the strokes; the histogram stays"), this)),
      radius_(small_number(QStringLiteral("scribble-radius"),
                           QStringLiteral("Radius of the brush, mm"), 0.1, 50, 1, this)) {
  setObjectName(QStringLiteral("predicates"));
  setAccessibleName(QStringLiteral("Predicate histogram"));
  // They show their title only; the names of their items may be long.
  for (QComboBox* choice : {presets_, add_}) {
    choice->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
    choice->setMinimumContentsLength(7);
  }
  message_->setObjectName(QStringLiteral("predicate-words"));
  message_->setAccessibleName(QStringLiteral("About the predicates"));
  parameters_->setObjectName(QStringLiteral("predicate-parameters"));
  parameters_->setAccessibleName(QStringLiteral("Parameters of the chosen predicate"));
  parameters_->setWidgetResizable(true);
  parameters_->setFrameShape(QFrame::NoFrame);
  parameters_->setMinimumHeight(2 * kSmallControl + kPageGap);
  add_rows();
  bars_->picked = [this](std::size_t bar) { pick(bar); };
  bars_->drag_began = [this] { editor_.begin(); };
  bars_->drag_ended = [this] { editor_.end(); };
  bars_->dragged = [this](std::size_t bar, double importance) {
    editor_.drag(bar, importance);
    changed();
  };
  set_volume(false);
}

void PredicatePage::add_rows() {
  auto* column = new QVBoxLayout(this);
  column->setContentsMargins(6, 6, 6, 6);
  column->setSpacing(kPageGap);
  auto* top = new QWidget(this);
  auto* row = flow_of(top);
  presets_->addItem(QStringLiteral("Preset …"));
  for (const std::string& name : render::predicate_preset_names()) {
    presets_->addItem(QString::fromStdString(name));
  }
  row->addWidget(presets_);
  row->addWidget(undo_);
  row->addWidget(redo_);
  column->addWidget(top);
  column->addWidget(colour_and_bars(), 3);
  column->addWidget(parameters_, 2);
  column->addWidget(combination_row());
  column->addWidget(scribble_row());
  column->addWidget(message_);
  QObject::connect(presets_, &QComboBox::activated, this, [this](int item) {
    if (item > 0 && preset_chosen) preset_chosen(presets_->itemText(item));
    presets_->setCurrentIndex(0);
  });
  QObject::connect(undo_, &QPushButton::clicked, this, [this] { undo(); });
  QObject::connect(redo_, &QPushButton::clicked, this, [this] { redo(); });
}

QWidget* PredicatePage::colour_and_bars() {
  auto* row = new QWidget(this);
  auto* layout = new QHBoxLayout(row);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->setSpacing(kPageGap);
  const auto column = [&](QSlider* slider, const char* letter) {
    auto* both = new QVBoxLayout;
    auto* label = new QLabel(QLatin1String(letter), row);
    label->setAlignment(Qt::AlignCenter);
    both->addWidget(label);
    both->addWidget(slider, 1, Qt::AlignHCenter);
    layout->addLayout(both);
  };
  column(hue_, "H");
  column(saturation_, "S");
  layout->addWidget(bars_, 1);
  for (QSlider* slider : {hue_, saturation_}) {
    QObject::connect(slider, &QSlider::sliderPressed, this, [this] { editor_.begin(); });
    QObject::connect(slider, &QSlider::sliderReleased, this, [this] { editor_.end(); });
    QObject::connect(slider, &QSlider::valueChanged, this, [this] { set_colour(); });
  }
  return row;
}

QWidget* PredicatePage::combination_row() {
  auto* row = new QWidget(this);
  auto* layout = flow_of(row);
  add_->addItem(QStringLiteral("Add …"));
  for (const render::PredicateKind* kind : render::predicate_kinds()) {
    add_->addItem(QString::fromStdString(kind->name()));
    add_->setItemData(add_->count() - 1, theme::plain(kind->description()), Qt::ToolTipRole);
  }
  layout->addWidget(add_);
  for (QPushButton* button : {remove_, not_, and_, or_}) layout->addWidget(button);
  QObject::connect(add_, &QComboBox::activated, this, [this](int item) { add_kind(item); });
  QObject::connect(remove_, &QPushButton::clicked, this, [this] {
    if (!editor_.selected()) return;
    editor_.remove(*editor_.selected());
    after({});
  });
  QObject::connect(not_, &QPushButton::clicked, this, [this] {
    if (editor_.selected()) after(editor_.negate(*editor_.selected()));
  });
  using Operator = render::PredicateEditor::Operator;
  QObject::connect(and_, &QPushButton::clicked, this, [this] { combine_next(Operator::kAnd); });
  QObject::connect(or_, &QPushButton::clicked, this, [this] { combine_next(Operator::kOr); });
  return row;
}

QWidget* PredicatePage::scribble_row() {
  auto* row = new QWidget(this);
  auto* layout = flow_of(row);
  const auto brush = [&](const char* name, const char* text, const char* accessible) {
    auto* made =
        small_button(QLatin1String(name), QLatin1String(text), QLatin1String(accessible), row);
    made->setCheckable(true);
    const int which = static_cast<int>(brushes_.size());
    QObject::connect(made, &QPushButton::clicked, this, [this, which] { choose_brush(which); });
    brushes_.push_back(made);
    layout->addWidget(made);
  };
  brush("scribble-show", "Show", "Paint on slices what is to be shown");
  brush("scribble-hide", "Hide", "Paint on slices what is to be hidden");
  brush("scribble-erase", "Erase", "Erase strokes on slices");
  constexpr double kFirstRadiusMm = 1;
  radius_->setValue(kFirstRadiusMm);
  radius_->setSuffix(QStringLiteral(" mm"));
  layout->addWidget(radius_);
  layout->addWidget(clear_);
  QObject::connect(radius_, &QDoubleSpinBox::valueChanged, this, [this] {
    if (brush_changed) brush_changed();
  });
  QObject::connect(clear_, &QPushButton::clicked, this, [this] {
    if (editor_.strokes().empty()) return;
    editor_.clear_strokes();
    after({});
  });
  return row;
}

void PredicatePage::after(const Result<void>& done) {
  say(done ? QString() : theme::plain(done.error().message));
  changed();
}

void PredicatePage::changed() {
  refresh();
  if (edited) edited();
}

void PredicatePage::pick(std::size_t bar) {
  if (combining_) {
    const Combining now = *combining_;
    combining_.reset();
    return after(editor_.combine(now.op, now.first, bar));
  }
  editor_.select(bar);
  refresh();
}

void PredicatePage::combine_next(render::PredicateEditor::Operator op) {
  if (!editor_.selected()) return;
  combining_ = Combining{op, *editor_.selected()};
  say(QStringLiteral("%1 %2 … click the second bar (Esc ends it)")
          .arg(theme::plain(editor_.model().entries[*editor_.selected()].name),
               op == render::PredicateEditor::Operator::kAnd ? QStringLiteral("AND")
                                                             : QStringLiteral("OR")));
}

void PredicatePage::set_colour() {
  if (!editor_.selected()) return;
  // The last step of the slider is not 360°, which is 0° again.
  constexpr double kMostHueDeg = 359.9;
  const auto& bar = editor_.model().histogram.bars()[*editor_.selected()];
  // The slider that stands still does not round its value to its own steps.
  const auto moved = [](const QSlider& slider, double now) {
    return std::abs(share_of(slider) - now) > 0.75 / kSliderSteps;
  };
  editor_.set_colour(*editor_.selected(),
                     moved(*hue_, bar.hue_deg / 360) ? kMostHueDeg * share_of(*hue_) : bar.hue_deg,
                     moved(*saturation_, bar.saturation) ? share_of(*saturation_) : bar.saturation);
  changed();
}

void PredicatePage::add_kind(int item) {
  if (item <= 0) return;
  const std::string name = add_->itemText(item).toStdString();
  add_->setCurrentIndex(0);
  after(editor_.add(name));
}

void PredicatePage::choose_brush(int which) {
  for (std::size_t i = 0; i < brushes_.size(); ++i) {
    if (static_cast<int>(i) != which) brushes_[i]->setChecked(false);
  }
  if (brush_changed) brush_changed();
}

std::optional<Brush> PredicatePage::brush() const {
  constexpr std::array kPaints{Paint::kShow, Paint::kHide, Paint::kErase};
  for (std::size_t i = 0; i < brushes_.size(); ++i) {
    if (brushes_[i]->isChecked()) return Brush{kPaints.at(i), radius_->value()};
  }
  return std::nullopt;
}

bool PredicatePage::cancel() {
  if (combining_) {
    combining_.reset();
    say(QString());
    return true;
  }
  if (!brush()) return false;
  choose_brush(-1);
  return true;
}

bool PredicatePage::undo() {
  combining_.reset();
  if (!editor_.undo()) return false;
  after({});
  return true;
}

bool PredicatePage::redo() {
  combining_.reset();
  if (!editor_.redo()) return false;
  after({});
  return true;
}

void PredicatePage::set_volume(bool there) {
  for (QWidget* control :
       std::initializer_list<QWidget*>{presets_, add_, undo_, redo_, remove_, not_, and_, or_, hue_,
                                       saturation_, bars_, parameters_, clear_, radius_}) {
    control->setEnabled(there);
  }
  for (QPushButton* button : brushes_) button->setEnabled(there);
  say(there ? QString()
            : QStringLiteral("No 3D ultrasound: --us-volume or --phantom, or [predicates] of the "
                             "session file."));
  refresh();
}

void PredicatePage::say(const QString& words) { message_->setText(words); }

void PredicatePage::refresh() {
  const auto chosen = editor_.selected();
  bars_->show_model(editor_.model(), chosen);
  const bool there = presets_->isEnabled();
  undo_->setEnabled(there && editor_.can_undo());
  redo_->setEnabled(there && editor_.can_redo());
  for (QWidget* control :
       std::initializer_list<QWidget*>{remove_, not_, and_, or_, hue_, saturation_}) {
    control->setEnabled(there && chosen.has_value());
  }
  clear_->setEnabled(there && !editor_.strokes().empty());
  if (chosen) {
    const auto& bar = editor_.model().histogram.bars()[*chosen];
    if (!hue_->isSliderDown()) set_quietly(*hue_, bar.hue_deg / 360);
    if (!saturation_->isSliderDown()) set_quietly(*saturation_, bar.saturation);
  }
  rebuild_parameters();
}

void PredicatePage::rebuild_parameters() {
  const auto chosen = editor_.selected();
  std::vector<render::EditableParameter> wanted;
  if (chosen) {
    const render::PredicateEntry& entry = editor_.model().entries[*chosen];
    wanted = render::editable_parameters(entry.expression);
    wanted.push_back({"least",
                      {.name = "brightness", .unit = "1", .low = 0, .high = 1, .initial = 0},
                      entry.floor});
  }
  if (!same_controls(wanted, shown_) || parameters_->widget() == nullptr) {
    numbers_.clear();
    auto* page = new QWidget;
    auto* grid = new QGridLayout(page);
    grid->setContentsMargins(0, 0, 0, 0);
    grid->setSpacing(kPageGap);
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      const render::PredicateParameter& parameter = wanted[i].parameter;
      const double unit = unit_of(parameter);
      const QString label = label_of(wanted[i]);
      auto* number =
          small_number(QStringLiteral("parameter%1").arg(i + 1), label, parameter.low / unit,
                       parameter.high / unit, kParameterDecimals, page);
      const bool floor = i + 1 == wanted.size();
      QObject::connect(number, &QDoubleSpinBox::valueChanged, this, [=, this](double value) {
        if (!editor_.selected()) return;
        const std::size_t bar = *editor_.selected();
        after(floor ? editor_.set_floor(bar, value) : editor_.set_parameter(bar, i, value * unit));
      });
      const int at = static_cast<int>(i);
      grid->addWidget(small_label(label, page), at, 0);
      grid->addWidget(number, at, 1);
      numbers_.push_back(number);
    }
    grid->setColumnStretch(0, 1);
    grid->setRowStretch(static_cast<int>(wanted.size()), 1);
    // The old page may hold the number field that is being changed.
    if (QWidget* old = parameters_->takeWidget()) old->deleteLater();
    parameters_->setWidget(page);
  }
  shown_ = wanted;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    set_quietly(*numbers_[i], wanted[i].value / unit_of(wanted[i].parameter));
  }
}

}  // namespace nav::app
