// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QWidget>
#include <functional>
#include <optional>
#include <string>

#include "app/window/judgement.hpp"
#include "app/window/picture.hpp"

namespace nav::app {

/// A plain widget that paints the finished image of an engine, and over it words about its state.
/// It draws no volume. Window's thread.
class ViewWidget : public QWidget {
 public:
  /// name: stable name of the control; title: what the user reads.
  ViewWidget(const QString& name, const QString& title, QWidget* parent);

  void set_picture(Picture picture);
  /// Forgets the image: the view has left the screen, and its image grows old.
  void clear_picture();
  /// State, and the kind of the session ("SIMULATED").
  void set_judgement(const ViewJudgement& judgement, const std::string& kind);
  /// Frozen by the user for that long; absent: not.
  void set_frozen(std::optional<double> seconds);
  [[nodiscard]] const std::optional<Picture>& picture() const { return picture_; }
  [[nodiscard]] const ViewJudgement& judgement() const { return judgement_; }
  /// Device pixels of the view.
  [[nodiscard]] PixelSize pixel_size() const;
  [[nodiscard]] QString title() const { return title_; }

  /// Called when an image has been painted for the first time, with the time of painting in ms.
  std::function<void(const Picture&, double paint_ms)> painted;
  /// Called when the view has another size.
  std::function<void()> resized;

 protected:
  /// Colour of name and frame; absent: the frame has the colour of the state.
  void set_own_colour(QRgb colour) { own_colour_ = colour; }
  void paintEvent(QPaintEvent* event) override;
  void resizeEvent(QResizeEvent* event) override;
  /// Marks over the image of one kind of view; not called while it is covered.
  virtual void paint_marks(QPainter&, const Picture&) {}

 private:
  void paint_words(QPainter& painter);
  void paint_cover(QPainter& painter);

  QString title_;
  std::optional<QRgb> own_colour_;
  std::optional<Picture> picture_;
  bool fresh_ = false;  ///< The image has not been painted yet.
  ViewJudgement judgement_{.safety = {}, .covered = true, .headline = "NOTHING YET"};
  std::optional<double> frozen_s_;
  QString kind_;
};

}  // namespace nav::app
