// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <QObject>
#include <functional>
#include <optional>
#include <string>

#include "app/console.hpp"
#include "app/window/assembler.hpp"
#include "app/window/flat_engine.hpp"
#include "app/window/flat_widget.hpp"
#include "app/window/judgement.hpp"
#include "app/window/numerals.hpp"
#include "app/window/scene_engine.hpp"
#include "app/window/scene_widget.hpp"
#include "app/window/session_thread.hpp"
#include "app/window/slice_control.hpp"
#include "app/window/status_lines.hpp"
#include "app/window/window_report.hpp"

namespace nav::app {

/// Widgets that show a session.
struct SessionViews {
  SceneWidget* scene;
  PerView<FlatWidget*> flat;  ///< Null for the 3D view.
  Numerals* numerals;
  StatusLines* status;
};

/// Brings the moments of a session to the widgets: orders images from the engines, shows those of
/// one moment together, and watches over what they are worth. Lives on the window's thread; the
/// session and each engine have a thread of their own.
class RefreshLoop final : public QObject {
 public:
  struct Options {
    SessionConfig config;
    std::string engine = "auto";
    bool loop = true;
    bool has_session = true;
  };
  /// Clock, console, report and widgets must outlive it.
  RefreshLoop(const Options& options, const Clock& clock, Console& console, WindowReport& report,
              const SessionViews& views);
  ~RefreshLoop() override { stop(); }

  void start();
  /// Joins all threads. Idempotent.
  void stop();

  void move_camera(const render::CameraMovement& movement);
  void reset_camera();
  /// The camera that the user has chosen; absent: the session's.
  [[nodiscard]] const std::optional<render::Camera>& chosen_camera() const { return camera_; }
  /// The camera of the 3D view; absent before the first moment.
  [[nodiscard]] std::optional<render::Camera> camera() const;
  void set_camera(const render::Camera& camera);
  /// Changes of the user to the 3D scene; null: none.
  void set_edits(std::shared_ptr<const SceneEdits> edits);
  [[nodiscard]] const std::shared_ptr<const SceneEdits>& edits() const { return edits_; }
  /// The orthogonal slices show the 3D ultrasound, or the CT.
  void show_ultrasound_slices(bool shown);
  /// Moves the slices of a view as the user does.
  void move_slices(ViewId id, const SliceInput& input, const ViewImage& seen);
  /// Cursor, zooms and grey window of the slices as at the beginning.
  void reset_slices();
  /// Tells which views are on the screen: orders their images, and forgets those of the others.
  void views_changed();
  /// Tells which views another screen shows: they are drawn also where they are hidden here.
  void set_mirrored(const PerView<bool>& views);
  /// Keeps what is on the screen, as frozen, until the next call.
  void set_frozen(bool frozen);
  [[nodiscard]] bool frozen() const { return frozen_.has_value(); }
  /// Orders images of the newest moment in the sizes of the views.
  void order_images();
  /// Switches a fault on for a time: "cover-marker" and "hold-images" of a simulated session,
  /// "hang-engine", "hang-views" and "hang-session" of the window's threads.
  /// False: there is none of that name.
  bool fault(const std::string& name, Duration time);
  /// Sessions, plans and placements as in SessionThread.
  void open(const SessionConfig& config);
  void cancel_opening() { session_.cancel_opening(); }
  void set_plan(const NeedlePlan& plan) { session_.set_plan(plan); }
  /// The plan or its structures have changed: distances from the old ones are withdrawn. The new
  /// ones follow by another call with the same number.
  void set_structures(const StructureOrder& order) {
    structures_ = order.number;
    session_.set_structures(order);
  }
  void set_placement(const session::Placement& placement) { session_.set_placement(placement); }
  [[nodiscard]] const JobNews& job() const { return job_; }
  /// Shows a job of another part of the window.
  void show_job(const JobNews& news);
  void set_overlay(const CtOverlay& overlay);
  /// Asked for each point that a click in the 3D view meets. True: it is taken; false, or none: the
  /// view looks at it.
  std::function<bool(const Point<frames::Ct>&)> looked;
  /// Cursor, zooms and grey windows of the slices, as they were saved.
  void set_slices(const SliceSettings& settings);
  /// Starts a recording of the devices into a file; absent: ends it.
  void record(RecordOrder order) { session_.record(std::move(order)); }
  /// Shows what has come, and judges what is on the screen. Called by a timer too: the watchdog.
  void tick();

