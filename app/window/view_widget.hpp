// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QWidget>
#include <functional>
#include <optional>
#include <string>

#include "app/window/judgement.hpp"
#include "app/window/view_image.hpp"

namespace nav::app {

/// A plain widget that paints the finished image of an engine, and over it words about its state.
/// It draws no volume. Window's thread.
class ViewWidget : public QWidget {
 public:
  /// name: stable name of the control; title: what the user reads.
  ViewWidget(const QString& name, const QString& title, QWidget* parent);

  void set_view_image(ViewImage view_image);
  /// Forgets the image: the view has left the screen, and its image grows old.
  void clear_image();
  /// State, and the kind of the session ("SIMULATED").
  void set_judgement(const ViewJudgement& judgement, const std::string& kind);
  /// Frozen by the user for that long; absent: not.
  void set_frozen(std::optional<double> seconds);
  [[nodiscard]] const std::optional<ViewImage>& view_image() const { return view_image_; }
  [[nodiscard]] const ViewJudgement& judgement() const { return judgement_; }
  /// Device pixels of the view.
  [[nodiscard]] PixelSize pixel_size() const;
  /// Words about the next click, shown in the view; empty: it does what it always does.
  void set_mode(const QString& mode);
  [[nodiscard]] QString title() const { return title_; }
  /// Kind of the session as the view says it: "SIMULATED".
  [[nodiscard]] QString kind() const { return kind_; }

  /// Called when an image has been painted for the first time, with the time of painting in ms.
  std::function<void(const ViewImage&, double paint_ms)> painted;
  /// Called when the view has another size.
  std::function<void()> resized;

 protected:
  [[nodiscard]] bool has_mode() const { return !mode_.isEmpty(); }
  /// Colour of name and frame; absent: the frame has the colour of the state.
  void set_own_colour(QRgb colour) { own_colour_ = colour; }
  void paintEvent(QPaintEvent* event) override;
  void resizeEvent(QResizeEvent* event) override;
  /// Marks over the image of one kind of view; not called while it is covered.
  virtual void paint_marks(QPainter&, const ViewImage&) {}

 private:
  void paint_words(QPainter& painter);
  [[nodiscard]] double header_height() const;
  void paint_cover(QPainter& painter);

  QString title_;
  std::optional<QRgb> own_colour_;
  std::optional<ViewImage> view_image_;
  bool fresh_ = false;  ///< The image has not been painted yet.
  ViewJudgement judgement_{.safety = {}, .covered = true, .headline = "NOTHING YET"};
  std::optional<double> frozen_s_;
  QString kind_;
  QString mode_;
};

}  // namespace nav::app
