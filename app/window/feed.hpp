// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/console.hpp"
#include "app/verbs/placed_view.hpp"
#include "app/window/moment.hpp"
#include "app/window/window_recorder.hpp"
#include "session/driver.hpp"
#include "session/session.hpp"

namespace nav::app {

/// A session as the window plays it: a recording, the simulator or live devices, each by session/.
/// One thread calls it.
class Feed {
 public:
  virtual ~Feed() = default;

  /// The next epoch once it is due, on the window's clock; absent: none is due now.
  virtual Result<std::optional<session::Epoch>> next(Timestamp now) = 0;
  /// The epoch that is shown, as it is by now, with newer poses where the session has them.
  [[nodiscard]] virtual session::Epoch again(session::Epoch epoch, Timestamp now) = 0;
  /// The window's time of a session time.
  [[nodiscard]] virtual Timestamp on_clock(Timestamp session_time) const = 0;
  /// True when nothing more comes.
  [[nodiscard]] virtual bool over() const = 0;
  /// Ends the session: counts what was not shown. Idempotent.
  virtual void finish() = 0;
  /// After finish(): a device that failed or gave nothing, as an error of exit code 4; else ok.
  [[nodiscard]] virtual Result<void> outcome() const { return {}; }
  /// For a time, the tracker does not see the markers. False: the session cannot do it.
  virtual bool cover_marker(Duration) { return false; }
  /// For a time, no image arrives. False: the session cannot do it.
  virtual bool hold_images(Duration) { return false; }
  /// Starts a recording of the devices, see WindowRecorder::start(). kUsage: the session has none.
  virtual Result<void> start_recording(const std::filesystem::path& path);
  /// Name of the patient's frame, to which a registration belongs.
  [[nodiscard]] virtual std::string reference_frame() { return "Reference"; }
  /// Replaces the plan.
  void set_plan(const NeedlePlan& plan) {
    view().set_plan(plan);
    session().navigator().set_plan(plan);
  }
  /// Replaces the placement of the CT, as the user has moved it.
  void set_placement(const session::Placement& placement) {
    view().set_placement(placement);
    session().navigator().set_placement(placement.placement);
  }
  /// Records the devices; null: the session has none.
  virtual WindowRecorder* recorder() { return nullptr; }

  /// Buttons that were pressed since the last call.
  virtual std::vector<session::PressedButton> take_presses() { return {}; }
  /// All of them, as reports give them; after finish().
  [[nodiscard]] virtual io::Json presses() { return io::Json::array(); }

  /// First camera of the 3D view; absent: the presenter's.
  [[nodiscard]] virtual std::optional<render::Camera> camera() const { return std::nullopt; }
  /// True for a stored volume, which has no live images.
  [[nodiscard]] virtual bool stored() const { return false; }

  [[nodiscard]] virtual session::Session& session() = 0;
  [[nodiscard]] virtual PlacedView& view() = 0;
  /// Sentence that stands in the last line all the while; may be empty.
  [[nodiscard]] virtual std::string notice() const { return {}; }
  /// Kind of the session: "SIMULATED", "RECORDING", "LIVE", "STORED VOLUME", "CT ALONE".
  [[nodiscard]] virtual std::string kind() const = 0;
  /// Sentence when nothing more comes.
  [[nodiscard]] virtual std::string ended() const = 0;
  /// Facts for the steps of the window, one sentence each: step and sentence.
  [[nodiscard]] virtual std::vector<std::pair<std::string, std::string>> facts() = 0;
};

/// A recording at its own pace. loop: it begins again at its end. The configuration must outlive
/// the feed, here and below. Errors: those of a replay.
Result<std::unique_ptr<Feed>> open_recorded_feed(const SessionConfig& config, bool loop,
                                                 Console& console);

/// The devices of a session file; output.record: also recorded from the first sample on. Errors:
/// those of a live session and of WindowRecorder::start(). The clock must outlive the feed.
Result<std::unique_ptr<Feed>> open_live_feed(const SessionConfig& config, const Clock& clock,
                                             Console& console);

/// The simulated procedure: a sweep, then a needle that approaches a lesion, again and again. The
/// CT is placed by the truth of the simulation. No file is read.
Result<std::unique_ptr<Feed>> open_simulated_feed(const SessionConfig& config, const Clock& clock,
                                                  Console& console);

/// 3D ultrasound alone, drawn by predicates: the volume or phantom of the configuration's
/// predicates. Errors: those of prepare_predicates().
Result<std::unique_ptr<Feed>> open_volume_feed(const SessionConfig& config, Console& console);
/// A CT alone, without recording and devices: to look at it and to plan. Errors: those of
/// PlacedView::prepare().
Result<std::unique_ptr<Feed>> open_ct_feed(const SessionConfig& config, Console& console);
/// True for a configuration of 3D ultrasound alone: no recording, no CT.
bool shows_volume_alone(const SessionConfig& config);

/// Opens the kind that the configuration asks for.
Result<std::unique_ptr<Feed>> open_feed(const SessionConfig& config, bool loop, const Clock& clock,
                                        Console& console);

/// Gives what is known of the recording of an image; null: nothing.
using RecordingOf = std::function<session::RecordingRead(const UltrasoundImage&)>;

/// Hands the paired images of a session to its view; the first one decides the placement.
session::Session::Listener placing_listener(PlacedView& view, session::Session& session,
                                            std::optional<Error>& failure,
                                            RecordingOf recording = nullptr);

}  // namespace nav::app
