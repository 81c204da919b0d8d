// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/devices_page.hpp"

#include <QSignalBlocker>
#include <QVBoxLayout>
#include <algorithm>

#include "app/window/flow_layout.hpp"
#include "app/window/small_controls.hpp"

namespace nav::app {
namespace {

/// A view that the second screen may show.
struct SecondView {
  const char* name;
  const char* text;
  const char* accessible;
};
constexpr std::array<SecondView, 4> kSecondViews{
    {{"view3d", "3D", "Second screen: 3D view"},
     {"ultrasound", "Ultrasound", "Second screen: ultrasound"},
     {"ctplane", "CT", "Second screen: CT along the plane"},
     {"slices", "Slices", "Second screen: axial, coronal and sagittal slice"}}};

}  // namespace

DevicesPage::DevicesPage(QWidget* parent) : QWidget(parent) {
  setObjectName(QStringLiteral("devices-page"));
  setAccessibleName(QStringLiteral("Devices"));
  auto* column = new QVBoxLayout(this);
  column->setContentsMargins(6, 6, 6, 6);
  column->setSpacing(4);
  column->addWidget(
      small_label(QStringLiteral("The second screen (Ctrl+D) shows, besides the numbers:"), this));
  auto* row = new FlowLayout(4);
  for (std::size_t i = 0; i < buttons_.size(); ++i) {
    const SecondView& view = kSecondViews[i];
    buttons_[i] = small_button(QStringLiteral("second-") + QLatin1String(view.name),
                               QLatin1String(view.text), QLatin1String(view.accessible), this);
    buttons_[i]->setCheckable(true);
    QObject::connect(buttons_[i], &QPushButton::toggled, this, [this] {
      if (chosen) chosen();
    });
    row->addWidget(buttons_[i]);
  }
  column->addLayout(row);
  column->addWidget(small_label(QStringLiteral("None chosen: the views of this window."), this));
  column->addStretch(1);
}

std::vector<std::string> DevicesPage::views() const {
  std::vector<std::string> views;
  for (std::size_t i = 0; i < buttons_.size(); ++i) {
    if (buttons_[i]->isChecked()) views.emplace_back(kSecondViews[i].name);
  }
  return views;
}

void DevicesPage::set_views(const std::vector<std::string>& views) {
  for (std::size_t i = 0; i < buttons_.size(); ++i) {
    const QSignalBlocker quiet(buttons_[i]);
    buttons_[i]->setChecked(std::ranges::count(views, kSecondViews[i].name) > 0);
  }
}

}  // namespace nav::app
