// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/refresh_loop.hpp"

#include <utility>

namespace nav::app {

namespace {

/// Puts a value into a box of the window's thread and wakes that thread once.
template <class T>
auto poster(Mailbox<T>& box, RefreshLoop& loop) {
  return [&box, &loop](T value) {
    if (!box.put(std::move(value))) return;
    QMetaObject::invokeMethod(
        &loop, [&loop] { loop.tick(); }, Qt::QueuedConnection);
  };
}

}  // namespace

RefreshLoop::RefreshLoop(const Options& options, const Clock& clock, Console& console,
                         WindowReport& report, const SessionViews& views)
    : clock_(clock),
      report_(report),
      views_(views),
      has_session_(options.has_session),
      flat_engine_({poster(flats_, *this), poster(flat_failures_, *this)}),
      scene_engine_(options.engine, options.config.output.threads, clock, console,
                    {poster(scenes_, *this), poster(scene_failures_, *this)}),
      session_(options.config, options.loop, clock, console,
               {poster(moments_, *this), poster(news_box_, *this)}) {
  if (!has_session_) news_.words = "no session: sonde window SESSION, or --simulated";
  views_.scene->moved = [this](const render::WindowInput& input) { move_camera(input); };
  for (ViewWidget* view : {static_cast<ViewWidget*>(views_.scene),
                           static_cast<ViewWidget*>(views_.ultrasound), views_.ct}) {
    view->resized = [this] { order_pictures(); };
  }
  measure_painting();
}

void RefreshLoop::measure_painting() {
  views_.ultrasound->painted = [this](const Picture& picture, double ms) {
    report_.paint(ms);
    report_.convert(picture.convert_ms);
    report_.draw("ultrasound", picture.draw_ms);
    const Moment& moment = *picture.moment;
    if (!moment.acquired || !moment.epoch.frame || frozen_) return;
    const std::uint64_t image = moment.epoch.frame->frame.sequence + 1;
    if (image == std::exchange(latency_of_, image)) return;
    report_.latency(1e3 * to_seconds(clock_.now() - *moment.acquired));
  };
  views_.ct->painted = [this](const Picture& picture, double ms) {
    report_.paint(ms);
    report_.convert(picture.convert_ms);
    report_.draw("ct", picture.draw_ms);
  };
  views_.scene->painted = [this](const Picture& picture, double ms) {
    report_.paint(ms);
    report_.convert(picture.convert_ms);
    report_.draw(picture.refined ? "scene, full" : "scene, coarse", picture.draw_ms);
    if (!camera_asked_ || picture.asked < camera_number_) return;
    report_.input_to_paint(1e3 * to_seconds(clock_.now() - *camera_asked_));
    camera_asked_.reset();
  };
}

void RefreshLoop::start() {
  flat_engine_.start();
  scene_engine_.start();
  if (has_session_) session_.start();
}

void RefreshLoop::stop() {
  session_.stop();
  flat_engine_.stop();
  scene_engine_.stop();
}

void RefreshLoop::move_camera(const render::WindowInput& input) {
  const SharedMoment moment = wanted();
  if (!moment) return;
  camera_ = render::moved(camera_.value_or(moment->scene->camera), input);
  ++camera_number_;
  if (!camera_asked_) camera_asked_ = clock_.now();
  scene_engine_.draw({moment, camera_, views_.scene->pixel_size(), camera_number_, frozen()});
}

void RefreshLoop::reset_camera() {
  camera_.reset();
  ++camera_number_;
  order_pictures();
}

void RefreshLoop::set_frozen(bool frozen) {
  if (frozen == frozen_.has_value() || (frozen && !flat_moment_)) return;
  if (frozen) {
    frozen_ = Frozen{flat_moment_, clock_.now()};
  } else {
    frozen_.reset();
    for (ViewWidget* view : {static_cast<ViewWidget*>(views_.scene),
                             static_cast<ViewWidget*>(views_.ultrasound), views_.ct}) {
      view->set_frozen(std::nullopt);
    }
  }
  order_pictures();
  tick();
}

void RefreshLoop::order_pictures() {
  const SharedMoment moment = wanted();
  if (!moment) return;
  flat_engine_.draw({moment, {views_.ultrasound->pixel_size(), views_.ct->pixel_size()}});
  scene_engine_.draw({moment, camera_, views_.scene->pixel_size(), camera_number_, frozen()});
}

bool RefreshLoop::fault(const std::string& name, Duration time) {
  if (name == "hang-engine") {
    scene_engine_.hang(time);
  } else if (name == "hang-views") {
    flat_engine_.hang(time);
  } else if (name == "hang-session") {
    session_.hang(time);
  } else if (name == "cover-marker" || name == "hold-images") {
    session_.order({name, time});
  } else {
    return false;
  }
  loss_ = Loss{clock_.now()};
  return true;
}

void RefreshLoop::take_all() {
  if (auto news = news_box_.take()) {
    news_ = std::move(*news);
    if (changed) changed();
  }
  if (auto failure = scene_failures_.take()) failures_.scene = std::move(*failure);
  if (auto failure = flat_failures_.take()) failures_.flat = std::move(*failure);
  const Timestamp now = clock_.now();
  if (auto moment = moments_.take()) {
    newest_ = std::move(*moment);
    for (const InputStatus& input : newest_->inputs) report_.state(to_seconds(now), input);
    if (!frozen_) order_pictures();
  }
  const auto fits = [this](const Picture& picture) {
    return !frozen_ || picture.moment->number == frozen_->moment->number;
  };
  if (auto flat = flats_.take(); flat && fits(flat->ultrasound)) {
    assembler_.add(std::move(*flat), now);
  }
  if (auto scene = scenes_.take(); scene && fits(*scene)) {
    assembler_.add(std::move(*scene), now);
  }
}

void RefreshLoop::show(Assembled shown) {
  if (!shown.flat && !shown.scene) return;
  if (shown.flat) {
    flat_moment_ = shown.flat->ultrasound.moment;
    views_.ultrasound->set_picture(std::move(shown.flat->ultrasound));
    views_.ct->set_picture(std::move(shown.flat->ct));
  }
  if (shown.scene) {
    scene_moment_ = shown.scene->moment;
    views_.scene->set_picture(std::move(*shown.scene));
  }
}

void RefreshLoop::tick() {
  take_all();
  Assembled shown = assembler_.next(clock_.now());
  const bool refreshed = shown.flat.has_value() || shown.scene.has_value();
  show(std::move(shown));
  const Timestamp now = clock_.now();
  judgement_ = judge(newest_, flat_moment_, scene_moment_, failures_, now);
  if (!newest_) {
    for (ViewJudgement* view : {&judgement_.ultrasound, &judgement_.ct, &judgement_.scene}) {
      view->headline = news_.stage == SessionNews::Stage::kFailed ? "NO SESSION"
                       : has_session_                             ? "LOADING"
                                                                  : "NO SESSION";
      view->safety.cause = failures_.scene.empty() ? news_.words : failures_.scene;
    }
    judgement_.withdrawn = news_.words;
  }
  apply(judgement_, now);
  measure(now);
  if (refreshed && flat_moment_ && scene_moment_) {
    // Each view keeps the moment that it shows; one that differs has to be marked or covered.
    const bool same =
        views_.ultrasound->picture()->moment->number == views_.ct->picture()->moment->number &&
        (views_.scene->picture()->moment->number == flat_moment_->number || judgement_.scene.late ||
         judgement_.scene.covered || judgement_.ultrasound.late || judgement_.ultrasound.covered);
    report_.refresh(same);
  }
}

void RefreshLoop::apply(const Judgement& judgement, Timestamp now) {
  const std::string kind = newest_ ? newest_->kind : "";
  Judgement shown = judgement;
  if (frozen_) {
    // A frozen view is not covered: it says that it is frozen, and shows no live number.
    for (ViewJudgement* view : {&shown.ultrasound, &shown.ct, &shown.scene}) {
      if (view->covered && scene_moment_) view->covered = false;
      view->safety = {SafetyState::kStale, "frozen by the user"};
    }
    shown.guidance.reset();
    shown.withdrawn = "frozen by the user";
    for (ViewWidget* view : {static_cast<ViewWidget*>(views_.scene),
                             static_cast<ViewWidget*>(views_.ultrasound), views_.ct}) {
      view->set_frozen(to_seconds(now - frozen_->since));
    }
  }
  views_.ultrasound->set_judgement(shown.ultrasound, kind);
  views_.ct->set_judgement(shown.ct, kind);
  views_.scene->set_judgement(shown.scene, kind);
  views_.numerals->show_numbers(shown.guidance, shown.withdrawn);
  QString notice;
  if (!newest_) {
    notice = QString::fromStdString(news_.words);
  } else {
    notice = QString::fromStdString(!newest_->notice.empty() ? newest_->notice : newest_->warning);
  }
  views_.status->show_inputs(newest_ ? newest_->inputs : std::vector<InputStatus>(), notice, now);
}

/// Times from an ordered fault to its effect.
void RefreshLoop::measure(Timestamp now) {
  if (!loss_) return;
  const double ms = 1e3 * to_seconds(now - loss_->since);
  if (!loss_->withdrawn && !judgement_.guidance) {
    loss_->withdrawn = true;
    report_.withdrawn(ms);
  }
  if (!loss_->covered && (judgement_.ultrasound.covered || judgement_.scene.covered)) {
    loss_->covered = true;
    report_.covered(ms);
  }
}

void RefreshLoop::complete(io::Json& report) const {
  const auto [name, device] = scene_engine_.engine();
  report["engine"] = name.empty() ? io::Json(nullptr) : io::Json(name);
  report["device"] = device.empty() ? io::Json(nullptr) : io::Json(device);
  report["superseded"] = {{"moments", moments_.superseded()},
                          {"3D view", scene_engine_.superseded()},
                          {"flat views", flat_engine_.superseded()},
                          {"pictures", assembler_.superseded()}};
  report["ledger"] = session_.ledger();
}

}  // namespace nav::app
