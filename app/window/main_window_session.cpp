// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The session as a file: saving, reopening, and recovery of unsaved changes.
#include <QApplication>
#include <algorithm>
#include <array>

#include "app/appearance/appearance_file.hpp"
#include "app/predicates/predicate_scribbles.hpp"
#include "app/window/main_window.hpp"
#include "app/window/theme.hpp"

namespace nav::app {
namespace {

constexpr std::array kLayoutNames{"guidance", "slices", "needle", "single"};
constexpr std::array kToolNames{"step", "predicates", "transfer", "cutaway"};

template <class Names>
int place_of(const Names& names, const std::string& name) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (name == names[i]) return static_cast<int>(i);
  }
  return 0;
}

/// Runs a call on the window's thread, from any thread.
template <class Call>
void on_window(QObject* window, Call call) {
  QMetaObject::invokeMethod(window, std::move(call), Qt::QueuedConnection);
}

}  // namespace

QString session_title(const SessionConfig& config) {
  using Kind = SessionConfig::SourceKind;
  QString title = QStringLiteral("Sonde");
  if (shows_volume_alone(config)) {
    return title + (config.predicates.volume.empty() ? QStringLiteral(" – SIMULATED VOLUME")
                                                     : QStringLiteral(" – STORED VOLUME"));
  }
  if (config.source.kind == Kind::kRecording && config.source.recording.empty()) {
    return title + QStringLiteral(" – CT ALONE");
  }
  title += config.source.kind == Kind::kSimulated   ? QStringLiteral(" – SIMULATED")
           : config.source.kind == Kind::kRecording ? QStringLiteral(" – RECORDING")
                                                    : QStringLiteral(" – LIVE");
  const bool simulates = std::ranges::any_of(
      config.source.devices, [](const auto& device) { return device.kind == "simulated"; });
  if (config.source.kind == Kind::kLive && simulates)
    title += QStringLiteral(" (SIMULATED DEVICE)");
  return title + QStringLiteral(" – research software, not a medical device");
}

SessionKeeper::Hears MainWindow::keeper_hears() {
  return {.saved =
              [this](SessionKeeper::Saved saved) {
                on_window(this, [this, saved = std::move(saved)] { take_saved(saved); });
              },
          .unsaved =
              [this](bool unsaved) {
                on_window(this, [this, unsaved] {
                  unsaved_ = unsaved;
                  show_title();
                });
              },
          .offer =
              [this](std::string words) {
                on_window(this, [this, words = std::move(words)] {
                  recovery_->say(theme::plain(words));
                  arrange();
                });
              },
          .restored =
              [this](SessionConfig config, std::filesystem::path file) {
                on_window(this, [this, config = std::move(config), file = std::move(file)] {
                  restored_ = true;
                  open_session(config, file, true);
                });
              },
          .failed =
              [this](std::string words) {
                on_window(this, [this, words = std::move(words)] {
                  session_page_->say(theme::plain(words), false);
                });
              }};
}

PerView<std::string> MainWindow::view_names() const {
  PerView<std::string> names;
  for (std::size_t i = 0; i < kViewCount; ++i) {
    const auto id = static_cast<ViewId>(i);
    names[id] = view(id)->objectName().toStdString();
  }
  return names;
}

WindowState MainWindow::state() const {
  WindowState state;
  const PerView<std::string> names = view_names();
  state.layout = kLayoutNames.at(static_cast<std::size_t>(layout_));
  if (layout_ == WindowLayout::kSingle) {
    state.layout_before = kLayoutNames.at(static_cast<std::size_t>(before_single_));
    state.single = names[single_];
  }
  state.step = step_ + 1;
  state.panel = kToolNames.at(static_cast<std::size_t>(tool()));
  state.second_views = devices_->views();
  state.verdict = verdict_;
  if (const auto& camera = loop_.chosen_camera()) state.camera = saved_camera(*camera);
  save_slices(loop_.slices(), names, state);
  if (edits_.cutaway) state.cutaway = saved_cutaway(cutaway_->settings());
  if (edits_.transfer) {
    state.transfer = kept_transfer_.text_of(to_json_text(AppearanceFile{
        .transfer = *edits_.transfer, .shading = {}, .cutaway = {}, .value_range = {}}));
  }
  if (!predicates_.has_volume()) return state;
  const render::PredicateEditor& editor = predicates_.editor();
  if (editor.selected()) state.predicate = static_cast<int>(*editor.selected()) + 1;
  if (editor.revision() == 0) return state;
  state.predicate_set = kept_predicates_.text_of(set_text());
  if (!editor.strokes().empty()) {
    state.strokes = kept_strokes_.text_of(to_json_text(editor.strokes()));
  }
  return state;
}

std::string MainWindow::set_text() const {
  PredicateFile file{"window", predicates_.editor().before_strokes()};
  return file.model.entries.empty() ? std::string("none") : to_json_text(file);
}

