// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QLabel>
#include <QTimer>
#include <QWidget>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "app/window/actions.hpp"
#include "app/window/arrangement.hpp"
#include "app/window/cutaway_page.hpp"
#include "app/window/predicate_desk.hpp"
#include "app/window/rail.hpp"
#include "app/window/refresh_loop.hpp"
#include "app/window/tool_deck.hpp"
#include "app/window/transfer_page.hpp"

namespace nav::app {

/// The one window: rail, views, numbers, panel of the step, states of the inputs.
class MainWindow final : public QWidget {
 public:
  struct Options {
    RefreshLoop::Options loop;
    QString title = QStringLiteral("Sonde");
    QString snapshot_folder{};  ///< Also of recordings. Empty: the folder in which the program was
                                ///< started.
  };
  /// Clock, console and report must outlive it.
  MainWindow(const Options& options, const Clock& clock, Console& console, WindowReport& report);
  ~MainWindow() override;

  /// Starts the session and the engines.
  void start();
  void stop();
  [[nodiscard]] RefreshLoop& loop() { return loop_; }
  [[nodiscard]] const PredicateDesk& predicates() const { return predicates_; }
  [[nodiscard]] const Actions& actions() const { return actions_; }
  [[nodiscard]] const Rail& rail() const { return *rail_; }
  [[nodiscard]] const Numerals& numerals() const { return *numerals_; }
  /// State of a thing by its stable name, as scripts read it: "state.ultrasound", "numeral.tip",
  /// "view.scene", "step.4", "session", "frozen", "recording", "layout". Absent: there is no such
  /// thing.
  [[nodiscard]] std::optional<QString> value(const QString& name) const;
  /// Runs the action of a key, whichever control has the focus. True: the key has one.
  bool press(const QKeyEvent& event) { return actions_.press(event, clock_.now()); }
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
  void toggle_keys();
  void take_snapshot();
  /// Starts or ends a recording of live devices.
  void toggle_recording();
  /// File of this moment in the folder of snapshots.
  [[nodiscard]] QString stamped_file(const QString& suffix) const;
  void update_steps();
  void update_panel();
  void cancel();

  const Clock& clock_;
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
  RefreshLoop loop_;
  SceneEdits edits_;
  PredicateDesk predicates_;
  TransferPage* transfer_;
  CutawayPage* cutaway_;
  bool opened_ = false;  ///< The first moment of the session has come.
  Actions actions_;
  QTimer watchdog_;
  WindowLayout layout_ = WindowLayout::kGuidance;
  WindowLayout before_single_ = WindowLayout::kGuidance;
  ViewId single_ = ViewId::kScene;  ///< View that fills the window in the layout single.
  bool with_rail_ = true;
  int step_ = 5;
  QString snapshot_words_, record_words_;
  std::vector<std::jthread> writers_;  ///< Write snapshots; joined first.
};

}  // namespace nav::app
