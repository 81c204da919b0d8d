// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/cutaway_page.hpp"

#include <QGridLayout>
#include <QSignalBlocker>
#include <QVBoxLayout>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "app/window/flow_layout.hpp"

namespace nav::app {
namespace {

constexpr int kCutawayGap = 4;
/// Angles of the sliders. render::validate() allows more, which is hard to see.
constexpr double kLeastAngleDeg = 1;
constexpr double kMostAngleDeg = 85;
constexpr double kMostOverlayMm = 100;
constexpr double kRadOfDeg = M_PI / 180;

double angle_of(const QSlider& slider) {
  return kRadOfDeg * (kLeastAngleDeg + share_of(slider) * (kMostAngleDeg - kLeastAngleDeg));
}

double share_of_angle(double rad) {
  return (rad / kRadOfDeg - kLeastAngleDeg) / (kMostAngleDeg - kLeastAngleDeg);
}

}  // namespace

bool operator==(const CutawaySettings& a, const CutawaySettings& b) {
  return a.cutaway == b.cutaway && std::tie(a.emphasis, a.style) == std::tie(b.emphasis, b.style);
}

CutawaySettings cutaway_settings_of(const render::Scene& scene) {
  const render::Cutaway cutaway = scene.cutaway.value_or(render::Cutaway{});
  return {.cutaway = {.on = scene.cutaway.has_value(),
                      .theta1_rad = cutaway.theta1_rad,
                      .theta2_rad = cutaway.theta2_rad,
                      .overlay_mm = cutaway.overlay_mm},
          .emphasis = scene.shading.emphasis,
          .style = scene.shading.style};
}

CutawayPage::CutawayPage(QWidget* parent)
    : QWidget(parent),
      on_(new QCheckBox(QStringLiteral("cut free what matters"), this)),
      endless_(new QCheckBox(QStringLiteral("no clear region"), this)),
      style_(
          small_choice(QStringLiteral("cutaway-style"), QStringLiteral("Style of shading"), this)),
      undo_(small_button(QStringLiteral("cutaway-undo"), QStringLiteral("Undo"),
                         QStringLiteral("Undo the last edit (Ctrl+Z)"), this)),
      redo_(small_button(QStringLiteral("cutaway-redo"), QStringLiteral("Redo"),
                         QStringLiteral("Redo the last edit (Ctrl+Shift+Z)"), this)),
      reset_(small_button(QStringLiteral("cutaway-reset"), QStringLiteral("Reset"),
                          QStringLiteral("The cutaway of the session"), this)) {
  setObjectName(QStringLiteral("cutaway"));
  setAccessibleName(QStringLiteral("Cutaway and shading"));
  on_->setObjectName(QStringLiteral("cutaway-on"));
  on_->setAccessibleName(QStringLiteral("Cutaway"));
  endless_->setObjectName(QStringLiteral("cutaway-endless"));
  endless_->setAccessibleName(QStringLiteral("Overlay without a clear region"));
  style_->addItems({QStringLiteral("phong"), QStringLiteral("gooch")});
  auto* column = new QVBoxLayout(this);
  column->setContentsMargins(6, 6, 6, 6);
  column->setSpacing(kCutawayGap);
  auto* top = new FlowLayout(kCutawayGap);
  top->addWidget(on_);
  for (QPushButton* button : {undo_, redo_, reset_}) top->addWidget(button);
  column->addLayout(top);
  auto* grid = new QGridLayout;
  grid->setSpacing(kCutawayGap);
  int row = 0;
  const auto add = [&](const char* label, const char* name, const char* accessible,
                       QLabel*& words) {
    auto* slider =
        small_slider(Qt::Horizontal, QLatin1String(name), QLatin1String(accessible), this);
    words = new QLabel(this);
    words->setMinimumWidth(64);
    words->setAlignment(Qt::AlignRight | Qt::AlignVCenter);
    grid->addWidget(new QLabel(QString::fromUtf8(label), this), row, 0);
    grid->addWidget(slider, row, 1);
    grid->addWidget(words, row++, 2);
    QObject::connect(slider, &QSlider::sliderPressed, this, [this] { history_.begin(); });
    QObject::connect(slider, &QSlider::sliderReleased, this, [this] { history_.end(); });
    QObject::connect(slider, &QSlider::valueChanged, this, [this] { take(); });
    return slider;
  };
  theta1_ = add("θ1, inner", "cutaway-theta1", "Angle of the inner surface", theta1_words_);
  theta2_ = add("θ2, outer", "cutaway-theta2", "Angle of the outer surface", theta2_words_);
  overlay_ = add("overlay", "cutaway-overlay", "Depth of the overlay region", overlay_words_);
  emphasis_ = add("emphasis", "cutaway-emphasis", "Emphasis of important material by shading",
                  emphasis_words_);
  grid->addWidget(endless_, row++, 1, 1, 2);
  grid->addWidget(new QLabel(QStringLiteral("style"), this), row, 0);
  grid->addWidget(style_, row, 1, 1, 2);
  column->addLayout(grid);
  column->addStretch(1);
  QObject::connect(on_, &QCheckBox::toggled, this, [this] { take(); });
  QObject::connect(endless_, &QCheckBox::toggled, this, [this] { take(); });
  QObject::connect(style_, &QComboBox::activated, this, [this] { take(); });
  QObject::connect(undo_, &QPushButton::clicked, this, [this] { undo(); });
  QObject::connect(redo_, &QPushButton::clicked, this, [this] { redo(); });
  QObject::connect(reset_, &QPushButton::clicked, this, [this] {
    if (!first_) return;
    history_ = render::UndoHistory<CutawaySettings>(*first_);
    refresh();
    if (edited) edited(std::nullopt);
  });
  setEnabled(false);
}

void CutawayPage::open(const CutawaySettings& settings) {
  first_ = settings;
  history_ = render::UndoHistory<CutawaySettings>(settings);
  setEnabled(true);
  refresh();
}

/// The settings of the controls. What the sliders cannot show exactly stays as it is.
void CutawayPage::take() {
  if (!first_) return;
  CutawaySettings now = history_.value();
  const QObject* moved = sender();
  now.cutaway.on = on_->isChecked();
  if (moved == theta1_) {
    now.cutaway.theta1_rad = angle_of(*theta1_);
    now.cutaway.theta2_rad = std::max(now.cutaway.theta2_rad, now.cutaway.theta1_rad);
  } else if (moved == theta2_) {
    now.cutaway.theta2_rad = angle_of(*theta2_);
    now.cutaway.theta1_rad = std::min(now.cutaway.theta1_rad, now.cutaway.theta2_rad);
  } else if (moved == emphasis_) {
    now.emphasis = share_of(*emphasis_);
  }
  if (moved == overlay_ || moved == endless_) {
    now.cutaway.overlay_mm = endless_->isChecked() ? std::numeric_limits<double>::infinity()
                                                   : kMostOverlayMm * share_of(*overlay_);
  }
  now.style =
      style_->currentIndex() == 1 ? render::ShadingStyle::kGooch : render::ShadingStyle::kPhong;
  if (now == history_.value()) return;
  change(now);
}

void CutawayPage::change(const CutawaySettings& settings) {
  history_.change(settings);
  refresh();
  if (edited) edited(settings);
}

bool CutawayPage::undo() {
  if (!history_.undo()) return false;
  refresh();
  if (edited) edited(history_.value());
  return true;
}

bool CutawayPage::redo() {
  if (!history_.redo()) return false;
  refresh();
  if (edited) edited(history_.value());
  return true;
}

void CutawayPage::refresh() {
  const CutawaySettings& now = history_.value();
  const bool endless = std::isinf(now.cutaway.overlay_mm);
  const QSignalBlocker quiet_on(on_);
  const QSignalBlocker quiet_endless(endless_);
  on_->setChecked(now.cutaway.on);
  endless_->setChecked(endless);
  const auto show = [](QSlider* slider, double share) {
    if (!slider->isSliderDown()) set_quietly(*slider, share);
  };
  show(theta1_, share_of_angle(now.cutaway.theta1_rad));
  show(theta2_, share_of_angle(now.cutaway.theta2_rad));
  if (!endless) show(overlay_, now.cutaway.overlay_mm / kMostOverlayMm);
  show(emphasis_, now.emphasis);
  style_->setCurrentIndex(now.style == render::ShadingStyle::kGooch ? 1 : 0);
  const auto degrees = [](double rad) {
    return QStringLiteral("%1°").arg(rad / kRadOfDeg, 0, 'f', 1);
  };
  theta1_words_->setText(degrees(now.cutaway.theta1_rad));
  theta2_words_->setText(degrees(now.cutaway.theta2_rad));
  overlay_words_->setText(endless ? QStringLiteral("∞")
                                  : QStringLiteral("%1 mm").arg(now.cutaway.overlay_mm, 0, 'f', 1));
  emphasis_words_->setText(QString::number(now.emphasis, 'f', 2));
  for (QWidget* control : std::initializer_list<QWidget*>{theta1_, theta2_, endless_}) {
    control->setEnabled(now.cutaway.on);
  }
  overlay_->setEnabled(now.cutaway.on && !endless);
  undo_->setEnabled(history_.can_undo());
  redo_->setEnabled(history_.can_redo());
}

}  // namespace nav::app