  [[nodiscard]] bool has_session() const { return has_session_; }
  [[nodiscard]] const SessionNews& news() const { return news_; }
  [[nodiscard]] const RecordingStatus& recording() const { return recording_; }
  [[nodiscard]] const SharedMoment& newest() const { return newest_; }
  /// Number of the newest change of camera or scene; ViewImage::asked of the image that obeys it.
  [[nodiscard]] std::uint64_t scene_number() const { return camera_number_; }
  [[nodiscard]] const Judgement& judgement() const { return judgement_; }
  [[nodiscard]] const SliceSettings& slices() const { return slices_.settings(); }
  [[nodiscard]] const RefreshAssembler& assembler() const { return assembler_; }
  /// The first recording that failed, else a device that failed or gave nothing; after stop().
  [[nodiscard]] const Result<void>& recorded() const { return session_.recorded(); }
  /// Adds what the threads know to a report.
  void complete(io::Json& report) const;

  /// Called when the state of the session has changed.
  std::function<void()> changed;
  /// Called for each button of a device that was pressed.
  std::function<void(const session::PressedButton&)> pressed;

  // For tests and scripts.
  [[nodiscard]] SceneEngine& scene_engine() { return scene_engine_; }
  [[nodiscard]] FlatEngine& flat_engine() { return flat_engine_; }
  [[nodiscard]] SessionThread& session() { return session_; }

 private:
  struct Frozen {
    SharedMoment moment;
    Timestamp since;
  };
  struct Loss {
    Timestamp since;
    bool withdrawn = false;
    bool covered = false;
  };
  void take_all();
  void show(Assembled shown);
  void apply(const Judgement& judgement, Timestamp now);
  void measure(Timestamp now);
  void measure_painting();
  void order_scene(const SharedMoment& moment);
  void scene_changed();
  [[nodiscard]] bool views_agree() const;
  [[nodiscard]] bool is_drawn(ViewId id) const;
  void judge_frozen(Judgement& shown, Timestamp now);
  [[nodiscard]] SharedMoment wanted() const { return frozen_ ? frozen_->moment : newest_; }

  const Clock& clock_;
  WindowReport& report_;
  SessionViews views_;
  bool has_session_;
  Mailbox<SharedMoment> moments_;
  Mailbox<SessionNews> news_box_;
  Mailbox<RecordingStatus> recording_box_;
  Mailbox<JobNews> job_box_;
  Mailbox<FlatImages> flats_;
  Mailbox<ViewImage> scenes_;
  Mailbox<std::optional<Point<frames::Ct>>> looks_;
  Mailbox<std::string> scene_failures_, flat_failures_;
  FlatEngine flat_engine_;
  SceneEngine scene_engine_;
  SessionThread session_;
  RefreshAssembler assembler_;

  SessionNews news_;
  RecordingStatus recording_;
  JobNews job_;
  EngineFailures failures_;
  SharedMoment newest_, flat_moment_, scene_moment_;
  std::optional<Frozen> frozen_;
  PerView<bool> mirrored_{};
  Judgement judgement_;
  std::optional<render::Camera> camera_;
  std::shared_ptr<const SceneEdits> edits_;
  std::uint64_t camera_number_ = 0;
  std::optional<Timestamp> camera_asked_;
  SliceControl slices_;
  std::optional<Timestamp> slices_asked_;
  std::uint64_t structures_ = 0;  ///< Number of the newest change of plan and structures.
  std::optional<Loss> loss_;
  std::uint64_t latency_of_ = 0;  ///< Number of the image whose latency was measured last.
};

}  // namespace nav::app
