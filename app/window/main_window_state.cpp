// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <QDateTime>
#include <QDir>
#include <array>
#include <cmath>

#include "app/window/main_window.hpp"
#include "app/window/theme.hpp"
#include "app/window/window_controls.hpp"

namespace nav::app {
namespace {

QString word_of(StepState state) { return mark_of(state).section(QLatin1Char(' '), 1); }

QString word_of(const ViewWidget& view) {
  if (view.isHidden()) return QStringLiteral("hidden");
  if (view.judgement().covered) return QStringLiteral("covered");
  if (!view.view_image()) return QStringLiteral("drawing");
  return view.judgement().late ? QStringLiteral("late") : QStringLiteral("shown");
}

/// A position along one of the patient's axes: "S12.3". It belongs to the orthogonal slices.
QString position_text(double ct_mm, const char* positive, const char* negative) {
  const double mm = std::round(10 * ct_mm) / 10;
  return QLatin1String(mm < 0 ? negative : positive) + QString::number(std::abs(mm), 'f', 1);
}

}  // namespace

void MainWindow::update_steps() {
  const SessionNews& news = loop_.news();
  const SharedMoment& moment = loop_.newest();
  const bool failed = news.stage == SessionNews::Stage::kFailed;
  const bool running = news.stage == SessionNews::Stage::kRunning;
  const bool image = moment && moment->epoch.frame.has_value();
  const auto done = [&](bool is) { return is ? StepState::kDone : StepState::kToDo; };
  const bool loading = news.stage == SessionNews::Stage::kLoading && loop_.has_session();
  const StepState begun = failed && !moment ? StepState::kFailed
                          : loading         ? StepState::kBusy
                                            : done(running || moment);
  rail_->set_step(0, begun);
  const StepState waits = moment && moment->stored ? StepState::kToDo : StepState::kBusy;
  rail_->set_step(1, begun == StepState::kDone && !image ? waits : begun);
  rail_->set_step(2, done(image));
  rail_->set_step(3, done(moment && moment->epoch.placement.state == SafetyState::kValid));
  rail_->set_step(4, done(moment && moment->plan));
  rail_->set_step(5, loop_.judgement().guidance ? StepState::kBusy : StepState::kToDo);
}

void MainWindow::update_panel() {
  const auto index = static_cast<std::size_t>(step_);
  QString text = QStringLiteral("%1  %2\n").arg(step_ + 1).arg(QLatin1String(kStepNames[index]));
  const QString step = QString::fromLatin1(kStepNames[index]).toLower();
  bool any = false;
  for (const auto& [name, sentence] : loop_.news().facts) {
    if (step != QString::fromStdString(name)) continue;
    text += theme::plain(sentence) + QStringLiteral("\n");
    any = true;
  }
  if (step_ == 5) {
    const SharedMoment& moment = loop_.newest();
    text += moment && moment->plan
                ? QStringLiteral("Numbers show while needle and CT are valid.\n")
                : QStringLiteral("Numbers need a target and an entry: step 5, Plan.\n");
    any = true;
  }
  if (step_ == 3 && verdict_) {
    text += QStringLiteral("Verdict of the user: %1.\n").arg(QString::fromStdString(*verdict_));
  }
  if (step_ == kStepCount - 1) any = true;  // Its controls say what there is.
  if (!any) text += QStringLiteral("Nothing yet.\n");
  if (const RecordingStatus& recording = loop_.recording(); !recording.path.empty()) {
    text +=
        (recording.since ? QStringLiteral("Recording into %1\n") : QStringLiteral("Recorded: %1\n"))
            .arg(QString::fromStdString(recording.path.string()));
  }
  if (!mark_words_.isEmpty()) text += mark_words_ + QStringLiteral("\n");
  if (!record_words_.isEmpty()) text += record_words_ + QStringLiteral("\n");
  if (!snapshot_words_.isEmpty()) text += snapshot_words_;
  panel_->setText(text.trimmed());
}

QString MainWindow::stamped_file(const QString& suffix) const {
  const QDir folder(snapshot_folder_.isEmpty() ? QDir::currentPath() : snapshot_folder_);
  const QString stamp =
      QDateTime::currentDateTime().toString(QStringLiteral("yyyyMMdd-HHmmss-zzz"));
  return folder.filePath(QStringLiteral("sonde-%1.%2").arg(stamp, suffix));
}

void MainWindow::toggle_recording() {
  if (!has_devices_) {
    record_words_ = QStringLiteral("Only live devices can be recorded.");
    return update_panel();
  }
  if (loop_.recording().since) return loop_.record(std::nullopt);
  loop_.record(std::filesystem::path(stamped_file(QStringLiteral("mcap")).toStdString()));
}

void MainWindow::obey(const session::PressedButton& press) {
  switch (press.action) {
    case ButtonAction::kNone:
      return;
    case ButtonAction::kCapture:
      return take_snapshot();
    case ButtonAction::kFreeze:
      return rail_->freeze();
    case ButtonAction::kMark:
      break;
  }
  mark_words_ = QStringLiteral("Mark %1 at %2 s of the session")
                    .arg(++marks_)
                    .arg(to_seconds(press.acquired), 0, 'f', 1);
  if (!loop_.recording().since) {
    mark_words_ += QStringLiteral(", not recorded: no recording goes on (Ctrl+R)");
  }
  update_panel();
}

void MainWindow::take_snapshot() {
  const QImage image = shot();
  const QString path = stamped_file(QStringLiteral("png"));
  // Compressing takes long: not on the window's thread.
  writers_.emplace_back([this, image, path] {
    const bool saved = image.save(path, "PNG");
    QMetaObject::invokeMethod(
        this,
        [this, saved, path] {
          snapshot_words_ = saved
                                ? QStringLiteral("Snapshot: %1").arg(path)
                                : QStringLiteral("The snapshot could not be written: %1").arg(path);
          update_panel();
        },
        Qt::QueuedConnection);
  });
}

std::optional<QString> MainWindow::value(const QString& name) const {
  const QString kind = name.section(QLatin1Char('.'), 0, 0);
  const QString what = name.section(QLatin1Char('.'), 1);
  if (kind == QLatin1String("state")) {
    for (const InputStatus& input : status_->inputs()) {
      if (what == QString::fromStdString(input.name)) {
        return QString::fromLatin1(to_string(input.safety.state));
      }
    }
    return loop_.newest() ? std::nullopt : std::optional(QStringLiteral("lost"));
  }
  if (kind == QLatin1String("numeral")) {
    const QString text = numerals_->value(what);
    return text.isEmpty() ? std::nullopt : std::optional(text);
  }
  if (kind == QLatin1String("view")) {
    for (std::size_t i = 0; i < kViewCount; ++i) {
      const ViewWidget* one = view(static_cast<ViewId>(i));
      if (one->objectName() == what) return word_of(*one);
    }
    return std::nullopt;
  }
  if (kind == QLatin1String("slice")) return slice_value(what);
  if (kind == QLatin1String("histogram")) return histogram_value(what);
  if (kind == QLatin1String("transfer")) return transfer_value(what);
  if (kind == QLatin1String("cutaway")) return cutaway_value(what);
  if (kind == QLatin1String("camera")) return camera_value(what);
  if (kind == QLatin1String("plan")) return plan_value(what);
  if (name == QLatin1String("registration")) return QString::fromStdString(registration_.state());
  if (name == QLatin1String("registration.landmarks")) {
    return QString::number(registration_.landmarks());
  }
  if (name == QLatin1String("predicates")) return predicates_.state();
  if (name == QLatin1String("scene")) {
    const auto& view_image = scene_->view_image();
    const PixelSize size = scene_->pixel_size();
    const bool obeys = view_image && view_image->asked >= loop_.scene_number() &&
                       view_image->image.size() == QSize(size.width, size.height);
    if (!obeys) return QStringLiteral("behind");
    return view_image->refined ? QStringLiteral("full") : QStringLiteral("coarse");
  }
  if (name == QLatin1String("controls")) {
    QStringList cut;
    for (const io::Json& one : controls_of(*this)) {
      if (!one["clipped"].get<bool>() && !one["elided"].get<bool>()) continue;
      cut.push_back(QString::fromStdString(one["name"].get<std::string>()));
    }
    return cut.isEmpty() ? QStringLiteral("whole") : QStringLiteral("cut: ") + cut.join(", ");
  }
  if (name == QLatin1String("panel")) {
    constexpr std::array tools{"step", "predicates", "transfer", "cutaway"};
    return QString::fromLatin1(tools.at(static_cast<std::size_t>(tools_->chosen())));
  }
  if (kind == QLatin1String("step")) {
    const int step = what.toInt() - 1;
    if (step < 0 || step >= kStepCount) return std::nullopt;
    return word_of(rail_->step(step));
  }
  if (name == QLatin1String("session")) {
    if (!loop_.has_session()) return QStringLiteral("none");
    switch (loop_.news().stage) {
      case SessionNews::Stage::kLoading:
        return QStringLiteral("loading");
      case SessionNews::Stage::kRunning:
        // Its panels are reset when its first image is here.
        return shown_session_ == 0 ? QStringLiteral("loading") : QStringLiteral("running");
      case SessionNews::Stage::kFailed:
        return QStringLiteral("failed");
    }
  }
  if (name == QLatin1String("unsaved")) {
    return unsaved_ ? QStringLiteral("yes") : QStringLiteral("no");
  }
  if (name == QLatin1String("saved")) return QString::fromStdString(saved_);
  if (name == QLatin1String("recovery")) {
    return !recovery_->isHidden() ? QStringLiteral("offered")
           : restored_            ? QStringLiteral("restored")
                                  : QStringLiteral("none");
  }
  if (name == QLatin1String("job")) {
    constexpr std::array stages{"none", "running", "done", "failed", "cancelled"};
    return QString::fromLatin1(stages.at(static_cast<std::size_t>(loop_.job().stage)));
  }
  if (name == QLatin1String("frozen")) {
    return loop_.frozen() ? QStringLiteral("yes") : QStringLiteral("no");
  }
  if (name == QLatin1String("marks")) return QString::number(marks_);
  if (name == QLatin1String("recording")) {
    switch (loop_.recording().stage) {
      case RecordingStatus::Stage::kOff:
        return QStringLiteral("off");
      case RecordingStatus::Stage::kOn:
        return QStringLiteral("on");
      case RecordingStatus::Stage::kFailed:
        return QStringLiteral("failed");
    }
  }
  if (name == QLatin1String("text-scale")) {
    return QString::number(user_.text_scale, 'f', 2);
  }
  if (name == QLatin1String("second-screen")) {
    return second_->isVisible() ? QStringLiteral("shown") : QStringLiteral("hidden");
  }
  if (name == QLatin1String("second-views")) {
    QStringList views;
    for (const std::string& one : devices_->views()) views.push_back(QString::fromStdString(one));
    return views.isEmpty() ? QStringLiteral("layout") : views.join(QLatin1Char(','));
  }
  if (name == QLatin1String("keys")) {
    return keys_->isVisible() ? QStringLiteral("shown") : QStringLiteral("hidden");
  }
  if (name == QLatin1String("layout")) {
    constexpr std::array names{"guidance", "slices", "needle", "single"};
    return QString::fromLatin1(names[static_cast<std::size_t>(layout_)]);
  }
  return std::nullopt;
}

/// Components by name: greatest opacity and importance, "0.100/0.80".
std::optional<QString> MainWindow::transfer_value(const QString& what) const {
  if (what == QLatin1String("panel")) {
    return transfer_->is_open() ? QStringLiteral("open") : QStringLiteral("none");
  }
  if (!transfer_->is_open()) return std::nullopt;
  for (const auto& component : transfer_->editor()->components()) {
    if (QString::fromStdString(component.name) != what) continue;
    const render::TransferNode& node = render::most_opaque(component);
    return QStringLiteral("%1/%2").arg(QString::number(node.opacity, 'f', 3),
                                       QString::number(node.importance, 'f', 2));
  }
  return std::nullopt;
}

std::optional<QString> MainWindow::cutaway_value(const QString& what) const {
  if (!cutaway_->is_open()) return std::nullopt;
  const CutawaySettings& settings = cutaway_->settings();
  const auto degrees = [](double rad) { return QString::number(rad * 180 / M_PI, 'f', 1); };
  if (what == QLatin1String("on")) {
    return settings.cutaway.on ? QStringLiteral("yes") : QStringLiteral("no");
  }
  if (what == QLatin1String("theta1")) return degrees(settings.cutaway.theta1_rad);
  if (what == QLatin1String("theta2")) return degrees(settings.cutaway.theta2_rad);
  if (what == QLatin1String("overlay")) {
    return std::isinf(settings.cutaway.overlay_mm)
               ? QStringLiteral("inf")
               : QString::number(settings.cutaway.overlay_mm, 'f', 1);
  }
  if (what == QLatin1String("emphasis")) return QString::number(settings.emphasis, 'f', 2);
  if (what == QLatin1String("style")) {
    return settings.style == render::ShadingStyle::kGooch ? QStringLiteral("gooch")
                                                          : QStringLiteral("phong");
  }
  return std::nullopt;
}

/// Direction of the camera as letters of the patient, and the point that it looks at.
std::optional<QString> MainWindow::camera_value(const QString& what) const {
  const auto camera = loop_.camera();
  if (!camera) return std::nullopt;
  if (what == QLatin1String("letters")) {
    const ViewLetters letters = view_letters(*camera);
    return theme::plain(letters.left + "/" + letters.up);
  }
  if (what != QLatin1String("looks-at")) return std::nullopt;
  const Eigen::Vector3d at = camera->look_at_ct.mm;
  return QStringLiteral("%1,%2,%3")
      .arg(QString::number(at.x(), 'f', 1), QString::number(at.y(), 'f', 1),
           QString::number(at.z(), 'f', 1));
}

/// Importance of a bar by its name, and the whole of the set.
std::optional<QString> MainWindow::histogram_value(const QString& what) const {
  const render::PredicateEditor& editor = predicates_.editor();
  const auto& bars = editor.model().histogram.bars();
  if (what == QLatin1String("count")) return QString::number(bars.size());
  if (what == QLatin1String("strokes")) return QString::number(editor.strokes().size());
  if (what == QLatin1String("sum")) {
    constexpr double kSumError = 1e-9;
    double sum = 0;
    for (const auto& bar : bars) sum += bar.importance;
    return std::abs(sum - 1) < kSumError ? QStringLiteral("1") : QString::number(sum, 'g', 12);
  }
  if (what == QLatin1String("selected")) {
    if (!editor.selected()) return QStringLiteral("none");
    return theme::plain(editor.model().entries[*editor.selected()].name)
        .replace(QLatin1Char(' '), QLatin1Char('-'));
  }
  const HistogramBars* shown = &predicates_.page().bars();
  const auto bar = shown->find(what);
  if (!bar) return std::nullopt;
  return QString::number(bars[*bar].importance, 'f', 3);
}

std::optional<QString> MainWindow::slice_value(const QString& what) const {
  const SharedMoment& moment = loop_.newest();
  if (!moment) return std::nullopt;
  const SliceSettings& settings = loop_.slices();
  const SlicedVolume sliced = sliced_volume(settings, *moment);
  const Eigen::Vector3d cursor = cursor_of(settings, *moment).mm;
  if (what == QLatin1String("axial")) return position_text(cursor.z(), "S", "I");
  if (what == QLatin1String("coronal")) return position_text(cursor.y(), "P", "A");
  if (what == QLatin1String("sagittal")) return position_text(cursor.x(), "L", "R");
  if (what == QLatin1String("window")) {
    const render::HuWindow window = sliced.window;
    return QStringLiteral("%1/%2").arg(std::lround(window.level)).arg(std::lround(window.width));
  }
  if (what.startsWith(QLatin1String("zoom-"))) {
    for (const ViewId id : kFlatViews) {
      if (slice_of(id) && flat_[id]->objectName() == what.mid(5)) {
        return QString::number(settings.zoom[id].factor, 'f', 2);
      }
    }
  }
  return std::nullopt;
}

}  // namespace nav::app
