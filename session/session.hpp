// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "nav/diagnostics.hpp"
#include "nav/source.hpp"
#include "session/image_watch.hpp"
#include "session/navigator.hpp"
#include "session/outline_estimator.hpp"
#include "session/pose_log.hpp"
#include "session/stream_queue.hpp"
#include "tracking/clock_model.hpp"

namespace nav::session {

/// Fixed facts of a session.
struct SessionSetup {
  /// Absent: probe_from_pixels decides.
  std::optional<ProbeCalibration> calibration = std::nullopt;
  /// ImageToProbe of PLUS, pixels to mm, for devices that do not say where their images lie on the
  /// probe. It holds for images of the first image's size and pixel spacing; other images have no
  /// calibration.
  std::optional<Eigen::Matrix4d> probe_from_pixels = std::nullopt;
  /// Tip of the needle relative to the body that is tracked, mm. Absent: the body's origin is the
  /// tip.
  std::optional<Eigen::Matrix4d> body_from_tip = std::nullopt;
  /// Given when nothing tracks the patient: the tracker plays the reference.
  std::optional<Transform<frames::Reference, frames::Tracker>> fixed_reference = std::nullopt;
  NavigatorOptions navigator = {};
  /// Queue of the images of a live session; poses always use a lossless queue.
  QueuePolicy images = QueuePolicy::kNewestOnly;
  std::size_t queue_capacity = 1024;  ///< Samples of one lossless queue.
  /// For images of a scanner's screen: withdraws them while the screen shows another sector or
  /// depth than at first. Absent: the device says it.
  std::optional<ImageWatchOptions> image_watch = std::nullopt;
  /// Learns the sector of images that come without an outline.
  bool learn_outline = true;
  /// Live: hears of every sample as its source delivers it, before clock models and gates, on the
  /// source's thread. \p source counts in the order of add(). May be empty.
  std::function<void(std::size_t source, const Sample& sample)> tap = {};
};

/// Account of one stream of a session.
struct StreamAccount {
  StreamInfo info;
  tracking::StreamLedger ledger;
  StreamTiming::Summary timing;
};

/// A button that was pressed.
struct PressedButton {
  std::size_t source = 0;  ///< Number of its source, in the order of add().
  std::string button;      ///< Name of its stream.
  ButtonAction action = ButtonAction::kNone;
  Timestamp acquired{};  ///< Session clock.
};

/// Takes samples from sources through queues to the navigator, on one clock. The same code serves a
/// recording, a simulation and live devices:
///   - virtual: advance_to() pulls what arrives by a time, on the caller's thread. The same samples
///     give the same bits.
///   - live: start() gives each source a thread; take_in() hands over what has been queued.
/// A source whose thread fails is lost with its sentence; the others go on. Not thread-safe: one
/// thread calls the session.
class Session {
 public:
  /// Hears of every image and of every pressed button once, in order; any part may be empty.
  struct Listener {
    Listener() = default;
    template <std::invocable<const tracking::PairedImage&> F>
    Listener(F hears) : settled(std::move(hears)) {}  // NOLINT: a function is a listener.

    std::function<void(const tracking::PairedImage&)> settled;
    std::function<void(std::uint64_t sequence, const MissingImage&)> missing;
    std::function<void(const PressedButton&)> pressed;
  };

  /// \p diagnostics must outlive the session.
  Session(const SessionSetup& setup, Diagnostics& diagnostics);
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  /// Before the first sample. Sources are asked in the order in which they were added.
  void add(std::shared_ptr<Source> source);

  /// Virtual: arrival of the next sample of all sources; absent at their end. Errors of a source
  /// end the session.
  Result<std::optional<Timestamp>> next_arrival();
  /// Virtual: takes in every sample that arrives by \p time, then pairs what can be paired.
  Result<void> advance_to(Timestamp time, const Listener& listener = {});

  /// Live: starts one thread for each source. \p clock must outlive the session.
  void start(const Clock& clock);
  [[nodiscard]] bool live() const { return clock_ != nullptr; }
  /// Live: takes in what the threads have queued until now, then pairs what can be paired.
  void take_in(const Listener& listener = {});
  /// Live: stops and joins the threads. Idempotent.
  void stop() noexcept;

  /// True when no source has anything more.
  [[nodiscard]] bool ended() const;
  /// Ends the session: images that still wait are settled or superseded.
  void finish(const Listener& listener = {});

  /// Session time: of the newest advance_to(), or of the clock.
  [[nodiscard]] Timestamp now() const { return clock_ != nullptr ? clock_->now() : now_; }
  [[nodiscard]] Epoch refresh() { return navigator_.refresh(now()); }
  [[nodiscard]] Navigator& navigator() { return navigator_; }
  [[nodiscard]] const Navigator& navigator() const { return navigator_; }
  /// One line for every image, in order.
  [[nodiscard]] const PoseLog& log() const { return log_; }