void MainWindow::restore_state(const WindowState& state) {
  if (!state.is_saved()) return;
  const PerView<std::string> names = view_names();
  layout_ = static_cast<WindowLayout>(place_of(kLayoutNames, *state.layout));
  if (state.single) {
    before_single_ = static_cast<WindowLayout>(place_of(kLayoutNames, *state.layout_before));
    single_ = static_cast<ViewId>(place_of(names.all, *state.single));
  }
  verdict_ = state.verdict;
  devices_->set_views(state.second_views);
  if (state.step) step_ = *state.step - 1;
  rail_->choose(step_);
  step_page_->choose(step_);
  loop_.set_slices(slices_of(state, names));
  if (state.camera.eye_mm) loop_.set_camera(camera_of(state.camera));
  restore_edits(state);
  choose_tool(static_cast<Tool>(place_of(kToolNames, state.panel.value_or("step"))));
  update_panel();
}

void MainWindow::restore_edits(const WindowState& state) {
  const auto complain = [this](const Error& error) {
    session_page_->say(theme::plain("Not restored: " + error.message), false);
  };
  if (state.transfer && transfer_->is_open()) {
    const auto file = parse_appearance_text("window.transfer", *state.transfer);
    const auto taken = file ? transfer_->restore(file->transfer) : Result<void>(file.error());
    if (!taken) {
      complain(taken.error());
    } else {
      kept_transfer_ = {
          *state.transfer,
          to_json_text(AppearanceFile{
              .transfer = file->transfer, .shading = {}, .cutaway = {}, .value_range = {}})};
    }
  }
  if (state.cutaway.enabled) cutaway_->restore(cutaway_of(state.cutaway));
  if (!predicates_.has_volume()) return;
  if (state.predicate_set) {
    auto file = *state.predicate_set == "none"
                    ? Result<PredicateFile>(PredicateFile{})
                    : parse_predicate_text("window.predicate_set", *state.predicate_set);
    auto strokes = state.strokes ? parse_scribble_text("window.strokes", *state.strokes)
                                 : Result<std::vector<render::features::Stroke>>(
                                       std::vector<render::features::Stroke>());
    if (!file || !strokes) return complain(!file ? file.error() : strokes.error());
    predicates_.restore(std::move(file->model), *strokes);
    kept_predicates_ = {*state.predicate_set, set_text()};
    if (state.strokes) kept_strokes_ = {*state.strokes, to_json_text(*strokes)};
  }
  if (state.predicate) predicates_.choose(static_cast<std::size_t>(*state.predicate) - 1);
}

SessionConfig MainWindow::session_now() const {
  SessionConfig now = config_;
  now.file = session_file_;
  now.window = state();
  return now;
}

void MainWindow::open_session(const SessionConfig& config, const std::filesystem::path& file,
                              bool changed) {
  opening_ = Opening{config, file, changed};
  loop_.open(config);
}

/// The first moment of a session: it is complete, and replaces the one before.
void MainWindow::begin_session(const Moment& moment) {
  if (opening_) {
    config_ = opening_->config;
    session_file_ = opening_->file;
    title_ = session_title(config_);
    has_devices_ = config_.source.kind == SessionConfig::SourceKind::kLive;
    rail_->can_record(has_devices_);
    keeper_.opened(session_file_, opening_->changed);
    opening_.reset();
    edits_ = {};
    loop_.reset_camera();
    loop_.reset_slices();
    push_edits();
  }
  kept_transfer_ = kept_predicates_ = kept_strokes_ = {};
  verdict_.reset();
  session_page_->set_path(QString::fromStdString(session_file_.string()));
  predicates_.follow(moment.predicates);
  open_panels(moment);
  open_steps(moment);
  restore_state(config_.window);
  // Changes from now on are unsaved.
  look_at_session();
  show_job();
  show_title();
}

void MainWindow::save_session(bool replace) {
  const std::string text = session_page_->path().trimmed().toStdString();
  const std::filesystem::path path = text.empty() ? session_file_ : std::filesystem::path(text);
  if (!shown_session_) {
    return session_page_->say(QStringLiteral("There is no session to save yet."), false);
  }
  if (path.empty()) {
    choose_step(kStepCount - 1);
    return session_page_->say(QStringLiteral("Give the session a file name, then Save."), false);
  }
  session_page_->say(QStringLiteral("Saving…"), false);
  SessionConfig now = session_now();
  keeper_.save(std::move(now), path, replace);
}

void MainWindow::take_saved(const SessionKeeper::Saved& saved) {
  using End = SessionKeeper::Saved::End;
  saved_ = saved.end == End::kDone ? "yes" : saved.end == End::kAsks ? "asks" : "failed";
  session_page_->say(theme::plain(saved.words), saved.end == End::kAsks);
  if (saved.end == End::kDone) {
    session_file_ = saved.path;
    session_page_->set_path(QString::fromStdString(saved.path.string()));
    show_title();
  } else if (step_ != kStepCount - 1 || tool() != Tool::kStep) {
    choose_step(kStepCount - 1);
  }
}

void MainWindow::look_at_session() {
  if (shown_session_ && !opening_) keeper_.look(session_now(), session_file_);
}

void MainWindow::answer_recovery(bool restore) {
  if (!restore) return keeper_.discard();
  if (unsaved_) {
    return session_page_->say(
        QStringLiteral("This window has unsaved changes: save them before you restore others."),
        false);
  }
  keeper_.restore();
}

void MainWindow::show_title() {
  QString title = title_;
  if (!session_file_.empty()) {
    title += QStringLiteral(" – ") + theme::plain(session_file_.filename().string());
  }
  if (unsaved_) title += QStringLiteral(" (not saved)");
  setWindowTitle(title);
}

}  // namespace nav::app
