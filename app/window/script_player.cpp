// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/script_player.hpp"

#include <QApplication>
#include <QDir>
#include <QMouseEvent>
#include <QWheelEvent>
#include <cmath>

#include "app/window/window_controls.hpp"
#include "io/atomic_file.hpp"
#include "io/digest.hpp"

namespace nav::app {
namespace {

constexpr int kScriptTickMs = 5;
constexpr int kDragSteps = 10;
constexpr double kLongestWait = 3600;
/// A view that the script has just opened has no image yet.
constexpr double kMostWaitForView = 30;

void send_mouse(QWidget& to, QEvent::Type type, QPointF at, Qt::MouseButton button,
                Qt::MouseButtons down) {
  QMouseEvent event(type, at, to.mapToGlobal(at), button, down, Qt::NoModifier);
  QApplication::sendEvent(&to, &event);
}

/// Writes an image and describes it. \p path may be empty: it is only described.
Result<io::Json> save_shot(const std::string& name, const QImage& image, const QString& path) {
  std::string bytes;
  for (int y = 0; y < image.height(); ++y) {
    bytes.append(reinterpret_cast<const char*>(image.constScanLine(y)),
                 4 * static_cast<std::size_t>(image.width()));
  }
  if (!path.isEmpty() && !image.save(path, "PNG")) {
    return Error{ErrorCode::kIo, path.toStdString() + ": could not be written"};
  }
  return io::Json{{"name", name},
                  {"sha256", io::sha256_hex(bytes)},
                  {"width", image.width()},
                  {"height", image.height()}};
}

Error cannot(const std::string& what) { return {ErrorCode::kUsage, what}; }

}  // namespace

ScriptPlayer::ScriptPlayer(std::vector<ScriptLine> lines, const Options& options,
                           MainWindow& window, const Clock& clock, WindowReport& report,
                           std::function<void(std::optional<Error>)> done)
    : lines_(std::move(lines)),
      options_(options),
      window_(window),
      clock_(clock),
      report_(report),
      done_(std::move(done)) {
  QObject::connect(&timer_, &QTimer::timeout, &window_, [this] { step(); });
  timer_.start(kScriptTickMs);
}

void ScriptPlayer::step() {
  if (next_ >= lines_.size() || lines_[next_].command == "quit") {
    return end(std::nullopt);
  }
  const ScriptLine& line = lines_[next_];
  const auto played = play(line);
  if (!played) {
    return end(Error{played.error().code, "line " + std::to_string(line.number) + ": " +
                                              line.command + ": " + played.error().message});
  }
  if (!*played) return;
  ++next_;
  waiting_since_.reset();
}

Result<bool> ScriptPlayer::play(const ScriptLine& line) {
  const auto once = [](const Result<void>& done) -> Result<bool> {
    if (!done) return done.error();
    return true;
  };
  if (line.command == "wait" || line.command == "expect" || line.command == "pause") {
    return await(line);
  }
  if (line.command == "click") return once_shown(&ScriptPlayer::click, line);
  if (line.command == "doubleclick") return once_shown(&ScriptPlayer::double_click, line);
  if (line.command == "hover") return once(hover(line));
  if (line.command == "key") return once(press(line.words[0]));
  if (line.command == "drag") return once_shown(&ScriptPlayer::drag, line);
  if (line.command == "choose") return once(choose(line));
  if (line.command == "set") return once(set(line));
  if (line.command == "type") return once(type(line));
  if (line.command == "stroke") return once_shown(&ScriptPlayer::stroke, line);
  if (line.command == "wheel") return once_shown(&ScriptPlayer::wheel, line);
  if (line.command == "shot") return once(shoot(line.words[0]));
  if (line.command == "controls") return once(list_controls(line.words[0]));
  if (line.command == "lengthen") {
    lengthen_texts(window_);
    window_.show_control(nullptr);
    return true;
  }
  if (line.command == "resize") {
    const auto width = script_number(line.words[0], 1, 7680);
    if (!width) return width.error();
    const auto height = script_number(line.words[1], 1, 4320);
    if (!height) return height.error();
    window_.resize(static_cast<int>(*width), static_cast<int>(*height));
    return true;
  }
  const auto seconds = script_number(line.words[1], 0, kLongestWait);
  if (!seconds) return seconds.error();
  if (!window_.loop().fault(line.words[0], from_seconds(*seconds))) {
    return cannot(
        "expected cover-marker, hold-images, hang-engine, hang-views or hang-session, found '" +
        line.words[0] + "'");
  }
  return true;
}

/// Does what the pointer does, once the view that it needs shows an image: before, the view would
/// ignore it.
Result<bool> ScriptPlayer::once_shown(Result<void> (ScriptPlayer::*act)(const ScriptLine&),
                                      const ScriptLine& line) {
  if (!waiting_since_) waiting_since_ = clock_.now();
  Result<void> done;
  const auto* view = dynamic_cast<const ViewWidget*>(
      window_.findChild<QWidget*>(QString::fromStdString(line.words[0])));
  const bool shows = view == nullptr || !view->isVisible() ||
                     (view->view_image().has_value() && !view->judgement().covered);
  if (!shows) {
    done = Error{ErrorCode::kUnavailable, "the view shows no image"};
  } else {
    done = (this->*act)(line);
  }
  if (done) return true;
  const bool later = done.error().code == ErrorCode::kUnavailable &&
                     to_seconds(clock_.now() - *waiting_since_) < kMostWaitForView;
  if (later) return false;
  return done.error();
}

/// wait: until a thing has a value. expect: as wait, with a default of no time at all.
Result<bool> ScriptPlayer::await(const ScriptLine& line) {
  if (!waiting_since_) waiting_since_ = clock_.now();
  const double waited = to_seconds(clock_.now() - *waiting_since_);
  if (line.command == "pause") {
    const auto seconds = script_number(line.words[0], 0, kLongestWait);
    if (!seconds) return seconds.error();
    return waited >= *seconds;
  }
  const auto most =
      line.words.size() > 2 ? script_number(line.words[2], 0, kLongestWait) : Result<double>(0.0);
  if (!most) return most.error();
  const auto value = window_.value(QString::fromStdString(line.words[0]));
  if (!value && window_.loop().newest()) {
    return cannot("expected a thing of the window, found '" + line.words[0] + "'");
  }
  const QString wanted = QString::fromStdString(line.words[1]);
  const bool shows = wanted == QLatin1String("shown") && line.words[0].starts_with("numeral.");
  const bool reached =
      value && (*value == wanted || (shows && *value != QLatin1String("withdrawn")));
  if (reached) return true;
  if (waited < *most) return false;
  return cannot("expected " + line.words[0] + " = " + line.words[1] + " within " +
                (line.words.size() > 2 ? line.words[2] : std::string("0")) + " s, found " +
                (value ? value->toStdString() : std::string("nothing")));
}

Result<QWidget*> ScriptPlayer::control(const std::string& name) {
  auto* found = window_.findChild<QWidget*>(QString::fromStdString(name));
  if (found == nullptr) return cannot("expected a control's name, found '" + name + "'");
  if (!found->isVisible()) return cannot("'" + name + "' is not visible");
  if (!found->isEnabled()) return cannot("'" + name + "' is disabled");
  window_.show_control(found);
  return found;
}

Result<ScriptPlayer::Target> ScriptPlayer::target(const std::string& name) {
  constexpr std::string_view kBar = "histogram.";
  if (!name.starts_with(kBar)) {
    const auto found = control(name);
    if (!found) return found.error();
    const QPointF centre = QRectF((*found)->rect()).center();
    // A check box is clicked on its box: its middle may be empty.
    constexpr double kBoxMiddle = 11;
    const bool box = qobject_cast<QCheckBox*>(*found) != nullptr;
    return Target{*found, box ? QPointF(kBoxMiddle, centre.y()) : centre};
  }
  const auto found = control("histogram");
  if (!found) return found.error();
  auto& bars = dynamic_cast<HistogramBars&>(**found);
  const auto bar = bars.find(QString::fromStdString(name.substr(kBar.size())));
  if (!bar) return cannot("expected the name of a bar, found '" + name + "'");
  return Target{&bars, bars.point_of(*bar, bars.importance_of(*bar))};
}

Result<void> ScriptPlayer::click(const ScriptLine& line) {
  const auto found = target(line.words[0]);
  if (!found) return found.error();
  send_mouse(*found->widget, QEvent::MouseButtonPress, found->at, Qt::LeftButton, Qt::LeftButton);
  send_mouse(*found->widget, QEvent::MouseButtonRelease, found->at, Qt::LeftButton, Qt::NoButton);
  return {};
}

Result<void> ScriptPlayer::double_click(const ScriptLine& line) {
  if (line.words.size() == 2) return cannot("expected DX and DY in pixels, found one number");
  if (auto first = click(line); !first) return first;
  QWidget* to = *control(line.words[0]);
  QPointF centre = QRectF(to->rect()).center();
  if (line.words.size() == 3) {
    const auto dx = script_number(line.words[1], -10000, 10000);
    const auto dy = script_number(line.words[2], -10000, 10000);
    if (!dx) return dx.error();
    if (!dy) return dy.error();
    centre += QPointF(*dx, *dy);
  }
  send_mouse(*to, QEvent::MouseButtonDblClick, centre, Qt::LeftButton, Qt::LeftButton);
  send_mouse(*to, QEvent::MouseButtonRelease, centre, Qt::LeftButton, Qt::NoButton);
  return {};
}

Result<void> ScriptPlayer::hover(const ScriptLine& line) {
  const auto found = control(line.words[0]);
  if (!found) return found.error();
  for (QWidget* other : window_.findChildren<QWidget*>()) {
    if (other == *found || !other->underMouse()) continue;
    QEvent leave(QEvent::Leave);
    QApplication::sendEvent(other, &leave);
  }
  const QPointF centre = QRectF((*found)->rect()).center();
  QEnterEvent enter(centre, centre, (*found)->mapToGlobal(centre));
  QApplication::sendEvent(*found, &enter);
  return {};
}

/// Makes the list of controls of a page anew.
Result<void> ScriptPlayer::list_controls(const std::string& path) {
  constexpr std::size_t kLargestPage = 1 << 24;
  const auto page = io::read_file(path, kLargestPage);
  if (!page) return page.error();
  const auto text = with_controls(*page, controls_of(window_));
  if (!text) return cannot(path + ": " + text.error().message);
  return io::write_file(path, *text);
}

Result<void> ScriptPlayer::press(const std::string& key) {
  const QKeySequence sequence(QString::fromStdString(key));
  if (sequence.count() != 1 || sequence[0].key() == Qt::Key_unknown) {
    return cannot("expected a key, found '" + key + "'");
  }
  QWidget* to = QApplication::focusWidget() != nullptr ? QApplication::focusWidget() : &window_;
  for (const auto type : {QEvent::KeyPress, QEvent::KeyRelease}) {
    QKeyEvent event(type, sequence[0].key(), sequence[0].keyboardModifiers());
    QApplication::sendEvent(to, &event);
  }
  return {};
}

/// Drags a bar of the histogram to an importance.
Result<void> ScriptPlayer::drag_bar(const ScriptLine& line) {
  const auto from = target(line.words[0]);
  if (!from) return from.error();
  const auto importance = script_number(line.words[1], 0, 1);
  if (!importance) return importance.error();
  const auto& bars = dynamic_cast<const HistogramBars&>(*from->widget);
  const auto bar = bars.find(QString::fromStdString(line.words[0]).section(QLatin1Char('.'), 1));
  const QPointF to = bars.point_of(*bar, *importance);
  send_mouse(*from->widget, QEvent::MouseButtonPress, from->at, Qt::LeftButton, Qt::LeftButton);
  for (int i = 1; i <= kDragSteps; ++i) {
    const double share = static_cast<double>(i) / kDragSteps;
    send_mouse(*from->widget, QEvent::MouseMove, from->at + share * (to - from->at), Qt::NoButton,
               Qt::LeftButton);
  }
  send_mouse(*from->widget, QEvent::MouseButtonRelease, to, Qt::LeftButton, Qt::NoButton);
  return {};
}

/// Paints on a slice: points are mm to the right and down from the cursor.
Result<void> ScriptPlayer::stroke(const ScriptLine& line) {
  const auto found = control(line.words[0]);
  if (!found) return found.error();
  auto* view = dynamic_cast<FlatWidget*>(*found);
  if (view == nullptr || !is_orthogonal(view->id())) {
    return cannot("expected axial, coronal or sagittal, found '" + line.words[0] + "'");
  }
  const std::string& paint = line.words[1];
  if (paint != "show" && paint != "hide" && paint != "erase") {
    return cannot("expected show, hide or erase, found '" + paint + "'");
  }
  std::vector<QPointF> points_mm;
  for (std::size_t i = 2; i < line.words.size(); ++i) {
    const std::string& word = line.words[i];
    const auto comma = word.find(',');
    if (comma == std::string::npos) return cannot("expected X,Y in mm, found '" + word + "'");
    const auto x = script_number(word.substr(0, comma), -1000, 1000);
    const auto y = script_number(word.substr(comma + 1), -1000, 1000);
    if (!x) return x.error();
    if (!y) return y.error();
    points_mm.emplace_back(*x, *y);
  }
  auto* brush = window_.findChild<QPushButton*>(QString::fromStdString("scribble-" + paint));
  if (brush == nullptr || !brush->isVisible() || !brush->isEnabled()) {
    return cannot("'scribble-" + paint + "' is not visible or disabled: open the predicates first");
  }
  if (!brush->isChecked()) brush->click();
  const auto& view_image = view->view_image();
  if (!view_image || !view_image->slice || !view_image->of_ultrasound) {
    return Error{ErrorCode::kUnavailable, "the slice does not show the 3D ultrasound yet"};
  }
  const double ratio = view_image->image.devicePixelRatio();
  const Eigen::Vector3d cursor = view_image->slice->pixel_of(view_image->cursor);
  const auto pixel = [&](const QPointF& mm) {
    const double scale = 1 / view_image->slice->mm_per_px;
    return QPointF((cursor.x() + scale * mm.x() + 0.5) / ratio,
                   (cursor.y() + scale * mm.y() + 0.5) / ratio);
  };
  send_mouse(*view, QEvent::MouseButtonPress, pixel(points_mm.front()), Qt::LeftButton,
             Qt::LeftButton);
  for (const QPointF& mm : points_mm) {
    send_mouse(*view, QEvent::MouseMove, pixel(mm), Qt::NoButton, Qt::LeftButton);
  }
  send_mouse(*view, QEvent::MouseButtonRelease, pixel(points_mm.back()), Qt::LeftButton,
             Qt::NoButton);
  return {};
}

/// Chooses an item of a list; spaces of its text may be written as '-'.
Result<void> ScriptPlayer::choose(const ScriptLine& line) {
  const auto found = control(line.words[0]);
  if (!found) return found.error();
  auto* list = qobject_cast<QComboBox*>(*found);
  if (list == nullptr) return cannot("expected a list, found '" + line.words[0] + "'");
  QStringList items;
  for (int i = 0; i < list->count(); ++i) {
    const QString text = list->itemText(i);
    const QString wanted = QString::fromStdString(line.words[1]);
    if (text == wanted || QString(text).replace(QLatin1Char(' '), QLatin1Char('-')) == wanted) {
      list->setCurrentIndex(i);
      emit list->activated(i);
      return {};
    }
    items.append(text);
  }
  return cannot("expected one of " + items.join(QStringLiteral(", ")).toStdString() + ", found '" +
                line.words[1] + "'");
}

/// Sets a slider, 0 to 1, or a number field.
Result<void> ScriptPlayer::set(const ScriptLine& line) {
  const auto found = control(line.words[0]);
  if (!found) return found.error();
  auto* slider = qobject_cast<QSlider*>(*found);
  auto* number = qobject_cast<QDoubleSpinBox*>(*found);
  if (slider != nullptr) {
    const auto share = script_number(line.words[1], 0, 1);
    if (!share) return share.error();
    slider->setValue(static_cast<int>(std::lround(*share * kSliderSteps)));
    return {};
  }
  if (number == nullptr) {
    return cannot("expected a slider or a number field, found '" + line.words[0] + "'");
  }
  const auto value = script_number(line.words[1], number->minimum(), number->maximum());
  if (!value) return value.error();
  number->setValue(*value);
  return {};
}

/// Replaces the text of a field by keys; spaces between words are single.
Result<void> ScriptPlayer::type(const ScriptLine& line) {
  const auto found = control(line.words[0]);
  if (!found) return found.error();
  auto* field = qobject_cast<QLineEdit*>(*found);
  if (field == nullptr) return cannot("expected a text field, found '" + line.words[0] + "'");
  std::string text;
  for (std::size_t i = 1; i < line.words.size(); ++i) text += (i > 1 ? " " : "") + line.words[i];
  field->setFocus();
  field->clear();
  for (const QChar letter : QString::fromStdString(text)) {
    QKeyEvent event(QEvent::KeyPress, Qt::Key_unknown, Qt::NoModifier, QString(letter));
    QApplication::sendEvent(field, &event);
  }
  return {};
}

Result<void> ScriptPlayer::drag(const ScriptLine& line) {
  if (line.words.size() == 2) {
    if (line.words[0].starts_with("histogram.")) return drag_bar(line);
    return cannot("expected DX and DY in pixels, found one number");
  }
  const auto found = control(line.words[0]);
  if (!found) return found.error();
  const auto dx = script_number(line.words[1], -10000, 10000);
  if (!dx) return dx.error();
  const auto dy = script_number(line.words[2], -10000, 10000);
  if (!dy) return dy.error();
  const std::string name = line.words.size() > 3 ? line.words[3] : "left";
  if (name != "left" && name != "middle" && name != "right") {
    return cannot("expected left, middle or right, found '" + name + "'");
  }
  const auto button = name == "left"     ? Qt::LeftButton
                      : name == "middle" ? Qt::MiddleButton
                                         : Qt::RightButton;
  QPointF at = QRectF((*found)->rect()).center();
  send_mouse(**found, QEvent::MouseButtonPress, at, button, button);
  for (int i = 0; i < kDragSteps; ++i) {
    at += QPointF(*dx, *dy) / kDragSteps;
    send_mouse(**found, QEvent::MouseMove, at, Qt::NoButton, button);
  }
  send_mouse(**found, QEvent::MouseButtonRelease, at, button, Qt::NoButton);
  return {};
}

Result<void> ScriptPlayer::wheel(const ScriptLine& line) {
  const auto found = control(line.words[0]);
  if (!found) return found.error();
  const auto notches = script_number(line.words[1], -1000, 1000);
  if (!notches) return notches.error();
  if (line.words.size() > 2 && line.words[2] != "ctrl") {
    return cannot("expected ctrl or nothing, found '" + line.words[2] + "'");
  }
  const auto keys = line.words.size() > 2 ? Qt::ControlModifier : Qt::NoModifier;
  const QPointF centre = QRectF((*found)->rect()).center();
  constexpr int kNotch = 120;
  QWheelEvent event(centre, (*found)->mapToGlobal(centre), QPoint(),
                    QPoint(0, static_cast<int>(*notches * kNotch)), Qt::NoButton, keys,
                    Qt::NoScrollPhase, false);
  QApplication::sendEvent(*found, &event);
  return {};
}

Result<void> ScriptPlayer::shoot(const std::string& name) {
  if (name.find_first_of("/\\") != std::string::npos || name.front() == '.') {
    return cannot("expected a name without a folder, found '" + name + "'");
  }
  const QString path = options_.shots_folder.isEmpty()
                           ? QString()
                           : QDir(options_.shots_folder)
                                 .filePath(QString::fromStdString(name) + QStringLiteral(".png"));
  // Compressing takes longer than the views may wait.
  shots_.push_back(std::async(std::launch::async, save_shot, name, window_.shot(), path));
  return {};
}

void ScriptPlayer::end(std::optional<Error> failure) {
  timer_.stop();
  for (auto& shot : shots_) {
    auto saved = shot.get();
    if (saved) {
      report_.shot(*std::move(saved));
    } else if (!failure) {
      failure = saved.error();
    }
  }
  done_(std::move(failure));
}

}  // namespace nav::app
