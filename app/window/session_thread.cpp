// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/session_thread.hpp"

#include <algorithm>
#include <chrono>
#include <exception>

#include "app/report.hpp"
#include "app/views/plane_overlays.hpp"

namespace nav::app {
namespace {

constexpr auto kPollSession = std::chrono::milliseconds(2);
constexpr auto kLookAgain = std::chrono::milliseconds(10);
/// Time between two moments in which only the needle moves.
constexpr auto kMostSilence = std::chrono::milliseconds(50);
constexpr double kMarkRadiusMm = 2;
/// Time between two looks whether the window closes, while there is no session.
constexpr auto kWaitForSession = std::chrono::milliseconds(50);

/// The scene of an epoch, with the probe's marked side on the plane.
std::shared_ptr<const render::Scene> scene_of(Feed& feed, const session::Epoch& epoch) {
  auto scene = std::make_shared<render::Scene>(feed.view().presenter().scene(epoch));
  if (const auto camera = feed.camera()) scene->camera = *camera;
  if (scene->plane && scene->plane->safety.state <= SafetyState::kDegraded) {
    const Eigen::Vector3d blue =
        Eigen::Vector3d(kNeedleColour.r, kNeedleColour.g, kNeedleColour.b) / 255.0;
    scene->spheres.push_back(
        {.centre_ct = scene->plane->ct_from_image * marked_corner(scene->plane->frame),
         .radius_mm = kMarkRadiusMm,
         .rgb = blue});
  }
  return scene;
}

/// Histogram of the values that a transfer function classifies, without outliers.
std::shared_ptr<const render::ValueCounts> counts_of(const StoredVolume& volume) {
  constexpr std::size_t kMostSorted = 20000;
  constexpr double kOutliers = 0.0005;
  constexpr double kMargin = 0.03;
  constexpr int kBins = 4096;
  const auto all = volume.values();
  std::vector<std::int16_t> values;
  const std::size_t every = std::max<std::size_t>(1, all.size() / kMostSorted);
  for (std::size_t i = 0; i < all.size(); i += every) values.push_back(all[i]);
  std::ranges::sort(values);
  const auto at = [&](double share) {
    return static_cast<double>(
        values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))]);
  };
  const double low = at(kOutliers);
  const double high = std::max(at(1 - kOutliers), low + 1);
  const double margin = kMargin * (high - low);
  return std::make_shared<const render::ValueCounts>(
      render::count_values(volume, low - margin, high + margin, kBins));
}

bool same_states(const session::Epoch& a, const session::Epoch& b) {
  return a.ultrasound.state == b.ultrasound.state && a.plane.state == b.plane.state &&
         a.needle.state == b.needle.state;
}

}  // namespace

SessionThread::SessionThread(SessionConfig config, bool loop, const Clock& clock, Console& console,
                             Hears hears)
    : config_(std::move(config)),
      loop_(loop),
      clock_(clock),
      console_(console),
      hears_(std::move(hears)) {}

void SessionThread::begin_thread(bool from_config) {
  thread_ = std::jthread([this, from_config](const std::stop_token& stop) {
    try {
      run(stop, from_config);
    } catch (const std::exception& failure) {
      tell(SessionNews::Stage::kFailed, std::string("the session failed: ") + failure.what());
    }
  });
}

void SessionThread::start() { begin_thread(true); }

void SessionThread::open(SessionConfig config) {
  const std::uint64_t ticket = ++ticket_;
  hears_.job({JobNews::Stage::kRunning, "open", "opening the session", {}});
  openers_.emplace_back([this, ticket, wanted = std::move(config)] {
    JobNews news{JobNews::Stage::kDone, "open", "the session is open", {}};
    std::optional<Opened> made;
    try {
      auto next = opened(wanted);
      if (next) {
        made = *std::move(next);
      } else {
        news = {JobNews::Stage::kFailed, "open", next.error().message, {}};
      }
    } catch (const std::exception& failure) {
      news = {JobNews::Stage::kFailed, "open", failure.what(), {}};
    }
    if (ticket != ticket_) return;  // Cancelled, or another was ordered.
    if (made) next_.put(*std::move(made));
    hears_.job(std::move(news));
  });
  if (!thread_.joinable()) begin_thread(false);
}

void SessionThread::cancel_opening() {
  ++ticket_;
  hears_.job({JobNews::Stage::kCancelled, "open", "opening was cancelled", {}});
}

void SessionThread::stop() {
  thread_.request_stop();
  faults_.close();
  if (thread_.joinable()) thread_.join();
  openers_.clear();
}

void SessionThread::tell(SessionNews::Stage stage, std::string words, Feed* feed) {
  hears_.news(
      {stage, std::move(words),
       feed != nullptr ? feed->facts() : std::vector<std::pair<std::string, std::string>>()});
}

