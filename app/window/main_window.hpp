// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QLabel>
#include <QTimer>
#include <QWidget>
#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "app/window/actions.hpp"
#include "app/window/arrangement.hpp"
#include "app/window/cutaway_page.hpp"
#include "app/window/devices_page.hpp"
#include "app/window/patient_page.hpp"
#include "app/window/plan_page.hpp"
#include "app/window/predicate_desk.hpp"
#include "app/window/rail.hpp"
#include "app/window/refresh_loop.hpp"
#include "app/window/registration_desk.hpp"
#include "app/window/second_screen.hpp"
#include "app/window/session_keeper.hpp"
#include "app/window/session_page.hpp"
#include "app/window/step_page.hpp"
#include "app/window/tool_deck.hpp"
#include "app/window/transfer_page.hpp"
#include "app/window/window_memory.hpp"

namespace nav::app {

/// Title of a window that shows a session: its kind, SIMULATED, RECORDING or LIVE, stands in it.
QString session_title(const SessionConfig& config);

/// The one window: rail, views, numbers, panel of the step, states of the inputs.
class MainWindow final : public QWidget {
 public:
  struct Options {
    RefreshLoop::Options loop;
    QString title = QStringLiteral("Sonde");
    QString snapshot_folder{};  ///< Also of recordings. Empty: the folder in which the program was
                                ///< started.
    std::filesystem::path session_file{};  ///< File of the session; empty: it has none yet.
    std::filesystem::path state_folder{};  ///< Folder of recovery files; empty: none are written.
    UserSettings user{};
    std::filesystem::path settings_folder{};  ///< Folder of user; empty: changes are not kept.
  };
  /// Clock, console and report must outlive it.
  MainWindow(const Options& options, const Clock& clock, Console& console, WindowReport& report);
  ~MainWindow() override;

  /// Starts the session and the engines.
  void start();
  void stop();
  /// The recovery file of unsaved changes stays after stop(), for the next window: the user has
  /// closed this one. Otherwise it goes.
  void keep_recovery(bool keep) { keeps_recovery_ = keep; }
  /// The session as it is now, with the state of the window.
  [[nodiscard]] SessionConfig session_now() const;
  /// Opens another session; the one that is shown stays until it is complete. file: of the session;
  /// changed: it differs from that file.
  void open_session(const SessionConfig& config, const std::filesystem::path& file, bool changed);
  [[nodiscard]] RefreshLoop& loop() { return loop_; }
  [[nodiscard]] const PredicateDesk& predicates() const { return predicates_; }
  [[nodiscard]] const Actions& actions() const { return actions_; }
  [[nodiscard]] const Rail& rail() const { return *rail_; }
  [[nodiscard]] const Numerals& numerals() const { return *numerals_; }
  /// State of a thing by its stable name, as scripts read it: "state.ultrasound", "numeral.tip",
  /// "view.scene", "step.4", "session", "frozen", "marks", "recording", "layout". Absent: there is
  /// no such thing.
  [[nodiscard]] std::optional<QString> value(const QString& name) const;
  /// Runs the action of a key, whichever control has the focus. True: the key has one.
  bool press(const QKeyEvent& event) { return actions_.press(event, clock_.now()); }
  /// Scrolls the open panel until a control of it can be seen. Null: arranges all controls anew,
  /// after their texts have changed.
  void show_control(QWidget* control);
  /// The window as it is painted now.
  [[nodiscard]] QImage shot();

 private:
  void resizeEvent(QResizeEvent* event) override;
  void paintEvent(QPaintEvent* event) override;
  void add_actions();
  void arrange();
  void choose_step(int step);
  /// Panels of the tool deck, in order.
  enum class Tool { kStep, kPredicates, kTransfer, kCutaway };
  /// Opens the panel of a tool; again: that of the step.
  void choose_tool(Tool tool);
  [[nodiscard]] Tool tool() const { return static_cast<Tool>(tools_->chosen()); }
  void push_edits();
  void undo(bool forth);
  /// Opens the panels of the first moment of a session.
  void open_panels(const Moment& moment);
  [[nodiscard]] std::optional<QString> transfer_value(const QString& what) const;
  [[nodiscard]] std::optional<QString> camera_value(const QString& what) const;
  [[nodiscard]] std::optional<QString> cutaway_value(const QString& what) const;
  [[nodiscard]] std::optional<QString> histogram_value(const QString& what) const;
  void tick();
  void set_layout(WindowLayout layout);
  /// Shows one view alone, or goes back if it is shown alone.
  void enlarge(ViewId id);
  [[nodiscard]] ViewWidget* view(ViewId id) const;
  [[nodiscard]] ViewId view_under_mouse() const;
  /// Position of the cursor, grey window and zoom of the slices, as scripts read them.
  [[nodiscard]] std::optional<QString> slice_value(const QString& what) const;
  void toggle_full_screen();
  void toggle_second_screen();
  /// The views that the second screen shows, and draws also where they are hidden here.
  [[nodiscard]] std::vector<SecondScreen::Mirrored> second_views() const;
  void arrange_second_screen();
  /// Adds to the factor of all texts, and keeps it for the user.
  void scale_texts(double change);
  void set_text_scale(double scale);
  void toggle_keys();
  void take_snapshot();
  /// Starts or ends a recording of live devices.
  void toggle_recording();
  /// File of this moment in the folder of snapshots.
  [[nodiscard]] QString stamped_file(const QString& suffix) const;
  /// Does what a button of a device is for.
  void obey(const session::PressedButton& press);
  void update_steps();
  void update_panel();
  void cancel();

