// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QCheckBox>
#include <QWidget>
#include <functional>
#include <optional>

#include "app/window/scene_edits.hpp"
#include "app/window/small_controls.hpp"
#include "render/undo_history.hpp"

namespace nav::app {

/// Cutaway and shading of the 3D view (Burns et al. 2007 §3.2 to §3.4).
struct CutawaySettings {
  CutawayEdit cutaway;
  double emphasis = 0;  ///< E, [0, 1].
  render::ShadingStyle style = render::ShadingStyle::kPhong;
};
bool operator==(const CutawaySettings& a, const CutawaySettings& b);
/// Settings of a scene; those of render::Cutaway where it has none.
CutawaySettings cutaway_settings_of(const render::Scene& scene);

/// The panel of the cutaway: angles, overlay, emphasis and style.
class CutawayPage final : public QWidget {
 public:
  explicit CutawayPage(QWidget* parent);

  /// Begins with the settings of a session.
  void open(const CutawaySettings& settings);
  /// Takes over settings that were saved, as an edit. Precondition: open.
  void restore(const CutawaySettings& settings) { change(settings); }
  [[nodiscard]] bool is_open() const { return first_.has_value(); }
  [[nodiscard]] const CutawaySettings& settings() const { return history_.value(); }
  bool undo();
  bool redo();

  /// The settings have changed; absent: they are those of the session again.
  std::function<void(const std::optional<CutawaySettings>&)> edited;

 private:
  void take();
  void refresh();
  void change(const CutawaySettings& settings);

  std::optional<CutawaySettings> first_;
  render::UndoHistory<CutawaySettings> history_;
  QCheckBox *on_, *endless_;
  QSlider *theta1_, *theta2_, *overlay_, *emphasis_;
  QLabel *theta1_words_, *theta2_words_, *overlay_words_, *emphasis_words_;
  QComboBox* style_;
  QPushButton *undo_, *redo_, *reset_;
};

}  // namespace nav::app
