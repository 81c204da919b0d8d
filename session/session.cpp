// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/session.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include "io/recorded_calibration.hpp"
#include "io/transform_tree.hpp"
#include "nav/cause_words.hpp"

namespace nav::session {
namespace {

/// How long a source may wait before its thread looks whether it is to stop.
constexpr Duration kPatience = std::chrono::milliseconds(50);

bool is_tool_of_navigator(ToolRole role) {
  return role == ToolRole::kProbe || role == ToolRole::kReference || role == ToolRole::kNeedle;
}

/// False for pixels of 1 x 1 mm: PLUS and others send it when they do not know the spacing.
bool says_spacing(const PixelGrid& grid) {
  return !grid.mm_per_pixel.isApprox(Eigen::Matrix2d::Identity(), 1e-6);
}

/// True when rows and columns are as far apart, to 2 %.
bool similar_spacing(const PixelGrid& a, const PixelGrid& b) {
  constexpr double kShare = 0.02;
  const auto similar = [&](int column) {
    const double mm = a.mm_per_pixel.col(column).norm();
    return std::abs(mm - b.mm_per_pixel.col(column).norm()) <= kShare * mm;
  };
  return similar(0) && similar(1);
}

}  // namespace

Session::Session(const SessionSetup& setup, Diagnostics& diagnostics)
    : setup_(setup),
      diagnostics_(diagnostics),
      navigator_(setup.calibration, setup.fixed_reference, setup.navigator, diagnostics) {
  if (setup.calibration) probe_from_image_ = setup.calibration->probe_from_image;
  if (setup.image_watch) watch_.emplace(*setup.image_watch);
}

Session::~Session() { stop(); }

void Session::add(std::shared_ptr<Source> source) {
  auto feed = std::make_unique<Feed>();
  feed->number = feeds_.size();
  feed->first_stream = streams_.size();
  for (const StreamInfo& info : source->streams()) {
    const bool images = info.kind == StreamKind::kImages;
    const auto same = [&](const Stream& other) {
      return other.used && other.info.kind == info.kind && (images || other.info.role == info.role);
    };
    Stream stream;
    stream.info = info;
    stream.queue = std::make_unique<StreamQueue>(images ? setup_.images : QueuePolicy::kLossless,
                                                 setup_.queue_capacity);
    const bool buttons = info.kind == StreamKind::kButtons;
    stream.used = !buttons && (images || is_tool_of_navigator(info.role)) &&
                  std::none_of(streams_.begin(), streams_.end(), same);
    streams_.push_back(std::move(stream));
  }
  feed->source = std::move(source);
  feeds_.push_back(std::move(feed));
}

/// Fills the head of a source.
Result<void> Session::fill_head(Feed& feed) {
  if (feed.head || feed.ended) return {};
  auto sample = feed.source->next(Timestamp::max());
  if (sample) {
    feed.head = *std::move(sample);
  } else if (sample.error().code == ErrorCode::kEndOfStream) {
    feed.ended = true;
  } else {
    return sample.error();
  }
  return {};
}

Result<std::optional<Timestamp>> Session::next_arrival() {
  std::optional<Timestamp> next;
  for (const auto& feed : feeds_) {
    if (auto ok = fill_head(*feed); !ok) return ok.error();
    if (feed->head && (!next || feed->head->received < *next)) next = feed->head->received;
  }
  return next;
}

Result<void> Session::advance_to(Timestamp time, const Listener& listener) {
  now_ = time;
  for (;;) {
    const auto next = next_arrival();
    if (!next) return next.error();
    if (!*next || **next > time) break;
    for (const auto& feed : feeds_) {
      if (!feed->head || feed->head->received != **next) continue;
      const std::size_t stream = feed->first_stream + feed->head->stream;
      streams_[stream].queue->push(*std::exchange(feed->head, std::nullopt));
      break;
    }
    drain(listener);
  }
  settle(false, listener);
  return {};
}

void Session::start(const Clock& clock) {
  clock_ = &clock;
  for (const auto& feed : feeds_) {
    Feed* one = feed.get();
    one->thread = std::jthread([this, one](const std::stop_token& stop) { run(*one, stop); });
  }
}

/// The root of a source's thread: nothing leaves it but through queues and the failure.
void Session::run(Feed& feed, const std::stop_token& stop) {
  std::string failure;
  try {
    while (!stop.stop_requested()) {
      auto sample = feed.source->next(clock_->now() + kPatience);
      if (sample) {
        const std::size_t stream = feed.first_stream + sample->stream;
        NAV_CHECK(sample->stream < feed.source->streams().size(), sample->stream);
        if (setup_.tap) setup_.tap(feed.number, *sample);
        streams_[stream].queue->push(*std::move(sample));
        continue;
      }
      const ErrorCode code = sample.error().code;
      if (code == ErrorCode::kTimeout) continue;
      if (code != ErrorCode::kEndOfStream && code != ErrorCode::kCancelled) {
        failure = sample.error().message;
      }
      break;
    }
  } catch (const std::exception& error) {
    failure = std::string("internal error: ") + error.what();
  } catch (...) {
    failure = "internal error of an unknown kind";
  }
  {
    const std::lock_guard lock(feed.mutex);
    feed.failure = std::move(failure);
  }
  feed.ended = true;
}

void Session::stop() noexcept {
  for (const auto& feed : feeds_) {
    if (!feed->thread.joinable()) continue;
    feed->thread.request_stop();
    feed->source->stop();
    feed->thread.join();
  }
}

void Session::take_in(const Listener& listener) {
  drain(listener);
  note_failures();
  look_at_sources();
  settle(false, listener);
}

/// Tells the navigator, ten times a second, which streams come from a device that is not there.
void Session::look_at_sources() {
  constexpr auto kPeriod = std::chrono::milliseconds(100);
  const Timestamp now = clock_->now();
  if (looked_at_ && now - *looked_at_ < kPeriod) return;
  looked_at_ = now;
  for (const auto& feed : feeds_) {
    const SourceHealth health = feed->source->health();
    std::string trouble;
    if (health.state == SourceState::kWaiting) {
      trouble = "the device is not there";
      if (!health.cause.empty()) trouble += " (" + words_of_cause(health.cause) + ")";
    } else if (health.state == SourceState::kSilent) {
      trouble = "the device is silent";
    }
    for (std::size_t i = 0; i < feed->source->streams().size(); ++i) {
      Stream& stream = streams_[feed->first_stream + i];
      if (!stream.used) continue;
      look_at_stream(stream, feed->ended);
      const bool images = stream.info.kind == StreamKind::kImages;
      navigator_.set_trouble(images, stream.info.role, trouble);
    }
  }
}

/// Reports a stream that has given samples and gives none any more.
void Session::look_at_stream(Stream& stream, bool ended) {
  constexpr auto kStopped = std::chrono::seconds(2);
  const std::uint64_t received = stream.queue->ledger().received();
  const Timestamp now = clock_->now();
  if (received != stream.received) {
    stream.received = received;
    stream.changed = now;
    stream.said_stopped = false;
    return;
  }
  if (received == 0 || ended || stream.said_stopped || now - stream.changed < kStopped) return;
  stream.said_stopped = true;
  diagnostics_.report("session", {.subject = stream.info.name,
                                  .key = "stream",
                                  .values = {"none for " + std::to_string(kStopped.count()) +
                                             " s, after " + std::to_string(received) + " samples"},
                                  .used = "nothing of it until it is back"});
}

/// Reports images of another size or pixel spacing than the first image of their stream.
void Session::look_at_geometry(Stream& stream, const UltrasoundImage& image) {
  const ImageGeometry geometry = geometry_of(image);
  if (!stream.geometry) stream.geometry = geometry;
  if (same_pixels(geometry, *stream.geometry)) return;
  diagnostics_.report("session", {.subject = stream.info.name,
                                  .key = "size of the images",
                                  .values = {"the first: " + stream.geometry->description(),
                                             "image " + std::to_string(image.sequence) + ": " +
                                                 geometry.description()},
                                  .used = "the images that the calibration is for"});
}

/// Reports, once for each stream, what is drawn of colours.
void Session::look_at_colours(Stream& stream, const UltrasoundImage& image) {
  if (stream.said_colours || image.colours.empty()) return;
  stream.said_colours = true;
  diagnostics_.report("session",
                      {.subject = stream.info.name,
                       .key = "colours",
                       .values = {"some, from image " + std::to_string(image.sequence) + " on"},
                       .used = "colours in the ultrasound view, their brightness everywhere else"});
}

/// A failed source takes its streams with it.
void Session::note_failures() {
  for (const auto& feed : feeds_) {
    if (feed->failure_known || !feed->ended) continue;
    {
      const std::lock_guard lock(feed->mutex);
      if (feed->failure.empty()) continue;
      feed->failure_known = true;
      failures_.push_back(feed->failure);
    }
    const std::string& cause = failures_.back();
    diagnostics_.report(Severity::kError, "session", cause);
    for (std::size_t i = 0; i < feed->source->streams().size(); ++i) {
      const Stream& stream = streams_[feed->first_stream + i];
      if (!stream.used) continue;
      if (stream.info.kind == StreamKind::kImages) {
        navigator_.lose_images(cause);
      } else {
        navigator_.lose_poses(stream.info.role, cause);
      }
    }
  }
}

/// Takes a device time into the clock of its stream, and reports a new epoch.
tracking::ClockModel::Reading Session::read_clock(Stream& stream, DeviceTime device,
                                                  Timestamp received) {
  if (!stream.clock) stream.clock.emplace();
  const auto reading = stream.clock->add(device, received);
  if (reading.began_epoch) {
    diagnostics_.report(Severity::kWarning, "session",
                        stream.info.name + ": the clock of the device was set, or its data take " +
                            std::to_string(1e3 * to_seconds(stream.clock->change())) +
                            " ms longer than at the beginning");
  }
  return reading;
}

/// Learns period and clock from images that were superseded. A replay, which shows all images,
/// learns the same.
void Session::learn_from(Stream& stream, const std::vector<SupersededStamp>& superseded) {
  if (!stream.used) return;
  for (const SupersededStamp& one : superseded) {
    std::optional<Timestamp> acquired = one.acquired;
    if (one.device_time) {
      const auto reading = read_clock(stream, *one.device_time, one.received);
      acquired = reading.acquired;
      if (reading.fault) continue;
    }
    if (acquired) navigator_.saw_image(*acquired);
  }
}

/// Hands over what is queued, in order of arrival; of samples that arrived together, by stream.
void Session::drain(const Listener& listener) {
  struct Taken {
    std::size_t stream;
    Sample sample;
  };
  std::vector<Taken> all;
  for (std::size_t i = 0; i < streams_.size(); ++i) {
    taken_.clear();
    superseded_.clear();
    streams_[i].queue->drain(taken_, superseded_);
    learn_from(streams_[i], superseded_);
    for (Sample& sample : taken_) all.push_back({i, std::move(sample)});
  }
  std::stable_sort(all.begin(), all.end(), [](const Taken& a, const Taken& b) {
    return a.sample.received < b.sample.received;
  });
  for (Taken& one : all) deliver(one.stream, std::move(one.sample), listener);
}

/// Maps the device time of a sample to the time of its acquisition, on the session clock. Returns a
/// fault of the device time.
std::optional<tracking::ClockFault> Session::map_time(Stream& stream, Sample& sample) {
  if (!sample.device_time) return std::nullopt;
  const auto reading = read_clock(stream, *sample.device_time, sample.received);
  const bool unsure = stream.clock->state() != tracking::ClockState::kKnown;
  if (auto* image = std::get_if<UltrasoundImage>(&sample.what)) {
    image->acquired = reading.acquired;
    image->received = sample.received;
    image->clock_unsure = unsure;
  } else if (auto* pose = std::get_if<PoseSample>(&sample.what)) {
    pose->pose.acquired = reading.acquired;
    pose->pose.received = sample.received;
    pose->pose.clock_unsure = unsure;
  }
  return reading.fault;
}

/// Gives an image the pixel grid of SessionSetup::probe_from_pixels if it is of the size and
/// spacing that this is for. Other images keep their own grid, which no calibration fits.
void Session::calibrate(UltrasoundImage& image) {
  if (!setup_.probe_from_pixels || image.pixels.empty() || !validate(image.grid)) return;
  const ImageGeometry of_device = geometry_of(image);
  if (pixels_) {
    if (same_pixels(of_device, pixels_->of_device)) image.grid = pixels_->grid;
    return;
  }
  if (pixels_rejected_) return;
  const auto made = io::calibration_from_matrix(*setup_.probe_from_pixels, image.pixels.width(),
                                                image.pixels.height());
  if (made) {
    UltrasoundImage calibrated = image;
    calibrated.grid = made->grid;
    const ImageGeometry geometry = geometry_of(calibrated);
    if (says_spacing(image.grid) && !similar_spacing(image.grid, made->grid)) {
      pixels_rejected_ = true;
      diagnostics_.report(Severity::kError, "session",
                          "the device says that its images have " + of_device.description() +
                              ", the calibration of the probe is for " + geometry.description() +
                              ": expected the same; the images are not drawn");
      return;
    }
    pixels_ = CalibratedPixels{made->grid, of_device};
    probe_from_image_ = made->probe_from_image;
    const auto placeholder = io::placeholder_calibration(*made);
    navigator_.add_calibration(
        {made->probe_from_image, geometry,
         placeholder ? placeholder->key + ": " + placeholder->values.at(0) : ""});
    image.grid = made->grid;
  } else {
    pixels_rejected_ = true;
    diagnostics_.report(Severity::kError, "session", made.error().message);
  }
}

/// Withdraws an image of a screen that shows another sector or depth than at first.
void Session::watch(Sample& sample) {
  const auto* image = std::get_if<UltrasoundImage>(&sample.what);
  if (image == nullptr || image->pixels.empty()) return;
  const bool was_good = watch_->change().empty();
  const std::string& change = watch_->look(image->pixels);
  if (change.empty()) {
    if (!was_good) {
      diagnostics_.report(Severity::kInfo, "session",
                          "the screen of the scanner is as at first: its images are shown again");
    }
    return;
  }
  if (was_good) {
    diagnostics_.report(Severity::kWarning, "session",
                        change + ": its images are withdrawn until it is as before");
  }
  sample.what = MissingImage{"screen_changed", change};
}

void Session::deliver(std::size_t index, Sample sample, const Listener& listener) {
  Stream& stream = streams_[index];
  if (const auto* button = std::get_if<ButtonSample>(&sample.what)) {
    NAV_CHECK(stream.info.kind == StreamKind::kButtons);
    stream.own.receive();
    stream.own.deliver();
    if (button->pressed) press(index, *button, listener);
    return;
  }
  if (!stream.used) {
    stream.own.receive();
    stream.own.drop("not_used");
    return;
  }
  if (const auto fault = map_time(stream, sample)) {
    const char* cause = tracking::to_string(*fault);
    if (stream.info.kind == StreamKind::kPoses) {
      navigator_.reject_pose(stream.info.role, cause);
      return;
    }
    sample.what =
        MissingImage{cause, stream.info.name + ", image " + std::to_string(sample.sequence) +
                                ": its device time cannot be used: " + words_of_cause(cause)};
  }
  if (watch_) watch(sample);
  if (auto* image = std::get_if<UltrasoundImage>(&sample.what)) {
    NAV_CHECK(stream.info.kind == StreamKind::kImages);
    if (!image->pixels.empty() && validate(image->grid)) look_at_geometry(stream, *image);
    look_at_colours(stream, *image);
    calibrate(*image);
    if (setup_.learn_outline && !set_outline_ && !image->outline) learned_.add(*image);
    if (!image->outline) image->outline = outline();
    navigator_.add_image(std::move(*image));
  } else if (const auto* missing = std::get_if<MissingImage>(&sample.what)) {
    NAV_CHECK(stream.info.kind == StreamKind::kImages);
    if (first_rejection_.empty()) first_rejection_ = missing->message;
    log_.add_missing(sample.sequence, missing->cause);
    navigator_.add_missing(*missing);
    if (listener.missing) listener.missing(sample.sequence, *missing);
  } else {
    NAV_CHECK(stream.info.kind == StreamKind::kPoses);
    PoseSample& tracked = std::get<PoseSample>(sample.what);
    RawPose& pose = tracked.pose;
    if (stream.info.role == ToolRole::kNeedle && setup_.body_from_tip) {
      pose.tracker_from_body *= *setup_.body_from_tip;
    }
    navigator_.add_pose(stream.info.role, pose, tracked.tracker_error_mm);
  }
}

void Session::press(std::size_t stream, const ButtonSample& button, const Listener& listener) {
  const auto feed = std::ranges::find_if(
      feeds_.rbegin(), feeds_.rend(), [&](const auto& one) { return one->first_stream <= stream; });
  const StreamInfo& info = streams_[stream].info;
  PressedButton pressed{.source = (*feed)->number,
                        .button = info.name,
                        .action = info.action,
                        .acquired = button.acquired};
  if (listener.pressed) listener.pressed(pressed);
  if (presses_.size() < kMostPresses) presses_.push_back(std::move(pressed));
}

void Session::settle(bool end, const Listener& listener) {
  navigator_.settle(now(), end, [&](const tracking::PairedImage& paired) {
    if (!paired.tracked && first_rejection_.empty()) {
      first_rejection_ =
          "frame " + std::to_string(paired.sequence) + ": " + words_of_cause(paired.cause);
    }
    log_.add(paired);
    if (listener.settled) listener.settled(paired);
  });
}

bool Session::ended() const {
  return std::all_of(feeds_.begin(), feeds_.end(),
                     [](const auto& feed) { return feed->ended && !feed->head; });
}

void Session::finish(const Listener& listener) {
  stop();
  drain(listener);
  note_failures();
  settle(true, listener);
}

void Session::set_outline(const std::optional<SectorOutline>& outline) { set_outline_ = outline; }

const std::optional<SectorOutline>& Session::outline() const {
  return set_outline_ ? *set_outline_ : learned_.outline();
}

std::vector<StreamAccount> Session::accounts() const {
  std::vector<StreamAccount> all;
  for (const Stream& stream : streams_) {
    const tracking::StreamLedger queued = stream.queue->ledger();
    const tracking::StreamLedger& next = !stream.used ? stream.own
                                         : stream.info.kind == StreamKind::kImages
                                             ? navigator_.ledger()
                                             : navigator_.ledger(stream.info.role);
    all.push_back({stream.info, queued.followed_by(next), stream.queue->timing()});
  }
  return all;
}

}  // namespace nav::session