  // The session as a file: main_window_session.cpp.
  SessionKeeper::Hears keeper_hears();
  [[nodiscard]] PerView<std::string> view_names() const;
  [[nodiscard]] WindowState state() const;
  [[nodiscard]] std::string set_text() const;
  void restore_state(const WindowState& state);
  void restore_edits(const WindowState& state);
  void begin_session(const Moment& moment);
  void save_session(bool replace);
  void take_saved(const SessionKeeper::Saved& saved);
  void look_at_session();
  void answer_recovery(bool restore);
  void show_title();

  // The steps that act: main_window_steps.cpp.
  void add_steps();
  [[nodiscard]] RegistrationDesk::Hears registration_hears();
  [[nodiscard]] std::optional<Point<frames::Ct>> cursor() const;
  [[nodiscard]] SessionConfig config_to_register() const;
  void judge(const RegistrationCandidate& candidate, bool accepted);
  void keep_rejected(const Moment& moment);
  void open_ct();
  void show_job();
  void open_steps(const Moment& moment);
  void use_plan();
  void check_plan();
  void show_pick();
  void show_handles();
  [[nodiscard]] std::optional<QString> plan_value(const QString& what) const;

  const Clock& clock_;
  WindowReport& report_;
  QString title_;
  QString snapshot_folder_;
  bool has_devices_;  ///< Live devices, which can be recorded.
  Rail* rail_;
  SceneWidget* scene_;
  PerView<FlatWidget*> flat_;
  Numerals* numerals_;
  StatusLines* status_;
  ToolDeck* tools_;
  QLabel* panel_;
  QLabel* keys_;
  SecondScreen* second_;
  RefreshLoop loop_;
  SceneEdits edits_;
  PredicateDesk predicates_;
  TransferPage* transfer_;
  CutawayPage* cutaway_;
  StepPage* step_page_;
  SessionPage* session_page_;
  RecoveryBar* recovery_;
  DevicesPage* devices_;
  PatientPage* patient_;
  RegistrationPage* registration_page_;
  PlanPage* plan_;
  RegistrationDesk registration_;
  std::atomic<std::uint64_t> plan_check_ = 0;  ///< Counts the checks of the path.
  std::uint64_t shown_session_ = 0;  ///< Moment::session of what is shown; 0: nothing yet.
  SessionConfig config_;             ///< The session that is shown.
  std::filesystem::path session_file_;
  /// A session that is being opened.
  struct Opening {
    SessionConfig config;
    std::filesystem::path file;
    bool changed;
  };
  std::optional<Opening> opening_;
  KeptText kept_transfer_, kept_predicates_, kept_strokes_;
  std::optional<std::string> verdict_;  ///< WindowState::verdict.
  bool unsaved_ = false;
  bool restored_ = false;  ///< From a recovery file.
  bool keeps_recovery_ = false;
  std::string saved_ = "no";  ///< End of the last order to save.
  QTimer looks_;
  Actions actions_;
  QTimer watchdog_;
  WindowLayout layout_ = WindowLayout::kGuidance;
  WindowLayout before_single_ = WindowLayout::kGuidance;
  ViewId single_ = ViewId::kScene;  ///< View that fills the window in the layout single.
  bool with_rail_ = true;
  UserSettings user_;
  std::filesystem::path settings_folder_;
  /// Positions of the views that were chosen for the second screen; absent: those of this window.
  std::optional<Arrangement> on_second_;
  int rail_width_ = 0;  ///< Width that it has.
  int tool_width_ = 0;  ///< That the open panel asked for.
  int step_ = 5;
  SessionKeeper keeper_;
  std::vector<std::jthread> checkers_;
  QString snapshot_words_, record_words_, mark_words_;
  int marks_ = 0;
  std::vector<std::jthread> writers_;  ///< Write snapshots; joined first.
};

}  // namespace nav::app