Result<SessionThread::Opened> SessionThread::opened(const SessionConfig& config) {
  auto own = std::make_unique<SessionConfig>(config);
  // Only the scenes of the session's own presenter are used: it draws nothing.
  own->output.engine = "cpu";
  auto feed = open_feed(*own, loop_, clock_, console_);
  if (!feed) return feed.error();
  return Opened{std::move(own), *std::move(feed)};
}

void SessionThread::run(const std::stop_token& stop, bool from_config) {
  std::optional<Opened> now;
  if (from_config) {
    tell(SessionNews::Stage::kLoading, "loading the session");
    auto first = opened(config_);
    if (first) {
      now = *std::move(first);
    } else {
      if (!config_.output.record.empty()) recorded_ = first.error();  // Nothing was.
      tell(SessionNews::Stage::kFailed, first.error().message);
    }
  }
  while (!stop.stop_requested()) {
    if (!now) now = next_.wait(kWaitForSession);
    if (!now) continue;
    config_ = *now->config;
    ++session_;
    counts_.reset();
    looked_.reset();
    plans_.take();
    placements_.take();
    structure_orders_.take();
    structures_ = {};
    tell(SessionNews::Stage::kRunning, "running", now->feed.get());
    auto following = play(*now->feed, stop);
    close(*now->feed);
    now = std::move(following);
  }
}

void SessionThread::close(Feed& feed) {
  feed.finish();
  presses_ = feed.presses();
  ledger_ = json_of(feed.session().navigator().ledger());
  if (WindowRecorder* recorder = feed.recorder()) {
    if (auto done = recorder->finish(); !done) recorded_ = done;
    recordings_ = recorder->json();
  }
  if (const auto outcome = feed.outcome(); recorded_ && !outcome) recorded_ = outcome;
}

/// Plays until another session is there, which it returns, or until it is stopped.
std::optional<SessionThread::Opened> SessionThread::play(Feed& feed, const std::stop_token& stop) {
  std::optional<session::Epoch> shown;
  std::string failure;
  bool placed = false;
  Timestamp looked{}, published{};
  while (!stop.stop_requested()) {
    if (auto following = next_.take()) return following;
    obey(feed);
    obey_records(feed);
    const bool changed = obey_user(feed);
    const Timestamp now = clock_.now();
    bool publish = false;
    if (failure.empty() && !feed.over()) {
      auto epoch = feed.next(now);
      for (auto& press : feed.take_presses()) hears_.pressed(std::move(press));
      if (!epoch) {
        failure = epoch.error().message;
        tell(SessionNews::Stage::kFailed, failure, &feed);
      } else if (*epoch) {
        shown = std::move(**epoch);
        publish = true;
      }
      if (shown && (feed.over() || !failure.empty())) {
        shown = session::ended(*std::move(shown), failure.empty() ? feed.ended() : failure);
        publish = true;
      }
    }
    if (shown && !publish && changed) {
      // A change by the user shows at once, also without a new image.
      shown = feed.again(*std::move(shown), now);
      publish = true;
    }
    if (shown && !publish && !feed.over() && failure.empty() && now - looked >= kLookAgain) {
      auto again = feed.again(*shown, now);
      looked = now;
      // A needle moves between two images.
      const bool moves = again.guidance && now - published >= kMostSilence;
      publish = moves || !same_states(again, *shown);
      if (publish) shown = std::move(again);
    }
    if (publish) {
      published = now;
      look_at_streams(feed, now);
      auto moment = moment_of(feed, *shown, now);
      moment->notice = feed.notice();
      if (feed.over()) moment->notice = feed.ended();
      if (!failure.empty()) moment->notice = failure;
      hears_.moment(std::move(moment));
    }
    if (!placed && feed.view().placement()) {
      placed = true;
      tell(SessionNews::Stage::kRunning, "running", &feed);
    }
    if (!publish) std::this_thread::sleep_for(kPollSession);
  }
  return std::nullopt;
}

/// True: the user has changed the plan or the placement.
bool SessionThread::obey_user(Feed& feed) {
  const auto plan = plans_.take();
  const auto placement = placements_.take();
  auto structures = structure_orders_.take();
  if (structures) structures_ = *std::move(structures);
  if (plan) feed.set_plan(*plan);
  if (placement) feed.set_placement(*placement);
  if (plan || placement) tell(SessionNews::Stage::kRunning, "running", &feed);
  return plan || placement || structures;
}

void SessionThread::obey(Feed& feed) {
  if (const auto ns = hang_ns_.exchange(0); ns > 0) {
    std::this_thread::sleep_for(std::chrono::nanoseconds(ns));
  }
  const auto fault = faults_.take();
  if (!fault) return;
  const bool done = fault->name == "cover-marker" ? feed.cover_marker(fault->time)
                                                  : feed.hold_images(fault->time);
  if (!done) {
    console_.report(Severity::kWarning, "fault",
                    fault->name + ": expected a simulated session, found another kind");
  }
}

