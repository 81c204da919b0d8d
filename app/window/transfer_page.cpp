// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/transfer_page.hpp"

#include <QGridLayout>
#include <QSignalBlocker>
#include <QVBoxLayout>
#include <algorithm>
#include <cmath>

#include "app/window/flow_layout.hpp"
#include "app/window/theme.hpp"

namespace nav::app {
namespace {

constexpr int kTransferGap = 4;

QSlider* transfer_slider(const char* name, const char* accessible, QWidget* parent) {
  return small_slider(Qt::Horizontal, QLatin1String(name), QLatin1String(accessible), parent);
}

/// The slider of opacity is a root, as the axis of the graph.
double root_of_opacity(double opacity) { return std::sqrt(std::clamp(opacity, 0.0, 1.0)); }

}  // namespace

TransferPage::TransferPage(QWidget* parent)
    : QWidget(parent),
      components_(small_choice(QStringLiteral("transfer-component"),
                               QStringLiteral("Component of the transfer function"), this)),
      undo_(small_button(QStringLiteral("transfer-undo"), QStringLiteral("Undo"),
                         QStringLiteral("Undo the last edit (Ctrl+Z)"), this)),
      redo_(small_button(QStringLiteral("transfer-redo"), QStringLiteral("Redo"),
                         QStringLiteral("Redo the last edit (Ctrl+Shift+Z)"), this)),
      reset_(small_button(QStringLiteral("transfer-reset"), QStringLiteral("Reset"),
                          QStringLiteral("The transfer function of the session"), this)),
      graph_(new TransferGraph(this)),
      hue_(transfer_slider("transfer-hue", "Hue of the component", this)),
      saturation_(transfer_slider("transfer-saturation", "Saturation of the component", this)),
      value_(transfer_slider("transfer-brightness", "Brightness of the component", this)),
      opacity_(transfer_slider("transfer-opacity", "Greatest opacity of 1 mm", this)),
      importance_(transfer_slider("transfer-importance", "Importance of the component", this)),
      words_(small_label(QString(), this)) {
  setObjectName(QStringLiteral("transfer"));
  setAccessibleName(QStringLiteral("Transfer function of the CT"));
  words_->setObjectName(QStringLiteral("transfer-words"));
  words_->setAccessibleName(QStringLiteral("About the component"));
  auto* column = new QVBoxLayout(this);
  column->setContentsMargins(6, 6, 6, 6);
  column->setSpacing(kTransferGap);
  auto* top = new FlowLayout(kTransferGap);
  top->addWidget(components_);
  for (QPushButton* button : {undo_, redo_, reset_}) top->addWidget(button);
  column->addLayout(top);
  column->addWidget(graph_, 1);
  add_sliders();
  column->addWidget(words_);
  QObject::connect(components_, &QComboBox::currentIndexChanged, this, [this] { refresh(); });
  QObject::connect(undo_, &QPushButton::clicked, this, [this] { undo(); });
  QObject::connect(redo_, &QPushButton::clicked, this, [this] { redo(); });
  QObject::connect(reset_, &QPushButton::clicked, this, [this] {
    if (!first_) return;
    editor_.emplace(*first_);
    refresh();
    if (edited) edited(std::nullopt);
  });
  graph_->drag_began = [this] { editor_->begin(); };
  graph_->drag_ended = [this] { editor_->end(); };
  graph_->moved = [this](std::size_t node, double value, double opacity) {
    editor_->move_node(component(), node, value, opacity);
    changed();
  };
  close();
}

void TransferPage::add_sliders() {
  auto* grid = new QGridLayout;
  grid->setSpacing(kTransferGap);
  int row = 0;
  const auto add = [&](const char* label, QSlider* slider, auto set) {
    grid->addWidget(new QLabel(QLatin1String(label), this), row, 0);
    grid->addWidget(slider, row++, 1);
    QObject::connect(slider, &QSlider::sliderPressed, this, [this] {
      if (editor_) editor_->begin();
    });
    QObject::connect(slider, &QSlider::sliderReleased, this, [this] {
      if (editor_) editor_->end();
    });
    QObject::connect(slider, &QSlider::valueChanged, this, [this, set] {
      if (!editor_) return;
      set();
      changed();
    });
  };
  add("hue", hue_, [this] { set_colour(); });
  add("saturation", saturation_, [this] { set_colour(); });
  add("brightness", value_, [this] { set_colour(); });
  add("opacity of 1 mm", opacity_, [this] {
    const double root = share_of(*opacity_);
    editor_->set_opacity(component(), root * root);
  });
  add("importance", importance_,
      [this] { editor_->set_importance(component(), share_of(*importance_)); });
  static_cast<QVBoxLayout*>(layout())->addLayout(grid);
}

std::size_t TransferPage::component() const {
  return static_cast<std::size_t>(std::max(0, components_->currentIndex()));
}

void TransferPage::set_colour() {
  constexpr double kMostHue = 0.999;
  const QColor colour = QColor::fromHsvF(static_cast<float>(kMostHue * share_of(*hue_)),
                                         static_cast<float>(share_of(*saturation_)),
                                         static_cast<float>(share_of(*value_)));
  editor_->set_colour(component(), {colour.redF(), colour.greenF(), colour.blueF()});
}

void TransferPage::open(const render::TransferFunction& function,
                        std::shared_ptr<const render::ValueCounts> counts) {
  first_ = function;
  editor_.emplace(function);
  graph_->show_counts(std::move(counts));
  {
    const QSignalBlocker quiet(components_);
    components_->clear();
    for (const auto& component : function.components()) {
      components_->addItem(component.name.empty() ? QStringLiteral("all")
                                                  : theme::plain(component.name));
    }
    components_->setCurrentIndex(0);
  }
  for (QWidget* control : std::initializer_list<QWidget*>{
           components_, reset_, graph_, hue_, saturation_, value_, opacity_, importance_}) {
    control->setEnabled(true);
  }
  words_->setText({});
  refresh();
}

Result<void> TransferPage::restore(const render::TransferFunction& function) {
  const auto& mine = first_->components();
  const auto& other = function.components();
  const bool same = std::ranges::equal(
      mine, other, [](const auto& a, const auto& b) { return a.name == b.name; });
  if (!same) {
    return Error{ErrorCode::kUsage,
                 "window.transfer: expected the components of the session's transfer function, "
                 "found others"};
  }
  editor_.emplace(function);
  changed();
  return {};
}

void TransferPage::close() {
  editor_.reset();
  first_.reset();
  for (QWidget* control :
       std::initializer_list<QWidget*>{components_, undo_, redo_, reset_, graph_, hue_, saturation_,
                                       value_, opacity_, importance_}) {
    control->setEnabled(false);
  }
  words_->setText(QStringLiteral("No CT that a transfer function draws."));
}

void TransferPage::changed() {
  refresh();
  if (edited) edited(editor_->function());
}

bool TransferPage::undo() {
  if (!editor_ || !editor_->undo()) return false;
  changed();
  return true;
}

bool TransferPage::redo() {
  if (!editor_ || !editor_->redo()) return false;
  changed();
  return true;
}

void TransferPage::refresh() {
  if (!editor_) return;
  const auto& chosen = editor_->components().at(component());
  graph_->show_function(editor_->function(), component());
  undo_->setEnabled(editor_->can_undo());
  redo_->setEnabled(editor_->can_redo());
  const render::TransferNode& node = render::most_opaque(chosen);
  const QColor colour =
      QColor::fromRgbF(static_cast<float>(node.rgb.x()), static_cast<float>(node.rgb.y()),
                       static_cast<float>(node.rgb.z()));
  const auto show = [](QSlider* slider, double share) {
    if (!slider->isSliderDown()) set_quietly(*slider, share);
  };
  // A grey has no hue: the slider stays where it is.
  if (colour.hsvHueF() >= 0 && colour.hsvSaturationF() > 0) show(hue_, colour.hsvHueF());
  if (colour.valueF() > 0) show(saturation_, colour.hsvSaturationF());
  show(value_, colour.valueF());
  show(opacity_, root_of_opacity(node.opacity));
  show(importance_, node.importance);
}

}  // namespace nav::app