  /// Buttons that were pressed, in order; the first kMostPresses of them.
  [[nodiscard]] const std::vector<PressedButton>& presses() const { return presses_; }
  static constexpr std::size_t kMostPresses = 10'000;

  /// Outline of the images that come without one; replaces the learned outline.
  void set_outline(const std::optional<SectorOutline>& outline);
  [[nodiscard]] const std::optional<SectorOutline>& outline() const;

  /// Position of the images on the probe; absent while probe_from_pixels waits for an image.
  [[nodiscard]] const std::optional<Transform<frames::Probe, frames::Image>>& probe_from_image()
      const {
    return probe_from_image_;
  }

  /// Clock of the device of a stream, in the order of accounts(); null: it gave no device time.
  [[nodiscard]] const tracking::ClockModel* clock(std::size_t stream) const {
    const auto& found = streams_.at(stream).clock;
    return found ? &*found : nullptr;
  }
  /// Accounts of all streams, sources and streams in order. Balanced when the session has ended.
  [[nodiscard]] std::vector<StreamAccount> accounts() const;
  /// One sentence for each source that failed.
  [[nodiscard]] const std::vector<std::string>& failures() const { return failures_; }
  /// Cause of the first image that could not be used; empty while there is none.
  [[nodiscard]] const std::string& first_rejection() const { return first_rejection_; }

 private:
  struct Stream {
    StreamInfo info;
    std::unique_ptr<StreamQueue> queue;
    bool used = false;
    tracking::StreamLedger own;  ///< Counts of a stream that the navigator does not use.
    // Live: what came until it changed last, and whether its end was reported.
    std::uint64_t received = 0;
    Timestamp changed{};
    bool said_stopped = false;
    /// Geometry of its first image.
    std::optional<ImageGeometry> geometry;
    bool said_colours = false;  ///< That its images have colours was reported.
    /// Clock of its device; only for samples with a device time.
    std::optional<tracking::ClockModel> clock;
  };
  struct Feed {
    std::shared_ptr<Source> source;
    std::size_t number = 0;
    std::size_t first_stream = 0;
    std::optional<Sample> head;      ///< Virtual only.
    std::atomic<bool> ended{false};  ///< The rest is live only.
    std::mutex mutex;
    std::string failure;  ///< Guarded by the mutex.
    bool failure_known = false;
    std::jthread thread;
  };
  Result<void> fill_head(Feed& feed);
  void run(Feed& feed, const std::stop_token& stop);
  void deliver(std::size_t stream, Sample sample, const Listener& listener);
  void drain(const Listener& listener);
  void learn_from(Stream& stream, const std::vector<SupersededStamp>& superseded);
  void look_at_sources();
  void look_at_stream(Stream& stream, bool ended);
  void look_at_geometry(Stream& stream, const UltrasoundImage& image);
  void look_at_colours(Stream& stream, const UltrasoundImage& image);
  tracking::ClockModel::Reading read_clock(Stream& stream, DeviceTime device, Timestamp received);
  std::optional<tracking::ClockFault> map_time(Stream& stream, Sample& sample);
  void calibrate(UltrasoundImage& image);
  void watch(Sample& sample);
  void press(std::size_t stream, const ButtonSample& button, const Listener& listener);
  void settle(bool end, const Listener& listener);
  void note_failures();

  SessionSetup setup_;
  Diagnostics& diagnostics_;
  Navigator navigator_;
  OutlineEstimator learned_;
  std::optional<ImageWatch> watch_;
  std::optional<std::optional<SectorOutline>> set_outline_;
  std::vector<Stream> streams_;
  std::vector<std::unique_ptr<Feed>> feeds_;
  std::vector<Sample> taken_;
  std::vector<SupersededStamp> superseded_;
  std::optional<Timestamp> looked_at_;  ///< Live: time at which the sources were looked at.
  /// Pixel grid by probe_from_pixels, and the geometry by the device of the images that it is for.
  struct CalibratedPixels {
    PixelGrid grid;
    ImageGeometry of_device;
  };
  std::optional<CalibratedPixels> pixels_;
  std::optional<Transform<frames::Probe, frames::Image>> probe_from_image_;
  bool pixels_rejected_ = false;
  const Clock* clock_ = nullptr;
  Timestamp now_{};
  PoseLog log_;
  std::vector<PressedButton> presses_;
  std::vector<std::string> failures_;
  std::string first_rejection_;
};

}  // namespace nav::session