void SessionThread::obey_records(Feed& feed) {
  constexpr auto kTellPeriod = std::chrono::milliseconds(500);
  const Timestamp now = clock_.now();
  const auto order = records_.take();
  if (order && !*order) {
    if (WindowRecorder* recorder = feed.recorder()) recorder->stop();
  } else if (order) {
    if (const auto started = feed.start_recording(**order); !started) {
      console_.report(Severity::kError, "recording", started.error().message);
      if (feed.recorder() == nullptr) recorded_ = started;
    }
  }
  WindowRecorder* recorder = feed.recorder();
  if (recorder == nullptr || (!order && told_ && now - *told_ < kTellPeriod)) return;
  const RecordingStatus status = recorder->status();
  if (!order && told_ && status.stage == RecordingStatus::Stage::kOff) return;
  told_ = now;
  hears_.recording(status);
}

/// Rates and drops, twice a second: percentiles of all periods take time.
void SessionThread::look_at_streams(Feed& feed, Timestamp now) {
  constexpr auto kLookPeriod = std::chrono::milliseconds(500);
  if (looked_ && now - *looked_ < kLookPeriod) return;
  looked_ = now;
  look_ = {};
  for (const auto& account : feed.session().accounts()) {
    const bool images = account.info.kind == StreamKind::kImages;
    if (!images && account.info.role != ToolRole::kNeedle) continue;
    auto& rate = images ? look_.images_hz : look_.needle_hz;
    auto& drops = images ? look_.images_dropped : look_.needle_dropped;
    if (account.timing.rate_hz > 0) rate = account.timing.rate_hz;
    drops +=
        account.ledger.dropped_total() + account.ledger.rejected_total() + account.timing.missing;
  }
}

std::shared_ptr<Moment> SessionThread::moment_of(Feed& feed, session::Epoch epoch, Timestamp now) {
  PlacedView& view = feed.view();
  auto moment = std::make_shared<Moment>();
  moment->number = ++number_;
  moment->session = session_;
  moment->ct = view.shared_ct();
  moment->scene = scene_of(feed, epoch);
  moment->predicates = view.predicates();
  moment->stored = feed.stored();
  if (!counts_ && !moment->scene->predicates) counts_ = counts_of(*moment->scene->ct);
  moment->counts = counts_;
  moment->plan = view.plan();
  moment->placement = view.placement();
  moment->reference_frame = feed.reference_frame();
  moment->window = view.presenter().window();
  if (epoch.guidance && epoch.ct_from_needle && moment->plan) {
    moment->guidance_error = session::guidance_error(
        *moment->plan, *epoch.ct_from_needle,
        {.registration = view.placement() ? view.placement()->uncertainty : std::nullopt,
         .tracker_rms_mm = epoch.tracker_error_mm});
  }
  moment->structures = structures_.number;
  if (epoch.guidance && epoch.ct_from_needle) {
    const auto tip = *epoch.ct_from_needle * Point<frames::Needle>{{0, 0, 0}};
    moment->nearest =
        structures_.distances
            ? structures_.distances->nearest(tip)
            : session::NearestStructure{.state = session::NearestStructure::State::kPending};
  }
  moment->needle_length_mm = config_.source.needle_size.length_mm;
  moment->needle_expected = view.needle_expected();
  moment->kind = feed.kind();
  const std::string outside = view.outside();
  if (const auto& placement = view.placement()) {
    moment->warning = outside.empty() ? registration_warning(placement->warnings) : outside;
  }
  moment->published = now;
  const auto at = [&](const std::optional<Timestamp>& time) -> std::optional<Timestamp> {
    if (!time) return std::nullopt;
    return feed.on_clock(*time);
  };
  std::optional<Timestamp> acquired;
  if (epoch.frame) acquired = epoch.frame->frame.acquired;
  moment->acquired = at(acquired);
  moment->ultrasound_until = at(epoch.ultrasound_until);
  moment->needle_until = at(epoch.needle_until);
  if (moment->stored) {
    moment->inputs = {{"volume", {SafetyState::kValid, ""}}};
  } else {
    moment->inputs = {{.name = "ultrasound",
                       .safety = epoch.ultrasound,
                       .acquired = moment->acquired,
                       .rate_hz = look_.images_hz,
                       .drops = look_.images_dropped},
                      {.name = "CT", .safety = epoch.placement}};
  }
  if (moment->needle_expected || moment->plan) {
    moment->inputs.push_back({.name = "needle",
                              .safety = epoch.needle,
                              .acquired = at(epoch.needle_acquired),
                              .rate_hz = look_.needle_hz,
                              .drops = look_.needle_dropped});
  }
  moment->epoch = std::move(epoch);
  return moment;
}

}  // namespace nav::app
