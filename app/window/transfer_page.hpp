// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QWidget>
#include <functional>
#include <optional>

#include "app/window/small_controls.hpp"
#include "app/window/transfer_graph.hpp"

namespace nav::app {

/// The panel of the transfer function: components over the histogram of the CT, and colour, opacity
/// and importance of the chosen one.
class TransferPage final : public QWidget {
 public:
  explicit TransferPage(QWidget* parent);

  /// Begins with the function and the histogram of a session. Null counts: no histogram.
  void open(const render::TransferFunction& function,
            std::shared_ptr<const render::ValueCounts> counts);
  /// Takes over a function that was saved, as an edit. Precondition: open. kUsage: it has other
  /// components than the session's.
  Result<void> restore(const render::TransferFunction& function);
  /// Without a CT that a transfer function draws.
  void close();
  [[nodiscard]] bool is_open() const { return editor_.has_value(); }
  [[nodiscard]] const std::optional<render::TransferEditor>& editor() const { return editor_; }
  bool undo();
  bool redo();

  /// The function has changed; absent: it is that of the session again.
  std::function<void(const std::optional<render::TransferFunction>&)> edited;

 private:
  void add_sliders();
  void changed();
  void refresh();
  [[nodiscard]] std::size_t component() const;
  void set_colour();

  std::optional<render::TransferEditor> editor_;
  std::optional<render::TransferFunction> first_;
  QComboBox* components_;
  QPushButton *undo_, *redo_, *reset_;
  TransferGraph* graph_;
  QSlider *hue_, *saturation_, *value_, *opacity_, *importance_;
  QLabel* words_;
};

}  // namespace nav::app
